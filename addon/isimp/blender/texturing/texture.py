"""Reads the texture of a scan from its materials, and writes the baked texture on the result."""

import json

import bpy
import numpy as np

from ... import messages
from ...engine import engine
from ...language import said
from ...recipe import Texture, step_from_dict
from ...session import Shown
from ..scene import mesh_io, runtime
from ..scene.result import MADE_OF, corner_order
from . import materials, tiles

OWN = "isimp_texture"  #: marks materials and images of the add-on
_GLTF, _OCCLUSION = "glTF Material Output", "Occlusion"
#: the input of the shader for each kind of image
_PLACES = {
    "color": "Base Color",
    "normal": "Normal",
    "roughness": "Roughness",
    "metallic": "Metallic",
    "emission": "Emission",
}
_ROWS = (*_PLACES, "occlusion")
_STEP = "isimp_texture_step"  #: on a result: the recipe's step of its texture


def is_textured(obj) -> bool:
    """Return whether an object has a UV map and a material with an image at its Base Color."""
    if not len(obj.data.uv_layers):
        return False
    return any(materials.image_name(slot.material) for slot in obj.material_slots)


class Baking:
    """Bakes the texture of a scan for its result. The main thread reads and writes; any thread computes."""

    def __init__(self, scan, step):
        """Reads the scan's materials. Raises Unusable."""
        (self._shown, self.notes), self._step = read(scan), step
        self._uv_map = next(layer.name for layer in scan.data.uv_layers if layer.active_render)
        self._made = None

    def make(self, arrays, outcome, watch=None) -> None:
        """Bakes the images. arrays: the scan that the outcome was made from. Raises ValueError or Stopped."""
        if outcome.polygons is None:  # `put` raises the error
            return
        self._made = runtime.get().session.texture(arrays, outcome, self._shown, self._step, watch)

    def put(self, result, outcome) -> dict:
        """Writes the texture on the result; returns the engine's report. Raises Unusable before any change."""
        order = _corners(result, outcome)
        write(result, self._made.uv[order], self._made, self._uv_map)
        result[_STEP] = json.dumps(self._step.to_dict())
        return self._made.report


def last_step(result) -> Texture | None:
    """Return the Texture step stored on a result, as edits of regions remove it from the recipe; None if unknown."""
    try:
        step = step_from_dict(json.loads(result[_STEP]))
    except (TypeError, KeyError, ValueError):  # no result, not stored, or not readable
        return None
    return step if isinstance(step, Texture) else None


def image_width(result) -> int:
    """Return the width in pixels of the widest image of the add-on on a result; 0 without one."""
    kept = [material for material in result.data.materials if material is not None and material.get(OWN)]
    trees = [tree for tree in map(materials.nodes_of, kept) if tree is not None]
    images = [node.image for tree in trees for node in tree.nodes if node.type == "TEX_IMAGE" and node.image]
    return max((image.size[0] for image in images if image.get(OWN)), default=0)


def _corners(result, outcome) -> np.ndarray:
    """Return the corner of the outcome's polygons for each corner of the result. Raises Unusable if they differ."""
    if outcome.polygons is None:
        raise mesh_io.Unusable(said(messages.REGIONS_CHANGED))
    order = corner_order(result, outcome)
    if order is not None:
        return order
    raise mesh_io.Unusable(
        said("'{name}' has changed since Mesh: press Mesh again, then Keep Texture.", name=result.name)
    )


def read(obj) -> tuple[Shown, list[str]]:
    """Return the texture by triangle, in the order of `mesh_io.read`, and a line for each input left out.

    Raises Unusable.
    """
    with mesh_io.whole(obj) as mesh:
        return _read(obj, mesh)


