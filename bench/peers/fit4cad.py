"""Measures planes and round parts by Fit4CAD: the Dice index of the points of each primitive (Romanengo et al. 2021).

    python -m bench.peers.fit4cad DATA [--detail X] [--json OUT.json]

DATA is a folder of Fit4CAD (github.com/chiararomanengo/Fit4CAD) or one above: each cloud NAME.txt, whose truth is
NAME_primitives.txt in the same folder or in pointCloud_primitives. `isimp_engine` and scipy must be importable.

The benchmark has points alone and the engine takes meshes, so points are joined first: balls as small as possible that
do not pass between neighbours carve the tetrahedra of Delaunay from outside, and the border of the rest is the mesh. It
has all points as vertices. A ball that is too small enters the solid, one too large closes its hollows.

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
BALLS = (1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0)  # radii in gaps: medians of the distance of the sixth neighbour
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
    """(F, 3) triangles of a surface through the points that faces outwards, by the ball that reaches most points."""
    from scipy.spatial import Delaunay, cKDTree

    gap = float(np.median(cKDTree(points).query(points, k=min(7, len(points)))[0][:, -1]))
    cells = Delaunay(points)
    tetrahedra, neighbours = cells.simplices, cells.neighbors
    centre = points[tetrahedra].mean(axis=1)
    sides = np.array([(1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1)])
    best = np.zeros((0, 3), np.int32)
    for ball in BALLS:
        faces = tetrahedra[:, sides]  # (T, 4, 3): the face beyond each corner
        opened = circumradius(points[faces]) > ball * gap
        outside = carved(neighbours, opened)
        beyond = np.where(neighbours < 0, True, outside[neighbours])
        at = np.argwhere(~outside[:, None] & beyond)
        found = faces[at[:, 0], at[:, 1]]
        a, b, c = points[found].swapaxes(0, 1)
        inwards = (np.cross(b - a, c - a) * (centre[at[:, 0]] - a)).sum(axis=1) > 0
        found[inwards] = found[inwards][:, ::-1]
        if len(np.unique(found)) > len(np.unique(best)):
            best = found.astype(np.int32)
    return best


def circumradius(corners):
    """(...) of triangles (..., 3, 3); infinite without area."""
    a, b, c = (corners[..., k, :] for k in range(3))
    lengths = [np.linalg.norm(side, axis=-1) for side in (b - a, c - b, a - c)]
    area = np.linalg.norm(np.cross(b - a, c - a), axis=-1) / 2
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(area > 0, lengths[0] * lengths[1] * lengths[2] / (4 * area), np.inf)


def carved(neighbours, opened):
    """(T,) whether each tetrahedron is reached from outside through open faces."""
    outside = (opened & (neighbours < 0)).any(axis=1)
    reached = np.flatnonzero(outside)
    while len(reached):
        beyond = np.where(opened[reached], neighbours[reached], -1).ravel()
        beyond = np.unique(beyond[beyond >= 0])
        reached = beyond[~outside[beyond]]
        outside[reached] = True
    return outside


def distance(surface, points):
    """(N,) distances of points from a plane (normal, offset) or a round part; NaN where the kind has no formula."""
    if isinstance(surface, tuple):
        normal, offset = surface
        return np.abs(points @ normal - offset)
    off, axis = points - np.asarray(surface.point), np.asarray(surface.axis)
    if surface.kind == "sphere":
        return np.abs(np.linalg.norm(off, axis=1) - surface.radius)
    along = off @ axis
    rho = np.linalg.norm(off - np.outer(along, axis), axis=1)
    if surface.kind in ("cylinder", "cone"):
        slope = surface.slope if surface.kind == "cone" else 0.0
        return np.abs(rho - surface.radius - slope * along) / np.hypot(1, slope)
    return np.full(len(points), np.nan)


def primitives_of(points, triangles, made):
    """The points of each plane and round part of a result. Points on a neighbour too belong to both."""
    part, label = made.partition, np.asarray(made.labels)
    of_region, surfaces = np.arange(part.region_count + 1), {}
    for patch in part.curved:
        of_region[patch.regions] = part.region_count + 1 + patch.number
        surfaces[part.region_count + 1 + patch.number] = patch
    owner = of_region[label]  # -1 is the last one: faces in no region
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    found = []
    for number in np.unique(owner[label >= 0]).tolist():
        own = np.unique(triangles[owner == number])
        surface = surfaces.get(number) or plane_of(points[own])
        around = np.unique(triangles[np.isin(triangles, own).any(axis=1)])
        around = np.setdiff1d(around, own)
        away = distance(surface, points)
        most = NEAR * diagonal
        keeps = own[~(away[own] > most)]
        found.append(np.union1d(keeps if 2 * len(keeps) > len(own) else own, around[away[around] <= most]))
    return found


def plane_of(points):
    """(normal, offset) of the plane of least squares of points, without the fifth that is farthest from it."""
    for _ in range(3):
        middle = points.mean(axis=0)
        normal = np.linalg.svd(points - middle, full_matrices=False)[2][2]
        away = np.abs((points - middle) @ normal)
        points = points[away <= np.quantile(away, 0.8)] if len(points) > 8 else points
    return normal, float(normal @ middle)


def dice(truth, found):
    """(P,) of each primitive of the truth with the found one that shares most points; 0 where none does."""
    values = []
    for one in truth:
        shared = [len(np.intersect1d(one, other, assume_unique=True)) for other in found]
        best = int(np.argmax(shared)) if shared else -1
        both = len(one) + len(found[best]) if shared else 1
        values.append(2 * shared[best] / both if shared and shared[best] else 0.0)
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
        except ValueError as error:  # of the engine too; the cloud counts 0
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
