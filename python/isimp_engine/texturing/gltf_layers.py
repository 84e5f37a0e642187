"""What glTF's materials have beside their colour, read and written."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import images, layers
from .gltf_file import GltfFile
from .layers import TextureLayer

_STRENGTH = "KHR_materials_emissive_strength"
_Parts = list[tuple[dict[str, Any], NDArray[np.int64]]]  # primitives with their triangles


def read(file: GltfFile, used: list[int], parts: _Parts) -> dict[str, TextureLayer]:
    """The layers that any of the materials in use has. One without a factor and an image says nothing."""
    materials = [file.json["materials"][m] for m in used]
    strength = max([1.0, *(float(max(_emission(m))) for m in materials)])
    found = {}
    for name in (*layers.NEUTRAL, layers.NORMAL):
        pictures = [_image(file, name, material, strength) for material in materials]
        if any(picture is not None for picture in pictures):
            uv = _uv(file, name, parts)
            found[name] = TextureLayer(pictures, uv, strength if name == "emission" else 1.0)
    return found


def _base(material: dict[str, Any]) -> dict[str, Any]:
    base: dict[str, Any] = material.get("pbrMetallicRoughness", {})
    return base


def _texture(name: str, material: dict[str, Any]) -> dict[str, Any] | None:
    if name in layers.NUMBERS:
        return _base(material).get("metallicRoughnessTexture")
    return material.get({"emission": "emissiveTexture"}.get(name, f"{name}Texture"))


def _emission(material: dict[str, Any]) -> NDArray[np.float64]:
    """Linear."""
    strength = material.get("extensions", {}).get(_STRENGTH, {}).get("emissiveStrength", 1.0)
    return np.asarray(material.get("emissiveFactor", (0, 0, 0)), dtype=np.float64) * float(strength)


def _image(file: GltfFile, name: str, material: dict[str, Any], strength: float) -> images.Image | None:
    texture = _texture(name, material)
    picture = None if texture is None else file.picture(texture)
    if name in layers.NUMBERS:
        factor = _base(material).get(f"{name}Factor")
        if picture is not None:
            return layers.channel(picture, 1 if name == "roughness" else 2, 1.0 if factor is None else float(factor))
        return None if factor is None else images.rgba(layers.number(float(factor)))
    if name == "emission":
        factors = _emission(material) / strength
        if not factors.any():
            return None
        return layers.scaled_colors(np.full((1, 1, 4), 255, np.uint8) if picture is None else picture, factors)
    if picture is None:
        return None
    assert texture is not None
    if name == layers.NORMAL:
        return layers.scaled_normals(picture, float(texture.get("scale", 1)))
    share = float(texture.get("strength", 1))  # of occlusion: 1 + strength * (image - 1)
    red = layers.channel(picture, 0)
    return red if share == 1 else images.rgba(1 + share * (layers.shares(red)[:, :, 0] - 1))


def _uv(file: GltfFile, name: str, parts: _Parts) -> NDArray[np.float64] | None:
    """(F, 3, 2) if the layer has UVs other than those of the colours."""
    pairs = []
    for primitive, _ in parts:
        number = primitive.get("material", -1)
        colors = file.color_texture(number)
        texture = _texture(name, file.json["materials"][number]) if number >= 0 else None
        pairs.append((colors, colors if texture is None else texture))
    if all(file.placing(colors) == file.placing(own) for colors, own in pairs):
        return None
    pieces = zip(parts, pairs, strict=True)
    return np.concatenate([file.uv(primitive, own)[triangles] for (primitive, triangles), (_, own) in pieces])


@dataclass(frozen=True)
class Shown:
    """What a material of a result has: images as PNG files, and numbers."""

    name: str  #: of its images, which have more behind it
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
