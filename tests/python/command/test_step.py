"""STEP, read back by OpenCASCADE, whose shapes are compared with the shapes that were scanned."""

import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import isimp_engine as engine
from bench.generators.round_shapes import made, shapes, with_noise
from isimp_engine.cli import main
from isimp_engine.exporting.step.fitting import joined, round_of
from isimp_engine.exporting.step.meeting import settle, touch
from isimp_engine.exporting.step.outlines import outlines
from isimp_engine.exporting.step.shapes import Cone, Cylinder, Plane, Sphere, Spun, Torus, circle_of
from isimp_engine.exporting.step.triangles import ears

Z, X, ZERO = np.array([0.0, 0, 1]), np.array([1.0, 0, 0]), np.zeros(3)
SHAPES = shapes()


class Read:
    """A STEP file as OpenCASCADE reads it: its surfaces in millimetres, the volume in cubic metres."""

    def __init__(self, path: Path) -> None:
        from OCP.BRepCheck import BRepCheck_Analyzer
        from OCP.BRepGProp import BRepGProp
        from OCP.GProp import GProp_GProps
        from OCP.STEPControl import STEPControl_Reader

        reader = STEPControl_Reader()
        reader.ReadFile(str(path))
        reader.TransferRoots()
        self.shape = reader.OneShape()
        found = GProp_GProps()
        BRepGProp.VolumeProperties_s(self.shape, found)
        self.volume = found.Mass() * 1e-9
        self.valid = bool(BRepCheck_Analyzer(self.shape).IsValid())
        self.solid = "SOLID" in str(self.shape.ShapeType())
        self.surfaces = list(self._surfaces())
        self.kinds = sorted(kind for kind, _ in self.surfaces)

    def _surfaces(self) -> Iterator[tuple[str, Any]]:
        from OCP.BRepAdaptor import BRepAdaptor_Surface
        from OCP.TopAbs import TopAbs_FACE
        from OCP.TopExp import TopExp_Explorer
        from OCP.TopoDS import TopoDS

        walk, face = TopExp_Explorer(self.shape, TopAbs_FACE), getattr(TopoDS, "Face_s", None) or TopoDS.Face
        while walk.More():
            surface = BRepAdaptor_Surface(face(walk.Current()))
            yield str(surface.GetType()).rsplit("_", 1)[-1], surface
            walk.Next()


@pytest.fixture
def read() -> Callable[[Path], Read]:
    pytest.importorskip("OCP", reason="cadquery-ocp-novtk is not installed")
    return Read


def scanned(name: str, noise: float = 0.001, seed: int = 1) -> tuple[engine.Mesh, engine.Partition, engine.PolygonMesh]:
    vertices, faces = made(SHAPES[name])
    mesh = engine.clean(with_noise(vertices, noise, seed), faces)
    part = engine.partition(mesh, engine.PartitionOptions(curved=True))
    return mesh, part, engine.polygonize(mesh, part, engine.MeshingOptions(planar=True))


def volume_of(mesh: engine.Mesh) -> float:
    corners = np.asarray(mesh.vertices)[np.asarray(mesh.triangles)]
    return float((corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])).sum() / 6)


def degrees(direction: Any, truth: np.ndarray) -> float:
    found = np.array([direction.X(), direction.Y(), direction.Z()])
    return float(np.degrees(np.arccos(min(1.0, abs(found @ truth) / np.linalg.norm(truth)))))


TRUE_FACES = {  # the surfaces of the solids that were scanned
    "column": ["Cylinder"] + ["Plane"] * 12,
    "capped": ["Cylinder"] + ["Plane"] * 2,
    "cone": ["Cone"] + ["Plane"] * 2,
    "dome": ["Plane"] * 6 + ["Sphere"],
    "torus": ["Torus"],
    "elbow": ["Cylinder"] * 2 + ["Plane"] * 2 + ["Torus"],
    "vase": ["Plane"] * 2 + ["SurfaceOfRevolution"],
    "plate": ["Cylinder"] * 3 + ["Plane"] * 6,
    "tee": ["Cylinder"] * 2 + ["Plane"] * 3,
    "shaft": ["Cylinder"] * 3 + ["Plane"] * 4,
    "knob": ["Cylinder"] + ["Plane"] * 6 + ["Sphere"],
}


