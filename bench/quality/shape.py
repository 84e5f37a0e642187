"""Measures the shape of polygons, and its price in distance and planarity.

    python -m bench.quality.shape [--data DIR] [--only bunny,castle] [--proxies 100,300,1000] [--json OUT.json]
                                  [--against OLD.json]
    python -m bench.quality.shape --resolution [...]

`isimp_engine` must be importable. A row a mesh and number of regions; with --against, the row of an earlier run is
above each, and the summary lists which of the limits of `LIMITS` are kept. Times are of the processor. With
--resolution each mesh is also measured with every face split in four, once and twice, so that the same surface has a
quarter, once and four times as many faces; the summary has the columns of the first and the last over the columns of
the one between.

Columns, of polygons unless another object is named:
  corners   a polygon, mean
  conc      % with a corner above 190 degrees
  strong    % that miss more than 10 % of their convex hull
  reflex    corners above 190 degrees, a 100 polygons; forced: at inner vertices of three edges whose angles sum
            to more than 361 degrees, where three planar polygons can't all be convex
  <15       % with a corner below 15 degrees; needle: % that are triangles with one
  iq        4 pi area / perimeter^2, mean
  short     % of the edges shorter than .12 sqrt(area / polygons)
  ratio     longest over shortest edge of a polygon, median
  val3      % of the inner vertices with three edges
  border    length of the borders on the scan over sqrt(area * regions)
  ragged    the same length over that of the polygons' edges
  D         distortion of the regions over the area
  bend      distance of the corners from their polygon's plane, mean by area, % of the diagonal
  mean max  distance of the scan's vertices from the polygons, % of the diagonal
"""

import itertools
import json
import time
from pathlib import Path

import numpy as np

import isimp_engine as engine
from bench.files import scan_command, scans
from bench.generators.known_shapes import split_in_four
from isimp_engine.guides import shared_edges
from isimp_engine.within import scan_distances

COUNTS = (100, 300, 1000)
COLUMNS = (
    *("corners", "conc", "strong", "reflex", "forced", "<15", "needle", "iq", "short", "ratio", "val3"),
    *("border", "ragged", "D", "bend", "mean", "max", "split", "mesh_s"),
)
DIGITS = {"iq": 2, "corners": 2, "border": 2, "ragged": 2, "D": 4, "bend": 3, "mean": 3, "max": 2, "mesh_s": 2}
# Figures that may be no worse than before, and the factor by which they may differ.
LIMITS = {"bend": 1.0, "mean": 1.0, "max": 1.0, "<15": 1.0}


def newell(points, start):
    """Vector area of each polygon; `points` are its corners, the rows from start[q] to start[q + 1]."""
    first = np.repeat(points[start[:-1]], np.diff(start), axis=0)
    after = following(start)
    return np.add.reduceat(np.cross(points - first, points[after] - first), start[:-1]) / 2


def following(start):
    """The row of the next corner of each corner."""
    after = np.arange(start[-1]) + 1
    after[start[1:] - 1] = start[:-1]
    return after


def hull_area(points):
    """The area of the convex hull of points in the plane. Andrew's monotone chain."""
    order = points[np.lexsort((points[:, 1], points[:, 0]))]

    def half(some):
        chain = []
        for p in some:
            while len(chain) > 1:
                (ax, ay), (bx, by) = chain[-2], chain[-1]
                if (bx - ax) * (p[1] - ay) - (by - ay) * (p[0] - ax) > 0:
                    break
                chain.pop()
            chain.append((p[0], p[1]))
        return chain[:-1]

    x, y = np.array(half(order) + half(order[::-1])).T
    return 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))


