"""Convex parts: of hollow solids with noise, enclosing, limits and refusals."""

import numpy as np
import pytest

import isimp_engine as engine
import shapes
from bench.generators import hollow_solids
from bench.quality.convex import outside, planes_of, volume


def distances(parts, points):
    return outside([planes_of(part.vertices, part.triangles) for part in parts], np.asarray(points, float))


def check_convex(parts):
    for part in parts:
        assert distances([part], part.vertices).max() < 1e-9
        assert len(part.triangles) == 2 * len(part.vertices) - 4
        a, b, c = (part.vertices[part.triangles[:, k]] for k in range(3))
        assert part.volume == pytest.approx((np.cross(a, b) * c).sum() / 6)


@pytest.mark.parametrize("name", ["room", "table", "cabinet", "flight", "chair", "floor_plan"])
def test_a_scan_of_boxes_becomes_these_boxes(name):
    solid = hollow_solids.SOLIDS[name]()
    vertices, faces = hollow_solids.twin(solid)
    parts = engine.convex_parts(engine.simplify((vertices, faces), planar=True, keep_openings=True))
    check_convex(parts)
    assert len(parts) <= len(solid.boxes)
    assert np.mean([len(part.triangles) for part in parts]) <= 14
    planes = [planes_of(part.vertices, part.triangles) for part in parts]
    whole = volume(planes, vertices, np.random.default_rng(0))
    assert whole == pytest.approx(solid.volume, rel=0.03)
    assert (distances(parts, solid.free) > 0).all()
    size = np.linalg.norm(np.ptp(vertices, axis=0))
    assert distances(parts, vertices).max() < 5 * 0.001 * size  # the noise is normal: some vertices are far out


def test_enclosing_parts_have_every_vertex():
    solid = hollow_solids.table()
    vertices, faces = hollow_solids.twin(solid)
    result = engine.simplify((vertices, faces), planar=True, keep_openings=True)
    parts = engine.convex_parts(result, enclose=True)
    check_convex(parts)
    assert distances(parts, vertices).max() <= 0
    far = 4 * 0.001 * np.linalg.norm(np.ptp(vertices, axis=0))  # one in thousands is as far out
    grown = sum(np.prod(np.subtract(high, low) + 2 * far) for low, high in solid.boxes)
    assert sum(part.volume for part in parts) < 1.05 * grown
    assert distances(engine.convex_parts(result), vertices).max() > 0
    points = np.vstack([vertices, [[0.7, 0.4, 0.8]]])
    assert distances(engine.convex_parts(result, enclose=points), points).max() <= 0


def test_forms_of_a_solid_give_the_same_parts():
    vertices, faces = hollow_solids.surface(hollow_solids.crate())
    mesh = engine.clean(vertices, faces)
    flat, _ = engine.merge_flat(mesh)
    parts = engine.convex_parts(flat)
    assert len(parts) == 5
    again = engine.convex_parts((vertices, faces))
    assert [part.volume for part in again] == pytest.approx([part.volume for part in parts])
    assert repr(parts[0]).startswith("<Convex: 8 vertices")


def test_a_repaired_mesh_is_a_solid():
    vertices, triangles = shapes.cube(2)
    twice = np.concatenate([triangles[:3], triangles[:-1]])  # and a hole
    mesh = engine.clean(vertices, twice, engine.CleanOptions(fill_holes=3))
    assert mesh.source_face.min() == -1
    assert len(mesh.triangles) == len(triangles) == len(twice) - 2
    (part,) = engine.convex_parts(mesh)
    assert part.volume == pytest.approx(1)


def test_limits():
    vertices, faces = hollow_solids.surface(hollow_solids.stairs())
    assert len(engine.convex_parts((vertices, faces), parts=3)) == 3
    assert len(engine.convex_parts((vertices, faces), tolerance=1.0)) == 1
    parts = engine.convex_parts(shapes.torus(), parts=4, most_vertices=16)
    check_convex(parts)
    assert max(len(part.vertices) for part in parts) == 16


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"tolerance": 0}, "tolerance must be a length above 0, got 0"),
        ({"tolerance": -1.0}, "tolerance must be a length above 0"),
        ({"parts": 0}, "parts must be at least 1, got 0"),
        ({"thickness": 0}, "thickness must be a length above 0, got 0"),
        ({"thickness": 0.1, "parts": 3}, "parts can't be limited with a thickness"),
        ({"most_vertices": 4}, "most_vertices must be at least 8, got 4"),
        ({"enclose": np.zeros((2, 2))}, r"enclose .*\(N, 3\)"),
        ({"enclose": [[0, 0, np.nan]]}, "point 0 to enclose is not finite"),
    ],
)
def test_options_out_of_range_are_refused(options, message):
    with pytest.raises(engine.InvalidInput, match=message):
        engine.convex_parts(shapes.cube(), **options)


