"""Measures how near polygons lie to the scan, and how flat and well shaped they are for that.

    python -m bench.quality.fit [--data DIR] [--only bunny,castle] [--proxies 100,300,1000,detail] [--options '{...}']
                                [--samples 20000] [--pairs] [--json OUT.json] [--against OLD.json]

A row a scan and run. `--options`: fields of MeshingOptions, as JSON. `--pairs` counts intersecting pairs by an exact
test outside the engine, which takes longer. With --against, the last lines are the ratios to an earlier run of the same
script and samples, by run and over all. To compare two builds, run the script with each, since both make the same
regions and samples. Times are processor times.

Columns; lengths are in % of the diagonal of the scan:
  polys      polygons
  mean rms p99  distances between scan and polygons by samples: both ways, p99 from the scan to the polygons
  far back   the largest distance from the scan to the polygons, and from the polygons to the scan
  bend bendx distance of the corners from their polygon's plane: the largest of a polygon, mean by area and largest
  needle     polygons with a corner below 15 degrees
  concave    polygons with a corner above 190 degrees
  defects    polygons and pairs with a defect, by the report
  pairs      pairs of polygons that intersect, by ears and by least surface (see bench.quality.intersections)
"""

import json
import time
from pathlib import Path

import numpy as np

import isimp_engine as engine
from bench.files import scan_command, scans
from bench.quality import shape
from bench.quality.intersections import EVERY, RUNS, least, meetings, partition
from tests.shared.polygon_judge import distance_to_triangles, polygons_of

GROUP, BLOCK = 12, 16  # triangles in one box of a search, and points that search together
CHUNK = 20_000  # points of which distances are measured at once
LENGTHS = ("mean", "rms", "p99", "far", "back", "bend", "bendx")
COUNTS = ("polys", "needle", "concave", "defects", "ears", "least")


def areas(corners):
    """Areas of triangles, (T, 3, 3)."""
    return np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2


def sample(corners, count, seed=5):
    """Points spread over triangles (T, 3, 3) by area, the same every time."""
    random = np.random.default_rng(seed)
    ends = np.cumsum(areas(corners))
    face = np.searchsorted(ends, (np.arange(count) + random.random(count)) / count * ends[-1]).clip(0, len(ends) - 1)
    u, v = random.random((2, count))
    root = np.sqrt(u)
    weights = np.stack([1 - root, root * (1 - v), root * v], 1)
    return np.einsum("nk,nkc->nc", weights, corners[face])


