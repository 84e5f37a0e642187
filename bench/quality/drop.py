"""Drops 200 boxes on convex parts in MuJoCo: how many pass a part, and how many steps a second it makes.

    python -m bench.quality.drop [--peers] [--only NAME]
      --peers             CoACD too, where the package coacd is installed

Scenes: the floor plan of hollow_solids.py, and scanned rooms whose walls get a thickness. Boxes of 6 cm start at rest
in free space and fall for two seconds. A box is lost if it is below the lowest part or in a part at the end, and its
centre was a centimetre deep in a part before. Others fell out of openings that the scan has behind its furniture.
Needs the package mujoco.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np

import isimp_engine as engine
from bench.generators import hollow_solids, real_scans
from bench.quality.convex import coacd, in_front, outside, planes_of
from isimp_engine.convex import Convex
from isimp_engine.exporting import colliders

BOXES = 200
HALF = 0.03  # metres
SECONDS = 2.0
STEP = 0.002
SEEN = 5  # steps between two looks


def drop(parts, places):
    """The places of boxes as they fall, (T, B, 3), and steps a second."""
    import mujoco

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.xml"
        colliders.write(path, "scene", parts, "plain", path)
        spec = mujoco.MjSpec.from_file(str(path))
        spec.option.timestep = STEP
        for place in places:
            body = spec.worldbody.add_body(pos=place.tolist())
            body.add_freejoint()
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[HALF] * 3, mass=0.2)
        model = spec.compile()
    data = mujoco.MjData(model)
    path = []
    begun = time.process_time()
    for _ in range(round(SECONDS / STEP / SEEN)):
        mujoco.mj_step(model, data, SEEN)
        path.append(data.xpos[-len(places) :].copy())
    return np.array(path), round(SECONDS / STEP) / (time.process_time() - begun)


def scenes():
    solid = hollow_solids.floor_plan()
    yield "floor plan", *hollow_solids.twin(solid), False
    for seed in (1, 2, 3):
        yield f"room {seed}", *real_scans.room(seed), True


def main():
    command = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    command.add_argument("--peers", action="store_true")
    command.add_argument("--only")
    arguments = command.parse_args()
    for name, vertices, faces, is_open in scenes():
        if arguments.only and arguments.only not in name:
            continue
        result = engine.simplify(
            (vertices, faces), planar=True, keep_openings=not is_open
        )  # boxes fall through holes of a floor
        made = {"ours": engine.convex_parts(result, thickness=is_open)}
        if arguments.peers:
            found = coacd(vertices, faces, None, arguments)
            made["coacd"] = [Convex(points, corners, 0.0) for points, corners in found]
        low, high = np.quantile(vertices, 0.1, axis=0), np.quantile(vertices, 0.9, axis=0)
        rng = np.random.default_rng(1)
        points = rng.uniform(low, high, (40 * BOXES, 3))
        if is_open:  # its furniture is hollow
            points = in_front(vertices, faces, float(np.linalg.norm(np.ptp(vertices, axis=0))), rng)
        for parts in made.values():
            points = points[outside([planes_of(p.vertices, p.triangles) for p in parts], points) > 2 * HALF]
        for maker, parts in made.items():
            planes = [planes_of(part.vertices, part.triangles) for part in parts]
            path, speed = drop(parts, points[:BOXES])
            floor = min(part.vertices[:, 2].min() for part in parts)
            deep = outside(planes, path.reshape(-1, 3)).reshape(path.shape[:2]) < -HALF / 3
            gone = deep[-1] | (path[-1, :, 2] < floor)
            lost, out = (gone & deep.any(axis=0)).sum(), (gone & ~deep.any(axis=0)).sum()
            told = f"boxes {path.shape[1]}  lost {lost}  out {out}  {speed:.0f} steps/s"
            print(f"{name:12} {maker:6} parts {len(parts)}  {told}", flush=True)


if __name__ == "__main__":
    main()
