"""Generated twins of real scans: openings, rims, triangles, sharp edges, chunks, grids."""

import json
import pickle

import numpy as np
import pytest

import isimp_engine as engine
from bench.files import write_ply
from bench.generators import known_shapes, real_scans
from isimp_engine.cli import main
from isimp_engine.within import TriangleSearch, triangles_of
from shapes import bumpy, cube, joined, plane, voxels


def sheet_with_hole(n=21):
    """A unit square with a hole of a third in the middle."""
    vertices, faces = plane(n)
    middle = vertices[faces].mean(1) - 0.5
    return vertices, faces[np.abs(middle[:, :2]).max(1) > 1 / 6]


def crossing_sheet():
    """A sheet that stands in that hole and meets nothing of the square."""
    vertices, faces = real_scans.sheet((0.5, 0.4, -0.1), (0, 0.2, 0), (0, 0, 0.2), 6, 6)
    return vertices + 1e-3 * np.array([1.0, 0.3, 0.2]), faces


def ragged_sheet(ragged=0.02, n=80, seed=3):
    """A rectangle with some waves, cut raggedly."""
    rng = np.random.default_rng(seed)
    vertices, faces = real_scans.sheet((0, 0, 0), (2, 0, 0), (0, 1, 0), 2 * n, n)
    vertices[:, 2] += rng.normal(0, 0.001, len(vertices))
    off = ragged * (2 + rng.normal(0, 1, len(vertices)))
    x, y = vertices[:, 0], vertices[:, 1]
    gone = (x < off) | (y < off) | (x > 2 - off) | (y > 1 - off)
    mesh = engine.clean(vertices, faces[~gone[faces].any(1)], engine.CleanOptions(fill_holes=0.3))
    return mesh.vertices, mesh.triangles


def test_a_cover_is_no_excuse_for_polygons_that_meet():
    mesh = engine.clean(*joined(sheet_with_hole(), crossing_sheet()), engine.CleanOptions(fill_holes=1.5))
    part = engine.partition_from(mesh, np.asarray(mesh.component))
    assert part.region_count == 2
    report = engine.polygonize(mesh, part).report
    assert (report["excused"], report["intersecting"]) == (0, 1)
    assert report["polygons"] <= 3  # no region is split for a defect that a split can't change


def cube_without(gone):
    """A cube of 4,800 faces without the faces whose middle satisfies a condition, closed."""
    vertices, faces = real_scans.carton(size=(0.07, 0.07, 0.07), bulge=0.0, rounding=0.0)
    return engine.clean(vertices, faces[~gone(vertices[faces].mean(1))], engine.CleanOptions(fill_holes=np.inf))


def regions_of_patches(mesh, part):
    """The regions all of whose faces cover openings."""
    scanned = np.asarray(part.face_region)[np.asarray(mesh.source_face) >= 0]
    return sorted(set(range(part.region_count)) - set(scanned.tolist()))


@pytest.mark.parametrize("proxies", [6, 8])
def test_a_small_patch_draws_no_region(proxies):
    mesh = cube_without(lambda middle: middle.sum(1) > 0.093)  # a corner is cut off
    assert (np.asarray(mesh.source_face) < 0).any()
    part = engine.partition(mesh, engine.PartitionOptions(proxies=proxies))
    assert part.region_count == proxies
    assert regions_of_patches(mesh, part) == []


def test_a_large_patch_is_a_region():
    mesh = cube_without(lambda middle: middle[:, 2] > 0.0349)
    part = engine.partition(mesh, engine.PartitionOptions(proxies=6))
    assert len(regions_of_patches(mesh, part)) == 1


def test_the_rim_of_a_ragged_sheet_is_straight_by_itself():
    vertices, faces = ragged_sheet()
    mesh = engine.Mesh(vertices, faces)
    part = engine.partition_from(mesh, np.zeros(len(faces), np.int32))
    straight = engine.polygonize(mesh, part)
    ragged = engine.polygonize(mesh, part, engine.MeshingOptions(straight_rims=0))
    assert len(straight.vertices) <= 8 < 2 * len(straight.vertices) < len(ragged.vertices)
    rims = straight.report["rims"]
    assert rims["reach"] > 0.02
    assert 0 < rims["area_added"] < 0.2
    assert 0 < rims["area_lost"] < 0.2
    assert ragged.report["rims"]["reach"] == 0
    # the area between border and rim is the difference of both areas
    scan = np.linalg.norm(np.cross(*(vertices[faces[:, k]] - vertices[faces[:, 0]] for k in (1, 2)))[:, 2:], axis=1)
    loops = [np.asarray(straight.vertices)[q] for q in np.split(straight.loops, straight.loop_start[1:])]
    area = sum(0.5 * np.cross(loop, np.roll(loop, -1, 0)).sum(0)[2] for loop in loops)
    assert area - 0.5 * scan.sum() == pytest.approx(rims["area_added"] - rims["area_lost"], abs=2e-3)