@pytest.mark.parametrize("name", TRUE_FACES)
def test_a_noisy_scan_gives_the_solid_that_was_scanned(name: str, tmp_path: Path, read: Any) -> None:
    mesh, part, poly = scanned(name)
    told = engine.write(tmp_path / "a.step", poly, partition=part, mesh=mesh)
    found = read(tmp_path / "a.step")
    assert found.valid
    assert found.solid
    assert found.kinds == TRUE_FACES[name]
    assert found.volume == pytest.approx(volume_of(mesh), rel=0.005)
    assert told["valid"]
    assert told["faces"] == len(found.surfaces)
    assert told["volume"] == pytest.approx(found.volume, rel=2e-5)  # integrated over the torus of the elbow
    assert [row["number"] for row in told["true_surfaces"]] == [patch.number for patch in part.curved]
    assert told["planes"] == []


def test_axes_and_radii_equal_the_plate(tmp_path: Path, read: Any) -> None:
    mesh, part, poly = scanned("plate")
    engine.write(tmp_path / "plate.stp", poly, partition=part, mesh=mesh)
    holes = [surface.Cylinder() for kind, surface in read(tmp_path / "plate.stp").surfaces if kind == "Cylinder"]
    assert max(degrees(hole.Axis().Direction(), Z) for hole in holes) < 0.2
    assert sorted(hole.Radius() for hole in holes) == pytest.approx([350, 450, 550], rel=0.005)


@pytest.mark.parametrize("unit", ["m", "mm"])
def test_the_file_has_the_unit_and_the_place(unit: str, tmp_path: Path, read: Any) -> None:
    vertices, faces = made(SHAPES["capped"])
    mesh = engine.clean(vertices + [450000.25, 5500000.5, 112.0], faces)
    part = engine.partition(mesh, engine.PartitionOptions(curved=True))
    poly = engine.polygonize(mesh, part, engine.MeshingOptions(planar=True))
    path = tmp_path / "a.step"
    engine.write(path, poly, partition=part, mesh=mesh, unit=unit)
    assert ("SI_UNIT(.MILLI.,.METRE.)" in path.read_text()) == (unit == "mm")
    found = read(path)
    assert found.valid
    (axis,) = [surface.Cylinder().Axis() for kind, surface in found.surfaces if kind == "Cylinder"]
    place, scale = axis.Location(), 1e-3 if unit == "m" else 1.0
    away = np.array([place.X(), place.Y(), place.Z()]) * scale - [450000.25, 5500000.5, 112.0]
    along = np.array([0.3, 0.2, 1]) / np.linalg.norm([0.3, 0.2, 1])
    assert np.linalg.norm(away - (away @ along) * along) < 0.001


def test_the_same_input_gives_the_same_file(tmp_path: Path, read: Any) -> None:
    mesh, part, poly = scanned("dome")
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        engine.write(tmp_path / name / "dome.step", poly, partition=part, mesh=mesh)
    assert (tmp_path / "a" / "dome.step").read_bytes() == (tmp_path / "b" / "dome.step").read_bytes()
    assert read(tmp_path / "a" / "dome.step").valid


def test_a_name_of_any_letters_is_written_in_ascii(tmp_path: Path, read: Any) -> None:
    mesh, part, poly = scanned("capped")
    path = tmp_path / "Säule's 漢.step"
    engine.write(path, poly, partition=part, mesh=mesh)
    text = path.read_bytes().decode("ascii")
    assert "PRODUCT('S_ule''s _'" in text
    assert read(path).valid


