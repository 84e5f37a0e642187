"""The scan's texture put on its polygons."""

from collections.abc import Iterator, Sequence
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
    _Atlas,
    _bake,
    _occlusion,
    _source_corners,
    _unwrap,
    _uv,
)
from ..surfaces import areas
from .layers import NEUTRAL, NORMAL, NUMBERS, TextureLayer, constant
from .soup import TexturedSoup

FINER = 1.0  # texels of the result per pixel of the scan's images, at least; sizes are powers of two, so 1.4 on average


@dataclass(frozen=True, eq=False)
class Texture:
    """UVs and images of polygons. `uv, image = texture(...)` takes the first two.

    uv: (L, 2) float64: of each corner in `loops`, from 0 to 1; v = 1 is the upper edge of the image.
    image: (H, W, 4) uint8, row 0 at the top. normal: (H, W, 3) uint8 tangent-space normals (green up), None if not
    requested: they are right if all corners of a polygon have its `polygon_normal` and `polygon_tangent`.
    layers: further images that the scan's materials have, or that were requested: (H, W) uint8 "roughness", "metallic"
    and "occlusion", (H, W, 3) uint8 "emission", stored as colours are. factors: "roughness" and "metallic" where they
    are one number everywhere, and the factor of the image of "emission".
    With several tiles all images have one more axis in front, (N, H, W, ...). tile: (Q,) int32, the tile of each
    polygon; its UVs are from 0 to 1 there. tile_material: the source's material of each tile, -1 for none, or if
    materials are not kept apart.
    """

    uv: NDArray[np.float64]
    image: NDArray[np.uint8] = field(repr=False)
    normal: NDArray[np.uint8] | None = field(repr=False)
    polygon_normal: NDArray[np.float64] = field(repr=False)  #: (Q, 3)
    polygon_tangent: NDArray[np.float64] = field(repr=False)  #: (Q, 3) the direction of u
    report: dict[str, Any]
    layers: dict[str, NDArray[Any]] = field(default_factory=dict, repr=False)
    factors: dict[str, float] = field(default_factory=dict)
    tile: NDArray[np.int32] | None = field(default=None, repr=False)
    tile_material: tuple[int, ...] = (-1,)
    tile_name: tuple[str, ...] = ("",)  #: the name of that material

    @property
    def materials_apart(self) -> bool:
        """Whether the source's materials have tiles of their own."""
        return int(self.report["materials"]) > 0

    def __iter__(self) -> Iterator[Any]:
        yield self.uv
        yield self.image


