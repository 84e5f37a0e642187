"""Tiles in groups: no process has the graph of all, and the result is as good, exact and repeatable as without."""

import os
import subprocess
import sys

import numpy as np
import pytest

import isimp_engine as engine
import shapes
import tilesets
from batches import ENVIRONMENT, wait_for
from isimp_engine import tiles
from isimp_engine.tiles import grouped
from isimp_engine.tiles.store import values_of

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="tiles need fork")

P = 24


@pytest.fixture(scope="module")
def whole():
    return tilesets.hilly(56)


@pytest.fixture(scope="module")
def folder(tmp_path_factory, whole):
    return tilesets.write(tmp_path_factory.mktemp("tiles") / "in", tilesets.cut(*whole, 4, 3))


@pytest.fixture(scope="module")
def ungrouped(tmp_path_factory, folder):
    return tiles.run(folder, tmp_path_factory.mktemp("all") / "out.obj", proxies=P, group=12).report


@pytest.mark.parametrize("group", [1, 2, 5])
def test_groups_give_as_many_regions_and_as_small_an_error(tmp_path, whole, folder, ungrouped, group):
    labels = tmp_path / "labels"
    report = tiles.run(folder, tmp_path / "out.obj", proxies=P, group=group, labels=labels).report
    assert report["groups"] == {1: 12, 2: 8, 5: 4}[group]
    assert ungrouped["groups"] == 0
    label = tilesets.labels_of(labels, tilesets.cut(*whole, 4, 3), len(whole[1]))
    assert sorted(set(label.tolist())) == list(range(P))
    assert tilesets.regions_are_connected(whole[1], label)
    assert report["error"] < 1.03 * ungrouped["error"]
    assert report["output"]["manifold"]
    for name in ("border_edges", "unmatched_edges", "patches", "graph_bytes", "regions_needed", "parts_left_out"):
        assert report[name] == ungrouped[name], name


def test_groups_merge_most_before_all_is_joined(tmp_path, folder):
    report = tiles.run(folder, tmp_path / "out.obj", proxies=P, group=6, work=tmp_path / "work").report
    assert report["groups"] == 2
    left = sum(values_of(p)["patches"] for p in (tmp_path / "work" / "cut").iterdir())
    assert left < 0.8 * report["patches"]
    assert report["regions_joined"] < 1.9 * P


