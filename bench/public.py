"""The benchmarks of docs/benchmarks.md, one command each, and the small ones that a nightly job checks.

    python -m bench.public                              the tasks
    python -m bench.public TASK [ARGUMENTS]             runs the program of a task, with more arguments of it
    python -m bench.public small [--against OLD.json] [--json NEW.json] [--no-operations]

`small` needs no data: made scans, a minute. It prints figures of quality, where less is better, and operations:
millions of instructions of partition and meshing under valgrind, which other programs on the machine do not change.
With --against it ends with 1 if a figure is more than 5 % worse than in OLD.json, or operations are 15 % more.
bench/public.json has the figures of Debian 12 (g++ 12, x86-64); write it again by --json after a change that is meant
to change them.
"""

import argparse
import json
import os
import re
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np

import isimp_engine as engine
from bench.files import data_folder
from bench.generators import hollow_solids, houses, round_shapes
from tests.shared import shapes

ROOT = Path(__file__).resolve().parents[1]
QUALITY, OPERATIONS = 1.05, 1.15  # the factors by which figures may be worse
LEAST = 0.01  # a figure of 0 may become this
STAGES = "partition", "meshing"


def data(name):
    folder = data_folder(None)
    return str(folder / name) if folder else name


# Task, the module, its arguments, the question.
TASKS = {
    "speed": ("bench.timer.run", [], "partition and meshing against the plain method"),
    "decimate": ("bench.peers.peers", [], "polygons against Blender's Decimate (Planar) and CGAL's VSA"),
    "patches": ("bench.peers.patches", [], "polygons against CGAL's remesh_almost_planar_patches"),
    "collapse": ("bench.peers.decimate", [], "distance against edge collapse under quadric error"),
    "texture": ("bench.quality.texture", [], "likeness of the texture: SCAN PROXIES"),
    "cycles": ("bench.peers.texture_peer", [], "texture against Cycles: SCAN PROXIES SIZE, in bpy"),
    "houses": ("bench.quality.buildings", [], "planes of houses that are known"),
    "shapes": ("bench.quality.found_counts", [], "the number of planes of known shapes"),
    "mfcad": ("bench.quality.mfcad", [], "the number of planes of parts of MFCAD"),
    "round": ("bench.quality.curved", [], "cylinders, cones, spheres, revolutions, extrusions"),
    "step": ("bench.quality.step", [], "STEP files read back by OpenCASCADE"),
    "convex": ("bench.quality.convex", [], "convex parts, with --peers against CoACD and V-HACD"),
    "tiles": (
        "bench.studies.tiles",
        ["pieces", "fine:" + data("scan/dragon_871k.ply"), "2000"],
        "tiles against one",
    ),
}


def torus():
    """A torus with waves: 20,000 faces of a curved scan."""
    i, j = (g.ravel() for g in np.meshgrid(np.arange(100), np.arange(100), indexing="ij"))
    u, v = 2 * np.pi * i / 100, 2 * np.pi * j / 100
    tube = 0.4 + 0.05 * np.cos(5 * u) * np.cos(3 * v)
    points = np.stack([(1 + tube * np.cos(v)) * np.cos(u), (1 + tube * np.cos(v)) * np.sin(u), tube * np.sin(v)], 1)
    return points, shapes.torus(100, 100)[1]


def waves():
    from bench.quality.shape import run

    row, _, _ = run(engine.clean(*torus()), 300, {}, {})
    return {name: row[name] for name in ("polygons", "conc", "border", "D", "bend", "mean", "max")}


def walls():
    """Houses with noise of .1 %: faces in a region of another plane in %, and the corners' distance from the scan."""
    found = {"wrong": 0.0, "distance": 0.0, "polygons": 0.0}
    for seed in (1, 2, 3):
        made = houses.make(noise=0.001, seed=seed)
        result = engine.simplify((made.vertices, made.triangles), planar=True, regularise=True)
        region, label = result.partition.face_region, made.label[result.mesh.source_face]
        votes = np.zeros((result.partition.region_count, label.max() + 1))
        np.add.at(votes, (region[region >= 0], label[region >= 0]), 1)
        found["wrong"] += 100 * (1 - votes.max(axis=1).sum() / len(label))
        found["distance"] += 100 * result.polygons.report["distance_max"] / made.diagonal
        found["polygons"] += len(result.polygons.loop_start)
    return found


