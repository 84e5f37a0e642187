"""Triangles with their materials and colours."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import InvalidInput
from .images import rgba
from .layers import LARGEST_UV, TextureLayer, checked
from .tiled_materials import split_tiles


@dataclass(frozen=True, eq=False)
class TexturedSoup:
    """Triangles of a scan with their UVs, images and colours.

    vertices: (V, 3) float64. triangles: (F, 3) int32: the input of `clean`.
    uv: (F, 3, 2) float64: of each corner; v = 1 is the upper edge of an image. None: zeros. UVs outside 0 to 1 repeat
    the image. (V, 2), one of each vertex, is accepted too. A face with a UV that is not finite shows no image.
    material: (F,) int32: the image of each face, -1 for none. None: 0 where there are images.
    images: of each material an array of (H, W), (H, W, 3) or (H, W, 4), uint8, uint16 or floating-point numbers from 0
    to 1, row 0 at the top, kept as (H, W, 4) uint8 or uint16; None for a material that shows the colours. The UDIM
    tiles of a material are a dict of such arrays by their numbers from 1001 on; each becomes a material of its own.
    colors: (F, 3, 4) uint8: RGBA of each corner. None: no colours. (V, 3 or 4), (F, 3 or 4) and (F, 3, 3) are accepted
    too.
    layers: further layers of the materials, by name: "roughness", "metallic", "emission", "occlusion" and "normal".
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]
    uv: NDArray[np.float64] = None  # type: ignore[assignment]  # set below
    material: NDArray[np.int32] = None  # type: ignore[assignment]
    images: Sequence[Any] = field(default=(), repr=False)
    colors: NDArray[np.uint8] | None = field(default=None, repr=False)
    names: Sequence[str] = ()  #: names of the materials in the file
    files: Sequence[Path] = ()  #: files that were read in addition to the scan's own: materials and images
    layers: Mapping[str, TextureLayer] = field(default_factory=dict, repr=False)
    #: the material that each one was before tiles became materials; `names` are of these
    given: Sequence[int] = field(default=(), init=False, repr=False)
    #: (F,) int32: of which polygon of a glTF file each triangle is a part (FB_ngon_encoding); None: of none
    polygon: NDArray[np.int32] | None = field(default=None, init=False, repr=False)

    def __post_init__(self) -> None:
        vertices, triangles = np.asarray(self.vertices), np.asarray(self.triangles)
        faces, images = len(triangles), list(self.images)
        if self.uv is None:
            uv = np.zeros((faces, 3, 2))
        else:
            uv = np.asarray(self.uv, dtype=np.float64)
            if uv.shape == (len(vertices), 2):
                uv = uv[triangles]
        if self.material is None:
            material = np.full(faces, 0 if images else -1, dtype=np.int32)
        else:
            material = np.asarray(self.material).astype(np.int32)
        if uv.shape != (faces, 3, 2):
            raise InvalidInput(f"uv must have the shape ({faces}, 3, 2), got {uv.shape}")
        if material.shape != (faces,):
            raise InvalidInput(f"material must have the shape ({faces},), got {material.shape}")
        if faces and (material.min() < -1 or material.max() >= len(images)):
            face = int(np.flatnonzero((material < -1) | (material >= len(images)))[0])
            raise InvalidInput(f"face {face} has material {material[face]}, but there are {len(images)} images")
        uv, material = _without_unknown(uv, material)
        for name, layer in self.layers.items():
            if len(layer.images) != len(images):
                there = f"there are {len(images)} materials"
                raise InvalidInput(f"layers[{name!r}] has {len(layer.images)} images, but {there}")
        uv, material, images, layers, given = split_tiles(uv, material, images, self.layers)
        images = [None if image is None else rgba(image, f"images[{i}]") for i, image in enumerate(images)]
        values: dict[str, Any] = {
            "vertices": vertices,
            "triangles": triangles,
            "uv": uv,
            "material": material,
            "images": images,
            "given": given,
        }
        values["colors"] = None if self.colors is None else corner_colors(self.colors, len(vertices), triangles)
        values["layers"] = checked(layers, faces)
        for name, value in values.items():
            object.__setattr__(self, name, value)

    @property
    def has_texture(self) -> bool:
        """Whether any face shows an image, or there are colours."""
        return self.colors is not None or any(self.images[m] is not None for m in np.unique(self.material) if m >= 0)

    def material_name(self, material: int) -> str:
        """The file's name of a material; its number if it has none, "" for -1."""
        if material < 0:
            return ""
        return self.names[material] if material < len(self.names) else str(material)


def _without_unknown(uv: NDArray[np.float64], material: NDArray[np.int32]) -> tuple[Any, Any]:
    """UVs that single precision can hold; faces that have others show no image."""
    unknown = np.logical_not((np.abs(uv) < LARGEST_UV).all(axis=(1, 2)))
    if not unknown.any():
        return uv, material
    return np.where(unknown[:, None, None], 0.0, uv), np.where(unknown, -1, material).astype(np.int32)


def corner_colors(colors: Any, vertices: int, triangles: NDArray[np.int32]) -> NDArray[np.uint8]:
    """Colours of vertices, faces or corners as RGBA of corners."""
    array, faces = np.asarray(colors), len(triangles)
    if np.issubdtype(array.dtype, np.floating):
        array = np.round(np.clip(np.nan_to_num(array), 0, 1) * 255).astype(np.uint8)
    elif array.dtype == np.uint16:
        array = (array // 257).astype(np.uint8)
    if array.dtype != np.uint8 or array.ndim not in (2, 3) or array.shape[-1] not in (3, 4):
        raise InvalidInput(f"colors must be (F, 3, 4) uint8, got {array.shape} {array.dtype}")
    if array.shape[-1] == 3:
        array = np.concatenate([array, np.full(array.shape[:-1] + (1,), 255, dtype=np.uint8)], axis=-1)
    if array.shape == (vertices, 4):
        array = array[triangles]
    elif array.shape == (faces, 4):
        array = np.repeat(array[:, None], 3, axis=1)
    if array.shape != (faces, 3, 4):
        raise InvalidInput(f"colors must have the shape ({faces}, 3, 4), got {array.shape}")
    return np.ascontiguousarray(array)


def corner_places(
    loops: NDArray[np.int32], loop_start: NDArray[np.int32], triangles: NDArray[np.int32], polygon: NDArray[np.int32]
) -> NDArray[np.int64]:
    """(F, 3): the place in `loops` of each corner of the triangles that the polygons were cut into."""
    start = np.append(loop_start, len(loops)).astype(np.int64)
    size = np.diff(start)
    places = start[polygon][:, None] + np.arange(3)
    for t in np.flatnonzero((size[polygon] != 3) | (loops[np.minimum(places, len(loops) - 1)] != triangles).any(1)):
        q = polygon[t]
        loop = loops[start[q] : start[q + 1]].tolist()
        places[t] = [start[q] + loop.index(v) for v in triangles[t]]
    return places