@pytest.mark.parametrize("group", [2, 6])
def test_detail_finds_the_number_that_it_finds_without_groups(tmp_path, folder, group):
    options = {"detail": 0.01}
    one = tiles.run(folder, tmp_path / "a.obj", options=options, group=12).report
    report = tiles.run(folder, tmp_path / "b.obj", options=options, group=group).report
    assert report["groups"] > 1
    assert report["tolerance"] == one["tolerance"]
    assert report["regions"] == pytest.approx(one["regions"], abs=max(1, one["regions"] // 10))
    assert report["snapped"] == one["snapped"]


def test_a_closed_component_over_several_groups_gets_what_it_needs(tmp_path):
    folder = tilesets.write(tmp_path / "in", tilesets.cut(*shapes.cube(10), 2, 2))
    for proxies, regions in ((6, 6), (1, 4)):
        report = tiles.run(folder, tmp_path / "a.obj", proxies=proxies, group=1).report
        assert (report["groups"], report["regions"], report["unmatched_edges"]) == (4, regions, 0)
        assert report["output"]["closed"]


def test_specks_in_groups_are_left_out(tmp_path):
    cube, speck = shapes.cube(8), shapes.cube(1)
    speck = (speck[0] * 0.01 + [3, 0, 0], speck[1])
    folder = tilesets.write(tmp_path / "in", [(*cube, None), (*speck, None)])
    report = tiles.run(folder, tmp_path / "a.obj", proxies=6, group=1, labels=tmp_path / "labels").report
    assert (report["groups"], report["parts_left_out"], report["regions"]) == (2, 1, 6)
    assert np.load(tmp_path / "labels" / "tile_01.npy").tolist() == [-1] * 12


def test_groups_give_the_same_bits_for_any_number_of_workers(tmp_path, folder):
    for name, jobs in (("a.ply", 1), ("b.ply", 2)):
        tiles.run(folder, tmp_path / name, proxies=P, group=3, jobs=jobs, labels=tmp_path / f"{name}.labels")
    assert (tmp_path / "a.ply").read_bytes() == (tmp_path / "b.ply").read_bytes()
    for path in (tmp_path / "a.ply.labels").iterdir():
        assert path.read_bytes() == (tmp_path / "b.ply.labels" / path.name).read_bytes()


@pytest.mark.parametrize("step", ["group/000001", "cut/000000", "regroup/000002"])
def test_groups_that_were_killed_go_on_and_give_the_same_bits(tmp_path, folder, step):
    code = "import sys; from isimp_engine import tiles; "
    code += f"tiles.run(sys.argv[1], sys.argv[2], proxies={P}, group=3, work=sys.argv[3])"
    command = [sys.executable, "-c", code, str(folder), str(tmp_path / "a.ply"), str(tmp_path / "work")]
    process = subprocess.Popen(command, env=ENVIRONMENT)
    wait_for((tmp_path / "work" / step).exists)
    process.kill()
    process.wait()
    assert not (tmp_path / "a.ply").exists()
    states = []
    run = {"proxies": P, "group": 3, "watch": lambda state: states.append(state.before)}
    tiles.run(folder, tmp_path / "a.ply", work=tmp_path / "work", **run)
    assert max(states) > 20
    tiles.run(folder, tmp_path / "b.ply", **run)
    assert (tmp_path / "a.ply").read_bytes() == (tmp_path / "b.ply").read_bytes()


def test_a_group_has_near_tiles_and_each_tile_a_group():
    x, y = np.meshgrid(np.arange(6.0), np.arange(4.0))
    centres = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], 1)
    groups = grouped.groups_of(centres, 6)
    assert sorted(k for own in groups for k in own) == list(range(24))
    assert [len(own) for own in groups] == [6] * 4
    assert all(np.ptp(centres[own], axis=0).max() <= 2 for own in groups)
    low, high = centres - 0.5, centres + 0.5
    assert grouped.beside(low, high, [0], 1e-9) == [1, 6, 7]
    assert grouped.beside(low, high - 0.1, [0], 1e-9) == []


def strip(tilt):
    """Sums and pairs of nodes in a row, each tilted against the one before by the same angle; unit areas."""
    angle = np.cumsum(tilt)
    sums = np.stack([np.sin(angle), 0 * angle, np.cos(angle), np.full(len(angle), 2.0), np.full(len(angle), 9.0)], 1)
    return sums, np.stack([np.arange(len(angle) - 1), np.arange(1, len(angle))], 1).astype(np.int32)


def test_merges_at_a_common_price_are_those_of_one_piece():
    tilt = np.array([0, 0.01, 0.3, 0.02, 0.01, 0.4, 0.02, 0.03])
    sums, pairs = strip(tilt)
    found = tiles.Components(np.zeros(8, np.int32), np.array([1], np.int32), 0, 0.0)
    whole = tiles.merge(sums, pairs, np.zeros(7), found, 3)
    parts, price = [], []
    for own, at_border in ((slice(0, 4), 3), (slice(4, 8), 0)):
        border = np.zeros(4, bool)
        border[at_border] = True
        part = tiles.Components(found.component[own], found.need, 0, 0.0)
        merges = tiles.merge_inside(sums[own], pairs[:3], np.zeros(3), part, border, 1)
        assert (np.diff(merges.price) >= 0).all()
        parts.append(merges)
        price.append(merges.price)
    at = tiles.common_price(price, 8, 4)
    labels = [tiles.labels_after(4, each, at) for each in parts]
    both = np.append(labels[0], labels[1] + labels[0].max() + 1).astype(np.int32)
    rest, near, lengths = tiles.contracted(both, sums, pairs, np.ones(7))
    assert len(rest) == 4
    assert rest.sum(0) == pytest.approx(sums.sum(0))
    assert lengths.tolist() == [1.0] * 3
    left = tiles.Components(np.zeros(4, np.int32), found.need, 0, 0.0)
    assert tiles.merge(rest, near, 0 * lengths, left, 3)[both].tolist() == whole.tolist() == [0, 0, 1, 1, 1, 2, 2, 2]


