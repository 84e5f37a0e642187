"""Polygons of the same meshes by isimp, Blender's Decimate (Planar) and CGAL's VSA, judged alike: a table.

    python -m bench.peers.peers [--data DIR] [--only bunny,castle] [--proxies 300] [--keep FOLDER]

`isimp_engine` must be importable; `blender` and CGAL are used if they are there. Decimate gets the
angle at which it makes about as many polygons as isimp does; CGAL as many proxies. `--keep` writes the polygons as OBJ.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from types import SimpleNamespace

import numpy as np

import isimp_engine as engine
from bench.files import ROOT, compiled, scan_command, scans, write_off
from bench.quality.intersections import EVERY
from tests.shared.polygon_judge import distances, judge

MESHES = ("bunny", "armadillo_86k", "fandisk", "castle", "frankfurt")
SAMPLES = 3000
# Runs in Blender: planar decimation to about a number of polygons. The angle grows by half until few enough are left,
# then the range is halved. On large scans wide angles take minutes: no try follows one longer than `PATIENCE`.
PATIENCE = 20  # seconds of the processor
DECIMATE = """
import math, sys, time, bpy, numpy as np
source, result, wanted, patience = sys.argv[sys.argv.index("--") + 1:]
data = np.load(source)
mesh = bpy.data.meshes.new("scan")
mesh.from_pydata(data["vertices"].tolist(), [], data["triangles"].tolist())
scan = bpy.data.objects.new("scan", mesh)
bpy.context.collection.objects.link(scan)
decimate = scan.modifiers.new("planar", "DECIMATE")
decimate.decimate_type = "DISSOLVE"
low, high, angle, best = 0.0, None, math.radians(1), None
for _ in range(16):
    decimate.angle_limit, started = angle, time.process_time()
    found = scan.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    many = len(found.polygons)
    if best is None or abs(many - int(wanted)) < best[0]:
        loops, start = np.empty(len(found.loops), np.int32), np.empty(many, np.int32)
        position = np.empty(3 * len(found.vertices), np.float32)
        found.loops.foreach_get("vertex_index", loops)
        found.polygons.foreach_get("loop_start", start)
        found.vertices.foreach_get("co", position)
        best = abs(many - int(wanted)), position.reshape(-1, 3), loops, start
    low, high = (angle, high) if many > int(wanted) else (low, angle)
    if many == int(wanted) or low >= math.pi or time.process_time() - started > float(patience):
        break
    angle = min(1.5 * low, math.pi) if high is None else (low + high) / 2
np.savez(result, vertices=best[1], loops=best[2], loop_start=best[3])
"""


def nearest(points, places):
    """Index of the point nearest to each place."""
    return np.array([int(((points - place) ** 2).sum(1).argmin()) for place in places])


def as_polygons(vertices, loops, loop_start, mesh, part):
    """A peer's result, in the shape of the engine's own, without corners that no polygon has."""
    used, loops = np.unique(loops, return_inverse=True)
    vertices = np.asarray(vertices, float)[used]
    middle = np.add.reduceat(vertices[loops], loop_start) / np.diff(np.append(loop_start, len(loops)))[:, None]
    kept = np.flatnonzero(part.face_region >= 0)
    faces = mesh.vertices[mesh.triangles[kept]].mean(1)
    region = part.face_region[kept[nearest(faces, middle)]]
    return SimpleNamespace(
        vertices=vertices, loops=loops.astype(np.int32), loop_start=np.asarray(loop_start, np.int32),
        polygon_region=region, source_vertex=nearest(np.asarray(mesh.vertices), vertices),
    )  # fmt: skip


def by_decimate(mesh, part, wanted, folder):
    np.savez(folder / "scan.npz", vertices=mesh.vertices, triangles=mesh.triangles)
    (folder / "decimate.py").write_text(DECIMATE)
    script = ["--python-exit-code", "1", "--python", folder / "decimate.py"]
    files = [folder / "scan.npz", folder / "planar.npz", str(wanted), str(PATIENCE)]
    subprocess.run(["blender", "-b", "--factory-startup", *script, "--", *files], check=True, stdout=subprocess.DEVNULL)
    made = np.load(folder / "planar.npz")
    return as_polygons(made["vertices"], made["loops"], made["loop_start"], mesh, part)


def cgal(mesh, proxies, seeding, folder):
    """The figures, the region of each face, the vertices and the triangles of CGAL's method."""
    program = compiled(ROOT / "bench" / "peers" / "peer_cgal.cpp", cgal="Variational_shape_approximation.h")
    write_off(folder / "scan.off", mesh.vertices, mesh.triangles)
    command = [program, folder / "scan.off", str(proxies), seeding, folder / "cgal.off", folder / "cgal.labels"]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    labels = np.loadtxt(folder / "cgal.labels", dtype=np.int32)
    return json.loads(done.stdout), labels, *engine.read(folder / "cgal.off")


