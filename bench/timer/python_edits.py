"""Times add and delete through Python, copies of the labels included: python_edits.py MESH PROXIES EDITS prints JSON.

MESH is a file, or made:torus:FACES for a small ring.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable

import numpy as np

import isimp_engine as engine


def ring(faces: int) -> tuple[np.ndarray, np.ndarray]:
    """A grid closed in both directions."""
    n = max(3, round((faces / 2) ** 0.5))
    i, j = (g.ravel() for g in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    u, v = 2 * np.pi * i / n, 2 * np.pi * j / n
    r = 1 + 0.4 * np.cos(v)
    a, b, c, d = (((i + di) % n) * n + (j + dj) % n for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)))
    triangles = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    return np.column_stack([r * np.cos(u), r * np.sin(u), 0.4 * np.sin(v)]), triangles.astype(np.int32)


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
    arrays = ring(int(name.split(":")[-1])) if name.startswith("made:") else engine.read(name)
    mesh = engine.Mesh(*arrays)
    start = engine.partition(mesh, engine.PartitionOptions(proxies=int(proxies), threads=1))
    both = {"add": engine.add_proxy, "delete": engine.delete_proxy}
    print(json.dumps({name: laps(edit, mesh, start, int(edits)) for name, edit in both.items()}))


if __name__ == "__main__":
    main(*sys.argv[1:])
