"""The sizes of a machine part: distances of planes and axes, diameters, angles, each with its uncertainty."""

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import Mesh, Partition
from .planes import is_held

SIZE_COLUMNS = ("name", "kind", "of", "to", "value", "uncertainty")
SNAPPED_COLUMNS = (*SIZE_COLUMNS, "measured", "snapped")

SURE = 3.0  #: standard deviations of an uncertainty
CLEAR = 10.0  #: a step is at least this many times the uncertainty of a size that moves to a multiple of it
ANGLE = 5.0  #: degrees, the step of angles
EXACT = 1e-9  #: difference of two unit vectors that are one direction; as a share of the diagonal, also of two offsets

LEAST = 6  #: vertices of a region or round part that has sizes

_MOST = 64  # regions, the largest
_BLOCKS, _WIDTH = 4, 0.87  # blocks along each side of a region, and the width of one, in deviations of its vertices
_PARALLEL = np.radians(1.0)  # planes with a larger angle between them have no distance
_WHOLE = 1e-6  # difference from a multiple, as a share of the step

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Planes:
    """The planes of regions by the vertices whose faces are all in the region: edges are rounded in most scans."""

    count: Array  #: (R,) vertices
    mean: Array  #: (R, 3), relative to the mesh's origin
    best: Array  #: (R, 3) normals of best fit, as the faces of the region face
    normal: Array  #: (R, 3) normals in the model: given by held planes, else of best fit
    offset: Array  #: (R,) in the model: normal * x = offset
    spread: Array  #: (R, 3, 3) covariance of the vertices
    noise: Array  #: (R,) root mean square distance of the vertices from the plane, as if they were independent
    held: NDArray[np.uint8]  #: (R,) Partition.region_held

    def turn(self, region: int, along: Array) -> float:
        """The variance of the angle of a plane of best fit, as it tips in a direction in it."""
        width = along @ self.spread[region] @ along
        return float(self.noise[region] ** 2 / self.count[region] / width) if width > 0 else np.inf

    def foot(self, region: int) -> Array:
        """(3,) the middle of the vertices on the plane of the model."""
        mean, normal = self.mean[region], self.normal[region]
        found: Array = mean + (self.offset[region] - normal @ mean) * normal
        return found

    def shift(self, region: int) -> float:
        """The variance of the place of a plane at its middle."""
        return float(self.noise[region] ** 2 / self.count[region])


@dataclass(frozen=True)
class Round:
    """A cylinder or sphere by the vertices inside its cells."""

    patch: Any  #: a CurvedProxy
    point: Array  #: (3,) on its axis in the model, relative to the mesh's origin
    best: Array  #: (3,) the same by the vertices
    radius: float  #: by the vertices
    spread: Array | None  #: (4, 4) covariance of the radius and the point; None: too few vertices

    @property
    def axis(self) -> Array:
        return np.asarray(self.patch["axis"], np.float64)

    @property
    def has_axis(self) -> bool:
        return bool(self.patch["kind"] == "cylinder" and self.patch["full"])

    def shift(self, along: Array) -> float:
        """The variance of the place of the axis along a direction."""
        return np.inf if self.spread is None else float(along @ self.spread[1:, 1:] @ along)


class Measured:
    """The planes and round parts of a partition by the scan's vertices."""

    def __init__(self, mesh: Mesh, part: Partition) -> None:
        self._label, self._triangles = np.asarray(part.face_region), np.asarray(mesh.triangles)
        places = np.asarray(mesh.vertices, np.float64) - np.asarray(mesh.origin, np.float64)
        self._region = _regions_of_vertices(self._label, self._triangles, len(places))
        deep = _regions_of_vertices(_of_faces(self._region, self._triangles), self._triangles, len(places))
        self.planes = _planes(mesh, part, _deeper(self._region, deep), places)
        cells = {cell for patch in part.curved for cell in patch["regions"]}
        order = np.argsort(-self.planes.count, kind="stable").tolist()
        self.flat = [r for r in order if self.planes.count[r] > 0 and r not in cells]  #: regions, the largest first
        self.large = [r for r in self.flat if self.planes.count[r] >= LEAST][:_MOST]  #: regions that have sizes
        self.round = self._round_parts(part, places, np.asarray(mesh.origin, np.float64))

    def _round_parts(self, part: Partition, places: Array, origin: Array) -> list[Round]:
        patches = [patch for patch in part.curved if patch["kind"] in ("cylinder", "sphere")]
        if not patches:
            return []
        number = np.full(part.region_count + 1, -1, np.int32)  # the last one is for faces without a region
        for k, patch in enumerate(patches):
            number[patch["regions"]] = k
        inner = _regions_of_vertices(number[self._label], self._triangles, len(places))
        within = _of_faces(inner, self._triangles)
        return [
            _round(patch, places[inner == k], places[self._triangles[within == k]], origin)
            for k, patch in enumerate(patches)
        ]

    @cached_property
    def touching(self) -> set[tuple[int, int]]:
        """Pairs of large regions with a common edge, the lower number first."""
        at_border = sum(self._region[corners] < 0 for corners in self._triangles.T) > 1
        pairs, _ = borders(self._label[at_border], self._triangles[at_border])
        return set(map(tuple, np.unique(pairs, axis=0).tolist())) & set(combinations(sorted(self.large), 2))


