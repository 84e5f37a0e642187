"""The texture of a scan: read from its materials, and put on its result as one material."""

import bpy
import numpy as np

from .. import messages
from ..language import own, said
from ..session import Shown
from . import mesh_io, runtime
from .result import turned

OWN = "isimp_texture"  #: marks the material and the images that were made here
_GREY = (0.8, 0.8, 0.8, 1.0)


def is_textured(obj) -> bool:
    """Whether a material of an object has an image at its Base Color, and there is a UV map for it."""
    if not len(obj.data.uv_layers):
        return False
    return any(image_name(slot.material) for slot in obj.material_slots)


def image_name(material) -> str:
    """The name of the image at a material's Base Color; empty if there is none."""
    shader = None if material is None else _shader(material)
    links = () if shader is None else shader.inputs["Base Color"].links
    image = links[0].from_node.image if links and links[0].from_node.type == "TEX_IMAGE" else None
    return "" if image is None else image.name


class Baking:
    """The texture of a scan on its way to the result: read by the main thread, made by any, put by the main thread."""

    def __init__(self, scan, size=None):
        """Reads the scan's materials. Raises Unusable."""
        self._shown, self._size = read(scan), size
        self._uv_map = next(layer.name for layer in scan.data.uv_layers if layer.active_render)
        self._made = None

    def make(self, arrays, outcome, watch=None) -> None:
        """arrays: those of the scan that the outcome was made from. Raises ValueError or Stopped."""
        if outcome.polygons is None:  # `put` says so
            return
        self._made = runtime.get().session.texture(arrays, outcome, self._shown, self._size, watch)

    def put(self, result, outcome) -> dict:
        """Puts what was made on the result; returns the engine's report. Raises Unusable, and then nothing changes."""
        order = _corners(result, outcome)
        write(result, self._made.uv[order], self._made, self._uv_map)
        return self._made.report


def _corners(result, outcome) -> np.ndarray:
    """Which corner of the outcome's polygons each corner of the result is. Raises Unusable if it was edited."""
    if outcome.polygons is None:
        raise mesh_io.Unusable(said(messages.REGIONS_CHANGED))
    wanted, start = np.array(outcome.polygons.loops), np.array(outcome.polygons.loop_start)
    loops = np.empty(len(result.data.loops), np.int32)
    result.data.loops.foreach_get("vertex_index", loops)
    each = np.arange(len(wanted))
    for order in (each, turned(each, start)):
        if np.array_equal(wanted[order], loops):
            return order
    raise mesh_io.Unusable(
        said("'{name}' has changed since Mesh: press Mesh again, then Keep Texture.", name=result.name)
    )