def in_plane(points, start, normal):
    """Corners in the plane of their polygon, and the interior angle at each in degrees."""
    unit = normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    helper = np.eye(3)[np.argmin(np.abs(unit), axis=1)]
    u = np.cross(unit, helper)
    u /= np.maximum(np.linalg.norm(u, axis=1), 1e-300)[:, None]
    w = np.cross(unit, u)
    size = np.diff(start)
    local = points - np.repeat(points[start[:-1]], size, axis=0)
    flat = np.stack([(local * np.repeat(a, size, axis=0)).sum(1) for a in (u, w)], axis=1)
    out = flat[following(start)] - flat
    into = np.empty_like(out)
    into[following(start)] = out
    turn = np.arctan2(into[:, 0] * out[:, 1] - into[:, 1] * out[:, 0], (into * out).sum(1))
    return flat, np.degrees(np.pi - turn)


def shape(vertices, loops, start):
    """The columns that depend on the polygons alone."""
    points, size, after = vertices[loops], np.diff(start), following(start)
    normal = newell(points, start)
    area = np.linalg.norm(normal, axis=1)
    flat, angle = in_plane(points, start, normal)
    length = np.linalg.norm(points[after] - points, axis=1)
    polygons = len(size)
    of = np.repeat(np.arange(polygons), size)

    def any_of(corner):
        return np.logical_or.reduceat(corner, start[:-1])

    ends = np.sort(np.stack([loops, loops[after]], axis=1), axis=1)
    edges, first, used = np.unique(ends, axis=0, return_index=True, return_counts=True)
    valence = np.bincount(edges.ravel(), minlength=len(vertices))
    inner = valence > 0
    inner[edges[used == 1].ravel()] = False
    around = np.bincount(loops, angle, minlength=len(vertices))
    reflex, sharp = angle > 190, angle < 15
    forced = reflex & inner[loops] & (valence[loops] == 3) & (around[loops] > 361)
    hull = np.array([hull_area(flat[a:b]) for a, b in itertools.pairwise(start)])
    perimeter = np.bincount(of, length, minlength=polygons)
    longest, shortest = np.maximum.reduceat(length, start[:-1]), np.minimum.reduceat(length, start[:-1])
    return {
        "polygons": polygons,
        "corners": len(loops) / polygons,
        "conc": 100 * any_of(reflex).mean(),
        "strong": 100 * np.mean(1 - area / np.maximum(hull, 1e-300) > 0.1),
        "reflex": 100 * reflex.sum() / polygons,
        "forced": 100 * forced.sum() / polygons,
        "<15": 100 * any_of(sharp).mean(),
        "needle": 100 * np.mean(any_of(sharp) & (size == 3)),
        "iq": np.mean(4 * np.pi * area / perimeter**2),
        "short": 100 * np.mean(length[first] < 0.12 * np.sqrt(area.sum() / polygons)),
        "ratio": np.median(longest / np.maximum(shortest, 1e-300)),
        "val3": 100 * np.mean(valence[inner] == 3),
        "edges": length[first].sum(),
    }


def borders(mesh, label):
    """Length of the borders between regions, and on the border of the mesh."""
    corners = mesh.vertices[mesh.triangles]
    whole = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).sum()
    pairs, ends = shared_edges(mesh.triangles)
    length = np.linalg.norm(mesh.vertices[ends[:, 0]] - mesh.vertices[ends[:, 1]], axis=1)
    return length[label[pairs[:, 0]] != label[pairs[:, 1]]].sum(), whole - 2 * length.sum()


