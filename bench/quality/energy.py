"""Runs energy models of real houses in EnergyPlus: severe errors, and surfaces that it calls concave.

    python -m bench.quality.energy [--data DIR] [--houses N] [--noise 0.001]

Houses are parts of buildings of DIR/lod2 (CityJSON), made dense, with noise as a share of the diagonal, and simplified
by `--planar --regularise --convex`. Each runs for a day in winter. It needs the package pyenergyplus-lbnl.

Columns: polygons; surfaces that are called non-convex; zones that are not enclosed; severe errors.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tempfile
from itertools import islice
from pathlib import Path

import numpy as np

import isimp_engine as engine
from bench.files import data_folder

EDGE = 0.02  # share of the diagonal
POLYGONS = 8, 60  # of a house: the least and the most
RUN = """
SimulationControl, No, No, No, Yes, No;
SizingPeriod:DesignDay, Winter, 1, 21, WinterDesignDay, -10, 0, , , WetBulb, -10, , , , , 101325, 3, 0, No, No, No,
  ASHRAEClearSky, , , , , 0;
Site:Location, Zurich, 47.4, 8.5, 1, 400;
Site:GroundTemperature:BuildingSurface, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10;
Output:Diagnostics, DisplayExtraWarnings;
"""

PROGRAM = """
import sys
from pyenergyplus.api import EnergyPlusAPI
api = EnergyPlusAPI()
state = api.state_manager.new_state()
api.runtime.set_console_output_status(state, False)
api.runtime.run_energyplus(state, ["-d", *sys.argv[1:]])
"""


def buildings(path: Path):
    """The parts of buildings of a CityJSON file by name, as OBJ text of their polygons."""
    city = json.loads(path.read_text())
    at = np.array(city["vertices"]) * city["transform"]["scale"]
    for name, part in city["CityObjects"].items():
        for geometry in part.get("geometry", ()):
            faces = geometry["boundaries"] if geometry["type"] == "MultiSurface" else geometry["boundaries"][0]
            without_holes = all(len(face) == 1 for face in faces)
            if without_holes and POLYGONS[0] <= len(faces) <= POLYGONS[1]:
                used = {v: k + 1 for k, v in enumerate(dict.fromkeys(v for face in faces for v in face[0]))}
                lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in at[list(used)].tolist()]
                yield name, "\n".join(lines + ["f " + " ".join(str(used[v]) for v in face[0]) for face in faces])


def dense(path: Path, noise: float, seed: int):
    """The triangles of a model, with edges of at most EDGE, and noise along the coordinates."""
    vertices, faces = engine.read(path)
    size = np.linalg.norm(np.ptp(vertices, axis=0))
    while True:
        sides = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2)
        ends, index = np.unique(sides.reshape(-1, 2), axis=0, return_inverse=True)
        is_long = np.linalg.norm(vertices[ends[:, 0]] - vertices[ends[:, 1]], axis=1) > EDGE * size
        if not is_long.any():
            break
        middle = np.where(is_long, len(vertices) + np.cumsum(is_long) - 1, -1)[index.reshape(-1, 3)]
        vertices = np.concatenate([vertices, vertices[ends[is_long]].mean(axis=1)])
        faces = np.array([part for f, m in zip(faces.tolist(), middle.tolist(), strict=True) for part in split(f, m)])
    return vertices + np.random.default_rng(seed).normal(0, noise * size, vertices.shape), faces


def split(face, middle):
    """A triangle cut at the middles of some of its sides; -1: this side stays whole."""
    outline = [v for pair in zip(face, middle, strict=True) for v in pair if v >= 0]
    while len(outline) > 3:  # cut off a corner between two middles, else at a middle
        k = next(
            (
                i
                for i, v in enumerate(outline)
                if v in face and {outline[i - 1], outline[(i + 1) % len(outline)]} <= set(middle)
            ),
            None,
        )
        if k is None:
            k = next(i for i, v in enumerate(outline) if outline[i - 1] in middle)
        yield [outline[k - 1], outline[k], outline[(k + 1) % len(outline)]]
        del outline[k]
    yield outline


def run(model: Path):
    """The lines of EnergyPlus's report of errors. A process of its own: a second run in one may hang."""
    with tempfile.TemporaryDirectory() as folder:
        whole = Path(folder) / "run.idf"
        whole.write_text(model.read_text() + RUN)
        subprocess.run([sys.executable, "-c", PROGRAM, folder, str(whole)], check=True, timeout=300)
        return (Path(folder) / "eplusout.err").read_text()


def main() -> None:
    command = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    command.add_argument("--data")
    command.add_argument("--houses", type=int, default=30)
    command.add_argument("--noise", type=float, default=0.001)
    arguments = command.parse_args()
    folder = data_folder(arguments.data) / "lod2"
    totals = np.zeros(4, int)
    with tempfile.TemporaryDirectory() as made:
        houses = islice(buildings(folder / "zurich_subset_lod2.json"), arguments.houses)
        for seed, (name, text) in enumerate(houses):
            (obj := Path(made) / "house.obj").write_text(text)
            result = engine.simplify(dense(obj, arguments.noise, seed), planar=True, regularise=True, convex=True)
            result.write(idf := Path(made) / "house.idf")
            errors = run(idf)
            row = [
                len(result.polygons.faces()),
                len(re.findall(r"CheckConvexity", errors)),
                len(re.findall(r"not fully enclosed", errors)),
                len(re.findall(r"\*\* Severe", errors)),
            ]
            totals += row
            print(f"{name[:20]:20}", *row, flush=True)
    print(f"{'all':20}", *totals)


if __name__ == "__main__":
    main()
