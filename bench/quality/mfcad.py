"""Counts the planes of parts of MFCAD (github.com/hducg/MFCAD, MIT) from noisy meshes of them.

    python -m bench.quality.mfcad [--data DIR] [--noise 0.001] [--parts N]

It needs OpenCASCADE (cadquery-ocp-novtk), and DIR/mfcad with mfcad_61.tar.xz (STEP files) and truth.csv (file, planes).
A part becomes a mesh whose edges are at most `EDGE` long, a share of the diagonal, with noise on each vertex. A row a
part: the number of planes, of regions and of polygons that the defaults make.
"""

import argparse
import csv
import tarfile
import tempfile
from pathlib import Path

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.TopAbs import TopAbs_FACE, TopAbs_REVERSED
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS

import isimp_engine as engine
from bench.quality.step import read
from bench.timer.run import data_folder

EDGE = 0.015


def triangles_of(shape):
    """Corners (F, 3, 3) of a coarse mesh of planar faces."""
    BRepMesh_IncrementalMesh(shape, 1e9, False, 10.0)
    walk, found = TopExp_Explorer(shape, TopAbs_FACE), []
    cast, triangulation = getattr(TopoDS, "Face_s", None) or TopoDS.Face, BRep_Tool.Triangulation_s
    while walk.More():
        face = cast(walk.Current())
        mesh = triangulation(face, TopLoc_Location())
        at = [mesh.Node(k + 1) for k in range(mesh.NbNodes())]
        nodes = np.array([[p.X(), p.Y(), p.Z()] for p in at])
        corners = np.array([mesh.Triangle(k + 1).Get() for k in range(mesh.NbTriangles())]) - 1
        found.append(nodes[corners[:, ::-1] if face.Orientation() == TopAbs_REVERSED else corners])
        walk.Next()
    return np.concatenate(found)


def refined(corners, most):
    """Halves all edges that are longer than `most`, until none is: conforming, since both sides halve the same."""
    while True:
        length = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)
        first = length.argmax(axis=1)
        long = length.max(axis=1) > most
        if not long.any():
            return corners
        turned = np.take_along_axis(corners, (first[:, None] + np.arange(3))[..., None] % 3, axis=1)
        a, b, c = turned[long].swapaxes(0, 1)
        middle = (a + b) / 2
        halves = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
        corners = np.concatenate([corners[~long], halves])


def scan_of(corners, noise, seed):
    size = np.linalg.norm(np.ptp(corners.reshape(-1, 3), axis=0))
    corners = refined(corners, EDGE * size)
    places, index = np.unique(np.round(corners.reshape(-1, 3), 9), axis=0, return_inverse=True)
    random = np.random.default_rng(seed)
    return places + random.normal(size=places.shape) * noise * size / np.sqrt(3), index.reshape(-1, 3).astype(np.int32)


def counts(archive, names, noise):
    """(name, regions, polygons) of each part."""
    with tarfile.open(archive) as file, tempfile.TemporaryDirectory() as folder:
        members = sorted((m for m in file.getmembers() if Path(m.name).name in names), key=lambda m: m.name)
        for seed, member in enumerate(members):
            path = Path(folder, Path(member.name).name)
            path.write_bytes(file.extractfile(member).read())
            made = engine.simplify(scan_of(triangles_of(read(path)), noise, seed))
            yield path.name, made.partition.region_count, len(made.polygons.loop_start)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", help="default: $ISIMP_DATA, else ../shared/data")
    parser.add_argument("--noise", type=float, default=0.001, help="share of the diagonal")
    parser.add_argument("--parts", type=int, help="only the first ones")
    asked = parser.parse_args()
    folder = data_folder(asked.data) / "mfcad"
    with (folder / "truth.csv").open() as file:
        planes = {row["file"]: int(row["planes"]) for row in csv.DictReader(file)}
    names = sorted(planes)[: asked.parts]
    misses = []
    for name, regions, polygons in counts(folder / "mfcad_61.tar.xz", names, asked.noise):
        misses.append(regions - planes[name])
        print(f"{name:36} planes {planes[name]:3}  regions {regions:3}  polygons {polygons:3}", flush=True)
    off = np.abs(misses)
    print(f"{len(off)} parts: {(off == 0).sum()} exact, {(off <= 2).sum()} within two, mean miss {off.mean():.2f}")


if __name__ == "__main__":
    main()