def test_polygons_alone_are_a_solid_of_planes(tmp_path: Path, read: Any) -> None:
    mesh, _, poly = scanned("capped")
    told = engine.write(tmp_path / "a.step", poly)
    found = read(tmp_path / "a.step")
    assert found.valid
    assert found.solid
    assert set(found.kinds) == {"Plane"}
    assert told["faces"] == len(poly.loop_start)
    assert found.volume == pytest.approx(volume_of(mesh), rel=0.02)


def test_bent_polygons_become_triangles_of_a_valid_solid(tmp_path: Path, read: Any) -> None:
    mesh, part, _ = scanned("vase")
    poly = engine.polygonize(mesh, engine.release_round(mesh, part, int(np.flatnonzero(part.face_region == 0)[0])))
    told = engine.write(tmp_path / "a.step", poly)
    assert told["triangulated"] > 0
    found = read(tmp_path / "a.step")
    assert found.valid
    assert found.solid
    assert len(found.surfaces) == told["faces"] > len(poly.loop_start)


def test_a_part_without_a_valid_face_is_planes_and_the_report_has_the_reason(tmp_path: Path, read: Any) -> None:
    mesh, part, poly = scanned("vault")
    told = engine.write(tmp_path / "a.step", poly, partition=part, mesh=mesh)
    assert told["true_surfaces"] == []
    ((number, reason),) = [row.values() for row in told["planes"]]
    assert (number, reason) == (0, "its face is not valid")
    found = read(tmp_path / "a.step")
    assert found.valid
    assert found.solid
    assert set(found.kinds) == {"Plane"}


def test_an_open_scan_gives_a_shell(tmp_path: Path, read: Any) -> None:
    vertices, faces = made(SHAPES["capped"])
    up = np.array([0.3, 0.2, 1]) / np.linalg.norm([0.3, 0.2, 1])
    mesh = engine.clean(vertices, faces[(vertices[faces].mean(axis=1) @ up) < 0.7])
    part = engine.partition(mesh, engine.PartitionOptions(curved=True))
    poly = engine.polygonize(mesh, part, engine.MeshingOptions(planar=True))
    told = engine.write(tmp_path / "a.step", poly, partition=part, mesh=mesh)
    found = read(tmp_path / "a.step")
    assert told["solids"] == 0
    assert told["volume"] is None
    assert found.valid
    assert not found.solid
    assert found.kinds == ["Cylinder", "Plane"]