def blocks(points, size):
    """Indices of near points by blocks, (B, S) with S at most `size`: halved along the longest side, some twice."""
    levels = max(0, int(np.ceil(np.log2(len(points) / size))))
    each = -(-len(points) // 2**levels)
    index = np.resize(np.arange(len(points)), (1, each * 2**levels))
    for _ in range(levels):
        some = points[index]
        axis = np.ptp(some, axis=1).argmax(1)
        value = np.take_along_axis(some, axis[:, None, None], axis=2)[:, :, 0]
        order = np.argsort(value, axis=1, kind="stable")
        index = np.take_along_axis(index, order, axis=1).reshape(2 * len(index), -1)
    return index


class Surface:
    """Triangles, for distances from points."""

    def __init__(self, corners):
        corners = corners[areas(corners) > 0]
        self.groups = corners[blocks(corners.mean(1), GROUP)]
        self.low, self.high = self.groups.min((1, 2)), self.groups.max((1, 2))

    def distances(self, points):
        order = blocks(points, BLOCK)
        some = points[order]
        # Near a block are groups whose boxes may be as near as a corner of the one that is nearest for sure.
        low, high = some.min(1), some.max(1)
        block, group = [], []
        for k in range(len(order)):
            least = np.square(np.maximum(np.maximum(self.low - high[k], low[k] - self.high), 0)).sum(1)
            most = np.square(np.maximum(self.high - low[k], high[k] - self.low)).sum(1).min()
            group.append(np.flatnonzero(least <= most))
            block.append(np.full(len(group[-1]), k))
        block, group = np.concatenate(block), np.concatenate(group)
        point, group = order[block].ravel(), np.repeat(group, order.shape[1])
        p, low, high = points[point], self.low[group], self.high[group]
        least = np.square(np.maximum(np.maximum(low - p, p - high), 0)).sum(1)
        most = np.full(len(points), np.inf)
        np.minimum.at(most, point, np.square(np.maximum(high - p, p - low)).sum(1))
        nearest = np.full(len(points), np.inf)
        rising = np.argsort(least, kind="stable")
        point, group, least = point[rising], group[rising], least[rising]
        while len(point):  # the nearest box of each point, then the next
            keep = least <= np.minimum(np.square(nearest), most)[point]
            point, group, least = point[keep], group[keep], least[keep]
            _, now = np.unique(point, return_index=True)
            self._measure(points, point[now], group[now], nearest)
            point, group, least = (np.delete(x, now) for x in (point, group, least))
        return nearest

    def _measure(self, points, rows, groups, nearest):
        size = self.groups.shape[1]
        for s in range(0, len(rows), CHUNK):
            some, t = rows[s : s + CHUNK], self.groups[groups[s : s + CHUNK]].reshape(-1, 3, 3)
            d = distance_to_triangles(np.repeat(points[some], size, axis=0), t[:, 0], t[:, 1], t[:, 2])
            np.minimum.at(nearest, some, d.reshape(-1, size).min(1))


class Scan:
    """A scan and its samples."""

    def __init__(self, mesh, samples):
        self.mesh, self.samples = mesh, samples
        self.corners = np.asarray(mesh.vertices)[np.asarray(mesh.triangles)]
        self.diagonal = np.linalg.norm(np.ptp(self.corners.reshape(-1, 3), axis=0))

    def kept(self, face_region):
        """The surface and the samples of the faces that have a region."""
        keep = np.asarray(face_region) >= 0
        if not hasattr(self, "known") or not np.array_equal(keep, self.known[0]):
            corners = self.corners[keep]
            self.known = keep, Surface(corners), sample(corners, self.samples)
        return self.known[1:]


def bends(points, start, normal):
    """By polygon: the largest distance of a corner from the plane through the mean."""
    size = np.diff(start)
    unit = normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    middle = np.add.reduceat(points, start[:-1]) / size[:, None]
    off = np.abs(((points - np.repeat(middle, size, axis=0)) * np.repeat(unit, size, axis=0)).sum(1))
    return np.maximum.reduceat(off, start[:-1])


def measure(scan, part, poly, pairs=False):
    """The columns of one result."""
    vertices, loops = np.asarray(poly.vertices), np.asarray(poly.loops)
    start = np.append(poly.loop_start, len(loops))
    triangles, owner = engine.regions.triangulate(vertices, loops, poly.loop_start)
    surface, from_scan = scan.kept(part.face_region)
    corners = vertices[triangles]
    there, back = Surface(corners).distances(from_scan), surface.distances(sample(corners, scan.samples))
    points = vertices[loops]
    normal = shape.newell(points, start)
    area = np.linalg.norm(normal, axis=1)
    bend = bends(points, start, normal)
    _, angle = shape.in_plane(points, start, normal)
    share = 100 / scan.diagonal
    report = poly.report
    row = {
        "polys": len(start) - 1, "mean": share * (there.mean() + back.mean()) / 2,
        "rms": share * np.sqrt((np.square(there).mean() + np.square(back).mean()) / 2),
        "p99": share * np.quantile(there, 0.99), "far": share * there.max(), "back": share * back.max(),
        "bend": share * (bend * area).sum() / area.sum(), "bendx": share * bend.max(),
        "needle": int(np.logical_or.reduceat(angle < 15, start[:-1]).sum()),
        "concave": int(np.logical_or.reduceat(angle > 190, start[:-1]).sum()),
        "defects": sum(report[key] for key in ("crossing", "flipped", "bent", "intersecting", "excused")),
    }  # fmt: skip
    if pairs:
        position = (vertices - np.array(scan.mesh.origin)).astype(np.float32).astype(float)
        for name, found in (("ears", meetings(position, triangles, owner)),
                            ("least", meetings(position, *least(position, polygons_of(poly))))):  # fmt: skip
            row[name] = sum(a != b for a, b in found)
    return row


def line(row, columns):
    return " ".join(f"{row[c]:7.3f}" if c in LENGTHS or c == "time" else f"{row[c]:7}" for c in columns if c in row)


def ratios(rows, before):
    """Geometric means of lengths and times, quotients of the sums of counts; a sum of 0 before counts as 1."""
    found = {}
    for name in rows[0]:
        now, then = np.array([r[name] for r in rows], float), np.array([r[name] for r in before], float)
        if name in COUNTS:
            found[name] = now.sum() / max(then.sum(), 1)
        else:  # a result that is exact before and now does not count
            keep = (now > 1e-6) & (then > 1e-6)
            found[name] = float(np.exp(np.log(now[keep] / then[keep]).mean())) if keep.any() else 1.0
    return found


def compare(results, before):
    """Prints the ratios by run and over all."""
    keys = [key for key in results if key in before]
    runs = list(dict.fromkeys(key.split()[1] for key in keys))
    for run in (*runs, "all"):
        some = [key for key in keys if run in ("all", key.split()[1])]
        found = ratios([results[k] for k in some], [before[k] for k in some])
        print(f"{'ratio':24} {run:>7} " + " ".join(f"{found[c]:7.3f}" for c in found))
    sums = {
        c: (sum(before[k][c] for k in keys), sum(results[k][c] for k in keys)) for c in COUNTS if c in results[keys[0]]
    }
    print("sums " + ", ".join(f"{c} {a} -> {b}" for c, (a, b) in sums.items()))


def main():
    parser = scan_command(__doc__, RUNS)
    parser.add_argument("--options", type=json.loads, default={})
    parser.add_argument("--samples", type=int, default=20_000)
    parser.add_argument("--pairs", action="store_true")
    parser.add_argument("--against", type=Path)
    options = parser.parse_args()
    results = {}
    before = json.loads(options.against.read_text()) if options.against else {}
    for path in scans(options, EVERY):
        scan = Scan(engine.clean(*engine.read(path)), options.samples)
        for run in options.proxies.split(","):
            part = partition(scan.mesh, run)
            started = time.process_time()
            poly = engine.polygonize(scan.mesh, part, engine.MeshingOptions(**options.options))
            spent = time.process_time() - started
            row = measure(scan, part, poly, options.pairs) | {"time": spent}
            if not results:
                print(f"{'scan':24} {'run':>7} " + " ".join(f"{c:>7}" for c in row))
            results[f"{path.stem} {run}"] = row
            print(f"{path.stem[:24]:24} {run:>7} {line(row, row)}", flush=True)
            if options.json:
                options.json.write_text(json.dumps(results, indent=1))
    if before:
        compare(results, before)


if __name__ == "__main__":
    main()