def run(mesh, proxies, partition_options, meshing_options):
    started = time.process_time()
    part = engine.partition(mesh, engine.PartitionOptions(proxies=proxies, **partition_options))
    split = time.process_time() - started
    poly = engine.polygonize(mesh, part, engine.MeshingOptions(**meshing_options))
    seconds = time.process_time() - started - split
    start = np.append(poly.loop_start, len(poly.loops)).astype(np.int64)
    row = shape(np.asarray(poly.vertices), np.asarray(poly.loops), start)
    label = np.asarray(part.face_region)
    between, rim = borders(mesh, label)
    corners = mesh.vertices[mesh.triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    weight = np.bincount(mesh.triangles.ravel(), np.repeat(np.where(label >= 0, area, 0), 3), len(mesh.vertices))
    far = scan_distances(mesh, part, poly)
    share = 100 / mesh.report["diagonal"]
    known = ~np.isnan(far)
    row |= {
        "border": between / np.sqrt(area.sum() * part.region_count),
        "ragged": (between + rim) / row.pop("edges"),
        "D": part.error / area.sum(),
        "bend": share * poly.report["planarity_mean"],
        "mean": share * float(np.average(far[known], weights=weight[known])),
        "max": share * float(far[known].max()),
        "split": split,
        "mesh_s": seconds,
        "extra": row["polygons"] - part.region_count,
        "imperfect": len(poly.report["imperfect"]),
    }
    return {key: float(value) for key, value in row.items()}, part, poly


def line(name, proxies, row):
    cells = [f"{row[c]:{max(7, len(c) + 1)}.{DIGITS.get(c, 1)}f}" for c in COLUMNS]
    return f"{name[:14]:14} {proxies:5} {row['polygons']:6.0f} {''.join(cells)}"


def head():
    return f"{'mesh':14} {'P':>5} {'n':>6} " + "".join(f"{c:>{max(7, len(c) + 1)}}" for c in COLUMNS)


def summary(rows, before):
    """Means of the ratios, and the figures that are worse than before."""
    same = [(key, rows[key], before[key]) for key in rows if key in before]
    print(f"\nmean ratio to before, of {len(same)} runs:")
    for c in COLUMNS:
        ratios = [new[c] / old[c] for _, new, old in same if old[c] > 0]
        if ratios:
            print(f"  {c:8} {np.mean(ratios):6.3f}  worst {max(ratios):6.2f}")
    for c, factor in LIMITS.items():
        worse = [f"{key} {old[c]:.3f} -> {new[c]:.3f}" for key, new, old in same if new[c] > factor * old[c] * 1.005]
        print(f"{c}: {len(same) - len(worse)} of {len(same)} not above before; {'; '.join(worse)}")


def by_resolution(rows):
    """The dependence of the figures on the number of faces: the worst of the columns, and the means."""
    runs = {key.removesuffix(" x4") for key in rows if key.endswith(" x4")}
    print(f"\nmean ratio to four times the faces of the file, of {len(runs)} runs: as in the file; sixteen times")
    for c in COLUMNS:
        both = []
        for ends in ("", " x16"):
            ratios = [rows[run + ends][c] / rows[run + " x4"][c] for run in runs if rows[run + " x4"][c] > 0]
            both.append(np.mean(ratios) if ratios else np.nan)
        print(f"  {c:8} {both[0]:6.3f} {both[1]:6.3f}")


def main():
    parser = scan_command(__doc__, COUNTS)
    parser.add_argument("--against", type=Path, help="the --json file of an earlier run")
    parser.add_argument("--resolution", action="store_true", help="also with four and sixteen times the faces")
    parser.add_argument("--partition", type=json.loads, default={}, help="fields of PartitionOptions as JSON")
    parser.add_argument("--meshing", type=json.loads, default={}, help="fields of MeshingOptions as JSON")
    given = parser.parse_args()
    before = json.loads(given.against.read_text()) if given.against else {}
    rows = {}
    print(head())
    for path in scans(given):
        meshes = {"": engine.clean(*engine.read(path))}
        if given.resolution:
            meshes[" x4"] = engine.Mesh(*split_in_four(meshes[""].vertices, meshes[""].triangles))
            meshes[" x16"] = engine.Mesh(*split_in_four(meshes[" x4"].vertices, meshes[" x4"].triangles))
        for (finer, mesh), proxies in itertools.product(meshes.items(), map(int, given.proxies.split(","))):
            if 8 * proxies > len(mesh.triangles):
                continue
            key = f"{path.stem} {proxies}{finer}"
            rows[key], _, _ = run(mesh, proxies, given.partition, given.meshing)
            if key in before:
                print(line("  before", proxies, before[key]))
            print(line(path.stem[: 14 - len(finer)] + finer, proxies, rows[key]), flush=True)
    if given.json:
        given.json.write_text(json.dumps(rows, indent=1))
    if before:
        summary(rows, before)
    if given.resolution:
        by_resolution(rows)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
