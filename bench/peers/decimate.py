"""Compares polygons with as many triangles of edge collapse under quadric error, by their distance from the scan.

    python -m bench.peers.decimate [--data DIR] [--only bunny,armadillo] [--proxies 300,1000] [--samples 10000]

`isimp_engine` and `fast_simplification` (PyPI; Garland and Heckbert 1997) must be importable. `agg` 4 is the least, and
best, with which it reaches the number. A row a scan and number of regions. The polygons are triangulated, and the peer
decimates the scan to the same number of triangles.

Columns: triangles; mean distance between scan and polygons both ways, of isimp, of isimp with exactly planar polygons,
and of the peer, in % of the diagonal; quotients of isimp and of planar over the peer. The last line has the geometric
means.
"""

import fast_simplification
import numpy as np

import isimp_engine as engine
from bench.files import scan_command, scans
from bench.quality.fit import Scan, Surface, measure, sample
from bench.quality.intersections import partition


def triangles_of(poly):
    return len(poly.loops) - 2 * len(poly.loop_start)


def decimated(scan, count):
    """Mean distance of the decimated scan, both ways, in % of the diagonal."""
    vertices, triangles = np.array(scan.mesh.vertices), np.array(scan.mesh.triangles)  # not read-only
    points, faces = fast_simplification.simplify(vertices, triangles, target_count=count, agg=4)
    corners = np.asarray(points, float)[faces]
    surface, from_scan = scan.kept(np.zeros(len(triangles)))
    there, back = Surface(corners).distances(from_scan), surface.distances(sample(corners, scan.samples))
    return 100 / scan.diagonal * (there.mean() + back.mean()) / 2


def main():
    parser = scan_command(__doc__, (300, 1000), "armadillo_86k,bunny,lion,rockerarm")
    parser.add_argument("--samples", type=int, default=10_000)
    options = parser.parse_args()
    print(f"{'scan':24} {'P':>5} {'tris':>6}   isimp  planar    peer  quotients")
    quotients = []
    for path in scans(options):
        scan = Scan(engine.clean(*engine.read(path)), options.samples)
        for run in options.proxies.split(","):
            part = partition(scan.mesh, run)
            polys = [engine.polygonize(scan.mesh, part, engine.MeshingOptions(planar=p)) for p in (False, True)]
            bent, planar = (measure(scan, part, poly)["mean"] for poly in polys)
            peer = decimated(scan, triangles_of(polys[0])), decimated(scan, triangles_of(polys[1]))
            quotients.append((bent / peer[0], planar / peer[1]))
            print(f"{path.stem[:24]:24} {run:>5} {triangles_of(polys[0]):6} {bent:7.3f} {planar:7.3f} {peer[0]:7.3f}"
                  f"  {quotients[-1][0]:.2f} {quotients[-1][1]:.2f}", flush=True)  # fmt: skip
    print("geometric means: {:.2f} {:.2f}".format(*np.exp(np.log(quotients).mean(0))))


if __name__ == "__main__":
    main()