def texture(
    mesh: Mesh,
    part: Partition,
    poly: PolygonMesh,
    source: TexturedSoup,
    options: TextureOptions | None = None,
    *,
    job: Job | None = None,
) -> Texture:
    """Lay the polygons out in an image, and show the scan there.

    source: the input of the mesh: `clean(source.vertices, source.triangles)`.
    The report: `size`, `tiles`, `materials` (how many are kept apart, 0: none are), `charts`, `fill` (area of the
    polygons over that of the image), `texels_per_unit` and `source_texels_per_unit` (of the result and of the scan, per
    scene unit), `gutter`, `texels` (in polygons), `searched` (texels that show the closest face, since none lies above
    or below), `unknown` (texels that show the mean colour), `turned_faces` (faces that repairs changed), `lost_faces`
    (faces without a place on the scan) and `layers` (the names of further images).
    Raises InvalidInput (the source is not the mesh's, or shows nothing; charts do not fit into the size) or Cancelled.
    """
    options = options or TextureOptions()
    if not source.has_texture:
        raise InvalidInput("the scan has neither an image nor colours to make a texture of")
    face, weight, turned, lost = _source_corners(mesh, source.vertices, source.triangles, job)
    look = _look(source, face, weight)
    density = _density(mesh, look)
    group, tile_materials = _groups(mesh, part, poly, source, face) if options.materials else (_NO_GROUP, [-1])
    atlas = _unwrap(poly, options, FINER * density, group, job)
    wanted, factors = _wanted(source)
    shown = [_layer(source, name, face, weight, look.uv) for name in wanted]
    relief = None
    if options.normals and NORMAL in source.layers:
        relief = _layer(source, NORMAL, face, weight, look.uv)
    args = ((look.uv, look.image, look.colors, look.known), look.pictures, shown, relief)
    color, normal, images, texels = _bake(mesh, part, poly, atlas, *args, options, job)
    layers: dict[str, NDArray[Any]] = {
        n: np.ascontiguousarray(i[:, :, :3] if n == "emission" else i[:, :, 0])
        for n, i in zip(wanted, images, strict=True)
    }
    if options.occlusion:  # in place of that of the scan's materials
        layers["occlusion"] = _occlusion(mesh, part, poly, atlas, options, job)
    report: dict[str, Any] = {"size": atlas.side, "tiles": atlas.tiles, "charts": atlas.chart_count, "fill": atlas.fill}
    report |= {"materials": len(tile_materials) if options.materials else 0}
    report |= {"gutter": atlas.gutter, "texels_per_unit": atlas.scale, "source_texels_per_unit": density}
    report |= dict(zip(("texels", "searched", "unknown"), texels.sum(axis=0).tolist(), strict=True))
    report |= {"turned_faces": turned, "lost_faces": lost, "layers": list(layers)}
    return Texture(
        _uv(poly, atlas),
        _tiles(color, atlas),
        None if normal is None else _tiles(normal, atlas),
        atlas.normal,
        atlas.tangent,
        report,
        {name: _tiles(image, atlas) for name, image in layers.items()},
        factors,
        np.array(atlas.tile),
        tuple(tile_materials[g] for g in atlas.tile_group.tolist()),
        tuple(source.material_name(tile_materials[g]) for g in atlas.tile_group.tolist()),
    )


_NO_GROUP = np.zeros(0, dtype=np.int32)


def _tiles(image: NDArray[Any], atlas: _Atlas) -> NDArray[Any]:
    """Images with the last tile at the top as (N, H, W, ...); a single tile as it is."""
    if atlas.tiles == 1:
        return image
    return image.reshape(atlas.tiles, atlas.side, *image.shape[1:])[::-1]


def _groups(
    mesh: Mesh, part: Partition, poly: PolygonMesh, source: TexturedSoup, face: NDArray[np.int32]
) -> tuple[NDArray[np.int32], list[int]]:
    """(Q,) the material of each polygon, by most of its region's area, as an index into the returned list."""
    area = areas(mesh.vertices, mesh.triangles)
    counts = (face >= 0) & (part.face_region >= 0)
    given = np.append(np.asarray(source.given, dtype=np.int64), -1)  # the last one: no material
    count = int(given.max()) + 2
    material = given[source.material[face[counts]]] % count
    keys = part.face_region[counts].astype(np.int64) * count + material
    votes = np.bincount(keys, area[counts], part.region_count * count).reshape(-1, count)
    chosen = votes.argmax(axis=1)[poly.polygon_region]
    materials, group = np.unique(chosen, return_inverse=True)
    return group.astype(np.int32), [-1 if m == count - 1 else m for m in materials.tolist()]


@dataclass(frozen=True)
class _Look:
    """The appearance of each face of the mesh, in the engine's form."""

    uv: NDArray[np.float32]  # (F, 3, 2)
    image: NDArray[np.int32]  # (F,) of `pictures`; -1: colours
    colors: NDArray[np.uint8]  # (F, 3, 4), or of no length
    known: NDArray[np.uint8]  # (F,)
    pictures: list[Any]


