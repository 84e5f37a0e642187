"""The texture of a scan: read from its materials, and put on its result as one material."""

import bpy
import numpy as np

from .. import messages
from ..language import said
from ..session import Shown
from . import materials, mesh_io, runtime
from .result import corner_order

OWN = "isimp_texture"  #: marks the material and the images that were made here
_GLTF, _OCCLUSION = "glTF Material Output", "Occlusion"
#: What kinds of images go to which inputs
_PLACES = {
    "color": "Base Color",
    "normal": "Normal",
    "roughness": "Roughness",
    "metallic": "Metallic",
    "emission": "Emission",
}
_ROWS = (*_PLACES, "occlusion", "height")
_RANGE = "isimp_range"  #: of an image of heights: what black to white is, in scene units


def is_textured(obj) -> bool:
    """Whether a material of an object has an image at its Base Color, and there is a UV map for it."""
    if not len(obj.data.uv_layers):
        return False
    return any(materials.image_name(slot.material) for slot in obj.material_slots)


class Baking:
    """The texture of a scan on its way to the result: read by the main thread, made by any, put by the main thread."""

    def __init__(self, scan, step):
        """Reads the scan's materials. Raises Unusable."""
        (self._shown, self.notes), self._step = read(scan), step
        self._uv_map = next(layer.name for layer in scan.data.uv_layers if layer.active_render)
        self._made = None

    def make(self, arrays, outcome, watch=None) -> None:
        """arrays: those of the scan that the outcome was made from. Raises ValueError or Stopped."""
        if outcome.polygons is None:  # `put` says so
            return
        self._made = runtime.get().session.texture(arrays, outcome, self._shown, self._step, watch)

    def put(self, result, outcome) -> dict:
        """Puts what was made on the result; returns the engine's report. Raises Unusable, and then nothing changes."""
        order = _corners(result, outcome)
        write(result, self._made.uv[order], self._made, self._uv_map)
        return self._made.report


def _corners(result, outcome) -> np.ndarray:
    """Which corner of the outcome's polygons each corner of the result is. Raises Unusable if it was edited."""
    if outcome.polygons is None:
        raise mesh_io.Unusable(said(messages.REGIONS_CHANGED))
    order = corner_order(result, outcome)
    if order is not None:
        return order
    raise mesh_io.Unusable(
        said("'{name}' has changed since Mesh: press Mesh again, then Keep Texture.", name=result.name)
    )


def read(obj) -> tuple[Shown, list[str]]:
    """What each triangle shows, in the order of `mesh_io.read`, and a line for each input left out. Raises Unusable."""
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
    slotted = [slot.material for slot in obj.material_slots]
    images = [materials.color(material) for material in slotted]
    if not images or all(image.size == 4 for image in images):
        raise mesh_io.Unusable(said("'{name}' has no image texture at the Base Color of a material.", name=obj.name))
    if len(mesh.loops) == 3 * len(mesh.polygons):
        corners, faces = np.arange(len(mesh.loops)), np.arange(len(mesh.polygons))
    else:
        corners, faces = mesh_io.loop_triangles(mesh, "loops")
    more = materials.Layers(slotted)
    shown = np.clip(slots, 0, len(images) - 1)[faces]
    of_corners = uv.reshape(-1, 2)[corners.reshape(-1, 3)]
    return Shown(of_corners, shown, images, more.images, more.strength), more.notes


def write(result, uv: np.ndarray, made, name: str) -> None:
    """Gives the result a UV map, images that are packed into the file, and one material. uv: (loops, 2)."""
    mesh = result.data
    layer = mesh.uv_layers.get(name) or mesh.uv_layers.new(name=name, do_init=False)
    name = layer.name
    layer.data.foreach_set("uv", uv.astype(np.float32).ravel())
    layer.active = layer.active_render = True
    own = next((i for i, material in enumerate(mesh.materials) if material is not None and material.get(OWN)), -1)
    if own < 0:
        mesh.materials.append(_new_material(result.name))
        own = len(mesh.materials) - 1
    layers = {"color": made.image} | ({} if made.normal is None else {"normal": made.normal}) | made.layers
    images = {kind: _new_image(f"{result.name} {kind}", stored, kind) for kind, stored in layers.items()}
    if "height" in images:
        images["height"][_RANGE] = made.factors["height"]
    _set_images(mesh.materials[own], name, images, made.factors)
    mesh.polygons.foreach_set("material_index", np.full(len(mesh.polygons), own, np.int32))
    mesh.update()


def _new_material(name: str):
    material = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    material[OWN] = "new"  # else the kinds of images, and with = those of numbers, that it was given
    tree = material.node_tree
    tree.nodes.clear()
    output, shader = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new("ShaderNodeBsdfPrincipled")
    output.location, shader.location = (300, 0), (0, 0)
    tree.links.new(shader.outputs["BSDF"], output.inputs["Surface"])
    return material


