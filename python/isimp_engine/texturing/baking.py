"""The scan's texture put on its polygons."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import (
    InvalidInput,
    Job,
    Mesh,
    Partition,
    PolygonMesh,
    TextureOptions,
    _bake,
    _height,
    _occlusion,
    _source_corners,
    _unwrap,
)
from .layers import NEUTRAL, NORMAL, NUMBERS, TextureLayer, constant
from .soup import TexturedSoup

FINER = 1.0  # texels of the result per pixel of the scan's images, at least; sizes are powers of two, so 1.4 on average


@dataclass(frozen=True, eq=False)
class Texture:
    """UVs and images of polygons. `uv, image = texture(...)` takes the first two.

    uv: (L, 2) float64: of each corner in `loops`, from 0 to 1; v = 1 is the upper edge of the image.
    image: (H, W, 4) uint8, row 0 at the top. normal: (H, W, 3) uint8 tangent-space normals (green up), None if not
    asked for: they are right where all corners of a polygon have its `polygon_normal` and `polygon_tangent`.
    layers: further images that the scan's materials have, or that were asked for: (H, W) uint8 "roughness", "metallic"
    and "occlusion", (H, W) uint16 "height", (H, W, 3) uint8 "emission", stored as colours are. factors: "roughness" and
    "metallic" where they are one number everywhere, what the image of "emission" is multiplied by, and the range of
    "height": the scan lies (value / 65535 - 0.5) * range above the polygon, in scene units.
    """

    uv: NDArray[np.float64]
    image: NDArray[np.uint8] = field(repr=False)
    normal: NDArray[np.uint8] | None = field(repr=False)
    polygon_normal: NDArray[np.float64] = field(repr=False)  #: (Q, 3)
    polygon_tangent: NDArray[np.float64] = field(repr=False)  #: (Q, 3) the direction of u
    report: dict[str, Any]
    layers: dict[str, NDArray[Any]] = field(default_factory=dict, repr=False)
    factors: dict[str, float] = field(default_factory=dict)

    def __iter__(self) -> Iterator[Any]:
        yield self.uv
        yield self.image


def texture(
    mesh: Mesh,
    part: Partition,
    poly: PolygonMesh,
    source: TexturedSoup,
    options: TextureOptions | None = None,
    job: Job | None = None,
) -> Texture:
    """Lay the polygons out in an image, and show the scan there.

    source: what the mesh was made from: `clean(source.vertices, source.triangles)`.
    The report: `size`, `charts`, `fill` (area of the polygons over that of the image), `texels_per_unit` and
    `source_texels_per_unit` (of the result and of the scan, per scene unit), `gutter`, `texels` (in polygons),
    `searched` (of them those that show the closest face, since none lies above or below), `unknown` (those that show
    the mean colour), `turned_faces` (faces that repairs changed), `lost_faces` (those without a place on the scan),
    `layers` (the names of further images) and, with a height map, `height_range` (see `Texture.factors`).
    Raises InvalidInput (the source is not the mesh's, or shows nothing; charts do not fit into the size) or Cancelled.
    """
    options = options or TextureOptions()
    if not source.has_texture:
        raise InvalidInput("the scan has neither an image nor colours to make a texture of")
    face, weight, turned, lost = _source_corners(mesh, source.vertices, source.triangles, job)
    look = _look(source, face, weight)
    density = _density(mesh, look)
    atlas = _unwrap(poly, options, FINER * density, job)
    wanted, factors = _wanted(source)
    shown = [_layer(source, name, face, weight, look.uv) for name in wanted]
    relief = None
    if options.normals and NORMAL in source.layers:
        relief = _layer(source, NORMAL, face, weight, look.uv)
    image, normal, images, counts = _bake(
        mesh,
        part,
        poly,
        atlas,
        look.uv,
        look.image,
        look.colors,
        look.known,
        look.pictures,
        shown,
        relief,
        options,
        job,
    )
    layers: dict[str, NDArray[Any]] = {
        n: np.ascontiguousarray(i[:, :, :3] if n == "emission" else i[:, :, 0])
        for n, i in zip(wanted, images, strict=True)
    }
    if options.height:
        layers["height"], factors["height"] = _height(mesh, part, poly, atlas, options, job)
    if options.occlusion:  # in place of that of the scan's materials
        layers["occlusion"] = _occlusion(mesh, part, poly, atlas, options, job)
    report = {"size": atlas.side, "charts": atlas.chart_count, "fill": atlas.fill, "gutter": atlas.gutter}
    report |= {"texels_per_unit": atlas.scale, "source_texels_per_unit": density} | counts
    report |= {"turned_faces": turned, "lost_faces": lost, "layers": list(layers)}
    if options.height:
        report["height_range"] = factors["height"]
    return Texture(atlas.uv, image, normal, atlas.normal, atlas.tangent, report, layers, factors)


@dataclass(frozen=True)
class _Look:
    """What each face of the mesh shows, as the engine takes it."""

    uv: NDArray[np.float32]  # (F, 3, 2)
    image: NDArray[np.int32]  # (F,) of `pictures`; -1: colours
    colors: NDArray[np.uint8]  # (F, 3, 4), or of no length
    known: NDArray[np.uint8]  # (F,)
    pictures: list[Any]


def _wanted(source: TexturedSoup) -> tuple[list[str], dict[str, float]]:
    """The layers that get an image, and the numbers of those that do not."""
    names, factors = [], {}
    used = np.unique(source.material)
    for name, layer in source.layers.items():
        if name == NORMAL:
            continue
        single = constant(name, layer, used)
        if single is not None and (name in NUMBERS or single == NEUTRAL[name]):
            factors[name] = single
            continue
        names.append(name)
        if name == "emission":
            factors[name] = layer.strength
    return names, factors


def _layer(
    source: TexturedSoup, name: str, face: NDArray[np.int32], weight: NDArray[np.float32], uv: NDArray[np.float32]
) -> tuple[NDArray[np.float32], NDArray[np.int32], list[Any]]:
    """What each face of the mesh shows of a layer: UVs, image and images. Materials that do not say are neutral."""
    layer: TextureLayer = source.layers[name]
    at = np.maximum(face, 0)
    if layer.uv is not None:
        uv = np.ascontiguousarray(np.einsum("fkc,fcd->fkd", _shares(weight), layer.uv[at]).astype(np.float32))
    pictures = [np.ascontiguousarray(image) for image in layer.images if image is not None]
    none = -1
    if name != NORMAL:
        none = len(pictures)
        pictures.append(np.full((1, 1, 4), round(255 * NEUTRAL[name]), dtype=np.uint8))
    number = np.full(len(layer.images) + 1, none, dtype=np.int32)
    given = [i for i, image in enumerate(layer.images) if image is not None]
    number[given] = np.arange(len(given), dtype=np.int32)
    image = number[source.material[at]]
    image[face < 0] = none
    return uv, image, pictures


def _shares(weight: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.stack([1 - weight[:, :, 0] - weight[:, :, 1], weight[:, :, 0], weight[:, :, 1]], axis=2)


def _look(source: TexturedSoup, face: NDArray[np.int32], weight: NDArray[np.float32]) -> _Look:
    share, at = _shares(weight), np.maximum(face, 0)
    uv = np.einsum("fkc,fcd->fkd", share, source.uv[at]).astype(np.float32)
    pictures = [image for image in source.images if image is not None]
    number = np.full(len(source.images) + 1, -1, dtype=np.int32)  # the last one: no material
    shown = [i for i, image in enumerate(source.images) if image is not None]
    number[shown] = np.arange(len(shown), dtype=np.int32)
    image = number[source.material[at]]
    image[face < 0] = -1
    colors = np.zeros((0, 3, 4), dtype=np.uint8)
    if source.colors is not None:
        colors = np.round(np.einsum("fkc,fcd->fkd", share, source.colors[at].astype(np.float32))).astype(np.uint8)
    known = (face >= 0) & ((image >= 0) | (source.colors is not None))
    pictures = [np.ascontiguousarray(picture) for picture in pictures]
    return _Look(np.ascontiguousarray(uv), image.astype(np.int32), colors, known.astype(np.uint8), pictures)


def _density(mesh: Mesh, look: _Look) -> float:
    """Pixels of the scan's images per scene unit; a pixel for each vertex where it has colours only."""
    corners = mesh.vertices[mesh.triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    pixels, shown = 0.0, 0.0
    if look.pictures:
        size = np.array([p.shape[1::-1] for p in look.pictures], dtype=np.float64)
        with_image = look.image >= 0
        q = look.uv[with_image] * size[look.image[with_image]][:, None]
        d, e = q[:, 1] - q[:, 0], q[:, 2] - q[:, 0]
        covered = np.abs(d[:, 0] * e[:, 1] - d[:, 1] * e[:, 0]) / 2
        large = np.prod(size, axis=1)[look.image[with_image]] > 1  # a single pixel is a colour
        pixels = float(np.nansum(covered[large]))
        shown = float(area[with_image][large].sum())
    if pixels > 0 and shown > 0:
        return float(np.sqrt(pixels / shown))
    return float(np.sqrt(len(mesh.vertices) / max(float(area.sum()), 1e-300)))
