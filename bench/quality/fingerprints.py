"""Fingerprints of labels and polygons, one line for each mesh and setting.

Equal lines before and after a change mean that it changed no result.

    python -m bench.quality.fingerprints FOLDER [PART_OF_NAME ...] > after.txt; diff before.txt after.txt
"""

import hashlib
import sys
from pathlib import Path

import numpy as np

import isimp_engine as engine

COUNTS = ({"proxies": 50}, {"proxies": 300}, {"detail": 0.005})
SETTINGS = (  # settings for small meshes only
    {"proxies": 50, "method": "lloyd"},
    {"proxies": 50, "method": "lloyd", "seeding": "hierarchical"},
    {"detail": 0.01, "method": "teleport"},
    {"proxies": 50, "method": "naive"},
    {"detail": 0.01, "method": "queued", "connect": "flood"},
    {"proxies": 50, "method": "hybrid"},
    {"detail": 0.01, "method": "hybrid", "connect": "flood"},
    {"proxies": 50, "adaptivity": 0.25},
    {"detail": 0.01, "adaptivity": 0.5},
)
SMALL = 30_000  # faces


def fingerprint(*arrays: np.ndarray) -> str:
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()[:12]


def lines(path: Path):
    mesh = engine.clean(*engine.read(path))
    faces = len(mesh.triangles)
    yield "mesh", fingerprint(mesh.vertices, mesh.triangles, mesh.source_face)
    settings = COUNTS + ((*SETTINGS, {"bound": 0.01 * mesh.report["diagonal"]}) if faces <= SMALL else ())
    for setting in settings:
        options = {name: min(value, faces) if name == "proxies" else value for name, value in setting.items()}
        part = engine.partition(mesh, engine.PartitionOptions(**options))
        name = " ".join(f"{key}={value:.4g}" if key == "bound" else f"{key}={value}" for key, value in setting.items())
        yield f"labels {name}", fingerprint(part.face_region, part.region_seed, part.region_normal, part.history)
        if "method" not in setting:
            poly = engine.polygonize(mesh, part)
            yield f"polygons {name}", fingerprint(poly.vertices, poly.loops, poly.loop_start)


def main(folder: str, *wanted: str) -> None:
    for path in sorted(Path(folder).rglob("*")):
        name = path.relative_to(folder)
        if path.suffix not in {".ply", ".obj", ".stl", ".off"} or not all(text in str(name) for text in wanted):
            continue
        try:
            for what, found in lines(path):
                print(name, what, found, flush=True)
        except engine.InvalidInput as error:
            print(name, "refused:", error, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
