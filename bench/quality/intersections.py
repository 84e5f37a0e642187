"""Compares the engine's report on intersecting polygons with an exact test of all pairs that shares no code with it.

    python -m bench.quality.intersections [--data DIR] [--only bunny,castle] [--proxies 100,300,1000,detail] [--planar]

A bent polygon is a surface only once it is triangulated, so pairs are counted by triangulation: `least` has the least
surface, as the engine's judge, and `ears` is that of files and textures. A row a run: polygons, pairs that the report
lists (`said`, excused ones included), and by triangulation all pairs found and the pairs that the report lacks.
`own`: polygons whose own triangles meet. The last row is the sum. Pairs with polygons that the report calls crossing
do not count, nor do lacking pairs with a polygon of more than 64 corners, since the judge cuts ears off these, nor
those of reports with 1,000 pairs, as no more are listed. The exit code is 1 if a pair of `least` is lacking.
"""

import sys

import numpy as np

import isimp_engine as engine
from bench.files import FOLDERS, scan_command, scans
from isimp_engine.regions import triangulate
from tests.shared.polygon_judge import box_pairs, crosses_itself, flat, least_surface, meeting, polygons_of

EVERY = (*FOLDERS, "real")
RUNS = ("100", "300", "1000", "detail")
LISTED = 1000
SLIVER = 4e-6  # share of the diagonal; triangles of planar polygons are not thinner
LARGE = 64  # corners from which on the engine does not look for the least surface
COLUMNS = ("polygons", "said", "least", "lacking", "ears", "lacking", "own")


def least(position, loops, thin=0.0):
    """Triangles of the least surface and the polygon of each; none of polygons that cross themselves."""
    facets, owner = [], []
    for q, loop in enumerate(loops):
        points = position[loop]
        plane, _, _ = flat(points)
        triangles = None if crosses_itself(plane) else least_surface(points, plane, thin)
        for t in triangles or ():
            facets.append(loop[list(t)])
            owner.append(q)
    return np.array(facets), np.array(owner)


def meetings(position, facets, owner):
    """The pairs of polygons of which triangles meet elsewhere than in shared corners; a polygon may meet itself."""
    corners = position[facets]
    full = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).any(1)
    facets, owner = facets[full], owner[full]
    pairs = box_pairs(position, facets)
    pairs = pairs[meeting(position, facets[pairs[:, 0]], facets[pairs[:, 1]])]
    return {tuple(sorted(pair)) for pair in owner[pairs].tolist()}


def compare(poly, origin, thin=0.0):
    """The row of a result, None for figures that are not known, and the lacking pairs of `least`."""
    loops = polygons_of(poly)
    position = (np.asarray(poly.vertices) - origin).astype(np.float32).astype(float)  # as the report
    listed = poly.report["imperfect"]
    crossing = {e["polygon"] for e in listed if e["flaw"] in ("crossing", "no_area")}
    said = {tuple(sorted((e["polygon"], e["other"]))) for e in listed if e.get("other", -1) not in (-1, None)}
    is_whole = max(poly.report["intersecting"], poly.report["excused"], poly.report["crossing"]) < LISTED
    row = [len(loops), poly.report["intersecting"] + poly.report["excused"]]
    lacking = []
    for facets, owner in (least(position, loops, thin),
                          triangulate(np.asarray(poly.vertices), poly.loops, poly.loop_start)):  # fmt: skip
        found = meetings(position, np.asarray(facets), np.asarray(owner))
        own = {pair for pair in found if pair[0] == pair[1]}
        found = {pair for pair in found - own if not crossing & set(pair)}
        lacking.append(sorted(p for p in found - said if max(len(loops[p[0]]), len(loops[p[1]])) <= LARGE))
        row += [len(found), len(lacking[-1]) if is_whole else None]
        if len(row) == 4:
            own_of_least = len(own)
    return [*row, own_of_least], lacking[0] if is_whole else []


def partition(mesh, run):
    if run == "detail":
        return engine.partition(mesh, engine.PartitionOptions())
    return engine.partition(mesh, engine.PartitionOptions(proxies=min(int(run), len(mesh.triangles))))


def main():
    parser = scan_command(__doc__, RUNS)
    parser.add_argument("--planar", action="store_true")
    options = parser.parse_args()
    print(f"{'scan':32} {'run':>7} " + " ".join(f"{name:>8}" for name in COLUMNS))
    total = np.zeros(len(COLUMNS), int)
    for path in scans(options, EVERY):
        mesh = engine.clean(*engine.read(path))
        for run in options.proxies.split(","):
            poly = engine.polygonize(mesh, partition(mesh, run), engine.MeshingOptions(planar=options.planar))
            diagonal = np.linalg.norm(np.ptp(np.asarray(mesh.vertices), axis=0))
            row, lacking = compare(poly, np.array(mesh.origin), SLIVER * diagonal if options.planar else 0)
            total += [n or 0 for n in row]
            figures = " ".join(f"{'' if n is None else n:8}" for n in row)
            print(f"{path.stem:32} {run:>7} {figures}  {' '.join(map(str, lacking[:5]))}", flush=True)
    print(f"{'all':32} {'':7} " + " ".join(f"{n:8}" for n in total))
    sys.exit(bool(total[COLUMNS.index("lacking")]))


if __name__ == "__main__":
    main()