def _read(obj, mesh) -> tuple[Shown, list[str]]:
    """Return `read` from the object's mesh or a copy of it."""
    if mesh_io.has_modifiers(obj):
        raise mesh_io.Unusable(
            said("'{name}' has modifiers: apply them first, since they may move its UVs.", name=obj.name)
        )
    layer = next((layer for layer in mesh.uv_layers if layer.active_render), None)
    if layer is None:
        raise mesh_io.Unusable(said("'{name}' has no UV map, so it has no texture to keep.", name=obj.name))
    slots = np.empty(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("material_index", slots)
    slotted = [slot.material for slot in obj.material_slots]
    images = [materials.color(material) for material in slotted]
    if not any(isinstance(image, dict) or image.size > 4 for image in images):
        raise mesh_io.Unusable(said("'{name}' has no image texture at the Base Color of a material.", name=obj.name))
    if len(mesh.loops) == 3 * len(mesh.polygons):
        corners, faces = np.arange(len(mesh.loops)), np.arange(len(mesh.polygons))
    else:
        corners, faces = mesh_io.loop_triangles(mesh, "loops")
    more = materials.Layers(slotted)
    shown = np.clip(slots, 0, len(images) - 1)[faces]
    corners = corners.reshape(-1, 3)
    places = [_named(materials.color_place(material), layer) for material in slotted]
    uvs = {}
    for name in more.images:
        own = [_named(more.places.get((name, m), place), layer) for m, place in zip(slotted, places, strict=True)]
        if own != places:
            uvs[name] = _laid(mesh, corners, shown, own)
    names = tuple("" if material is None else material.name for material in slotted)
    uv = _laid(mesh, corners, shown, places)
    return Shown(uv, shown, images, more.images, more.strength, names, uvs), more.notes


def _named(place: tuple, rendered) -> tuple:
    """Return the place of an image with the name of its UV map."""
    return place[0] or rendered.name, place[1]


def _laid(mesh, corners: np.ndarray, shown: np.ndarray, places: list) -> np.ndarray:
    """Return (T, 3, 2) the coordinates of triangles in the images of their materials, which lie at these places."""
    laid = np.zeros((len(corners), 3, 2), np.float32)  # as in Blender for a map that does not exist
    for name, matrix in set(places):
        rows = np.array(matrix)
        here = np.isin(shown, [k for k, place in enumerate(places) if place == (name, matrix)])
        layer, uv = mesh.uv_layers.get(name), np.empty(2 * len(mesh.loops), np.float32)
        if layer is not None:
            layer.data.foreach_get("uv", uv)
            laid[here] = (uv.reshape(-1, 2) @ rows[:, :2].T + rows[:, 3])[corners[here]]
    return laid


def write(result, uv: np.ndarray, made, name: str) -> None:
    """Writes a UV map, images that are packed into the file, and a material on the result. uv: (loops, 2).

    If materials are kept apart, there is one for each material of the scan.
    """
    mesh = result.data
    sheets = engine.texturing.writing.sheets(made, result.name)
    of_loop = np.repeat(made.tile, mesh_io.corner_totals(mesh))
    uv = uv + np.array([(sheet.column, sheet.row) for sheet in sheets])[of_loop]
    layer = mesh.uv_layers.get(name) or mesh.uv_layers.new(name=name, do_init=False)
    name = layer.name
    layer.data.foreach_set("uv", uv.astype(np.float32).ravel())
    layer.active = layer.active_render = True
    groups = {}
    for sheet in sheets:
        groups.setdefault(sheet.material if made.materials_apart else "", []).append(sheet)
    _drop_materials(mesh, groups)
    index = np.zeros(len(sheets), np.int32)
    for title, group in groups.items():
        own = _own_material(mesh, title, result.name)
        _set_images(mesh.materials[own], name, _images_of(group, result.name, title), made.factors)
        index[[sheets.index(sheet) for sheet in group]] = own
    mesh.polygons.foreach_set("material_index", index[made.tile])
    mesh.update()


def _images_of(group: list, name: str, title: str) -> dict:
    """Return the new images of one material, by kind."""
    images = {}
    kinds = ["color", *([] if group[0].normal is None else ["normal"]), *group[0].layers]
    for kind in kinds:
        stored = [
            {"color": sheet.color, "normal": sheet.normal}[kind] if kind in {"color", "normal"} else sheet.layers[kind]
            for sheet in group
        ]
        full = f"{name} {title} {kind}" if title else f"{name} {kind}"
        if len(stored) == 1:
            images[kind] = _new_image(full, stored[0], kind)
        else:
            numbers = (1001 + sheet.column + 10 * sheet.row for sheet in group)
            images[kind] = _new_tiles(full, dict(zip(numbers, stored, strict=True)), kind)
    return images


def _own_material(mesh, title: str, name: str) -> int:
    """Return the index of the add-on's material for one of the scan's, or for all (title ""). Adds it if missing."""
    for i, material in enumerate(mesh.materials):
        if material is not None and material.get(OWN) and material.get(MADE_OF, "") == title:
            if material.users - material.use_fake_user > 1:  # a copy of the result keeps the former images
                mesh.materials[i] = material.copy()
            return i
    mesh.materials.append(_new_material(f"{name} {title}" if title else name))
    mesh.materials[-1][MADE_OF] = title
    return len(mesh.materials) - 1


def _drop_materials(mesh, wanted) -> None:
    """Removes materials of the add-on whose title is not wanted, with their unused images."""
    for i in reversed(range(len(mesh.materials))):
        material = mesh.materials[i]
        if material is None or not material.get(OWN) or material.get(MADE_OF, "") in wanted:
            continue
        mesh.materials.pop(index=i)
        if material.users == 0:
            old = [node.image for node in material.node_tree.nodes if node.type == "TEX_IMAGE" and node.image]
            bpy.data.materials.remove(material)
            for image in old:
                if image.users == 0 and image.get(OWN):
                    bpy.data.images.remove(image)


def _new_material(name: str):
    material = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    material[OWN] = "new"  # later the kinds of its images, and of its factors with a leading "="
    tree = material.node_tree
    tree.nodes.clear()
    output, shader = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new("ShaderNodeBsdfPrincipled")
    output.location, shader.location = (300, 0), (0, 0)
    tree.links.new(shader.outputs["BSDF"], output.inputs["Surface"])
    return material


def _set_images(material, uv_map: str, images: dict, factors: dict) -> None:
    """Replaces the images of a material in its nodes and removes the former images. The user's changes stay.

    Images of a kind that is new to the material get nodes, unless the user has linked that input.
    """
    given = material[OWN].split() if isinstance(material[OWN], str) else ["color", "normal"]  # kinds of iSimp 0.1
    tree, shader = materials.nodes_of(material), materials.shader_of(material)
    for node in () if tree is None else [node for node in tree.nodes if node.type == "TEX_IMAGE"]:
        old = node.image
        kind = None if old is None else old.get(OWN)
        if kind in images:
            node.image = images[kind]
        elif kind is not None:  # a kind that is not baked now, such as heights, which earlier versions made
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
        for kind in (kind for kind in factors if f"={kind}" not in given):
            socket = shader.inputs["Emission Strength"] if kind == "emission" else _input(shader, kind)
            socket.default_value = factors[kind]
    material[OWN] = " ".join([*images, *(f"={kind}" for kind in factors)])
    for image in images.values():
        if image.users == 0:  # the user's nodes do not use it
            bpy.data.images.remove(image)


def _plug(tree, shader, uv_map: str, kind: str, image) -> None:
    """Adds a node for an image and links it to its input, unless the input is linked already."""
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
    else:
        tree.links.new(node.outputs["Color"], _input(shader, kind))


def _displacements(node) -> list:
    return [link.to_node for link in node.outputs["Color"].links if link.to_node.type == "DISPLACEMENT"]


def _put_occlusion(tree, node, place) -> None:
    """Links an image to the group of nodes from which Blender's glTF exporter reads the occlusion."""
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


def _new_tiles(name: str, stored: dict, kind: str):
    """Return a new packed image of UDIM tiles."""
    image = tiles.make(name, stored, lambda title, one: _loose_image(title, one, kind))
    image[OWN] = kind
    _name_file(image)
    return image


def _new_image(name: str, stored: np.ndarray, kind: str):
    image = _loose_image(name, stored, kind)
    image.pack()
    image[OWN] = kind
    _name_file(image)
    return image


def _loose_image(name: str, stored: np.ndarray, kind: str):
    """Return a new image that is not packed."""
    height, width = stored.shape[:2]
    image = bpy.data.images.new(name, width, height, alpha=False)
    image.colorspace_settings.name = "sRGB" if kind in {"color", "emission"} else "Non-Color"
    values = np.ones((height, width, 4), np.float32)
    values[:, :, :3] = (stored[::-1, :, None] if stored.ndim == 2 else stored[::-1, :, :3]) / np.float32(255)
    image.pixels.foreach_set(values.ravel())
    image.update()
    return image


def _name_file(image) -> None:
    """Sets the file name of a packed image to its unique name. Exporters, such as USD, distinguish images by it."""
    name = image.name.replace("/", "_").replace("\\", "_")
    if image.source != "TILED":
        image.filepath_raw = f"//{name}.png"
        return
    image.filepath_raw = f"//{name}.<UDIM>.png"
    for packed in image.packed_files:  # USD writes each tile by its own name
        packed.filepath = f"//{name}.{packed.tile_number}.png"