def test_a_round_rim_is_not_ragged():
    vertices, faces = real_scans.sheet((-1, -1, 0), (2, 0, 0), (0, 2, 0), 60, 60)
    radius = np.linalg.norm(vertices, axis=1, keepdims=True)
    vertices *= np.abs(vertices).max(1, keepdims=True) / np.maximum(radius, 1e-12)  # the square becomes a disc
    mesh = engine.Mesh(vertices, faces)
    part = engine.partition_from(mesh, np.zeros(len(faces), np.int32))
    assert engine.polygonize(mesh, part).report["rims"]["reach"] == 0


@pytest.mark.parametrize("most", [60, 400])
def test_a_budget_of_triangles_is_kept_and_used(most):
    found = engine.simplify(bumpy(60), triangles=most)
    assert 0.9 * most <= triangles_of(found.polygons) <= most


def test_a_search_for_triangles_ends_on_numbers_that_jump():
    search, proxies = TriangleSearch(100, 1000), 40
    while proxies is not None:
        search.take(proxies, 90 if proxies < 33 else 150)
        assert search.tries <= 8
        proxies = search.next()
    assert search.take(5, 400) is False


def test_triangles_beside_another_count_are_refused():
    with pytest.raises(ValueError, match="proxies and triangles"):
        engine.partition(engine.Mesh(*cube()), engine.PartitionOptions(triangles=10, proxies=3))


def test_rounded_edges_of_a_box_become_sharp():
    mesh = engine.Mesh(*real_scans.carton(bulge=0.0, rounding=0.006))
    fine = {"detail": 0.0025}
    assert engine.partition(mesh, engine.PartitionOptions(**fine, snap=False)).region_count > 12
    assert engine.partition(mesh, engine.PartitionOptions(**fine)).region_count == 6  # its sides are flat with noise
    sharp = engine.partition(mesh, engine.PartitionOptions(**fine, sharp_edges=0.0))
    assert sharp.region_count == 6
    assert len(engine.polygonize(mesh, sharp).vertices) == 8


def test_chunks_of_a_hall_grow_together():
    vertices, faces = real_scans.chunks(1, size=(12.0, 9.0, 5.0), tile=4.5)
    apart = engine.clean(vertices, faces, engine.CleanOptions(stitch=0))
    mesh = engine.clean(vertices, faces)
    assert apart.report["stitched_vertices"] == 0
    assert mesh.report["stitched_vertices"] > 100
    assert mesh.report["border_edges"] < 0.6 * apart.report["border_edges"]
    assert engine.partition(apart, engine.PartitionOptions()).region_count >= 20
    assert engine.partition(mesh, engine.PartitionOptions()).region_count <= 8
    assert set(mesh.source_face) <= set(range(len(faces)))


def test_borders_of_holes_beside_each_other_are_not_stitched():
    vertices, faces = real_scans.sheet((0, 0, 0), (1, 0, 0), (0, 1, 0), 60, 60)
    cell = np.floor(vertices[faces].mean(1) * 20).astype(int)
    holes = (cell[:, 0] % 2 == 1) & (cell[:, 1] % 2 == 1)
    assert engine.clean(vertices, faces[~holes]).report["stitched_vertices"] == 0