def by_cgal(mesh, part, proxies, folder):
    _, _, vertices, triangles = cgal(mesh, proxies, "hierarchical", folder)
    return as_polygons(vertices, triangles.ravel(), np.arange(0, triangles.size, 3), mesh, part)


def write_obj(path, poly):
    with path.open("w") as file:
        np.savetxt(file, poly.vertices, fmt="v %.17g %.17g %.17g")
        for loop in np.split(np.asarray(poly.loops) + 1, poly.loop_start[1:]):
            file.write("f " + " ".join(map(str, loop.tolist())) + "\n")


def figures(poly, mesh, part, flatness):
    v, scan = judge(poly, mesh, part, flatness, engine.MeshingOptions().reach)
    share, count = 100 / scan.diagonal, len(poly.loop_start)
    if v.area is None:  # the arrays alone are wrong
        return [count, len(poly.loops) / count, *[None] * 8, "; ".join(["not sound", *v.defects])]
    far = distances(scan.samples(SAMPLES), np.asarray(poly.vertices), v.facets)
    weighed = float((v.bend * v.area).sum() / max(v.area.sum(), 1e-300))
    wrong = [len(x) for x in (v.crossing, v.empty, v.flipped, v.bent, v.hits)]
    words = "sound" if v.sound else "; ".join(["not sound", *v.defects])
    return [count, len(poly.loops) / count, share * weighed, share * float(v.bend.max()), share * far.mean(), *wrong,
            words]  # fmt: skip


def row(name, by, values):
    cells = ["-" if x is None else f"{x:.2f}" if isinstance(x, float) else str(x) for x in values]
    return f"| {' | '.join([name, by, *cells])} |"


def main():
    parser = scan_command(__doc__, [300], ",".join(MESHES))
    parser.add_argument("--keep", type=Path)
    options = parser.parse_args()
    proxies = int(options.proxies)
    print("| scan | by | polygons | corners | planarity mean | most | distance | crossing | no area | flipped | bent"
          " | meet | verdict |\n|" + "---|" * 13)  # fmt: skip
    for path in scans(options, EVERY):
        mesh = engine.clean(*engine.read(str(path)))
        part = engine.partition(mesh, engine.PartitionOptions(proxies=proxies))
        made = {"isimp": engine.polygonize(mesh, part)}
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            try:
                made["Decimate"] = by_decimate(mesh, part, len(made["isimp"].loop_start), folder)
                made["CGAL"] = by_cgal(mesh, part, proxies, folder)
            except (OSError, RuntimeError, subprocess.CalledProcessError) as error:
                print(f"{path.stem}: {error}", file=sys.stderr)
        for by, poly in made.items():
            print(row(path.stem, by, figures(poly, mesh, part, engine.MeshingOptions().flatness)), flush=True)
            if options.keep:
                options.keep.mkdir(parents=True, exist_ok=True)
                write_obj(options.keep / f"{path.stem}-{by}.obj", poly)


if __name__ == "__main__":
    main()