def _set_images(material, uv_map: str, images: dict, factors: dict) -> None:
    """Puts new images in the place of the last ones, which go; what the user did to the nodes stays.

    Images of a kind that the material had not before get nodes, where the user has nothing at that input.
    """
    given = material[OWN].split() if isinstance(material[OWN], str) else ["color", "normal"]  # those of iSimp 0.1
    tree, shader = materials.nodes_of(material), materials.shader_of(material)
    for node in () if tree is None else [node for node in tree.nodes if node.type == "TEX_IMAGE"]:
        old = node.image
        kind = None if old is None else old.get(OWN)
        if kind in images:
            node.image = images[kind]
            if kind == "height":
                _scale_height(node, old)
        elif kind is not None:  # a layer that there is no more
            for shift in _displacements(node):
                if not shift.outputs["Displacement"].is_linked:
                    tree.nodes.remove(shift)
            tree.nodes.remove(node)
        else:
            continue
        if old.users == 0:
            name = old.name
            bpy.data.images.remove(old)
            if kind in images:
                images[kind].name = name
                _name_file(images[kind])
    if shader is not None:
        for kind in (kind for kind in images if kind not in given):
            _plug(tree, shader, uv_map, kind, images[kind])
        for kind in (kind for kind in factors if kind != "height" and f"={kind}" not in given):
            socket = shader.inputs["Emission Strength"] if kind == "emission" else _input(shader, kind)
            socket.default_value = factors[kind]
    material[OWN] = " ".join([*images, *(f"={kind}" for kind in factors)])
    for image in images.values():
        if image.users == 0:  # the user's nodes have no place for it
            bpy.data.images.remove(image)


def _plug(tree, shader, uv_map: str, kind: str, image) -> None:
    """Gives an image a node, and links it to what it is for if that is free."""
    height = -300 * _ROWS.index(kind)
    if kind in _PLACES and _input(shader, kind).is_linked:
        return
    node = _image_node(tree, image, (-600, height))
    if kind == "normal":
        turn = tree.nodes.new("ShaderNodeNormalMap")
        turn.uv_map, turn.location = uv_map, (-250, height)
        tree.links.new(node.outputs["Color"], turn.inputs["Color"])
        tree.links.new(turn.outputs["Normal"], shader.inputs["Normal"])
    elif kind == "occlusion":
        _put_occlusion(tree, node, (0, height))
    elif kind == "height":
        shift = tree.nodes.new("ShaderNodeDisplacement")
        shift.location = (-250, height)
        shift.inputs["Midlevel"].default_value, shift.inputs["Scale"].default_value = 0.5, image[_RANGE]
        tree.links.new(node.outputs["Color"], shift.inputs["Height"])
    else:
        tree.links.new(node.outputs["Color"], _input(shader, kind))


def _scale_height(node, old) -> None:
    """Gives the Displacement nodes behind an image of heights its range, times what the user made of the last one."""
    before = old.get(_RANGE, 0.0)
    for shift in _displacements(node):
        scale = shift.inputs["Scale"]
        scale.default_value = node.image[_RANGE] * (scale.default_value / before if before > 0 else 1)


def _displacements(node) -> list:
    return [link.to_node for link in node.outputs["Color"].links if link.to_node.type == "DISPLACEMENT"]


def _put_occlusion(tree, node, place) -> None:
    """Plugs an image into the group of nodes where Blender's exporter of glTF looks for the occlusion."""
    group = bpy.data.node_groups.get(_GLTF) or bpy.data.node_groups.new(_GLTF, "ShaderNodeTree")
    names = [item.name for item in (group.interface.items_tree if hasattr(group, "interface") else group.inputs)]
    if _OCCLUSION not in names:
        if hasattr(group, "interface"):
            group.interface.new_socket(_OCCLUSION, socket_type="NodeSocketFloat")
        else:
            group.inputs.new("NodeSocketFloat", _OCCLUSION)
    holder = tree.nodes.new("ShaderNodeGroup")
    holder.node_tree, holder.location = group, place
    tree.links.new(node.outputs["Color"], holder.inputs[_OCCLUSION])


def _input(shader, kind: str):
    return materials.emission_of(shader) if kind == "emission" else shader.inputs[_PLACES[kind]]


def _image_node(tree, image, place):
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image, node.location = image, place
    return node


def _new_image(name: str, stored: np.ndarray, kind: str):
    height, width = stored.shape[:2]
    deep = stored.dtype == np.uint16
    image = bpy.data.images.new(name, width, height, alpha=False, float_buffer=deep)
    image.colorspace_settings.name = "sRGB" if kind in {"color", "emission"} else "Non-Color"
    values = np.ones((height, width, 4), np.float32)
    most = np.float32(np.iinfo(stored.dtype).max)
    values[:, :, :3] = (stored[::-1, :, None] if stored.ndim == 2 else stored[::-1, :, :3]) / most
    image.pixels.foreach_set(values.ravel())
    image.update()
    image.pack()
    image[OWN] = kind
    _name_file(image)
    return image


def _name_file(image) -> None:
    """Gives a packed image a file name of its own, by which exporters tell images apart. USD wants the image's name."""
    name = image.name.replace("/", "_").replace("\\", "_")
    image.filepath_raw = f"//{name}.{'exr' if image.is_float else 'png'}"
