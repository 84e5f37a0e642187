"""Compares models of parts of MFCAD (github.com/hducg/MFCAD, MIT) with the planes of the parts.

    python -m bench.quality.mfcad [--data DIR] [--first N] [--parts N] [--turned] [--preset NAME] [--seed N]
        [--noise 0.001] [--step]
        [--grid 64,128,256] [--dual] [--smoothed 3] [--defects]

It needs OpenCASCADE (cadquery-ocp-novtk), and DIR/mfcad with mfcad_61.tar.xz (STEP files) and truth.csv (file, planes).
A part becomes a scan, whose edges are at most `EDGE` long, a share of the diagonal, with noise on each vertex; with
--grid marching cubes make it of signed distances, in as many cells as the longest side of its box has. --turned: by any
angle. --preset: of the add-on; else the defaults. A row a part:

  planes     of the part
  regions    and polygons of the result
  found      planes that a polygon has within 2 degrees and half a cell or noise; on a grid those 4 cells wide, `large`
  degrees    angle between a plane of the part and the polygons of its region, at most, and of 95 %; square: the largest
             change of a right angle between two planes
  noises     distance of it at the centre of the plane, in noises (cells for a grid), at most
  hidden     polygons of inner walls and crumbs
  volume     error of it in %, of the STEP file, which must be valid and one solid (--step)

With --step the planes are made regular and polygons planar.
"""

import argparse
import csv
import json
import tarfile
import tempfile
import time
from pathlib import Path

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.TopAbs import TopAbs_FACE, TopAbs_REVERSED
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS

import isimp_engine as engine
from bench.files import data_folder
from bench.generators.known_shapes import rotation
from bench.generators.real_scans import marching_cubes
from bench.generators.solid_grids import distances, dual_contouring, smoothed, with_defects
from bench.quality.step import read, solid_of
from isimp_engine.recipe.presets import BY_NAME

EDGE = 0.015
MARGIN = 9  # cells outside the box of a part


def triangles_of(shape):
    """Corners (F, 3, 3) of a coarse mesh of planar faces, and the face of each."""
    BRepMesh_IncrementalMesh(shape, 1e9, False, 10.0)
    walk, found, faces = TopExp_Explorer(shape, TopAbs_FACE), [], []
    cast, triangulation = getattr(TopoDS, "Face_s", None) or TopoDS.Face, BRep_Tool.Triangulation_s
    while walk.More():
        face = cast(walk.Current())
        mesh = triangulation(face, TopLoc_Location())
        at = [mesh.Node(k + 1) for k in range(mesh.NbNodes())]
        nodes = np.array([[p.X(), p.Y(), p.Z()] for p in at])
        corners = np.array([mesh.Triangle(k + 1).Get() for k in range(mesh.NbTriangles())]) - 1
        faces.append(np.full(len(corners), len(found)))
        found.append(nodes[corners[:, ::-1] if face.Orientation() == TopAbs_REVERSED else corners])
        walk.Next()
    return np.concatenate(found), np.concatenate(faces)


def refined(corners, face, most):
    """Halves all edges that are longer than `most`, until none is: conforming, since both sides halve the same."""
    while True:
        length = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)
        first = length.argmax(axis=1)
        long = length.max(axis=1) > most
        if not long.any():
            return corners, face
        turned = np.take_along_axis(corners, (first[:, None] + np.arange(3))[..., None] % 3, axis=1)
        a, b, c = turned[long].swapaxes(0, 1)
        middle = (a + b) / 2
        halves = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
        corners, face = np.concatenate([corners[~long], halves]), np.concatenate([face[~long], face[long], face[long]])


def scan_of(corners, face, noise, seed):
    """Vertices, triangles, and the part's face of each triangle. noise: scene units."""
    corners, face = refined(corners, face, EDGE * size_of(corners))
    places, index = np.unique(np.round(corners.reshape(-1, 3), 9), axis=0, return_inverse=True)
    random = np.random.default_rng(seed)
    return places + random.normal(size=places.shape) * noise / np.sqrt(3), index.reshape(-1, 3).astype(np.int32), face