def rounds():
    """Three round shapes: the error of the radii in %, and parts that were not found."""
    found = {"radius": 0.0, "missed": 0.0}
    known = round_shapes.shapes()
    for name in ("column", "plate", "tee"):
        vertices, triangles = round_shapes.made(known[name])
        vertices = round_shapes.with_noise(vertices, 0.001, 1)
        part = engine.partition(engine.clean(vertices, triangles), engine.PartitionOptions(curved=True))
        wanted = [p.radius for p in known[name].parts]
        radii = [p.radius for p in part.curved]
        found["missed"] += max(0, len(wanted) - len(radii))
        found["radius"] += sum(100 * min(abs(r / w - 1) for w in wanted) for r in radii)
    return found


def solids():
    """Convex parts of three hollow solids."""
    found = {"parts": 0.0, "triangles": 0.0}
    for name in ("table", "crate", "room"):
        result = engine.simplify(hollow_solids.twin(getattr(hollow_solids, name)()), planar=True, keep_openings=True)
        parts = engine.convex_parts(result)
        found["parts"] += len(parts)
        found["triangles"] += sum(len(part.triangles) for part in parts)
    return found


def figures():
    groups = {"waves": waves, "walls": walls, "rounds": rounds, "solids": solids}
    return {f"{group} {name}": float(value) for group, make in groups.items() for name, value in make().items()}


def stages(count):
    """The first stages of the work whose operations are counted, with one thread."""
    mesh = engine.Mesh(*torus())
    if count > 0:
        part = engine.partition(mesh, engine.PartitionOptions(proxies=300, threads=1))
    if count > 1:
        engine.polygonize(mesh, part, engine.MeshingOptions(threads=1))


def operations():
    """Millions of instructions of each stage: the difference of a run with it and a run without it."""
    totals = []
    for count in range(len(STAGES) + 1):
        tool = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"]
        command = [*tool, sys.executable, "-m", "bench.public", "stages", str(count)]
        environment = os.environ | {"PYTHONHASHSEED": "0", "OMP_NUM_THREADS": "1"}
        done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"{' '.join(command)}: {done.stderr[-2000:]}")
        totals.append(int(re.search(r"Collected : (\d+)", done.stderr)[1]) / 1e6)
    return {name: after - before for name, before, after in zip(STAGES, totals, totals[1:], strict=False)}


def worse(new, old):
    """The figures that are worse than they may be, as lines. Figures that only one side has are worse too."""
    found = []
    for kind, factor in (("quality", QUALITY), ("operations", OPERATIONS)):
        if kind not in new:
            continue
        for name in sorted(new[kind].keys() | old[kind].keys()):
            a, b = old[kind].get(name), new[kind].get(name)
            if a is None or b is None or b > max(factor * a, a + (LEAST if kind == "quality" and a == 0 else 0)):
                found.append(f"{kind}: {name} {a} -> {b}, at most {factor} times as much is allowed")
    return found


def small(arguments):
    parser = argparse.ArgumentParser(prog="python -m bench.public small")
    parser.add_argument("--against", type=Path)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--no-operations", action="store_true")
    asked = parser.parse_args(arguments)
    new = {"quality": figures()} | ({} if asked.no_operations else {"operations": operations()})
    for kind, rows in new.items():
        for name, value in rows.items():
            print(f"{kind:10} {name:20} {value:12.4f}")
    if asked.json:
        asked.json.write_text(json.dumps(new, indent=1) + "\n")
    lines = worse(new, json.loads(asked.against.read_text())) if asked.against else []
    print(*lines, sep="\n")
    return bool(lines)


def main():
    task, *arguments = sys.argv[1:] or [""]
    if task == "stages":
        return stages(int(arguments[0]))
    if task == "small":
        return small(arguments)
    if task not in TASKS:
        rows = [f"  {name:10} {module:28} {about}" for name, (module, _, about) in TASKS.items()]
        print("small      checked every night, see --help of it", *rows, sep="\n")
        return 2 if task else 0
    module, before, _ = TASKS[task]
    sys.argv = [module, *before, *arguments]
    runpy.run_module(module, run_name="__main__", alter_sys=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
