"""The sizes of a machine part: distances of parallel planes, diameters and angles, each with its uncertainty."""

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core import Mesh, Partition

SIZE_COLUMNS = ("kind", "of", "to", "value", "uncertainty")

_MOST = 64  # regions, the largest
_PARALLEL = np.radians(1.0)  # planes with a larger angle between them have no distance
_LEAST = 6  # vertices of a region that has sizes


@dataclass(frozen=True)
class _Planes:
    """The planes of regions by the vertices whose faces are all in the region: edges are rounded in most scans."""

    count: NDArray[np.float64]  #: (R,) vertices
    mean: NDArray[np.float64]  #: (R, 3)
    normal: NDArray[np.float64]  #: (R, 3), as the faces of the region face
    spread: NDArray[np.float64]  #: (R, 3, 3) covariance of the vertices
    noise: NDArray[np.float64]  #: (R,) root mean square distance of the vertices from the plane
    held: NDArray[np.bool_]  #: (R,) the normal is that of a plane that was made regular

    def turn(self, region: int, along: NDArray[np.float64]) -> float:
        """The variance of the angle of a plane, as it tips in a direction in it."""
        if self.held[region]:
            return 0.0
        width = along @ self.spread[region] @ along
        return float(self.noise[region] ** 2 / self.count[region] / width) if width > 0 else np.inf


def size_rows(mesh: Mesh, part: Partition) -> list[dict[str, Any]]:
    """One row for each size of the largest regions and of the round parts; keys: SIZE_COLUMNS.

    kind: "distance" of two parallel regions, at the centre of the smaller; "angle" between the normals of two adjacent
    regions that are not parallel, degrees; "diameter" of a cylinder or sphere. of, to: numbers of regions; `of` of a
    diameter is the number of the round part, and `to` is None. uncertainty: two standard deviations, from the distances
    of the scan's vertices; it does not have the errors of the scanner's scale. Lengths are scene units.
    Cost: O(F).
    """
    label, triangles = np.asarray(part.face_region), np.asarray(mesh.triangles)
    places = np.asarray(mesh.vertices, np.float64) - np.asarray(mesh.origin, np.float64)
    region = _regions_of_vertices(label, triangles, len(places))
    planes = _planes(part, region, places)
    cells = {cell for patch in part.curved for cell in patch["regions"]}
    large = [r for r in np.argsort(-planes.count, kind="stable").tolist() if planes.count[r] >= _LEAST]
    large = [r for r in large if r not in cells][:_MOST]
    facing = planes.normal[large]
    is_parallel = np.triu(np.abs(facing @ facing.T) > np.cos(_PARALLEL), 1)
    parallel = [(large[a], large[b]) for a, b in np.argwhere(is_parallel).tolist()]
    rows = [_distance(planes, a, b) for a, b in parallel]
    at_border = (region[triangles] < 0).sum(axis=1) > 1
    touching = _touching(label[at_border], triangles[at_border]) & set(combinations(sorted(large), 2))
    rows += [_angle(planes, a, b) for a, b in sorted(touching - {(min(p), max(p)) for p in parallel})]
    rows += [_diameter(patch, places[np.isin(region, patch["regions"])], mesh) for patch in part.curved
             if patch["kind"] in ("cylinder", "sphere")]  # fmt: skip
    return rows


def _regions_of_vertices(label: NDArray[np.int32], triangles: NDArray[np.int32], count: int) -> NDArray[np.int64]:
    """The region of all faces at a vertex; -1: of several, or none."""
    corners, each = triangles.ravel(), np.repeat(label.astype(np.float64), 3)
    times, total = np.bincount(corners, minlength=count), np.bincount(corners, each, count)
    same = times * np.bincount(corners, each * each, count) == total * total
    return np.where(same & (times > 0), np.round(total / np.maximum(times, 1)), -1).astype(np.int64)


