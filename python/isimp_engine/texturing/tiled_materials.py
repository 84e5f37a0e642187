"""Materials of UDIM tiles in the engine's form: each tile is a material of its own."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import InvalidInput
from .layers import TextureLayer
from .udim import FIRST, ROW


def tile_of(uv: NDArray[np.float64]) -> NDArray[np.int64]:
    """(F,) the tile in which the middle of each triangle lies, from 1001 on."""
    at = np.floor(uv.mean(axis=1)).astype(np.int64)
    return np.asarray(FIRST + at[:, 0] + ROW * at[:, 1], dtype=np.int64)


def split_tiles(
    uv: NDArray[np.float64], material: NDArray[np.int32], images: list[Any], layers: Mapping[str, TextureLayer]
) -> tuple[NDArray[np.float64], NDArray[np.int32], list[Any], dict[str, TextureLayer], list[int]]:
    """Makes each tile of a material a material of its own, whose UVs are from 0 to 1.

    Returns uv, material, images and layers, and the earlier material of each one.
    Raises InvalidInput where a face lies in a tile that its image does not have.
    """
    has_tiles = [any(isinstance(one, Mapping) for one in _shown(m, images, layers)) for m in range(len(images))]
    if not any(has_tiles):
        return uv, material, images, dict(layers), list(range(len(images)))
    for name, layer in layers.items():
        if layer.uv is not None and any(isinstance(image, Mapping) for image in layer.images):
            raise InvalidInput(f"layers[{name!r}] has tiles and UVs of its own; it must have those of the colours")
    uv, material = uv.copy(), material.copy()
    number, before = material.copy(), list[int]()
    tiles = list[int]()
    for m in range(len(images)):
        faces = np.flatnonzero(material == m)
        if not has_tiles[m]:
            number[faces] = len(before)
            before.append(m)
            tiles.append(0)
            continue
        of = tile_of(uv[faces])
        for tile in np.unique(of).tolist():
            here = faces[of == tile]
            if isinstance(images[m], Mapping) and tile not in images[m]:
                there = ", ".join(map(str, sorted(images[m])))
                raise InvalidInput(f"face {here[0]} lies in the UDIM tile {tile}, but its image has only {there}")
            uv[here] -= ((tile - FIRST) % ROW, (tile - FIRST) // ROW)
            number[here] = len(before)
            before.append(m)
            tiles.append(tile)
        if not len(of):  # a material without faces
            before.append(m)
            tiles.append(FIRST)

    def pick(all_images: Any) -> list[Any]:
        chosen = []
        for m, tile in zip(before, tiles, strict=True):
            image = all_images[m]
            chosen.append(image.get(tile) if isinstance(image, Mapping) else image)
        return chosen

    made = {name: replace(layer, images=pick(layer.images)) for name, layer in layers.items()}
    return uv, number, pick(images), made, before


def _shown(m: int, images: list[Any], layers: Mapping[str, TextureLayer]) -> list[Any]:
    return [images[m], *(layer.images[m] for layer in layers.values() if m < len(layer.images))]