def _wanted(source: TexturedSoup) -> tuple[list[str], dict[str, float]]:
    """The layers that get an image, and the numbers of the other layers."""
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
    """The appearance of each face of the mesh in a layer: UVs, image and images. Materials without it are neutral."""
    layer: TextureLayer = source.layers[name]
    at = np.maximum(face, 0)
    if layer.uv is not None:
        uv = np.ascontiguousarray(_carried(layer.uv, at, weight).astype(np.float32))
    number, *pictures = _distinct(layer.images)
    none = -1
    if name != NORMAL:
        none = len(pictures)
        pictures.append(np.full((1, 1, 4), round(255 * NEUTRAL[name]), dtype=np.uint8))
    image = np.where(number < 0, np.int32(none), number)[source.material[at]]
    image[face < 0] = none
    return uv, image, pictures


def _carried(values: NDArray[Any], face: NDArray[np.int32], weight: NDArray[np.float32]) -> NDArray[Any]:
    """(F, 3, n): values of a source's corners at the corners of the mesh's faces, most of which have its corners."""
    carried = values[face]
    other = np.flatnonzero((weight != _CORNERS).reshape(len(weight), -1).any(axis=1))
    w = weight[other]
    share = np.stack([1 - w[:, :, 0] - w[:, :, 1], w[:, :, 0], w[:, :, 1]], axis=2)
    carried[other] = np.einsum("fkc,fcd->fkd", share, carried[other])
    return carried


_CORNERS = np.array([[0, 0], [1, 0], [0, 1]], dtype=np.float32)


_FACES = 1 << 14  # at once, so that intermediate values stay in a cache


def _uv_areas(uv: NDArray[np.float32]) -> NDArray[np.float64]:
    """(F,) of the triangles in the UV map."""
    found = np.empty(len(uv))
    for begin in range(0, len(uv), _FACES):
        part = uv[begin : begin + _FACES].reshape(-1, 6).T
        u0, v0, u1, v1, u2, v2 = np.ascontiguousarray(part, dtype=np.float64)
        found[begin : begin + _FACES] = np.abs((u1 - u0) * (v2 - v0) - (v1 - v0) * (u2 - u0)) / 2
    return found


def _distinct(images: Sequence[Any]) -> tuple[Any, ...]:
    """The index of each image in the following arrays, -1 for none, with one more -1 at the end; and these arrays."""
    place: dict[int, int] = {}
    number = [-1 if image is None else place.setdefault(id(image), len(place)) for image in images]
    each = {id(image): image for image in images if image is not None}
    return np.array([*number, -1], dtype=np.int32), *map(np.ascontiguousarray, each.values())


def _look(source: TexturedSoup, face: NDArray[np.int32], weight: NDArray[np.float32]) -> _Look:
    at = np.maximum(face, 0)
    uv = _carried(source.uv, at, weight).astype(np.float32)
    number, *pictures = _distinct(source.images)
    image = number[source.material[at]]
    image[face < 0] = -1
    colors = np.zeros((0, 3, 4), dtype=np.uint8)
    if source.colors is not None:
        colors = np.round(_carried(source.colors.astype(np.float32), at, weight)).astype(np.uint8)
    known = (face >= 0) & ((image >= 0) | (source.colors is not None))
    return _Look(np.ascontiguousarray(uv), image.astype(np.int32), colors, known.astype(np.uint8), pictures)


def _density(mesh: Mesh, look: _Look) -> float:
    """Pixels of the scan's images per scene unit; a pixel for each vertex where it has colours only."""
    area = areas(mesh.vertices, mesh.triangles)
    pixels, shown = 0.0, 0.0
    if look.pictures:
        size = np.array([p.shape[1::-1] for p in look.pictures], dtype=np.float64)
        of = np.append(np.prod(size, axis=1), 0)[look.image]  # pixels of each face's image
        large = of > 1  # a single pixel is a colour
        pixels = float(np.nansum((_uv_areas(look.uv) * of)[large]))
        shown = float(area[large].sum())
    if pixels > 0 and shown > 0:
        return float(np.sqrt(pixels / shown))
    return float(np.sqrt(len(mesh.vertices) / max(float(area.sum()), 1e-300)))
