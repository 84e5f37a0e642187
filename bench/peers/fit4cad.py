"""Measures planes and round parts by Fit4CAD: the Dice index of the points of each primitive (Romanengo et al. 2021).

    python -m bench.peers.fit4cad DATA [--detail X] [--json OUT.json]

DATA is a folder of Fit4CAD (github.com/chiararomanengo/Fit4CAD) or one above: each cloud NAME.txt, whose truth is
NAME_primitives.txt in the same folder or in pointCloud_primitives. `isimp_engine` and scipy must be importable.

The benchmark has points alone and the engine takes meshes, so points are joined first: the mesh is the border between
the tetrahedra of Delaunay inside and outside.

A round part with a free profile is one primitive for each line and arc of it: a benchmark's torus is an arc.

A row a cloud: points, primitives of the truth and found ones, share of the points in the mesh, and the mean Dice index.
As in the benchmark, each primitive of the truth is compared with the found one that has most of its points. The last
line has the mean over clouds. By the authors, a method of Hough transforms has .905.
"""

import argparse
import json
import re
from pathlib import Path

import numpy as np

import isimp_engine as engine

NEAR = 2e-3  # share of the diagonal: points of a neighbour at this distance from a primitive's surface belong to it too
STEPS = 48  # parts of a profile that lines and arcs consist of
SAMPLES = 500  # places along a profile, about
JITTER = 1e-6  # share of the diagonal, of a move of points while they are joined: planes have no flat tetrahedra then
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"


def read_points(path):
    """(N, 3) the points of a cloud: three numbers in each bracket, or in each line."""
    text = Path(path).read_text(encoding="utf-8", errors="replace")
    found = re.findall(rf"\[?\s*({NUMBER})[,;\s]+({NUMBER})[,;\s]+({NUMBER})\s*(?:\]|$)", text, re.MULTILINE)
    return np.array(found, np.float64).reshape(-1, 3)


def read_primitives(path, count):
    """The points of each primitive, as sorted numbers from 0. count: number of points, numbered from 1 in the file.

    Lists may have line breaks, commas or numbers such as 1e3; empty lists stay.
    """
    text = Path(path).read_text(encoding="utf-8", errors="replace")
    lists = re.findall(r"Primitive\s*\d+\s*:?=\s*\[(.*?)\]", text, re.DOTALL | re.IGNORECASE)
    numbers = [np.array(re.findall(NUMBER, one), np.float64).astype(np.int64) for one in lists]
    first = min((int(some.min()) for some in numbers if len(some)), default=1)
    found = [np.unique(some - (0 if first == 0 else 1)) for some in numbers]
    if any(len(some) and (some[0] < 0 or some[-1] >= count) for some in found):
        raise ValueError(f"{path}: names a point that is not among the {count} of its cloud")
    return found


def clouds(folder):
    """Pairs of a cloud and its truth, by number."""
    found = []
    for truth in sorted(Path(folder).rglob("*_primitives.txt")):
        name = truth.name.replace("_primitives", "")
        places = [truth.parent / name, truth.parent.with_name(truth.parent.name.replace("_primitives", "")) / name]
        found += [(place, truth) for place in places if place.is_file()][:1]
    return sorted(found, key=lambda pair: [int(part) for part in re.findall(r"\d+", pair[0].stem)])