def test_the_command_writes_step_and_reports_true_surfaces(tmp_path: Path, read: Any, capsys: Any) -> None:
    vertices, faces = made(SHAPES["capped"])
    scan, out, report = tmp_path / "scan.ply", tmp_path / "out.step", tmp_path / "report.json"
    _write(scan, vertices, faces)
    command = ["simplify", str(scan), str(out), "--curved", "--unit", "mm", "--report", str(report)]
    assert main(command) == 0
    said = capsys.readouterr().out
    assert "STEP: a solid, 3 faces, valid; true surfaces for 1 of 1 round part" in said
    whole = json.loads(report.read_text())
    assert whole["step"]["true_surfaces"] == [{"number": 0, "kind": "cylinder"}]
    (wide,) = [row for row in whole["sizes"] if row["kind"] == "diameter"]
    (high,) = [row for row in whole["sizes"] if row["kind"] == "distance"]
    names = sorted(re.findall(r"ADVANCED_FACE\('([^']*)'", out.read_text()))
    assert names == sorted(
        [f"cylinder {wide['name']} {wide['value']:.6g}", *(f"plane {high[end]}" for end in ("of", "to"))]
    )
    assert read(out).kinds == ["Cylinder", "Plane", "Plane"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out.step", "report.json", "scan.ply"]


def _write(path: Path, vertices: np.ndarray, faces: np.ndarray) -> None:
    lines = ["ply", "format ascii 1.0", f"element vertex {len(vertices)}", *(f"property double {k}" for k in "xyz")]
    lines += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    lines += [" ".join(map(repr, row)) for row in vertices.tolist()] + [f"3 {a} {b} {c}" for a, b, c in faces.tolist()]
    path.write_text("\n".join(lines) + "\n")


class Polled:
    """A job that counts the questions whether it was cancelled, and is so from a given one on."""

    def __init__(self, stop: float = np.inf) -> None:
        self.stop, self.polls = stop, 0

    @property
    def cancelled(self) -> bool:
        self.polls += 1
        return self.polls > self.stop


def test_a_cancel_is_seen_for_each_face_and_edge(read: Any) -> None:
    from isimp_engine.exporting.step.solid import make

    mesh, part, polygons = scanned("plate")
    job = Polled()
    solid = make(polygons, part, mesh, job)  # type: ignore[arg-type]
    assert job.polls > 4 * solid.faces
    for stop in range(0, job.polls, job.polls // 8):
        with pytest.raises(engine.Cancelled):
            make(polygons, part, mesh, Polled(stop))  # type: ignore[arg-type]


def test_an_unknown_unit_is_refused(tmp_path: Path) -> None:
    with pytest.raises(engine.InvalidInput, match="unit must be one of m, mm, cm, um, in, ft, got 'yd'"):
        engine.write(tmp_path / "a.obj", scanned("capped")[2], unit="yd")


def test_no_polygons_are_refused(tmp_path: Path, read: Any) -> None:
    none = np.zeros(0, np.int32)
    poly: Any = SimpleNamespace(vertices=np.zeros((0, 3)), loops=none, loop_start=none)
    with pytest.raises(engine.FileError, match="there are no polygons"):
        engine.write(tmp_path / "a.step", poly)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "surface",
    [
        Cylinder(ZERO, Z, X, 0.7),
        Cone(ZERO, Z, X, 0.9, 0.4),
        Sphere(ZERO, Z, X, 1.1),
        Torus(ZERO, Z, X, 1.5, 0.4),
        Spun(ZERO, Z, X, np.array([[0.5, -2.0], [0.7, -1], [0.9, 0], [0.6, 1], [0.8, 2]]), 0.0, 1.0, 2.0),
    ],
    ids=lambda surface: surface.kind,
)
def test_normals_are_the_slopes_of_distances(surface: Any) -> None:
    p = np.random.default_rng(1).normal(size=(50, 3)) * [1, 1, 0.3] + [1, 0, 0]
    step = 1e-6
    slopes = [(surface.distance(p + step * e) - surface.distance(p - step * e)) / 2 / step for e in np.eye(3)]
    inside = np.abs(surface.distance(p)) < 0.3
    assert inside.sum() > 5
    assert np.abs(np.stack(slopes, axis=1) - surface.normal(p))[inside].max() < 1e-4


def test_points_settle_where_surfaces_meet() -> None:
    cylinder, top = Cylinder(ZERO, Z, X, 1.0), Plane(Z, Z)
    found = settle(np.array([[0.9, 0.3, 0.8], [-1.2, 0.1, 1.1]]), [cylinder, top], [])
    assert np.abs(cylinder.distance(found)).max() < 1e-12
    assert np.abs(found[:, 2] - 1).max() < 1e-12


def test_surfaces_that_touch_meet_where_their_normals_agree() -> None:
    cylinder, floor = Cylinder(ZERO, X, Z, 1.0), Plane(-Z, -Z)
    near = np.array([[x, 0.2, -0.97] for x in (0.0, 0.5, 1.0)])
    assert touch(cylinder, floor, near)
    assert not touch(cylinder, Plane(X, X), np.array([[1.0, 0, 1], [1, 1, 0]]))
    rim = np.array([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0]])
    assert not touch(Cylinder(ZERO, Z, X, 1.0), Cone(ZERO, Z, X, 1.0, 0.3), rim), "their normals agree nowhere"
    found = settle(near, [cylinder, floor], [(cylinder, floor)])
    assert np.abs(found[:, 1:] - [0, -1]).max() < 1e-6


