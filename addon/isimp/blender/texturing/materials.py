"""Reads materials as arrays: the images and numbers at the inputs of their Principled BSDF."""

import bpy
import numpy as np
from mathutils import Matrix

from ...engine import engine
from ...language import own, said
from ..scene import mesh_io
from . import tiles

RENDERED = "", ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0))  #: place of an image by the UV map for renders
_GREY = (0.8, 0.8, 0.8, 1.0)
_NUMBERS = {"roughness": "Roughness", "metallic": "Metallic"}  # layers and inputs
_CHANNELS = {"Red": 0, "Green": 1, "Blue": 2, "R": 0, "G": 1, "B": 2}
_BAKE = own("Bake it to an image first: Render Properties > Bake, type Diffuse, in Cycles.")


def nodes_of(material):
    """Return the node tree of a material; None if it uses plain settings."""
    if bpy.app.version < (5, 0, 0) and not material.use_nodes:  # since 5.0 each material has nodes
        return None
    return material.node_tree


def shader_of(material):
    """Return the Principled BSDF at the output of a material, or None."""
    tree = None if material is None else nodes_of(material)
    output = None if tree is None else tree.get_output_node("ALL")
    if output is None or not output.inputs["Surface"].is_linked:
        return None
    node = output.inputs["Surface"].links[0].from_node
    return node if node.type == "BSDF_PRINCIPLED" else None


def emission_of(shader):
    """Return the input of the emission's colour. Its name depends on the version of Blender."""
    return shader.inputs.get("Emission Color") or shader.inputs["Emission"]


def image_name(material) -> str:
    """Return the name of the image at a material's Base Color; empty if there is none."""
    node = _color_node(material)
    return "" if node is None else node.image.name


def color_place(material) -> tuple:
    """Return `_place_of` the image at a material's Base Color, which `color` has read."""
    node = _color_node(material)
    return RENDERED if node is None else _place_of(node)


def color(material):
    """Return (H, W, 4) uint8 of the image at a material's Base Color, row 0 at the top.

    A plain colour is one pixel. An image with UDIM tiles is a dict of arrays by tile number. Raises Unusable.
    """
    if material is None or nodes_of(material) is None:
        return pixel(_GREY if material is None else material.diffuse_color)
    shader = shader_of(material)
    if shader is None:
        raise mesh_io.Unusable(_advice(own("The material '{name}' has no Principled BSDF."), material))
    place = shader.inputs["Base Color"]
    if not place.is_linked:
        return pixel(place.default_value)
    node = _image_node(place)
    if node is None or _place_of(node) is None:
        text = own("The Base Color of the material '{name}' comes from no image on a UV map.")
        raise mesh_io.Unusable(_advice(text, material))
    image = node.image
    return pixels(image) if _is_srgb(image) else pixels(image, engine.texturing.layers.to_srgb)


def _advice(text: str, material) -> str:
    return f"{said(text, name=material.name)} {said(_BAKE)}"


class Layers:
    """Images or numbers of materials other than their colour, by layer and material."""

    def __init__(self, materials):
        """Raises Unusable if an image can't be read."""
        self.images = {}  #: by layer a list by material: (H, W, channels) from 0 to 1, a number, or None
        self.strength = 1.0  #: strength of the brightest emission
        self.notes = []  #: messages about inputs that are left out, since they come from no image
        self.places = {}  #: by layer and material: `_place_of` the image
        shaders = [(shader, m) if (shader := shader_of(m)) is not None else None for m in materials]
        for layer, place in _NUMBERS.items():
            self._put(layer, [None if pair is None else self._number(pair, layer, place) for pair in shaders])
        emissions = [None if pair is None else self._emission(pair) for pair in shaders]
        to_srgb = engine.texturing.layers.to_srgb
        self.strength = max([1.0, *(e[1] for e in emissions if e is not None)])

        def stored(emission):
            return each(emission[0], lambda linear: to_srgb(linear * (emission[1] / self.strength)))

        self._put("emission", [None if e is None else stored(e) for e in emissions])
        self._put("normal", [None if pair is None else self._normals(pair) for pair in shaders])

    def _put(self, layer: str, images: list) -> None:
        if any(image is not None for image in images):
            self.images[layer] = images

    def _image(self, layer: str, material, socket):
        """Return the image at an input and store its place; None if there is none on a UV map."""
        node = _image_node(socket)
        place = None if node is None else _place_of(node)
        if place is None:
            return None
        self.places[layer, material] = place
        return node.image

    def _left_out(self, pair, place: str) -> None:
        place = bpy.app.translations.pgettext_iface(place)  # Blender's translation
        text = said(
            "'{input}' of the material '{name}' comes from no image on a UV map, and is left out.",
            input=place,
            name=pair[1].name,
        )
        self.notes.append(text)

    def _number(self, pair, layer: str, place: str):
        socket = pair[0].inputs[place]
        if not socket.is_linked:
            return float(np.clip(socket.default_value, 0, 1))
        link = socket.links[0]
        image, channel = self._image(layer, pair[1], socket), None
        if image is None and link.from_node.type in {"SEPARATE_COLOR", "SEPRGB"}:
            channel = _CHANNELS.get(link.from_socket.name)
            image = None if channel is None else self._image(layer, pair[1], link.from_node.inputs[0])
        if image is None:
            return self._left_out(pair, place)
        weights = np.array([0.2126, 0.7152, 0.0722])  # the luminance of a colour
        return each(linear_pixels(image), lambda v: v @ weights if channel is None else v[:, :, channel])

    def _emission(self, pair):
        """Return (linear colours (H, W, 3), strength), or None."""
        socket, strength = emission_of(pair[0]), pair[0].inputs["Emission Strength"]
        if strength.is_linked:
            return self._left_out(pair, "Emission Strength")
        if not strength.default_value > 0:
            return None
        if not socket.is_linked:
            values = np.array(socket.default_value[:3], np.float64).reshape(1, 1, 3)
            if not values.any():
                return None
            most = max(1.0, values.max())
            return values / most, float(strength.default_value * most)
        image = self._image("emission", pair[1], socket)
        if image is None:
            return self._left_out(pair, "Emission")
        return linear_pixels(image), float(strength.default_value)

    def _normals(self, pair):
        socket = pair[0].inputs["Normal"]
        if not socket.is_linked:
            return None
        node = socket.links[0].from_node
        is_usable = node.type == "NORMAL_MAP" and node.space == "TANGENT" and not node.inputs["Strength"].is_linked
        image = self._image("normal", pair[1], node.inputs["Color"]) if is_usable else None
        if image is None or _turns(self.places["normal", pair[1]][1]):
            return self._left_out(pair, "Normal")
        strength = node.inputs["Strength"].default_value
        return each(linear_pixels(image), lambda values: _strengthened(values * 2 - 1, strength) / 2 + 0.5)