def meshed(points):
    """(F, 3) triangles of a closed surface through the points that faces outwards.

    The tetrahedra of Delaunay are inside or outside. Neighbours are on one side the surer, the deeper the balls around
    them overlap, and the poles of a point, its largest balls in opposite directions, are on two sides. The surest of
    these facts counts first, and one that contradicts it does not count.
    Source: Kolluri, Shewchuk, O'Brien 2004 for the facts; Wolf et al. 2018 (mutex watershed) for their order.
    """
    from scipy.spatial import Delaunay

    points = points + JITTER * diagonal(points) * np.random.default_rng(0).normal(size=points.shape)
    cells = Delaunay(points)
    tetrahedra, neighbours = cells.simplices, cells.neighbors
    outside, centres = len(tetrahedra), ball_centres(points[tetrahedra])
    faces = tetrahedra[:, [(1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1)]]  # (T, 4, 3): the face beyond each corner
    a, b, c = points[faces].transpose(2, 0, 1, 3)
    away = unit(np.cross(b - a, c - a))
    inwards = ((points[tetrahedra] - a) * away).sum(axis=-1) > 0
    away[inwards] *= -1
    faces[inwards] = faces[inwards][:, ::-1]

    # Same sides: neighbours, and the hull with the outside, whose ball is the half space beyond.
    cell, side = np.nonzero(neighbours < np.arange(outside)[:, None])
    beyond = neighbours[cell, side]
    on = points[faces[cell, side, 0]]
    towards = np.where(beyond[:, None] < 0, away[cell, side], unit(centres[beyond] - on))
    same = (unit(centres[cell] - on) * towards).sum(axis=1), cell, np.where(beyond < 0, outside, beyond)

    # Two sides: the poles of each point. The first one of a point of the hull is the outside.
    corner, own = tetrahedra.ravel(), np.repeat(np.arange(outside), 4)
    ball = centres[own] - points[corner]
    size = np.linalg.norm(ball, axis=1)
    first = last_of_each(corner, size)
    pole, axis = own[first], ball[first] / size[first, None]
    at_hull = faces[neighbours < 0]
    normals = np.zeros_like(points)
    np.add.at(normals, at_hull.ravel(), np.repeat(away[neighbours < 0], 3, axis=0))
    hull = np.unique(at_hull)
    pole[hull], axis[hull] = outside, unit(normals[hull])
    turn = (ball * axis[corner]).sum(axis=1) / size
    second = last_of_each(corner, np.where(turn < 0, size, -1.0))
    two = -turn[second], pole, own[second]

    side_of = sides(outside + 1, same, two)
    is_inside = side_of[:-1] != side_of[-1]
    open_beyond = np.where(neighbours < 0, True, ~is_inside[neighbours])
    return faces[is_inside[:, None] & open_beyond].astype(np.int32)


def ball_centres(corners):
    """(T, 3) the centres of the balls through the corners (T, 4, 3) of tetrahedra."""
    sides = corners[:, 1:] - corners[:, :1]
    middle = np.linalg.solve(sides, (sides**2).sum(axis=2, keepdims=True) / 2)
    return corners[:, 0] + middle[:, :, 0]


def unit(vectors):
    """The vectors with length 1."""
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def last_of_each(number, value):
    """For each of the numbers 0, 1, ... the place where it has its largest value."""
    order = np.lexsort((value, number))
    return order[np.searchsorted(number[order], np.arange(number.max() + 1), side="right") - 1]


def sides(count, same, two):
    """(count,) 0 or 1 of each cell: its side. same, two: certainty and two cells of each fact, see `meshed`."""
    certainty, first, second = (np.concatenate(pair) for pair in zip(same, two, strict=True))
    differ = np.arange(len(certainty)) >= len(same[0])
    order = np.argsort(-certainty, kind="stable")
    parent, turn, size = list(range(count)), [0] * count, [1] * count

    def root(cell):
        """The root of the tree of a cell, and whether it is on the other side."""
        other = 0
        while parent[cell] != cell:
            other ^= turn[cell]
            cell = parent[cell]
        return cell, other

    for one, other, differs in zip(*(fact[order].tolist() for fact in (first, second, differ)), strict=True):
        (a, turn_a), (b, turn_b) = root(one), root(other)
        if a == b:
            continue
        small, large = (a, b) if size[a] < size[b] else (b, a)
        parent[small], turn[small] = large, turn_a ^ turn_b ^ differs
        size[large] += size[small]
    return np.array([root(cell)[1] for cell in range(count)])