def test_two_parts_of_one_torus_are_one() -> None:
    rng = np.random.default_rng(2)
    u, v = rng.uniform(0, 2 * np.pi, (2, 4000))
    rho = 1.5 + 0.5 * np.cos(v)
    points = np.stack([rho * np.cos(u), rho * np.sin(u), 0.5 * np.sin(v)], axis=1) + rng.normal(size=(4000, 3)) * 1e-3
    off = np.array([0.01, 0, 1.0]) / np.linalg.norm([0.01, 0, 1])
    halves = [points[points[:, 2] > 0], points[points[:, 2] < 0]]
    found = joined(Torus(ZERO, off, X, 1.49, 0.51), Torus(ZERO, off, X, 1.51, 0.49), *halves, [], [])
    assert found is not None
    assert found[0].large == pytest.approx(1.5, abs=1e-3)
    assert found[0].small == pytest.approx(0.5, abs=1e-3)
    assert np.degrees(np.arccos(abs(found[0].axis @ Z))) < 0.05
    assert joined(Torus(ZERO, Z, X, 1.5, 0.5), Cylinder(ZERO, Z, X, 0.5), *halves, [], []) is None


def test_a_profile_that_ends_on_the_axis_meets_it() -> None:
    t = np.linspace(0.0, 1.4, 30)
    profile = np.stack([1.3 * np.sin(t), np.cos(t)], axis=1)  # an ellipsoid, whose lower part is missing
    patch = {"kind": "revolution", "point": ZERO, "axis": Z, "radius": 1.3, "profile": profile}
    found = round_of(patch, np.zeros((0, 3)), ZERO, [float(profile[-1, 1])])
    assert isinstance(found, Spun)
    assert found.low is not None
    assert found.high is None
    assert found.at(np.array([found.low]))[0] == pytest.approx([0.0, 1.0], abs=0.01)


def test_an_extrusion_has_no_true_surface() -> None:
    patch = {"kind": "extrusion", "point": ZERO, "axis": Z, "radius": 2.0, "profile": [(2, 0), (0, 1), (-2, 0)]}
    assert round_of(patch, np.zeros((0, 3)), ZERO, []) == "it is an extrusion"


def test_regions_of_one_key_are_one_face_with_holes() -> None:
    ring = [[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]  # a square with a square hole
    loops, start = np.array(ring).ravel(), np.arange(4) * 4
    found = outlines(loops, start, np.array([9, 9, 9, 9]))
    assert set(found.of_polygon.tolist()) == {0}
    assert sorted(len(chain.vertices) for chain in found.chains) == [5, 5]
    assert all(chain.closed and chain.right == -1 for chain in found.chains)
    parts = outlines(loops, start, np.array([1, 1, 2, 2]))
    assert set(parts.junctions) == {0, 2, 4, 6}
    assert len(parts.chains) == 6


def test_ears_cover_a_polygon_that_is_not_convex() -> None:
    points = np.array([[0.0, 0, 0], [4, 0, 0.1], [4, 4, 0], [2, 1, 0.1], [0, 4, 0]])
    found = ears(points)
    areas = [np.cross(points[b] - points[a], points[c] - points[a])[2] / 2 for a, b, c in found]
    assert min(areas) > 0
    assert sum(areas) == pytest.approx(10.0)


def test_a_circle_of_points() -> None:
    angle = np.linspace(0.3, 1.2, 7)
    found = circle_of(np.stack([2 + 3 * np.cos(angle), 3 * np.sin(angle), np.ones(7)], axis=1))
    assert found is not None
    centre, normal, radius = found
    assert centre == pytest.approx([2, 0, 1])
    assert abs(normal @ Z) == pytest.approx(1)
    assert radius == pytest.approx(3)
    assert circle_of(np.outer(np.arange(5.0), X)) is None


def test_polygons_without_an_area_are_no_shape(tmp_path: Path, read: Any) -> None:
    mesh = engine.Mesh([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]], [[0, 1, 2], [1, 3, 2]])
    poly = engine.polygonize(mesh, engine.partition(mesh))
    assert len(poly.loop_start)
    with pytest.raises(engine.FileError, match=r"a\.step: no polygon has an area"):
        engine.write(tmp_path / "a.step", poly)
    assert not list(tmp_path.iterdir())
