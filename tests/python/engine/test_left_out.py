"""Results do not depend on components that are left out: they are the same bits without them in the scan."""

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
from isimp_engine import cli, openings

COUNTS = {
    "proxies": {"proxies": 40},
    "detail": {"detail": 0.01},
    "bound": {"bound": 0.8},
    "curved": {"proxies": 60, "curved": True},
    "sharp": {"proxies": 40, "sharp_edges": 2.0},
    "adaptivity": {"proxies": 40, "adaptivity": 0.5},
    "triangles": {"triangles": 200},
    "lloyd": {"proxies": 40, "method": "lloyd"},
}
SCANS = {
    "nasty/ogre_124k_44comp.ply": {"proxies": 100},
    "building/frankfurt_tile_49k.ply": {"proxies": 100},
    "real/office_27k.ply": {"detail": 0.005},
}
SPECKS = 300
FAR = (5e5, 4.6e6, 100)
FAR_COUNTS = {name: COUNTS[name] for name in ("detail", "curved")}


def with_specks(offset=(0, 0, 0)) -> tuple[np.ndarray, np.ndarray, int]:
    """A noisy house with holes and tunnels and, after its faces, specks of three open faces each far around it."""
    vertices, triangles = shapes.mvs_house(errors=True)
    mesh = engine.clean(vertices, triangles)
    largest = np.bincount(mesh.component).argmax()
    triangles = triangles[np.sort(mesh.source_face[mesh.component == largest])]
    rng = np.random.default_rng(7)
    corners = rng.uniform(-40, 100, (SPECKS, 1, 3)) + rng.uniform(0, 0.7, (SPECKS, 4, 3))
    faces = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1]])
    more = np.concatenate([len(vertices) + 4 * k + faces for k in range(SPECKS)])
    every = np.concatenate([vertices, corners.reshape(-1, 3)]) + offset
    return every, np.concatenate([triangles, more]), len(triangles)


def same_polygons(one: engine.PolygonMesh, other: engine.PolygonMesh) -> None:
    assert np.array_equal(one.loop_start, other.loop_start)
    assert np.array_equal(one.loops, other.loops)
    assert np.array_equal(one.vertices, other.vertices)
    assert np.array_equal(one.polygon_region, other.polygon_region)
    assert one.report == other.report


def compare(all_faces, some_faces, options: dict, leave_out: float) -> None:
    """Every step on the scan, and on the scan without what is left out.

    all_faces, some_faces: vertices and triangles.
    """
    one, other = engine.clean(*all_faces), engine.clean(*some_faces)
    ways = [
        (one, engine.PartitionOptions(**options, leave_out=leave_out)),
        (other, engine.PartitionOptions(**options, leave_out=0)),
    ]
    parts = [engine.partition(mesh, each) for mesh, each in ways]
    left = parts[0].face_region < 0
    assert left.any()
    assert not (parts[1].face_region < 0).any()
    assert np.array_equal(parts[0].face_region[~left], parts[1].face_region)
    for name in ("region_normal", "region_offset", "history"):
        assert np.array_equal(getattr(parts[0], name), getattr(parts[1], name)), name
    for name in ("error", "tolerance", "noise", "bound", "distance_max"):
        assert getattr(parts[0], name) == getattr(parts[1], name), name
    assert [repr(proxy) for proxy in parts[0].curved] == [repr(proxy) for proxy in parts[1].curved]
    for meshing in ({}, {"planar": True}):
        made = [
            engine.polygonize(mesh, p, engine.MeshingOptions(**meshing))
            for mesh, p in zip((one, other), parts, strict=True)
        ]
        same_polygons(*made)
    assert engine.regions.expected_polygons(one, parts[0]) == engine.regions.expected_polygons(other, parts[1])
    regular = [engine.regularise(mesh, part) for mesh, part in zip((one, other), parts, strict=True)]
    assert np.array_equal(regular[0].region_normal, regular[1].region_normal)
    same_polygons(*[engine.polygonize(mesh, part) for mesh, part in zip((one, other), regular, strict=True)])
    if "bound" not in options:
        lengths = [openings.lengths_for(mesh, each, None, lambda: parts[1].region_count) for mesh, each in ways]
        for name in ("holes", "flat_holes", "handles"):
            assert getattr(lengths[0], name) == getattr(lengths[1], name), name
        closed = [length.closed(mesh) for length, (mesh, _) in zip(lengths, ways, strict=True)]
        assert len(closed[0].openings) == len(closed[1].openings)
        again = [engine.partition(mesh, each) for mesh, (_, each) in zip(closed, ways, strict=True)]
        same_polygons(*[engine.polygonize(mesh, part) for mesh, part in zip(closed, again, strict=True)])