def size_rows(mesh: Mesh, part: Partition, step: float | None = None) -> list[dict[str, Any]]:
    """One row for each size of the largest regions and of the round parts; keys: SIZE_COLUMNS.

    kind: "distance" of two parallel regions, at the centre of the smaller; "angle" between the normals of two adjacent
    regions that are not parallel, degrees; "diameter" of a cylinder or sphere; "axis" from the axis of a full cylinder
    to a region along it; "axes" between two of these. of, to: numbers of regions; `of` of the last three kinds, and
    `to` of the last, is the number of a round part, and a diameter has no `to`. name: in the order of the kinds, as
    "3-7", "3/7", "D1", "D1-7", "D1-D2". uncertainty: three standard deviations, from the distances of the scan's
    vertices; it does not have the errors of the scanner's scale. Lengths are scene units.
    step: that the sizes were snapped to (see `snap_sizes`). Then the keys are SNAPPED_COLUMNS: `value` is that of the
    model, `measured` that of the scan, and `snapped` is "yes", or the reason why the size is no multiple.
    Cost: O(F).
    """
    measured = Measured(mesh, part)
    planes, large = measured.planes, measured.large
    facing = planes.normal[large]
    is_parallel = np.triu(np.abs(facing @ facing.T) > np.cos(_PARALLEL), 1)
    parallel = [(large[a], large[b]) for a, b in np.argwhere(is_parallel).tolist()]
    rows = [_distance(planes, a, b) for a, b in parallel]
    slanted = measured.touching - {(min(pair), max(pair)) for pair in parallel}
    rows += [_angle(planes, a, b) for a, b in sorted(slanted)]
    rows += [_diameter(each) for each in measured.round]
    axes = [each for each in measured.round if each.has_axis]
    rows += [
        _to_plane(each, planes, r)
        for each in axes
        for r in large
        if abs(planes.normal[r] @ each.axis) < np.sin(_PARALLEL)
    ]
    rows += [_between(a, b) for a, b in combinations(axes, 2) if abs(a.axis @ b.axis) > np.cos(_PARALLEL)]
    if step is None:
        return [{key: row[key] for key in SIZE_COLUMNS} for row in rows]
    rows = [row | {"value": row["model"], "uncertainty": row["sure"]} for row in rows]
    return [{key: row[key] for key in SNAPPED_COLUMNS[:-1]} | {"snapped": _snapped(row, step)} for row in rows]


def _snapped(row: dict[str, Any], step: float) -> str:
    """Whether the size of the model is a multiple, and if not, why."""
    step, sure = ANGLE if row["kind"] == "angle" else step, row["uncertainty"]
    off = {key: abs(row[key] - step * np.round(row[key] / step)) for key in ("value", "measured")}
    if off["value"] <= _WHOLE * step:
        return "yes"
    if sure is None or CLEAR * sure > step:
        return "its uncertainty is too large for the step"
    return "no multiple is near" if off["measured"] > sure else "others do not allow it"


def _regions_of_vertices(label: NDArray[np.int32], triangles: NDArray[np.int32], count: int) -> NDArray[np.int64]:
    """The region of all faces at a vertex; -1: of several, or none."""
    region = np.full(count, -1, np.int64)
    for corners in triangles.T:
        region[corners] = label
    for corners in triangles.T:
        region[corners[region[corners] != label]] = -1
    return region


def _of_faces(region: NDArray[np.int64], triangles: NDArray[np.int32]) -> NDArray[np.int32]:
    """(F,) the region of all three corners of a face; -1: of several, or none."""
    a, b, c = (region[corners] for corners in triangles.T)
    return np.where((a == b) & (b == c), a, -1).astype(np.int32)


def _deeper(region: NDArray[np.int64], deep: NDArray[np.int64]) -> NDArray[np.int64]:
    """The regions of vertices without the ones next to the border, where three quarters of a region's stay."""
    counts = [np.bincount(of[of >= 0], minlength=int(region.max(initial=-1)) + 1) for of in (region, deep)]
    keeps = np.append(4 * counts[1] < 3 * counts[0], False)
    return np.where(keeps[region], region, deep)


