"""Further layers of glTF's materials, read and written."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import FileError
from . import images, layers
from .gltf_file import GltfFile, texture_of
from .gltf_values import Item
from .layers import TextureLayer

_STRENGTH = "KHR_materials_emissive_strength"
_LARGEST = 1e30  # largest emission
_Parts = list[tuple[Item, NDArray[np.int32]]]  # primitives with their triangles


def read(file: GltfFile, used: list[int], parts: _Parts) -> dict[str, TextureLayer]:
    """The layers that any of the materials in use has. One without a factor and an image has none."""
    materials = [file.item("materials", m) for m in used]
    strength = max([1.0, *(float(max(_emission(m))) for m in materials)])
    found = {}
    for name in (*layers.NEUTRAL, layers.NORMAL):
        pictures = [_image(file, name, material, strength) for material in materials]
        if any(picture is not None for picture in pictures):
            uv = _uv(file, name, parts)
            found[name] = TextureLayer(pictures, uv, strength if name == "emission" else 1.0)
    return found


def _base(material: Item) -> Item:
    return material.item("pbrMetallicRoughness")


def _texture(name: str, material: Item) -> Item | None:
    if name in layers.NUMBERS:
        return texture_of(_base(material), "metallicRoughnessTexture")
    return texture_of(material, {"emission": "emissiveTexture"}.get(name, f"{name}Texture"))


def _emission(material: Item) -> NDArray[np.float64]:
    """Linear."""
    strength = material.extension(_STRENGTH).number("emissiveStrength", 1.0)
    found = material.numbers("emissiveFactor", 3, (0, 0, 0)) * strength
    if not (np.abs(found) <= _LARGEST).all():
        raise FileError(f"{material.place}: its emission is above {_LARGEST:g}")
    return found


def _image(file: GltfFile, name: str, material: Item, strength: float) -> images.Image | None:
    texture = _texture(name, material)
    picture = None if texture is None else file.picture(texture)
    changed = file.pictures.changed
    if name in layers.NUMBERS:
        given = f"{name}Factor" in _base(material)
        factor = _base(material).number(f"{name}Factor", 1.0)
        if picture is not None:
            k = 1 if name == "roughness" else 2
            return changed(picture, (k, factor), lambda image: layers.channel(image, k, factor))
        return images.rgba(layers.number(factor)) if given else None
    if name == "emission":
        factors = _emission(material) / strength
        if not factors.any():
            return None
        if picture is None:
            return layers.scaled_colors(np.full((1, 1, 4), 255, np.uint8), factors)
        return changed(picture, tuple(factors), lambda image: layers.scaled_colors(image, factors))
    if picture is None:
        return None
    assert texture is not None
    if name == layers.NORMAL:
        scale = texture.number("scale", 1)
        return changed(picture, ("normal", scale), lambda image: layers.scaled_normals(image, scale))
    share = texture.number("strength", 1)  # strength of occlusion: 1 + strength * (image - 1)
    dark = lambda rows: 1 + share * (layers.shares(rows)[:, :, 0] - 1)  # noqa: E731
    if share == 1:
        return changed(picture, (0, 1.0), lambda image: layers.channel(image, 0))
    return changed(picture, ("dark", share), lambda image: images.by_rows(image, dark))


def _uv(file: GltfFile, name: str, parts: _Parts) -> NDArray[np.float64] | None:
    """(F, 3, 2) if the layer has other UVs than the colours."""
    pairs = []
    for primitive, _ in parts:
        number = primitive.whole("material") if "material" in primitive else -1
        colors = file.color_texture(number)
        texture = _texture(name, file.item("materials", number)) if number >= 0 else None
        pairs.append((colors, colors if texture is None else texture))
    if all(file.placing(colors) == file.placing(own) for colors, own in pairs):
        return None
    pieces = zip(parts, pairs, strict=True)
    return np.concatenate([file.uv(primitive, own)[triangles] for (primitive, triangles), (_, own) in pieces])


@dataclass(frozen=True)
class Shown:
    """The appearance of a result's material: images as PNG files, and numbers."""

    name: str  #: beginning of its images' names
    color: bytes = field(repr=False)
    normal: bytes | None = field(repr=False)
    #: occlusion in red, roughness in green and metallic in blue; None if none of them has an image
    surface: bytes | None = field(repr=False)
    emission: bytes | None = field(repr=False)
    has: frozenset[str]  #: the layers that have an image
    factors: dict[str, float]

    def material(self, first: int) -> tuple[dict[str, Any], list[tuple[str, bytes]]]:
        """The material, and its images with the ends of their names. first: the number of the first image."""
        pictures: list[tuple[str, bytes]] = []

        def texture(suffix: str, data: bytes) -> dict[str, int]:
            pictures.append((suffix, data))
            return {"index": first + len(pictures) - 1}

        base: dict[str, Any] = {"baseColorTexture": texture("", self.color)}
        for name, neutral in (("metallic", 0.0), ("roughness", 1.0)):
            base[f"{name}Factor"] = 1 if name in self.has else self.factors.get(name, neutral)
        material: dict[str, Any] = {"pbrMetallicRoughness": base}
        if self.normal is not None:
            material["normalTexture"] = texture("_normal", self.normal)
        if self.surface is not None:
            shared = texture("_surface", self.surface)
            if self.has & {"roughness", "metallic"}:
                base["metallicRoughnessTexture"] = shared
            if "occlusion" in self.has:
                material["occlusionTexture"] = shared
        if self.emission is not None:
            material |= {"emissiveTexture": texture("_emission", self.emission), "emissiveFactor": [1, 1, 1]}
            if (strength := self.factors.get("emission", 1.0)) != 1:
                material["extensions"] = {_STRENGTH: {"emissiveStrength": strength}}
        return material, pictures