def test_stair_steps_of_a_grid_are_smoothed_within_half_a_cell():
    vertices, faces = real_scans.grid_house(4, cells=72)
    steps = engine.clean(vertices, faces, engine.CleanOptions(grid=0))
    mesh = engine.clean(vertices, faces)
    assert steps.report["smoothed_vertices"] == 0
    assert mesh.report["smoothed_vertices"] > 0.5 * len(vertices)
    cell = 2 * np.diff(np.unique(vertices[:, 0].round(6))).min()
    assert np.abs(mesh.vertices - steps.vertices).max() <= 0.5 * cell * (1 + 1e-4)
    assert mesh.report["cell"] == pytest.approx(cell, rel=1e-4)
    assert steps.report["cell"] == 0
    distances = engine.Mesh(*real_scans.grid_house(4, binary=False, cells=72))
    as_preset = engine.PartitionOptions(sharp_edges=0, snap=False)
    before, after, exact = (engine.partition(m, as_preset).region_count for m in (steps, mesh, distances))
    assert before > 2 * 21
    assert abs(after - 21) <= 2
    assert abs(exact - 21) <= 2
    copy = pickle.loads(pickle.dumps(mesh))  # noqa: S301
    for same in (mesh, copy, engine.regions.close_openings(mesh, engine.CleanOptions())):
        part = engine.partition(same, engine.PartitionOptions())
        assert part.report["noise"] == pytest.approx(0.12 * mesh.report["cell"])
        assert abs(part.region_count - 21) <= 2


@pytest.mark.parametrize("scan", [lambda: real_scans.grid_house(8, binary=False, cells=48), cube, bumpy])
def test_what_is_no_grid_of_occupancy_stays(scan):
    mesh = engine.clean(*scan())
    assert mesh.report["smoothed_vertices"] == 0


def test_blocks_are_no_stair_steps():
    solid = np.zeros((14, 14, 14), bool)
    solid[2:12, 2:12, 2:12] = True
    solid[2:6, 2:6, 2:6] = False
    assert engine.clean(*voxels(solid)).report["smoothed_vertices"] == 0


def test_the_command_takes_all_of_it(tmp_path):
    scan, out, report = (tmp_path / name for name in ("scan.ply", "out.obj", "report.json"))
    write_ply(scan, *real_scans.chunks(1, size=(8.0, 6.0, 4.0), tile=4.0))
    flags = ["--triangles", "40", "--sharp-edges", "--stitch", "0.5", "--straight-rims", "0.3", "--grid", "off"]
    assert main(["simplify", str(scan), str(out), "--report", str(report), "--quiet", *flags]) == 0
    told = json.loads(report.read_text())
    assert (told["options"]["triangles"], told["options"]["sharp_edges"]) == (40, 0)
    assert (told["options"]["clean"]["stitch"], told["options"]["clean"]["grid"]) == (0.5, 0)
    assert told["options"]["meshing"]["straight_rims"] == 0.3
    assert told["repair"]["stitched_vertices"] > 0
    assert told["output"]["rims"]["reach"] == 0.3
    assert told["output"]["corners"] - 2 * told["output"]["polygons"] <= 40


@pytest.mark.parametrize("flags", [["--grid", "on"], ["--stitch", "x"], ["--triangles", "1"], ["--straight-rims", "x"]])
def test_wrong_values_are_wrong_usage(tmp_path, flags, capsys):
    write_ply(tmp_path / "scan.ply", *cube())
    with pytest.raises(SystemExit) as ended:
        raise SystemExit(main(["simplify", str(tmp_path / "scan.ply"), str(tmp_path / "out.obj"), *flags]))
    assert ended.value.code == 2
    assert flags[0].strip("-") in capsys.readouterr().err


def test_a_drawn_model_is_not_stitched_by_itself(data):
    """Its triangles are large, so walls and grounds of other components are within two edges of its borders."""
    mesh = engine.clean(*engine.read(data / "building" / "frankfurt_tile_49k.ply"))
    assert mesh.report["stitched_vertices"] == 0


@pytest.mark.parametrize(("seed", "planes"), [(7, 34), (8, 16)])
def test_a_noisy_house_has_its_planes(seed, planes):
    """The first has strips at edges, the second chimneys and bays that a gap of the costs would leave out."""
    house = real_scans.clean_house(seed)
    assert real_scans.planes_of(seed, *house) == planes
    for noise in (0.001, 0.003):
        mesh = engine.clean(*real_scans.noisy(seed, *house, noise))
        assert engine.partition(mesh).region_count == planes
        with_strips = engine.partition(mesh, engine.PartitionOptions(snap=False)).region_count
        assert with_strips >= planes + (noise < 0.002)


def test_the_sides_of_a_plate_are_no_strips_of_an_edge():
    plate = known_shapes.base_shapes()["thin_plate"][1]
    mesh = engine.clean(plate.vertices, plate.faces)
    assert engine.partition(mesh, engine.PartitionOptions(sharp_edges=0)).region_count == 6