def _planes(mesh: Mesh, part: Partition, region: NDArray[np.int64], places: Array) -> Planes:
    regions, of, x = part.region_count, region[region >= 0], places[region >= 0]
    count = np.bincount(of, minlength=regions).astype(np.float64)
    some = np.maximum(count, 1)
    mean = np.stack([np.bincount(of, x[:, k], regions) for k in range(3)], axis=1) / some[:, None]
    off = x - mean[of]
    sums = [[np.bincount(of, off[:, i] * off[:, k], regions) for k in range(3)] for i in range(3)]
    spread = np.moveaxis(np.array(sums), 2, 0) / some[:, None, None]
    facing = np.asarray(part.region_normal, np.float64)
    frame = np.linalg.eigh(spread)[1]
    best = frame[:, :, 0]
    best = best * np.where((best * facing).sum(axis=1) < 0, -1.0, 1.0)[:, None]
    held = np.asarray(part.region_held) if len(part.region_held) else np.zeros(regions, np.uint8)
    held = np.where(is_held(held), held, 0).astype(np.uint8)
    normal = np.where(held[:, None] > 0, facing, best)
    offset = (normal * mean).sum(axis=1)
    if held.any():
        given = np.asarray(part.region_offset) - facing @ np.asarray(mesh.origin, np.float64)
        offset = np.where(held > 0, given, offset)
    square = np.einsum("ri,rij,rj->r", normal, spread, normal).clip(0) * some / np.maximum(some - 3, 1)
    usual = float((square * count).sum() / max(count.sum(), 1))
    in_blocks = _in_blocks(of, np.einsum("vk,vkj->vj", off, frame[of]), spread, count)
    square = np.maximum.reduce([square, np.full(regions, usual), in_blocks])
    return Planes(count, mean, best, normal, offset, spread, np.sqrt(square), held)


def _in_blocks(of: NDArray[np.int64], at: Array, spread: Array, count: Array) -> Array:
    """(R,) the variance of one vertex that explains the variance of the means of blocks of a region.

    Errors of neighbours are not independent: surfaces are wavy, scanners smooth, and at borders the vertices that lie
    off the plane are in other regions. at: (V, 3) across the plane and along it, from its middle.
    """
    wide = np.sqrt(np.maximum(np.linalg.eigvalsh(spread)[:, 1:], 1e-300))[of]
    place = np.clip(np.floor(at[:, 1:] / (_WIDTH * wide)) + _BLOCKS / 2, 0, _BLOCKS - 1).astype(np.int64)
    block = (of * _BLOCKS + place[:, 0]) * _BLOCKS + place[:, 1]
    size = len(count) * _BLOCKS**2
    sums = np.bincount(block, at[:, 0], size).reshape(len(count), -1)
    blocks = np.maximum((np.bincount(block, minlength=size).reshape(sums.shape) > 0).sum(axis=1), 2)
    found: Array = (sums**2).sum(axis=1) / np.maximum(count, 1) * blocks / (blocks - 1)
    return found


def _round(patch: Any, vertices: Array, faces: Array, origin: Array) -> Round:
    """By one step of Gauss and Newton from the patch: radius and point that fit vertices best together.

    The middles of faces lie nearer to the axis where meshes are coarse. The radius is between both, and uncertain by
    half of the difference too. faces: (F, 3, 3) corners.
    """
    point = np.asarray(patch["point"], np.float64) - origin

    def away(of: Array) -> Array:
        off: Array = of - point
        return off - np.outer(off @ np.asarray(patch["axis"]), patch["axis"]) if patch["kind"] == "cylinder" else off

    off = away(vertices)
    far = np.linalg.norm(off, axis=1)
    if len(far) <= LEAST:
        return Round(patch, point, point, patch["radius"], None)
    moves = np.column_stack([np.ones(len(far)), off / far[:, None]])
    inverse = np.linalg.pinv(moves.T @ moves, hermitian=True)
    step = inverse @ (moves.T @ (far - patch["radius"]))
    radius, half = float(patch["radius"] + step[0]), 0.0
    spread = float(np.mean((far - patch["radius"] - moves @ step) ** 2)) * inverse
    if len(faces):
        area = np.linalg.norm(np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0]), axis=1) + 1e-300
        middle = np.linalg.norm(away(faces.mean(axis=1)) - step[1:], axis=1)
        half = (float(np.average(middle, weights=area)) - radius) / 2
        spread[0, 0] += (half / SURE) ** 2
    return Round(patch, point, point + step[1:], radius + half, spread)