def grid_of(corners, face, asked, cells, seed):
    """As scan_of, of a mesh cut on a grid, and its cell."""
    low, high = (f(corners.reshape(-1, 3), axis=0) for f in (np.min, np.max))
    cell = (high - low).max() / cells
    origin = low - cell * (MARGIN + np.random.default_rng(seed).uniform(0.2, 0.8, 3))
    field, nearest = distances(corners, origin, cell, np.ceil((high - low) / cell).astype(int) + 2 * MARGIN + 1)
    points, triangles = dual_contouring(field) if asked.dual else marching_cubes(field)
    points, triangles = smoothed(points, triangles, asked.smoothed)
    if asked.defects:
        points, triangles = with_defects(points, triangles, field, seed)
    at = np.clip(points[triangles].mean(axis=1).round().astype(int), 0, np.array(nearest.shape) - 1)
    inner = np.abs(field[tuple(at.T)]) > 2
    return points * cell + origin, triangles, np.where(inner, -1, face[nearest[tuple(at.T)]]), cell


def size_of(corners):
    return float(np.linalg.norm(np.ptp(corners.reshape(-1, 3), axis=0)))


def sides(corners, group):
    """(area, normal, centre) of each group of triangles or fans."""
    product = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    area, count = np.linalg.norm(product, axis=1), group.max() + 1
    sums = np.stack([np.bincount(group, product[:, k], count) for k in range(3)], 1)
    centre = np.stack([np.bincount(group, area * corners.mean(axis=1)[:, k], count) for k in range(3)], 1)
    total = np.maximum(np.bincount(group, area, count), 1e-300)[:, None]
    return total[:, 0], sums / np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-300), centre / total


def fans(poly):
    """Triangles of polygons, and the region of each."""
    points, found = np.asarray(poly.vertices), []
    for loop, region in zip(np.split(poly.loops, poly.loop_start[1:]), poly.polygon_region, strict=True):
        found += [(points[loop[[0, k, k + 1]]], region) for k in range(1, len(loop) - 1)]
    return np.array([corners for corners, _ in found]), np.array([region for _, region in found])


def row_of(made, corners, face, label, length):
    """The columns of a result. label: the part's face of each face of the scan; -1: none. length: noise or cell."""
    mesh, part, poly = made.mesh, made.partition, made.polygons
    _, normal, centre = sides(corners, face)
    region, faces = np.asarray(part.face_region), np.asarray(mesh.source_face)
    label = np.where(faces >= 0, label[np.maximum(faces, 0)], -1)
    shared = np.zeros((part.region_count, len(normal) + 1))
    np.add.at(shared, (region[region >= 0], label[region >= 0]), 1)
    _, mean, middle = sides(*fans(poly))
    best = np.minimum(shared[:, :-1].argmax(axis=0), len(mean) - 1)
    degrees = np.degrees(np.arccos((mean[best] * normal).sum(axis=1).clip(-1, 1)))
    off = np.abs(((centre - middle[best]) * mean[best]).sum(axis=1)) / length if length else np.zeros(len(normal))
    a, b = np.nonzero(np.triu(np.abs(normal @ normal.T) < 1e-9))
    cosine = np.abs((np.asarray(part.region_normal)[best[a]] * np.asarray(part.region_normal)[best[b]]).sum(axis=1))
    hidden = (shared.argmax(axis=1) == len(normal))[np.asarray(poly.polygon_region)].sum()
    return {
        "planes": len(normal),
        "regions": part.region_count,
        "polygons": len(poly.loop_start),
        "close": (degrees <= 2) & (off <= 0.5),
        "degrees": float(degrees.max()),
        "95 %": float(np.quantile(degrees, 0.95)),
        "noises": float(off.max()),
        "square": float(np.degrees(np.arcsin(cosine.max(initial=0)))),
        "hidden": int(hidden),
    }


def widths(corners, face):
    """The smallest extent of each plane of the part, in its plane."""
    found = []
    for k in range(face.max() + 1):
        points = corners[face == k].reshape(-1, 3)
        _, _, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
        turns = np.linspace(0, np.pi, 90, endpoint=False)
        flat = (points - points.mean(axis=0)) @ axes[:2].T
        found.append(np.ptp(flat @ np.stack([np.cos(turns), np.sin(turns)]), axis=0).min())
    return np.array(found)


def options_of(asked):
    """The options of `simplify` for a preset, with the detail that it takes for a scan."""
    if asked.preset is None:
        return {}
    preset = BY_NAME[asked.preset]
    step = preset.partition_for(is_scanned=bool(asked.grid) or asked.noise > 0)
    names = ("detail", "adaptivity", "leave_out", "sharp_edges", "curved", "snap", "noise", "outside_only")
    given = {name: getattr(step, name) for name in names}
    given = {name: value for name, value in given.items() if isinstance(value, bool) or value >= 0}
    given |= {"planar": True, "planar_most": preset.mesh.planar_most} if preset.mesh.planar else {}
    return given | ({"regularise": True} if preset.regularise else {})


