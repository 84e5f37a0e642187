"""Times add and delete through Python, copies of the labels included: python_edits.py MESH PROXIES EDITS prints JSON.

MESH is a file, or made:torus:FACES for a small ring.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import isimp_engine as engine

sys.path.append(str(Path(__file__).resolve().parents[2]))
from tests.shared import shapes


def laps(edit: Callable[..., engine.Partition], mesh: engine.Mesh, start: engine.Partition, edits: int) -> list[float]:
    """Milliseconds of processor time of each edit, with the new labels read once."""
    taken = []
    for face in np.random.default_rng(1).integers(0, len(mesh.triangles), edits):
        begun = time.process_time()
        try:
            after = edit(mesh, start, int(face))
        except engine.InvalidInput:
            continue  # a region of one face, or the last one of its part
        np.array(after.face_region)
        taken.append(1e3 * (time.process_time() - begun))
    return taken


def main(name: str, proxies: str, edits: str) -> None:
    around = round((int(name.split(":")[-1]) / 2) ** 0.5) if name.startswith("made:") else 0
    mesh = engine.Mesh(*(shapes.torus(around, around) if around else engine.read(name)))
    start = engine.partition(mesh, engine.PartitionOptions(proxies=int(proxies), threads=1))
    both = {"add": engine.add_proxy, "delete": engine.delete_proxy}
    print(json.dumps({name: laps(edit, mesh, start, int(edits)) for name, edit in both.items()}))


if __name__ == "__main__":
    main(*sys.argv[1:])
