"""Layers of materials in addition to their colour: roughness, metallic, emission, occlusion, normals."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import InvalidInput
from .images import Image, by_rows, rgba, settled

#: The layers that are numbers and colours, with the values of a material without them.
NEUTRAL = {"roughness": 1.0, "metallic": 0.0, "emission": 0.0, "occlusion": 1.0}
LARGEST_UV = 1e30  #: UVs of any use are below, and single precision holds them
NORMAL = "normal"
NUMBERS = ("roughness", "metallic")  #: with one value everywhere these are a number of the result, and no image


@dataclass(frozen=True, eq=False)
class TextureLayer:
    """One property of the materials, as images.

    images: for each material an array as in `TexturedSoup.images`, or one number from 0 to 1; None for a material
    without it, and a dict of them for UDIM tiles. Emission is stored as colours are (sRGB), the others as they are;
    normals are tangent-space ones with green up.
    uv: (F, 3, 2) float64: its own, if they differ from the UVs of the colours.
    strength: the value of the images' 1; above 1 for bright emission.
    """

    images: Sequence[Any] = field(repr=False)
    uv: NDArray[np.float64] | None = field(default=None, repr=False)
    strength: float = 1.0


def checked(layers: Mapping[str, TextureLayer], faces: int) -> dict[str, TextureLayer]:
    """The layers with their images as (H, W, 4)."""
    result = {}
    for name, layer in layers.items():
        if name not in (*NEUTRAL, NORMAL):
            raise InvalidInput(f"layers has {name!r}; there are {', '.join(NEUTRAL)} and {NORMAL}")
        uv = None if layer.uv is None else np.asarray(layer.uv, dtype=np.float64)
        if uv is not None and uv.shape != (faces, 3, 2):
            raise InvalidInput(f"the uv of layers[{name!r}] must have the shape ({faces}, 3, 2), got {uv.shape}")
        if uv is not None:
            uv = np.where(np.abs(uv) < LARGEST_UV, uv, 0.0)
        if not layer.strength >= 0 or not np.isfinite(layer.strength):
            raise InvalidInput(f"the strength of layers[{name!r}] must be at least 0, got {layer.strength}")
        images = [
            None if image is None else rgba(number(image), f"the image {i} of layers[{name!r}]")
            for i, image in enumerate(layer.images)
        ]
        result[name] = TextureLayer(images, uv, float(layer.strength))
    return result


def number(value: Any) -> Any:
    """One number as the image of one pixel; images as they are."""
    return np.full((1, 1), value, dtype=np.float64) if np.ndim(value) == 0 else value


def constant(name: str, layer: TextureLayer, used: NDArray[np.int32]) -> float | None:
    """The number that a layer has on all materials in use; None if there are several, or images."""
    images = [layer.images[m] if m >= 0 else None for m in used]
    if any(image is not None and image.shape[:2] != (1, 1) for image in images):
        return None
    values = {(NEUTRAL[name],) * 3 if image is None else _values(image) for image in images}
    if len(values) != 1 or len(set(single := values.pop())) != 1:
        return None
    return single[0]


def _values(pixel: Image) -> tuple[float, ...]:
    return tuple(round(float(x), 4) for x in shares(pixel)[0, 0, :3])


def to_srgb(linear: NDArray[np.float64]) -> NDArray[np.float64]:
    """Linear numbers as images store them."""
    return np.where(linear <= 0.0031308, linear * 12.92, 1.055 * np.maximum(linear, 0) ** (1 / 2.4) - 0.055)


def to_linear(stored: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.where(stored <= 0.04045, stored / 12.92, ((np.maximum(stored, 0) + 0.055) / 1.055) ** 2.4)


def shares(image: Image) -> NDArray[np.float64]:
    """An image's numbers from 0 to 1."""
    return image / np.float64(np.iinfo(image.dtype).max)


def channel(image: Image, k: int, factor: float = 1.0) -> Image:
    """One channel of an image as a grey one, times a factor."""
    if factor == 1:
        return settled(rgba(image[:, :, k]))
    return by_rows(image, lambda rows: shares(rows[:, :, k]) * factor)


def scaled_colors(image: Image, factors: Any) -> Image:
    """An image of colours times linear factors, with its alpha times the fourth; three factors leave it opaque."""
    wanted = np.asarray(factors, dtype=np.float64)
    if (wanted == 1).all():
        return image

    def scaled(rows: Image) -> NDArray[np.float64]:
        stored = shares(rows)
        color = to_srgb(to_linear(stored[:, :, :3]) * wanted[:3])
        return np.dstack([color, stored[:, :, 3] * wanted[3]]) if len(wanted) == 4 else color

    return by_rows(image, scaled)


def scaled_normals(image: Image, scale: float) -> Image:
    """A tangent-space normal map whose slopes are multiplied."""
    if scale == 1:
        return image

    def scaled(rows: Image) -> NDArray[np.float64]:
        normals = shares(rows[:, :, :3]) * 2 - 1
        normals[:, :, :2] *= scale
        normals /= np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), 1e-12)
        return normals / 2 + 0.5

    return by_rows(image, scaled)