@pytest.mark.parametrize(
    ("options", "offset"),
    [*((each, (0, 0, 0)) for each in COUNTS.values()), *((each, FAR) for each in FAR_COUNTS.values())],
    ids=[*COUNTS, *(f"{name} far away" for name in FAR_COUNTS)],
)
def test_results_are_the_same_without_specks(options: dict, offset: tuple) -> None:
    vertices, triangles, house = with_specks(offset)
    compare((vertices, triangles), (vertices, triangles[:house]), options, 0.001)


@pytest.mark.parametrize("name", SCANS)
def test_results_of_quarters_of_scans_are_the_same_without_what_is_left_out(data, name: str) -> None:
    options = SCANS[name]
    vertices, triangles = engine.read(data / name)
    middle = vertices[triangles].mean(axis=1)
    middle = middle[:, np.argsort(np.ptp(middle, axis=0))[1:]]
    quarter = triangles[(middle < np.median(middle, axis=0)).all(axis=1)]
    mesh = engine.clean(vertices, quarter)  # else the faces that are left out may change others in cleaning
    part = engine.partition(mesh, engine.PartitionOptions(**options))
    assert part.parts_left_out
    every = mesh.vertices, mesh.triangles
    compare(every, (mesh.vertices, mesh.triangles[part.face_region >= 0]), options, 0.001)


@pytest.mark.parametrize("flags", [["--proxies", "40"], [], ["--bound", "1"]], ids=["proxies", "detail", "bound"])
def test_the_command_writes_the_same_polygons_without_specks(tmp_path, flags: list[str]) -> None:
    vertices, triangles, house = with_specks()
    for name, faces in (("all", triangles), ("house", triangles[:house])):
        meshfiles.ply_binary(tmp_path / f"{name}.ply", vertices, faces.tolist())
        leave = ["--leave-out", "0"] if name == "house" else []
        out = str(tmp_path / f"{name}.out.ply")
        assert cli.main(["simplify", str(tmp_path / f"{name}.ply"), out, "--quiet", *flags, *leave]) == 0
    assert (tmp_path / "all.out.ply").read_bytes() == (tmp_path / "house.out.ply").read_bytes()


def test_barriers_hold_in_polygons_where_specks_are_left_out() -> None:
    vertices, triangles = shapes.plane(8)
    vertices = np.concatenate([vertices, [[3.0, 0, 0], [3.001, 0, 0], [3, 0.001, 0]]])
    triangles = np.concatenate([triangles, [[len(vertices) - 3, len(vertices) - 2, len(vertices) - 1]]])
    mesh = engine.Mesh(vertices, triangles)
    middle = np.unique(vertices[:-3, 0])[4]
    line = [v for v in np.argsort(vertices[:-3, 1]) if vertices[v, 0] == middle]
    barriers = np.stack([line[:-1], line[1:]], axis=1)
    part = engine.partition(mesh, engine.PartitionOptions(proxies=2), barriers=barriers)
    assert part.parts_left_out == 1
    poly = engine.polygonize(mesh, part)
    for k, start in enumerate(poly.loop_start):
        loop = poly.loops[start : [*poly.loop_start, len(poly.loops)][k + 1]]
        x = poly.vertices[loop, 0]
        assert x.max() <= middle + 1e-9 or x.min() >= middle - 1e-9