def test_nodes_at_the_border_of_a_group_do_not_merge_with_each_other():
    sums, pairs = strip(np.array([0, 0, 0, 0.001]))
    found = tiles.Components(np.zeros(4, np.int32), np.array([1], np.int32), 0, 0.0)
    merges = tiles.merge_inside(sums, pairs, np.zeros(3), found, [1, 1, 0, 0], 1)
    assert tiles.labels_after(4, merges, np.inf).tolist() == [0, 1, 1, 1]
    assert len(tiles.merge_inside(sums, pairs, np.zeros(3), found, [1, 1, 0, 0], 3).price) == 1
    assert len(tiles.merge_inside(sums, pairs, np.zeros(3), found, [0, 0, 0, 0], 1, 0.0).price) == 0


def test_a_small_part_of_a_plane_counts_as_all_of_it():
    sums, pairs = strip(np.array([0, 0.3]))
    sums[0, :4] *= 0.01
    found = tiles.Components(np.zeros(2, np.int32), np.array([1], np.int32), 0, 0.0)
    alone = tiles.merge_inside(sums, pairs, np.zeros(1), found, [0, 0], 1).price[0]
    part = tiles.merge_inside(sums, pairs, np.zeros(1), found, [1, 0], 1).price[0]
    assert part == pytest.approx(1 - np.cos(0.3))
    assert alone < 0.02 * part


def test_prices_leave_no_fewer_than_wanted():
    prices = [np.array([1.0, 2.0, 2.0]), np.array([2.0, 5.0])]
    for nodes, target, below in ((10, 10, 0), (10, 9, 1), (10, 7, 1), (10, 6, 4), (10, 5, 5), (10, 1, 5)):
        price = tiles.common_price(prices, nodes, target)
        assert sum((each < price).sum() for each in prices) == below


def test_what_does_not_fit_is_refused():
    sums, pairs = strip(np.zeros(3))
    found = tiles.Components(np.zeros(3, np.int32), np.array([1], np.int32), 0, 0.0)
    with pytest.raises(ValueError, match="`border` must have one value for each node"):
        tiles.merge_inside(sums, pairs, np.zeros(2), found, [0, 0], 1)
    with pytest.raises(ValueError, match="pair 0 names node 7"):
        tiles.merge_inside(sums, pairs + 7, np.zeros(2), found, [0, 0, 0], 1)


def polygons_of(path):
    vertices, loops, start = engine.read_polygons(path)
    return vertices, [loop.tolist() for loop in np.split(loops, start[1:])]


@pytest.mark.parametrize(("columns", "rows", "group"), [(4, 3, 3), (4, 4, 1)])
def test_polygons_by_groups_are_sound_and_as_near_as_those_of_one_process(tmp_path, whole, columns, rows, group):
    folder = tilesets.write(tmp_path / "in", tilesets.cut(*whole, columns, rows))
    one = tiles.run(folder, tmp_path / "one.ply", proxies=P, group=group).report
    report = tiles.run(folder, tmp_path / "by.ply", proxies=P, group=group, mesh_faces=0).report
    assert one["rest_faces"] is None
    assert report["rest_faces"] > 0
    out, other = report["output"], one["output"]
    assert out["regions"] == P
    assert (out["manifold"], out["closed"], out["euler"]) == (True, other["closed"], other["euler"])
    flaws = {"crossing": 0, "flipped": 0, "bent": 0, "intersecting": 0}
    assert {name: out[name] for name in flaws} == flaws
    assert out["polygons"] <= other["polygons"] + P // 4
    assert out["planarity_mean"] < 1.05 * other["planarity_mean"]
    vertices, loops = polygons_of(tmp_path / "by.ply")
    count = {}
    for loop in loops:
        assert len(set(loop)) == len(loop) >= 3
        for a, b in zip(loop, loop[1:] + loop[:1], strict=True):
            assert count.setdefault((a, b), 0) == 0, "each side of an edge has one polygon"
            count[a, b] = 1
    rim = [vertices[[a, b]] for a, b in count if (b, a) not in count]
    assert sum(float(np.linalg.norm((b - a)[:2])) for a, b in rim) == pytest.approx(4, abs=0.15)


