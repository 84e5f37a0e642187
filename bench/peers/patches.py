"""Compares polygons with CGAL's remesh_almost_planar_patches, judged alike: a table.

    python -m bench.peers.patches [--data DIR] [--only bunny,castle] [--proxies 300] [--program PEER_PATCHES]

`isimp_engine` must be importable. The program is compiled where the headers of CGAL 6 are (scripts/headers.py). Its
regions grow by the angle of `COSINE`, and by the distance at which it makes about as many polygons as isimp does. The
table has the columns of bench/peers/peers.py.
"""

import os
import subprocess
import tempfile
import time
from pathlib import Path

import isimp_engine as engine
from bench.files import ROOT, compiled, scan_command, scans, write_off
from bench.peers import peers
from bench.quality.intersections import EVERY

COSINE = 0.8  # the largest angle between a face and the plane of its region, chosen by hand
TRIES = 10
SOURCE = ROOT / "bench" / "peers" / "peer_patches.cpp"


def by_patches(program, mesh, part, wanted, folder):
    """The result nearest to `wanted` polygons, and the processor's seconds of the program; None without a result."""
    write_off(folder / "scan.off", mesh.vertices, mesh.triangles)
    low, high, best = 0.0, 0.1 * mesh.report["diagonal"], None
    for _ in range(TRIES):
        distance = (low + high) / 2
        before = os.times().children_user
        command = [program, folder / "scan.off", folder / "out.off", str(distance), str(COSINE)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, timeout=600)
        seconds = os.times().children_user - before
        made = engine.reading.read_polygons(folder / "out.off")
        miss = abs(len(made[2]) - wanted)
        if len(made[2]) and (best is None or miss < best[0]):  # it makes nothing where a patch can't be cut
            best = miss, made, seconds
        low, high = (distance, high) if len(made[2]) > wanted else (low, distance)
    return best and (peers.as_polygons(*best[1], mesh, part), best[2])


def main():
    parser = scan_command(__doc__, [300], "bunny,fandisk,shark")
    parser.add_argument("--program", type=Path, help="peer_patches, compiled before")
    options = parser.parse_args()
    program = options.program or compiled(SOURCE, cgal="Kinetic_surface_reconstruction_3.h")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        heads = "scan", "by", "polygons", "corners", "planarity mean", "most", "distance", "crossing", "no area"
        heads += "flipped", "bent", "meet", "verdict", "seconds"
        print(f"| {' | '.join(heads)} |\n|" + "---|" * len(heads))
        for path in scans(options, EVERY):
            mesh = engine.clean(*engine.read(str(path)))
            before = time.process_time()
            part = engine.partition(mesh, engine.PartitionOptions(proxies=int(options.proxies)))
            poly = engine.polygonize(mesh, part)
            made = {"isimp": (poly, time.process_time() - before)}
            made["patches"] = by_patches(program, mesh, part, len(poly.loop_start), folder)
            for by, found in made.items():
                if found is None:
                    print(f"| {path.stem} | {by} | none |" + " |" * 11, flush=True)
                    continue
                values = peers.figures(found[0], mesh, part, engine.MeshingOptions().flatness)
                print(peers.row(path.stem, by, [*values, found[1]]), flush=True)


if __name__ == "__main__":
    main()