def walls(vertices, faces, **options):
    parts = engine.convex_parts(engine.merge_flat(engine.clean(vertices, faces))[0], **options)
    check_convex(parts)
    return parts


def test_a_room_gets_walls_that_meet_in_its_corners():
    vertices, faces = shapes.cube(3)
    parts = walls(vertices, faces[:, ::-1], thickness=0.1)
    assert len(parts) == 6
    assert sum(part.volume for part in parts) == pytest.approx(1.2**3 - 1)
    inside = np.stack(np.meshgrid(*[np.linspace(0.01, 0.99, 5)] * 3), axis=-1).reshape(-1, 3)
    assert (distances(parts, inside) > 0.009).all()
    around = np.stack(np.meshgrid(*[np.linspace(-0.099, 1.099, 13)] * 3), axis=-1).reshape(-1, 3)
    around = around[((around < -0.01) | (around > 1.01)).any(axis=1)]
    assert (distances(parts, around) < 1e-9).all()


def test_walls_stay_within_a_pillar_and_a_plate():
    vertices, faces = shapes.cube(3)
    parts = walls(vertices, faces, thickness=0.1)
    assert len(parts) == 6
    assert sum(part.volume for part in parts) == pytest.approx(1 - 0.8**3)
    plate = vertices * [1, 1, 0.05]
    sides = np.abs(np.cross(*(plate[faces[:, k]] - plate[faces[:, 0]] for k in (1, 2)))[:, 2]) > 0
    (part,) = walls(plate, faces[sides], thickness=0.2)
    assert part.volume == pytest.approx(0.05)
    (part,) = walls(*shapes.plane(4), thickness=0.25, enclose=[[0.5, 0.5, -0.5]])
    assert part.volume == pytest.approx(0.5)


def test_a_floor_is_one_slab_under_a_cupboard_and_open_where_it_has_a_hole():
    floor, squares = shapes.plane(10)
    under = (np.abs(floor[squares].mean(axis=1)[:, :2] - 0.5) < 0.2).all(axis=1)
    parts = walls(floor, squares[~under], thickness=0.1)
    assert len(parts) == 4
    assert distances(parts, np.array([[0.5, 0.5, -0.05]]))[0] > 0.19
    box, sides = shapes.cube(4)
    sides = sides[(box[sides][:, :, 2] > 0).any(axis=1)]  # its bottom is not in the scan
    cupboard = shapes.joined((floor, squares[~under]), (box * [0.4, 0.4, 0.5] + [0.3, 0.3, 0], sides))
    parts = walls(*shapes.welded(*cupboard), thickness=0.1)
    assert len(parts) == 6
    assert distances(parts, np.array([[0.5, 0.5, -0.05]]))[0] < 0


def test_doors_of_a_scanned_room_stay_free():
    solid = hollow_solids.floor_plan()
    vertices, faces = hollow_solids.twin(solid)
    low = vertices.min(axis=0)
    outer = (vertices[faces] < low + 0.05).all(axis=1).any(axis=1)  # outer sides are not in a scan from inside
    result = engine.simplify((vertices, faces[~outer]), planar=True, keep_openings=True)
    parts = engine.convex_parts(result, thickness=0.2)
    check_convex(parts)
    assert (distances(parts, solid.free) > 0).all()
    size = np.linalg.norm(np.ptp(vertices, axis=0))
    assert np.abs(distances(parts, vertices[np.unique(faces[~outer])])).mean() < 0.002 * size


def test_a_fin_on_a_solid_is_no_part_of_it():
    fin = shapes.joined(shapes.cube(2), ([[0, 0, 1], [1, 0, 1], [0.5, 0, 2]], np.array([[0, 1, 2]])))
    (part,) = engine.convex_parts(shapes.welded(*fin))  # a face that hangs on an edge: not manifold
    assert part.volume == pytest.approx(1)