def _distance(planes: Planes, a: int, b: int) -> dict[str, Any]:
    """The distance of region b, the smaller, from the plane of a."""
    way = planes.mean[b] - planes.mean[a]
    value, variance = planes.normal[a] @ way, planes.shift(a) + planes.shift(b)
    beside = way - value * planes.normal[a]
    length = float(np.linalg.norm(beside))
    if length > 0 and not planes.held[a]:
        variance += length**2 * planes.turn(a, beside / length)
    model = value
    if planes.held[a] and planes.held[b] and np.linalg.norm(np.cross(planes.normal[a], planes.normal[b])) <= EXACT:
        model = planes.offset[b] * np.sign(planes.normal[a] @ planes.normal[b]) - planes.offset[a]
    return _row(f"{a}-{b}", ("distance", a, b), abs(value), variance, abs(model))


def _angle(planes: Planes, a: int, b: int) -> dict[str, Any]:
    """By held normals, which have no uncertainty, and by the best ones."""
    value, edge = _between_normals(planes.normal[a], planes.normal[b])
    variance = sum(planes.turn(r, np.cross(planes.normal[r], edge)) for r in (a, b) if not planes.held[r])
    row = _row(f"{a}/{b}", ("angle", a, b), value, np.degrees(1.0) ** 2 * variance, value)
    measured, edge = _between_normals(planes.best[a], planes.best[b])
    variance = sum(planes.turn(r, np.cross(planes.best[r], edge)) for r in (a, b))
    return row | {"measured": measured, "sure": _sure(np.degrees(1.0) ** 2 * variance)}


def _between_normals(a: Array, b: Array) -> tuple[float, Array]:
    """The angle, degrees, and the unit direction of the edge."""
    edge = np.cross(a, b)
    length = float(np.linalg.norm(edge))
    return float(np.degrees(np.arctan2(length, a @ b))), edge / length


def _diameter(each: Round) -> dict[str, Any]:
    variance = np.inf if each.spread is None else each.spread[0, 0]
    number, value = each.patch["number"], 2 * each.patch["radius"]
    return _row(f"D{number}", ("diameter", number, None), value, 4 * variance, value, 2 * each.radius)


def _to_plane(each: Round, planes: Planes, r: int) -> dict[str, Any]:
    """From an axis to region r."""
    normal, number = planes.normal[r], each.patch["number"]
    measured = abs(normal @ (planes.mean[r] - each.best))
    model = abs(planes.offset[r] - normal @ each.point) if planes.held[r] else measured
    variance = planes.shift(r) + each.shift(normal)
    return _row(f"D{number}-{r}", ("axis", number, r), measured, variance, model)


def _between(a: Round, b: Round) -> dict[str, Any]:
    """Between two parallel axes."""

    def far(way: Array) -> tuple[float, Array]:
        beside = way - (way @ a.axis) * a.axis
        length = float(np.linalg.norm(beside))
        return length, beside / length if length > 0 else beside

    measured, along = far(b.best - a.best)
    variance = a.shift(along) + b.shift(along)
    names = a.patch["number"], b.patch["number"]
    return _row("D{}-D{}".format(*names), ("axes", *names), measured, variance, far(b.point - a.point)[0])


def _row(
    name: str,
    of: tuple[str, int, int | None],
    value: float,
    variance: float,
    model: float,
    measured: float | None = None,
) -> dict[str, Any]:
    """measured: the value itself if it is None."""
    sure = _sure(variance)
    own = dict(zip(SIZE_COLUMNS, (name, *of, float(value), sure), strict=True))
    return own | {"model": float(model), "measured": float(value if measured is None else measured), "sure": sure}


def _sure(variance: float) -> float | None:
    return float(SURE * np.sqrt(variance)) if np.isfinite(variance) else None


def borders(label: NDArray[np.int32], triangles: NDArray[np.int32]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(E, 2) the regions at each edge between two, the lower number first, and (E, 2) its vertices."""
    edges = np.sort(np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1).astype(np.int64)
    key = edges[:, 0] * (int(triangles.max(initial=0)) + 1) + edges[:, 1]
    order = np.argsort(key, kind="stable")
    of = np.tile(label, 3)[order].astype(np.int64)
    pairs = np.sort(np.stack([of[1:], of[:-1]], axis=1), axis=1)
    found = (key[order][1:] == key[order][:-1]) & (pairs[:, 0] != pairs[:, 1]) & (pairs[:, 0] >= 0)
    return pairs[found], edges[order][1:][found]