def in_step(made, corners):
    """The columns of the STEP file of a result."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "part.step")
        told = engine.write(path, made.polygons, partition=made.partition, mesh=made.mesh)
        volume, valid, solid = solid_of(read(path))
    true = float((corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])).sum() / 6)
    return {"faces": told["faces"], "valid": bool(valid and solid), "volume": abs(volume / true - 1) * 100}


def rows(archive, names, asked):
    options = options_of(asked) | ({"regularise": True, "planar": True} if asked.step else {})
    cells = [int(n) for n in asked.grid.split(",") if n]
    with tarfile.open(archive) as file, tempfile.TemporaryDirectory() as folder:
        members = sorted((m for m in file.getmembers() if Path(m.name).name in names), key=lambda m: m.name)
        for number, member in enumerate(members):
            path, seed = Path(folder, Path(member.name).name), asked.seed + number
            path.write_bytes(file.extractfile(member).read())
            corners, face = triangles_of(read(path))
            if asked.turned:
                corners = corners @ rotation(np.random.default_rng(seed + 1000)).T
            for cut in cells or [None]:
                length = asked.noise * size_of(corners)
                if cut:
                    *scan, label, length = grid_of(corners, face, asked, cut, seed)
                else:
                    *scan, label = scan_of(corners, face, length, seed)
                begin = time.process_time()
                made = engine.simplify(tuple(scan), **options)
                row = row_of(made, corners, face, label, length)
                row |= {"name": path.stem, "cells": cut, "seconds": time.process_time() - begin}
                large = widths(corners, face) > 4 * length if cut else np.ones(row["planes"], bool)
                row |= {"found": int((row.pop("close") & large).sum()), "large": int(large.sum())}
                yield row | in_step(made, corners) if asked.step else row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", help="default: $ISIMP_DATA, else ../shared/data")
    parser.add_argument("--noise", type=float, default=0.001, help="share of the diagonal")
    parser.add_argument("--first", type=int, default=0, help="without so many parts")
    parser.add_argument("--parts", type=int, help="only so many")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--turned", action="store_true")
    parser.add_argument("--preset", help="of the add-on")
    parser.add_argument("--step", action="store_true", help="write and read STEP files")
    parser.add_argument("--grid", default="", help="cells along the longest side")
    parser.add_argument("--dual", action="store_true", help="dual contouring")
    parser.add_argument("--smoothed", type=int, default=0)
    parser.add_argument("--defects", action="store_true", help="inner walls, crumbs, doubled faces")
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args()
    folder = data_folder(asked.data) / "mfcad"
    with (folder / "truth.csv").open() as file:
        names = sorted(row["file"] for row in csv.DictReader(file))[asked.first :][: asked.parts]
    made = []
    for row in rows(folder / "mfcad_61.tar.xz", names, asked):
        made.append(row)
        print("  ".join(f"{k} {v:.3g}" if isinstance(v, float) else f"{k} {v}" for k, v in row.items()), flush=True)
    off = np.abs([row["regions"] - row["planes"] for row in made])
    print(f"{len(off)} parts: {(off == 0).sum()} exact, {(off <= 1).sum()} within one, mean miss {off.mean():.2f}")
    print(f"all planes found: {sum(row['found'] == row['large'] for row in made)}; "
          f"polygons at most 1.1 times: {sum(row['polygons'] <= 1.1 * row['planes'] for row in made)}; "
          f"no hidden polygon: {sum(row['hidden'] == 0 for row in made)}")  # fmt: skip
    if asked.step:
        good = [row for row in made if row["valid"]]
        print(f"STEP: {len(good)} valid solids, {sum(r['faces'] == r['planes'] for r in made)} with all faces, "
              f"{sum(r['volume'] <= 0.2 for r in made)} within .2 % of the volume, "
              f"{sum(r['square'] < 1e-6 for r in made)} with exact right angles, 95 % of the planes within "
              f"{np.median([r['95 %'] for r in made]):.2f} degrees")  # fmt: skip
    if asked.json:
        asked.json.write_text(json.dumps(made, indent=1))


if __name__ == "__main__":
    main()
