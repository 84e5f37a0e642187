"""Reads materials as arrays: the images and numbers at the inputs of their Principled BSDF."""

import bpy
import numpy as np

from ...engine import engine
from ...language import own, said
from ..scene import mesh_io
from . import tiles

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
    shader = shader_of(material)
    image = None if shader is None else _linked_image(shader.inputs["Base Color"])
    return "" if image is None else image.name


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
    image = _linked_image(place)
    if image is None:
        raise mesh_io.Unusable(_advice(own("The Base Color of the material '{name}' comes from no image."), material))
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
        shaders = [(shader, m.name) if (shader := shader_of(m)) is not None else None for m in materials]
        for layer, place in _NUMBERS.items():
            self._put(layer, [None if pair is None else self._number(pair, place) for pair in shaders])
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

    def _left_out(self, pair, place: str) -> None:
        place = bpy.app.translations.pgettext_iface(place)  # Blender's translation
        text = said(
            "'{input}' of the material '{name}' comes from no image, and is left out.", input=place, name=pair[1]
        )
        self.notes.append(text)

    def _number(self, pair, place: str):
        socket = pair[0].inputs[place]
        if not socket.is_linked:
            return float(np.clip(socket.default_value, 0, 1))
        link = socket.links[0]
        image, channel = _linked_image(socket), None
        if image is None and link.from_node.type in {"SEPARATE_COLOR", "SEPRGB"}:
            image, channel = _linked_image(link.from_node.inputs[0]), _CHANNELS.get(link.from_socket.name)
            image = image if channel is not None else None
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
        image = _linked_image(socket)
        if image is None:
            return self._left_out(pair, "Emission")
        return linear_pixels(image), float(strength.default_value)

    def _normals(self, pair):
        socket = pair[0].inputs["Normal"]
        if not socket.is_linked:
            return None
        node = socket.links[0].from_node
        image = _linked_image(node.inputs["Color"]) if node.type == "NORMAL_MAP" and node.space == "TANGENT" else None
        if image is None or node.inputs["Strength"].is_linked:
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


def _linked_image(socket):
    """Return the image linked to an input, or None."""
    node = socket.links[0].from_node if socket.is_linked else None
    return node.image if node is not None and node.type == "TEX_IMAGE" else None


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
