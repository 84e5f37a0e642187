"""Gives an imported mesh the look of its file: UV map, materials with images, colours."""

from pathlib import Path

import bpy
import numpy as np
from bpy_extras.node_shader_utils import PrincipledBSDFWrapper

from ...engine import engine
from ...language import own, said

UV_MAP = "UVMap"  # the names that Blender's importers use
_COLORS = {".obj": "Color"}
_OTHER_COLORS = "Col"
_TEXTURES = {"color": "base_color", "emission": "emission_color", "normal": "normalmap"}  # others have their own name
#: what is not read: names for the user of the words in `Look.skipped`
_WORDS = {
    own("normals"): ("vn", "nx", "ny", "nz", "N"),
    own("lines"): ("l", "edge"),
    own("points"): ("p",),
    own("curves and surfaces"): ("vp", "cstype", "deg", "curv", "curv2", "surf", "parm", "trim", "hole", "end"),
    own("colours"): ("C", "red", "green", "blue", "r", "g", "b", "diffuse_red", "diffuse_green", "diffuse_blue"),
    own("UV maps"): ("ST",),
    own("further UV maps"): (
        *("s", "t", "u", "v", "texture_u", "texture_v", "texture_s", "texture_t", "texcoord_u", "texcoord_v"),
        *("texcoord",),
    ),
    own("bump maps"): ("bump", "map_bump", "map_Bump"),
    own("transparency"): ("d", "map_d", "alpha", "a"),
    own("specular maps"): ("map_Ks", "map_Ns"),
}
_MOST = 6  # names in a message


def skipped(look) -> list[str]:
    """Return the names of what the file has and the importer does not read, each once."""
    known = {word: name for name, words in _WORDS.items() for word in words}
    names = dict.fromkeys(said(known[word]) if word in known else word for word in look.skipped)
    return [*list(names)[:_MOST], *(["..."] if len(names) > _MOST else [])]


def write(mesh, look, kind: str) -> None:
    """Writes UV map, colours and materials' numbers on a mesh with the polygons of the file. kind: ".obj" and so on."""
    if look.uv is not None and look.uv.any():
        layer = mesh.uv_layers.new(name=UV_MAP)
        layer.data.foreach_set("uv", look.uv.astype(np.float32).ravel())
    if look.materials:
        mesh.polygons.foreach_set("material_index", np.maximum(look.material - _first(look), 0).astype(np.int32))
    if look.colors is not None:
        _write_colors(mesh, look, _COLORS.get(kind, _OTHER_COLORS))


def _first(look) -> int:
    """Return -1 if some faces have no material: an empty slot comes first for them; else 0."""
    return -1 if (look.material < 0).any() else 0


def _write_colors(mesh, look, name: str) -> None:
    """Writes colours as Blender's importers of PLY and OBJ do: linear floats of vertices."""
    linear = engine.texturing.layers.to_linear(np.arange(256) / 255).astype(np.float32)
    values = linear[look.colors]
    values[:, 3] = look.colors[:, 3] / np.float32(255)
    if look.colors_of_faces:
        values = np.repeat(values, np.diff(look.loop_start, append=len(look.loops)), axis=0)
    layer = mesh.color_attributes.new(name, "FLOAT_COLOR", "CORNER" if look.colors_of_faces else "POINT")
    layer.data.foreach_set("color", values.ravel())
    mesh.color_attributes.active_color = layer
    mesh.color_attributes.render_color_index = mesh.color_attributes.find(layer.name)


def give_materials(mesh, look) -> list[str]:
    """Adds the materials of the file to a mesh, and returns a warning for each missing image."""
    warnings: list[str] = []
    if look.materials and _first(look):
        mesh.materials.append(None)
    for described in look.materials:
        mesh.materials.append(_material(described, warnings))
    return warnings


def _material(described, warnings: list[str]):
    material = bpy.data.materials.new(described.name)
    shader = PrincipledBSDFWrapper(material, is_readonly=False)
    if described.color is not None:
        shader.base_color = np.clip(described.color, 0, 1)
    for layer, numbers in described.numbers.items():
        if layer == "emission":
            shader.emission_color = np.clip(numbers, 0, 1)
            shader.emission_strength = max(1.0, *numbers) if any(numbers) else 0.0
        else:
            setattr(shader, layer, float(np.clip(numbers[0], 0, 1)))
    for layer, (path, place) in described.maps.items():
        image = _image(path)
        if image is None:
            warnings.append(said("{place}: the image {file} does not exist", place=Path(place).name, file=path))
            continue
        getattr(shader, f"{_TEXTURES.get(layer, layer)}_texture").image = image
        if layer == "emission":
            shader.emission_strength = max(1.0, shader.emission_strength)
    return material


def _image(path: Path):
    """Return the image of a file, or of the UDIM tiles of a pattern; None if there is no file."""
    files = engine.texturing.udim.files(path)
    if not files or not min(files.items())[1].is_file():
        return None
    image = bpy.data.images.load(str(min(files.items())[1]), check_existing=True)
    if engine.texturing.udim.is_pattern(path) and image.source != "TILED":
        image.source, image.filepath = "TILED", str(path)
        there = {tile.number for tile in image.tiles}
        for number in sorted(files.keys() - there):
            image.tiles.new(number)
    return image