def read(obj) -> Shown:
    """What each triangle of a scan shows, in the order of `mesh_io.read`. Raises Unusable."""
    mesh = obj.data
    if mesh_io.has_modifiers(obj):
        raise mesh_io.Unusable(
            said("'{name}' has modifiers: apply them first, since they may move its UVs.", name=obj.name)
        )
    layer = next((layer for layer in mesh.uv_layers if layer.active_render), None)
    if layer is None:
        raise mesh_io.Unusable(said("'{name}' has no UV map, so it has no texture to keep.", name=obj.name))
    uv = np.empty(2 * len(mesh.loops), np.float32)
    layer.data.foreach_get("uv", uv)
    slots = np.empty(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("material_index", slots)
    materials = [slot.material for slot in obj.material_slots]
    images = [_image(material) for material in materials]
    if not images or all(image.size == 4 for image in images):
        raise mesh_io.Unusable(said("'{name}' has no image texture at the Base Color of a material.", name=obj.name))
    if len(mesh.loops) == 3 * len(mesh.polygons):
        corners, faces = np.arange(len(mesh.loops)), np.arange(len(mesh.polygons))
    else:
        corners, faces = mesh_io.loop_triangles(mesh, "loops")
    return Shown(uv.reshape(-1, 2)[corners.reshape(-1, 3)], np.clip(slots, 0, len(images) - 1)[faces], images)


def _image(material) -> np.ndarray:
    """(H, W, 4) uint8 of the image at a material's Base Color, row 0 at the top; its colour as one pixel without."""
    if material is None or _nodes(material) is None:
        return _pixel(_GREY if material is None else material.diffuse_color)
    shader = _shader(material)
    color = shader.inputs["Base Color"] if shader is not None else None
    if color is None:
        raise mesh_io.Unusable(_bake(own("The material '{name}' has no Principled BSDF."), material))
    if not color.is_linked:
        return _pixel(color.default_value)
    node = color.links[0].from_node
    if node.type != "TEX_IMAGE" or node.image is None:
        raise mesh_io.Unusable(_bake(own("The Base Color of the material '{name}' comes from no image."), material))
    return pixels(node.image)


def _bake(text: str, material) -> str:
    advice = said("Bake it to an image first: Render Properties > Bake, type Diffuse, in Cycles.")
    return f"{said(text, name=material.name)} {advice}"


def _nodes(material):
    """The node tree a material is shown by, None if by its plain settings."""
    if bpy.app.version < (5, 0, 0) and not material.use_nodes:  # from then on each has nodes
        return None
    return material.node_tree


def _shader(material):
    tree = _nodes(material)
    output = None if tree is None else tree.get_output_node("ALL")
    if output is None or not output.inputs["Surface"].is_linked:
        return None
    node = output.inputs["Surface"].links[0].from_node
    return node if node.type == "BSDF_PRINCIPLED" else None


def _pixel(linear) -> np.ndarray:
    """One pixel of a linear colour, as images store it."""
    c = np.clip(np.array(linear[:3], np.float64), 0, 1)
    stored = np.where(c <= 0.0031308, 12.92 * c, 1.055 * c ** (1 / 2.4) - 0.055)
    return np.append(np.round(255 * stored), 255).astype(np.uint8).reshape(1, 1, 4)


def pixels(image) -> np.ndarray:
    """(H, W, 4) uint8 as stored, row 0 at the top. Raises Unusable."""
    if image.source == "TILED":
        raise mesh_io.Unusable(said("The image '{name}' has UDIM tiles, which are not supported yet.", name=image.name))
    width, height = image.size
    if not width or not height or image.channels != 4:
        file = image.filepath or said("no file")
        raise mesh_io.Unusable(said("The image '{name}' can't be read ({file}).", name=image.name, file=file))
    values = np.empty(4 * width * height, np.float32)
    image.pixels.foreach_get(values)
    return np.round(np.clip(values, 0, 1) * 255).astype(np.uint8).reshape(height, width, 4)[::-1]


def write(result, uv: np.ndarray, made, name: str) -> None:
    """Gives the result a UV map, images that are packed into the file, and one material. uv: (loops, 2)."""
    mesh = result.data
    layer = mesh.uv_layers.get(name) or mesh.uv_layers.new(name=name, do_init=False)
    name = layer.name
    layer.data.foreach_set("uv", uv.astype(np.float32).ravel())
    layer.active = layer.active_render = True
    own = next((i for i, material in enumerate(mesh.materials) if material is not None and material.get(OWN)), -1)
    fresh = own < 0
    if fresh:
        material = bpy.data.materials.new(result.name)
        material[OWN] = True
        mesh.materials.append(material)
        own = len(mesh.materials) - 1
    color = _new_image(f"{result.name} color", made.image, "sRGB", "color")
    normal = None if made.normal is None else _new_image(f"{result.name} normal", made.normal, "Non-Color", "normal")
    (_set_nodes if fresh else _set_images)(mesh.materials[own], name, color, normal)
    mesh.polygons.foreach_set("material_index", np.full(len(mesh.polygons), own, np.int32))
    mesh.update()


def _set_nodes(material, uv_map: str, color, normal) -> None:
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output, shader = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new("ShaderNodeBsdfPrincipled")
    output.location, shader.location = (300, 0), (0, 0)
    tree.links.new(shader.outputs["BSDF"], output.inputs["Surface"])
    node = _image_node(tree, color, (-600, 0))
    tree.links.new(node.outputs["Color"], shader.inputs["Base Color"])
    if normal is None:
        return
    node = _image_node(tree, normal, (-600, -300))
    turn = tree.nodes.new("ShaderNodeNormalMap")
    turn.uv_map, turn.location = uv_map, (-250, -300)
    tree.links.new(node.outputs["Color"], turn.inputs["Color"])
    tree.links.new(turn.outputs["Normal"], shader.inputs["Normal"])


def _set_images(material, _uv_map: str, color, normal) -> None:
    """Puts new images in the place of the last ones, which go; what the user did to the nodes stays."""
    tree = _nodes(material)
    for node in () if tree is None else tree.nodes:
        old = node.image if node.type == "TEX_IMAGE" else None
        new = {"color": color, "normal": normal}.get(old.get(OWN)) if old is not None else None
        if new is None:
            continue
        node.image = new
        if old.users == 0:
            name = old.name
            bpy.data.images.remove(old)
            new.name = name
    for image in (color, normal):
        if image is not None and image.users == 0:  # the user's nodes have no place for it
            bpy.data.images.remove(image)


def _image_node(tree, image, place):
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image, node.location = image, place
    return node


def _new_image(name: str, stored: np.ndarray, space: str, kind: str):
    height, width = stored.shape[:2]
    image = bpy.data.images.new(name, width, height, alpha=False)
    image.colorspace_settings.name = space
    values = np.ones((height, width, 4), np.float32)
    values[:, :, :3] = stored[::-1, :, :3] / np.float32(255)
    image.pixels.foreach_set(values.ravel())
    image.update()
    image.pack()
    image[OWN] = kind
    return image