def test_a_cube_by_groups_has_its_six_sides(tmp_path):
    folder = tilesets.write(tmp_path / "in", tilesets.cut(*shapes.cube(12), 3, 2))
    report = tiles.run(folder, tmp_path / "a.ply", proxies=6, group=2, mesh_faces=0).report
    vertices, loops = polygons_of(tmp_path / "a.ply")
    assert report["output"]["closed"]
    assert len(loops) == 6
    corners = vertices[np.unique(np.concatenate(loops))]
    assert np.abs(corners - np.round(corners)).max() < 1e-6


def test_polygons_by_groups_are_the_same_bits_after_a_kill_and_for_any_number_of_workers(tmp_path, folder):
    code = "import sys; from isimp_engine import tiles; "
    code += f"tiles.run(sys.argv[1], sys.argv[2], proxies={P}, group=3, mesh_faces=0, work=sys.argv[3])"
    command = [sys.executable, "-c", code, str(folder), str(tmp_path / "a.ply"), str(tmp_path / "work")]
    process = subprocess.Popen(command, env=ENVIRONMENT)
    wait_for((tmp_path / "work" / "mesh-group" / "000001").exists)
    process.kill()
    process.wait()
    run = {"proxies": P, "group": 3, "mesh_faces": 0}
    tiles.run(folder, tmp_path / "a.ply", work=tmp_path / "work", jobs=2, **run)
    tiles.run(folder, tmp_path / "b.ply", jobs=1, **run)
    assert (tmp_path / "a.ply").read_bytes() == (tmp_path / "b.ply").read_bytes()


def test_planar_polygons_are_made_in_one_process(tmp_path, folder):
    run = {"proxies": P, "group": 3, "mesh_faces": 0, "options": {"planar": True}}
    report = tiles.run(folder, tmp_path / "a.ply", **run).report
    assert report["rest_faces"] is None
    assert report["output"]["planar"]


def test_moments_of_groups_are_those_of_all_their_faces():
    random = np.random.default_rng(2)
    points = random.normal(size=(40, 3)) + [5e5, 5e6, 100]
    each = np.concatenate([np.full((40, 1), 0.25), points, np.zeros((40, 6))], 1)
    group = random.integers(0, 3, 40).astype(np.int32)
    found = tiles.moments_of(group, each, 4)
    for k in range(3):
        own = points[group == k]
        assert found[k, 0] == 0.25 * len(own)
        assert found[k, 1:4] == pytest.approx(own.mean(0), abs=1e-8)
        spread = 0.25 * (own - own.mean(0)).T @ (own - own.mean(0))
        assert found[k, 4:] == pytest.approx(spread[[0, 1, 1, 2, 2, 2], [0, 0, 1, 0, 1, 2]], abs=1e-6)
    assert not found[3].any()


def test_fixed_corners_stay_and_others_beside_them_lie_where_they_were_put():
    vertices, triangles = shapes.plane(8)
    mesh = engine.clean(vertices, triangles)
    label = (mesh.vertices[mesh.triangles].mean(1)[:, 0] > 0.5).astype(np.int32)
    fixed = np.zeros(len(mesh.vertices), np.uint8)
    chosen = int(np.flatnonzero((np.abs(mesh.vertices - [0, 0.375, 0]) < 1e-9).all(1))[0])
    fixed[chosen] = 2
    options = engine.MeshingOptions()
    every = np.zeros((len(mesh.triangles), 10))
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    every[:, 0] = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    every[:, 1:4] = (a + b + c) / 3
    part = engine.partition_from(mesh, label)
    free, _ = tiles.polygonize_part(mesh, part, options, every, np.zeros(len(fixed), np.uint8))
    held, face_polygon = tiles.polygonize_part(mesh, part, options, every, fixed)
    assert chosen not in free.source_vertex
    assert held.vertices[held.source_vertex == chosen].tolist() == [mesh.vertices[chosen].tolist()]
    assert held.polygon_region[face_polygon].tolist() == part.face_region.tolist()
    with pytest.raises(ValueError, match="`fixed` must have one value for each vertex"):
        tiles.polygonize_part(mesh, part, options, every, fixed[:-1])
    with pytest.raises(ValueError, match="must be 0, 1 or 2"):
        tiles.polygonize_part(mesh, part, options, every, fixed + 1)
    with pytest.raises(ValueError, match="planar polygons can't be made of a part"):
        tiles.polygonize_part(mesh, part, engine.MeshingOptions(planar=True), every, fixed)


