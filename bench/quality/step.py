"""Measures STEP files of shapes whose truth is known: written from noisy scans, read back by OpenCASCADE.

    python -m bench.quality.step [--only column,vase] [--noise 0.001,0.003] [--seeds 1,2,3] [--json OUT.json]

`isimp_engine` and cadquery-ocp-novtk must be importable. A row is the mean of the seeds.

  faces true   faces of the file, and of the shape that was scanned
  valid solid  share of the files that OpenCASCADE finds valid once read, and that are one solid
  volume       largest difference from the volume of the scan, %
  parts        share of the round parts of the partition that have true surfaces
  axis radius  largest error of a round face against the part of the truth where it lies: degrees, %
  gap          largest distance of an edge from its faces, in thousandths of the diagonal
"""

import json
import tempfile
import time
from pathlib import Path

import numpy as np
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import TopAbs_FACE
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS

import isimp_engine as engine
from bench.generators.round_shapes import made, shapes, with_noise
from bench.quality.curved import shape_arguments

COLUMNS = ("faces", "true", "valid", "solid", "volume", "parts", "axis", "radius", "gap", "time")
_ONE_TO_THREE = {"torus": 1, "capped": 3, "cone": 3, "vase": 3, "capsule": 3, "silo": 3, "barrel": 3}
_MORE = {"elbow": 5, "tee": 5, "dome": 7, "shaft": 7, "link": 8, "knob": 8, "plate": 9, "vault": 10}
TRUE_FACES = _ONE_TO_THREE | _MORE | {"column": 13, "baluster": 13, "fillet": 26}


def read(path):
    """The shape of a file, in thousandths of scene units."""
    reader = STEPControl_Reader()
    reader.ReadFile(str(path))
    reader.TransferRoots()
    return reader.OneShape()


def solid_of(shape):
    """Volume in cubic scene units, whether OpenCASCADE finds the shape valid, and whether it is one solid."""
    volume = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, volume)
    return volume.Mass() * 1e-9, BRepCheck_Analyzer(shape).IsValid(), "SOLID" in str(shape.ShapeType())


def round_faces(shape):
    """(kind, axis or None, radius or None, a place on it) of each face that is no plane."""
    walk, face = TopExp_Explorer(shape, TopAbs_FACE), getattr(TopoDS, "Face_s", None) or TopoDS.Face
    count, found = 0, []
    while walk.More():
        surface = BRepAdaptor_Surface(face(walk.Current()))
        kind = str(surface.GetType()).rsplit("_", 1)[-1]
        p = surface.Value(
            (surface.FirstUParameter() + surface.LastUParameter()) / 2,
            (surface.FirstVParameter() + surface.LastVParameter()) / 2,
        )
        place = np.array([[p.X(), p.Y(), p.Z()]]) / 1000
        count += 1
        walk.Next()
        if kind == "Plane":
            continue
        body = surface.AxeOfRevolution() if kind == "SurfaceOfRevolution" else getattr(surface, kind)()
        axis = body.Direction() if kind == "SurfaceOfRevolution" else body.Position().Direction()
        radius = body.Radius() / 1000 if kind in ("Cylinder", "Sphere") else None
        found.append((kind, None if kind == "Sphere" else np.array([axis.X(), axis.Y(), axis.Z()]), radius, place))
    return count, found


def against_truth(parts, faces):
    """Largest errors of axes and radii, each against the part of the truth that is nearest."""
    axes, radii = [], []
    for _, axis, radius, place in faces:
        part = min(parts, key=lambda p, at=place: abs(float(p.distance(at)[0])))
        if axis is not None and part.axis is not None:
            cosine = abs(float(axis @ np.asarray(part.axis))) / float(np.linalg.norm(part.axis))
            axes.append(float(np.degrees(np.arccos(min(1.0, cosine)))))
        if radius is not None and part.radius is not None:
            radii.append(abs(radius / part.radius - 1) * 100)
    return max(axes, default=np.nan), max(radii, default=np.nan)


def row_of(name, shape, noise, seed, folder):
    clean_vertices, faces = made(shape)
    vertices = with_noise(clean_vertices, noise, seed)
    mesh = engine.clean(vertices, faces)
    part = engine.partition(mesh, engine.PartitionOptions(curved=True))
    poly = engine.polygonize(mesh, part, engine.MeshingOptions(planar=True))
    path, begin = folder / f"{name}.step", time.process_time()
    told = engine.write(path, poly, partition=part, mesh=mesh)
    seconds = time.process_time() - begin
    found = read(path)
    volume, valid, solid = solid_of(found)
    corners = vertices[faces]
    scan = float((corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])).sum() / 6)
    count, curved = round_faces(found)
    axis, radius = against_truth(shape.parts, curved)
    true, planes = len(told["true_surfaces"]), len(told["planes"])
    return {
        "faces": float(count),
        "true": float(TRUE_FACES[name]),
        "valid": float(valid),
        "solid": float(solid),
        "volume": abs(volume / scan - 1) * 100,
        "parts": true / (true + planes) if true + planes else np.nan,
        "axis": axis,
        "radius": radius,
        "gap": told["gap"] / mesh.report["diagonal"] * 1000,
        "time": seconds,
        "planes": told["planes"],
    }


def over(rows):
    most = ("volume", "axis", "radius", "gap")
    row = {}
    for column in COLUMNS:
        values = np.array([r[column] for r in rows])
        values = values[np.isfinite(values)]
        row[column] = float(values.max() if column in most else values.mean()) if len(values) else np.nan
    return row


def line(name, row):
    return f"{name:22s}" + "".join(f"{row[c]:8.3f}" for c in COLUMNS)


def main():
    given = shape_arguments(__doc__, "0.001,0.003").parse_args()
    known, all_rows = shapes(), {}
    names = [n for n in given.only.split(",") if n] or list(known)
    for noise in map(float, given.noise.split(",")):
        print(f"{f'noise {noise * 100:.2g} %':22s}" + "".join(f"{c:>8s}" for c in COLUMNS), flush=True)
        every = []
        for name in names:
            with tempfile.TemporaryDirectory() as folder:
                seeds = [int(s) for s in given.seeds.split(",")]
                rows = [row_of(name, known[name], noise, seed, Path(folder)) for seed in seeds]
            all_rows[f"{name} {noise}"] = rows
            every += rows
            print(line(name, over(rows)), flush=True)
        print(line("all", over(every)), flush=True)
        counts = [r for r in every if r["parts"] == 1.0]
        few = sum(r["faces"] <= 1.2 * r["true"] for r in every), sum(r["faces"] <= 1.2 * r["true"] for r in counts)
        print(f"at most 1.2 x the true faces: {few[0]} of {len(every)}; with all parts true: {few[1]} of {len(counts)}")
    if given.json:
        given.json.write_text(json.dumps(all_rows, indent=1))


if __name__ == "__main__":
    main()