def _strengthened(normals: np.ndarray, strength: float) -> np.ndarray:
    """Return normals scaled by a strength, like the Normal Map node."""
    if strength == 1:
        return normals
    normals[:, :, :2] *= strength
    normals[:, :, 2] = 1 + (normals[:, :, 2] - 1) * min(strength, 1)
    return normals / np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), 1e-12)


def each(image, change):
    """Return `change` of an image, or of each of its tiles."""
    return engine.texturing.udim.each(image, change)


def _color_node(material):
    shader = shader_of(material)
    return None if shader is None else _image_node(shader.inputs["Base Color"])


def _image_node(socket):
    """Return the node of the image linked to an input, or None."""
    node = socket.links[0].from_node if socket.is_linked else None
    return node if node is not None and node.type == "TEX_IMAGE" and node.image is not None else None


def _place_of(node) -> tuple | None:
    """Return (UV map, two rows of the matrix of its coordinates) of an image node; None if other nodes place the image.

    The name of the map for renders is empty, where no node names it.
    """
    socket, matrix = node.inputs["Vector"], Matrix()
    if node.projection != "FLAT" or not socket.is_linked:
        return RENDERED if node.projection == "FLAT" else None
    while socket.is_linked:
        link = socket.links[0]
        source = link.from_node
        if source.type == "UVMAP" or (source.type == "TEX_COORD" and link.from_socket.identifier == "UV"):
            return getattr(source, "uv_map", ""), tuple(tuple(row) for row in matrix[:2])
        if source.type == "MAPPING":
            if source.vector_type not in {"POINT", "TEXTURE"} or any(other.is_linked for other in source.inputs[1:]):
                return None
            parts = (source.inputs[name].default_value for name in ("Location", "Rotation", "Scale"))
            step = Matrix.LocRotScale(*parts)
            matrix = matrix @ (step if source.vector_type == "POINT" else step.inverted_safe())
        elif source.type != "REROUTE":
            return None
        socket = source.inputs[0]
    return None


def _turns(rows: tuple) -> bool:
    """Return whether a matrix turns or mirrors UV coordinates, and so the axes of a normal map."""
    (a, b), (c, d) = (row[:2] for row in rows)
    return not (a > 0 and d > 0 and b == c == 0)


def pixel(linear) -> np.ndarray:
    """Return (1, 1, 4) uint8 with a linear colour in sRGB."""
    stored = engine.texturing.layers.to_srgb(np.clip(np.array(linear[:3], np.float64), 0, 1))
    return np.append(np.round(255 * stored), 255).astype(np.uint8).reshape(1, 1, 4)


def _is_srgb(image) -> bool:
    return image.colorspace_settings.name == "sRGB" and not image.is_float  # Blender reads these as linear values


def linear_pixels(image):
    """Return (H, W, 3) from 0 to 1, with sRGB images converted to linear values. UDIM tiles give a dict."""
    to_linear = engine.texturing.layers.to_linear if _is_srgb(image) else lambda values: values
    return each(pixels(image), lambda values: to_linear(values[:, :, :3] / 255))


def pixels(image, change=lambda values: values):
    """Return (H, W, 4) uint8, row 0 at the top; a dict of arrays for UDIM tiles. Raises Unusable.

    change: function of the stored colours (H, W, 3), from 0 to 1, that returns others.
    """
    if image.source == "TILED":
        return tiles.read(image, lambda tile: pixels(tile, change))
    width, height = image.size
    if not width or not height or image.channels != 4:
        file = image.filepath or said("no file")
        raise mesh_io.Unusable(said("The image '{name}' can't be read ({file}).", name=image.name, file=file))
    values = np.empty(4 * width * height, np.float32)
    image.pixels.foreach_get(values)
    values = np.clip(values, 0, 1).reshape(height, width, 4)[::-1]
    values[:, :, :3] = change(values[:, :, :3])
    return np.round(values * 255).astype(np.uint8)