def diagonal(points):
    """The length of the diagonal of the box of points."""
    return float(np.linalg.norm(np.ptp(points, axis=0)))


def primitives_of(points, triangles, made):
    """The points of each primitive of a result. Points on a neighbour too belong to both."""
    part, label = made.partition, np.asarray(made.labels)
    of_region, patches = np.arange(part.region_count + 1), {}
    for patch in part.curved:
        of_region[patch.regions] = part.region_count + 1 + patch.number
        patches[part.region_count + 1 + patch.number] = patch
    owner = of_region[label]  # -1 is the last one: faces in no region
    most = NEAR * diagonal(points)
    is_own = np.zeros(len(points), bool)
    found = []
    for number in np.unique(owner[label >= 0]).tolist():
        faces = owner == number
        for some, away in surfaces(patches.get(number), points, triangles[faces], most):
            own = np.unique(some)
            is_own[:] = False
            is_own[own] = True
            around = np.unique(triangles[is_own[triangles].any(axis=1)])
            around = around[~is_own[around]]
            keeps = own[away(points[own]) <= most]
            more = around[away(points[around]) <= most]
            found.append(np.union1d(keeps if 2 * len(keeps) > len(own) else own, more))
    return found


def surfaces(patch, points, triangles, most):
    """Pairs of the triangles of a primitive and the function of its distance from points.

    patch: a round part; None: a plane. One with a profile has a primitive for each line and arc of its profile, which
    keeps to the points within `most`.
    """
    own = np.unique(triangles)
    if patch is None:
        return [(triangles, plane_of(points[own]))]
    if patch.kind not in ("revolution", "extrusion"):
        return [(triangles, lambda at: distance(patch, at))]
    curves = curves_of(in_profile(patch, points[own]), np.asarray(patch.profile), most)
    middle = in_profile(patch, points[triangles]).mean(axis=1)
    nearest = np.argmin([curve(middle) for curve in curves], axis=0)
    return [
        (triangles[nearest == k], lambda at, curve=curve: curve(in_profile(patch, at)))
        for k, curve in enumerate(curves)
        if (nearest == k).any()
    ]


def distance(patch, points):
    """(N,) distances of points from a sphere, a cylinder or a cone."""
    if patch.kind == "sphere":
        return np.abs(np.linalg.norm(points - np.asarray(patch.point), axis=1) - patch.radius)
    rho, along = in_profile(patch, points).T
    slope = patch.slope if patch.kind == "cone" else 0.0
    return np.abs(rho - patch.radius - slope * along) / np.hypot(1, slope)


def in_profile(patch, points):
    """(..., 2) the places of points in the plane of a profile: from the axis and along it, or across an extrusion."""
    off, axis = points - np.asarray(patch.point), np.asarray(patch.axis)
    if patch.kind == "extrusion":
        across = np.asarray(patch.across)
        return np.stack([off @ across, off @ np.cross(axis, across)], axis=-1)
    along = off @ axis
    return np.stack([np.linalg.norm(off - along[..., None] * axis, axis=-1), along], axis=-1)