def test_polygons_of_different_parts_that_meet_are_found():
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    wall = np.array([[0.5, 0.2, -1], [0.5, 0.8, -1], [0.5, 0.8, 1], [0.5, 0.2, 1]])
    both = np.concatenate([square, wall])
    apart = tiles.judge_together(both, np.arange(8), [0, 4], [0, 1], [0, 1]).report
    assert (apart["intersecting"], apart["polygons"], apart["crossing"]) == (1, 2, 0)
    assert [each["other"] for each in apart["imperfect"]] == [1, 0]
    assert tiles.judge_together(both, np.arange(8), [0, 4], [0, 1], [0, 0]).report["intersecting"] == 0
    square[3] = [-3, 2, 0]
    crossed = tiles.judge_together(square, [0, 2, 1, 3], [0], [0], [0]).report
    assert (crossed["crossing"], crossed["manifold"]) == (1, True)
    with pytest.raises(ValueError, match="a corner names vertex 8"):
        tiles.judge_together(both, np.arange(8) + 2, [0, 4], [0, 1], [0, 1])


def settled(vertices, parts, home, normal=(0, 0, 1), reach=0.01):
    """Two quads of different parts after settling; each represents a unit square in the plane through its home."""
    moments = np.zeros((2, 10))
    moments[:, 0], moments[:, [4, 6]] = 1, 1 / 12
    moments[:, 1:4] = home[[0, 1, 2, 3, 1, 4, 5, 2]].reshape(2, 4, 3).mean(1)
    return tiles.settle_seams(
        vertices,
        [0, 1, 2, 3, 1, 4, 5, 2],
        [0, 4],
        [0, 1],
        parts,
        home=home,
        vector_area=np.tile(np.array(normal, float), (2, 1)),
        moments=moments,
        diagonal=10.0,
        region_count=2,
        options=engine.MeshingOptions(reach=reach),
    )


TWO_SQUARES = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0.0]])


def test_corners_on_seams_settle_where_all_planes_round_them_meet():
    home = TWO_SQUARES + [5e5, 5e6, 100]
    off = home.copy()
    off[2, 2] += 0.08  # the result of one part alone
    before = tiles.judge_together(off, [0, 1, 2, 3, 1, 4, 5, 2], [0, 4], [0, 1], [0, 1]).report
    found = settled(off, [0, 1], home)
    assert found.report["planarity_max"] < 0.1 * before["planarity_max"]
    assert np.abs(found.vertices - home).max() < 0.02
    assert found.report["distance_max"] == pytest.approx(np.linalg.norm(found.vertices - home, axis=1).max(), rel=1e-6)
    alone = settled(off, [0, 0], home)
    assert alone.vertices.tolist() == off.tolist(), "where parts do not meet all stays, bit for bit"


def test_polygons_of_parts_that_meet_go_back_towards_the_scan():
    folded = TWO_SQUARES.copy()
    folded[4:] = [[0.5, 0.2, 0.1], [0.5, 0.8, -0.1]]
    before = tiles.judge_together(folded, [0, 1, 2, 3, 1, 4, 5, 2], [0, 4], [0, 1], [0, 1]).report
    assert before["intersecting"] == 1
    found = settled(folded, [0, 1], TWO_SQUARES, reach=1.0)
    assert (found.report["intersecting"], found.report["flipped"], found.report["crossing"]) == (0, 0, 0)


def test_places_that_do_not_fit_polygons_are_refused():
    with pytest.raises(ValueError, match="one place for each vertex"):
        settled(TWO_SQUARES[:6], [0, 1], np.concatenate([TWO_SQUARES, TWO_SQUARES]))
    with pytest.raises(ValueError, match="one part and one region for each of 2 polygons"):
        settled(TWO_SQUARES, [0], TWO_SQUARES)