def _planes(part: Partition, region: NDArray[np.int64], places: NDArray[np.float64]) -> _Planes:
    regions, of, x = part.region_count, region[region >= 0], places[region >= 0]
    count = np.bincount(of, minlength=regions).astype(np.float64)
    some = np.maximum(count, 1)
    mean = np.stack([np.bincount(of, x[:, k], regions) for k in range(3)], axis=1) / some[:, None]
    off = x - mean[of]
    sums = [[np.bincount(of, off[:, i] * off[:, k], regions) for k in range(3)] for i in range(3)]
    spread = np.moveaxis(np.array(sums), 2, 0) / some[:, None, None]
    facing = np.asarray(part.region_normal, np.float64)
    least = np.linalg.eigh(spread)[1][:, :, 0]
    least *= np.where((least * facing).sum(axis=1) < 0, -1.0, 1.0)[:, None]
    held = np.asarray(part.region_held) > 0 if len(part.region_held) else np.zeros(regions, bool)
    normal = np.where(held[:, None], facing, least)
    square = np.einsum("ri,rij,rj->r", normal, spread, normal).clip(0) * some / np.maximum(some - 3, 1)
    usual = float((square * count).sum() / max(count.sum(), 1))
    return _Planes(count, mean, normal, spread, np.sqrt(np.maximum(square, usual)), held)


def _distance(planes: _Planes, a: int, b: int) -> dict[str, Any]:
    """Of region b, the smaller, from the plane of a."""
    way = planes.mean[b] - planes.mean[a]
    value, variance = planes.normal[a] @ way, (planes.noise[[a, b]] ** 2 / planes.count[[a, b]]).sum()
    beside = way - value * planes.normal[a]
    length = float(np.linalg.norm(beside))
    if length > 0:
        variance += length**2 * planes.turn(a, beside / length)
    return _row("distance", a, b, abs(value), variance)


def _angle(planes: _Planes, a: int, b: int) -> dict[str, Any]:
    edge = np.cross(planes.normal[a], planes.normal[b])
    angle = np.arctan2(np.linalg.norm(edge), planes.normal[a] @ planes.normal[b])
    edge /= np.linalg.norm(edge)
    variance = sum(planes.turn(r, np.cross(planes.normal[r], edge)) for r in (a, b))
    return _row("angle", a, b, np.degrees(angle), np.degrees(1.0) ** 2 * variance)


def _diameter(patch: Any, places: NDArray[np.float64], mesh: Mesh) -> dict[str, Any]:
    """By the distances of the vertices from the axis or centre, and how well they determine it together."""
    off = places - (np.asarray(patch["point"]) - np.asarray(mesh.origin))
    if patch["kind"] == "cylinder":
        off -= np.outer(off @ np.asarray(patch["axis"]), patch["axis"])
    far = np.linalg.norm(off, axis=1)
    variance = np.inf
    if len(far) > _LEAST:
        moves = np.column_stack([np.ones(len(far)), off / far[:, None]])
        variance = np.mean((far - patch["radius"]) ** 2) * np.linalg.pinv(moves.T @ moves)[0, 0]
    return _row("diameter", patch["number"], None, 2 * patch["radius"], 4 * variance)


def _row(kind: str, of: int, to: int | None, value: float, variance: float) -> dict[str, Any]:
    sure = float(2 * np.sqrt(variance))
    return dict(zip(SIZE_COLUMNS, (kind, of, to, float(value), sure if np.isfinite(sure) else None), strict=True))


def _touching(label: NDArray[np.int32], triangles: NDArray[np.int32]) -> set[tuple[int, int]]:
    """Pairs of regions with a common edge, the lower number first."""
    edges = np.sort(np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1).astype(np.int64)
    key = edges[:, 0] * (int(triangles.max(initial=0)) + 1) + edges[:, 1]
    order = np.argsort(key, kind="stable")
    of = np.tile(label, 3)[order]
    same = key[order][1:] == key[order][:-1]
    pairs = np.sort(np.stack([of[1:], of[:-1]], axis=1)[same & (of[1:] != of[:-1])], axis=1)
    return {(a, b) for a, b in np.unique(pairs, axis=0).tolist() if a >= 0}