def curves_of(places, profile, most):
    """The least number of lines and arcs at most `most` from places along a profile, as functions of distance."""
    places = places[:: 1 + len(places) // SAMPLES]
    sides = np.roll(profile, -1, axis=0) - profile
    length = np.maximum(np.linalg.norm(sides, axis=1), 1e-300)
    if length[-1] > 2 * np.median(length):  # an open profile
        profile, sides, length = profile[:-1], sides[:-1], length[:-1]
    share = np.clip(((places[:, None] - profile) * sides).sum(axis=2) / length**2, 0, 1)
    nearest = np.linalg.norm(places[:, None] - profile - share[..., None] * sides, axis=2).argmin(axis=1)
    along = (np.cumsum(length) - length)[nearest] + (share * length)[np.arange(len(places)), nearest]
    step = np.unique((STEPS * along / np.ptp(along).clip(1e-300)).astype(int), return_inverse=True)[1]
    count = step.max() + 1
    best = [(0, 0.0, [])] + [None] * count  # by step, the curves before it: their number, misfit and functions
    for first in range(count):
        for end in range(first + 1, count + 1):
            some = places[(step >= first) & (step < end)]
            curve = min((line_of(some), arc_of(some)), key=lambda one: one(some).max())
            misfit = curve(some)
            if end > first + 1 and misfit.max() > most:
                break
            now = (best[first][0] + 1, best[first][1] + (misfit**2).sum(), [*best[first][2], curve])
            if best[end] is None or now[:2] < best[end][:2]:
                best[end] = now
    return best[count][2]


def line_of(places):
    """The distance from the line that fits places best."""
    middle = places.mean(axis=0)
    normal = np.linalg.svd(places - middle, full_matrices=True)[2][1]
    return lambda at: np.abs((at - middle) @ normal)


def arc_of(places):
    """The distance from the circle that fits places best."""
    middle = places.mean(axis=0)
    off = places - middle
    x, y, rest = np.linalg.lstsq(np.c_[2 * off, np.ones(len(off))], (off**2).sum(axis=1), rcond=None)[0]
    radius = np.sqrt(max(rest + x * x + y * y, 0.0))
    return lambda at: np.abs(np.linalg.norm(at - middle - [x, y], axis=-1) - radius)


def plane_of(points):
    """The distance from the plane of least squares of points, without the fifth that is farthest from it."""
    for _ in range(3):
        middle = points.mean(axis=0)
        normal = np.linalg.svd(points - middle, full_matrices=False)[2][2]
        away = np.abs((points - middle) @ normal)
        points = points[away <= np.quantile(away, 0.8)] if len(points) > 8 else points
    return lambda at: np.abs((at - middle) @ normal)


def dice(truth, found):
    """(P,) of each primitive of the truth with the found one that shares most points; 0 where none does."""
    values = []
    for one in truth:
        is_one = np.zeros(1 + max(int(some.max()) for some in [one, *found]), bool)
        is_one[one] = True
        shared = [np.count_nonzero(is_one[other]) for other in found]
        best = int(np.argmax(shared)) if shared else -1
        both = len(one) + len(found[best]) if shared else 1
        values.append(2 * shared[best] / both if shared else 0.0)
    return np.array(values)


def measured(cloud, truth, detail=None):
    """The row of a cloud."""
    points = read_points(cloud)
    wanted = read_primitives(truth, len(points))
    triangles = meshed(points)
    made = engine.simplify((points, triangles), curved=True, keep_openings=True, detail=detail)
    found = primitives_of(points, triangles, made)
    values = dice([one for one in wanted if len(one)], found)
    row = {"cloud": cloud.stem, "points": len(points), "primitives": len(wanted), "found": len(found)}
    return row | {"meshed": len(np.unique(triangles)) / max(len(points), 1), "dice": float(values.mean())}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--detail", type=float)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    pairs = clouds(options.data)
    if not pairs:
        parser.error(f"{options.data}: has no cloud with its NAME_primitives.txt")
    rows = []
    print(f"{'cloud':12} {'points':>7} {'truth':>6} {'found':>6} {'meshed':>7}   Dice")
    for cloud, truth in pairs:
        try:
            row = measured(cloud, truth, options.detail)
        except ValueError as error:  # also by the engine; the cloud counts 0
            row = {"cloud": cloud.stem, "points": 0, "primitives": 0, "found": 0, "meshed": 0.0, "dice": 0.0}
            row |= {"failed": str(error)}
        rows.append(row)
        print(f"{row['cloud']:12} {row['points']:7} {row['primitives']:6} {row['found']:6} {row['meshed']:7.3f}"
              f"  {row['dice']:.3f}  {row.get('failed', '')}", flush=True)  # fmt: skip
    print(f"mean Dice of {len(rows)} clouds: {np.mean([row['dice'] for row in rows]):.3f}")
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