def pierced_wall(width):
    """A noisy wall with a hole of this width, and a tube of this width next to it."""
    wall, faces = real_scans.sheet((0, 0, 0), (2, 0, 0), (0, 2, 0), 40, 40)
    wall[:, 2] += np.random.default_rng(1).normal(0, 0.002, len(wall))
    middle = wall[faces].mean(1)
    faces = faces[np.abs(middle[:, :2] - 1).max(1) > width / 2]
    tube, sides = real_scans.sheet((0, 0, 0), (1, 0, 0), (0, 1, 0), 24, 12)
    turn = np.pi / 12 * (np.rint(24 * tube[:, 0]) % 24)
    tube = np.column_stack([5 + width / 2 * np.cos(turn), width / 2 * np.sin(turn), tube[:, 1]])
    return engine.clean(*joined((wall, faces), (tube, sides)))


def test_a_hole_in_a_wall_is_closed_where_another_stays_open():
    mesh = pierced_wall(0.2)
    lengths = engine.openings.lengths(mesh, 6)
    assert lengths.holes < 0.6 < 0.8 < lengths.flat_holes
    assert engine.regions.opening_lengths(mesh, 6) == (lengths.holes, lengths.handles)
    assert mesh.report["border_loops"] == 4
    closed = engine.openings.closed_for(mesh, 6)
    assert closed.report["filled_holes"] == 1  # not the ends of the tube, nor the rim of the wall
    assert closed.report["border_loops"] == 3
    points = np.asarray(closed.vertices)[np.asarray(closed.triangles)[np.asarray(closed.source_face) < 0]]
    assert np.abs(points[..., :2] - 1).max() <= 0.1 + 1e-9


def test_a_wide_gap_in_a_wall_stays():
    mesh = pierced_wall(0.8)
    assert engine.openings.closed_for(mesh, 6).report["filled_holes"] == 0


def test_the_command_names_clutter_and_leaves_it_out_or_boxes_it(tmp_path, capsys):
    wall, faces = real_scans.sheet((0, 0, 0), (1, 0, 0), (0, 1, 0), 120, 120)
    cell = np.floor(wall[faces].mean(1) * 40).astype(int)
    sieve = faces[~((cell[:, 0] % 4 == 2) & (cell[:, 1] % 4 == 2))]
    write_ply(tmp_path / "scan.ply", *joined((wall, sieve), (wall + [3, 0, 0], faces)))
    report = tmp_path / "report.json"

    def run(*more):
        given = ["simplify", str(tmp_path / "scan.ply"), str(tmp_path / "out.obj"), "--report", str(report)]
        assert main([*given, "--proxies", "2", "--keep-openings", *more]) == 0
        return json.loads(report.read_text()), capsys.readouterr().out

    told, said = run()
    (found,) = told["clutter"]
    assert found["polygons"] == told["output"]["polygons"] - 1 > engine.clutter.MOST
    assert np.abs(np.array(found["center"]) - [0.5, 0.5, 0]).max() < 0.1
    assert f"clutter: 1 region takes {found['polygons']} polygons" in said
    told, said = run("--clutter", "leave-out")
    assert (told["output"]["polygons"], told["clutter"]) == (1, [found])
    assert f"clutter: 1 region left out, with {found['polygons']} polygons" in said
    told, said = run("--clutter", "box")
    assert (told["output"]["polygons"], told["output"]["boxes"]) == (7, 1)
    assert "replaced by boxes" in said
    assert "more than regions" not in said


@pytest.mark.parametrize("seed", [1, 2])
def test_a_table_is_one_region_and_what_stands_on_it_is_in_others(seed):
    vertices, faces, table = real_scans.on_table(seed)
    mesh = engine.openings.closed_for(engine.clean(vertices, faces), 6)
    part = engine.partition(mesh, engine.PartitionOptions())
    source = np.asarray(mesh.source_face)
    region = np.full(len(faces), -1)
    region[source[source >= 0]] = np.asarray(part.face_region)[source >= 0]
    high = vertices[faces].mean(1)[:, 2] > 0.02
    top = np.bincount(region[table & (region >= 0)]).argmax()
    assert (region[table] == top).mean() > 0.99
    assert not (region[high] == top).any()
    assert part.region_count == 6
