"""Tiles in groups: no process has the graph of all, and the result is as good, exact and repeatable as without."""

import os
import subprocess
import sys

import numpy as np
import pytest

import shapes
import tilesets
from batches import ENVIRONMENT, wait_for
from isimp_engine import batch, machine, tiles
from isimp_engine.tiles import grouped, steps
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


@pytest.fixture(scope="module")
def by_detail(tmp_path_factory, folder):
    options = {"detail": 0.01}
    return tiles.run(folder, tmp_path_factory.mktemp("all") / "a.obj", options=options, group=12).report


@pytest.fixture(scope="module")
def by_threes(tmp_path_factory, folder):
    """The polygons and the labels of groups of three tiles, done by as many workers as there are cores."""
    out = tmp_path_factory.mktemp("threes") / "b.ply"
    tiles.run(folder, out, proxies=P, group=3, labels=out.with_suffix(".labels"))
    return out.read_bytes(), bits_of(out.with_suffix(".labels"))


def bits_of(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


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
def test_detail_finds_the_number_that_it_finds_without_groups(tmp_path, folder, by_detail, group):
    report = tiles.run(folder, tmp_path / "b.obj", options={"detail": 0.01}, group=group).report
    assert report["groups"] > 1
    assert report["tolerance"] == by_detail["tolerance"]
    assert report["regions"] == pytest.approx(by_detail["regions"], abs=max(1, by_detail["regions"] // 10))
    assert report["snapped"] == by_detail["snapped"]


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


def test_groups_give_the_same_bits_for_any_number_of_workers(tmp_path, folder, by_threes):
    jobs = 1 if machine.cores() > 1 else 2
    tiles.run(folder, tmp_path / "a.ply", proxies=P, group=3, children=batch.Children(jobs), labels=tmp_path / "labels")
    assert ((tmp_path / "a.ply").read_bytes(), bits_of(tmp_path / "labels")) == by_threes


@pytest.mark.parametrize("step", ["group/000001", "cut/000000", "regroup/000002"])
def test_groups_that_were_killed_go_on_and_give_the_same_bits(tmp_path, folder, by_threes, step):
    code = "import sys; from isimp_engine import tiles; "
    code += f"tiles.run(sys.argv[1], sys.argv[2], proxies={P}, group=3, work=sys.argv[3])"
    command = [sys.executable, "-c", code, str(folder), str(tmp_path / "a.ply"), str(tmp_path / "work")]
    process = subprocess.Popen(command, env=ENVIRONMENT)
    wait_for((tmp_path / "work" / step).exists)
    process.kill()
    process.wait()
    assert not (tmp_path / "a.ply").exists()
    states = []
    watch = lambda state: states.append(state.before)  # noqa: E731
    tiles.run(folder, tmp_path / "a.ply", proxies=P, group=3, work=tmp_path / "work", watch=watch)
    assert max(states) > 20
    assert (tmp_path / "a.ply").read_bytes() == by_threes[0]


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
    found = steps.Components(np.zeros(8, np.int32), np.array([1], np.int32), 0, 0.0)
    whole = steps.merge(sums, pairs, np.zeros(7), found, 3)
    parts, price = [], []
    for own, at_border in ((slice(0, 4), 3), (slice(4, 8), 0)):
        border = np.zeros(4, bool)
        border[at_border] = True
        part = steps.Components(found.component[own], found.need, 0, 0.0)
        merges = steps.merge_inside(sums[own], pairs[:3], np.zeros(3), part, border, 1)
        assert (np.diff(merges.price) >= 0).all()
        parts.append(merges)
        price.append(merges.price)
    at = steps.common_price(price, 8, 4)
    labels = [steps.labels_after(4, each, at) for each in parts]
    both = np.append(labels[0], labels[1] + labels[0].max() + 1).astype(np.int32)
    rest, near, lengths = steps.contracted(both, sums, pairs, np.ones(7))
    assert len(rest) == 4
    assert rest.sum(0) == pytest.approx(sums.sum(0))
    assert lengths.tolist() == [1.0] * 3
    left = steps.Components(np.zeros(4, np.int32), found.need, 0, 0.0)
    assert steps.merge(rest, near, 0 * lengths, left, 3)[both].tolist() == whole.tolist() == [0, 0, 1, 1, 1, 2, 2, 2]


def test_nodes_at_the_border_of_a_group_do_not_merge_with_each_other():
    sums, pairs = strip(np.array([0, 0, 0, 0.001]))
    found = steps.Components(np.zeros(4, np.int32), np.array([1], np.int32), 0, 0.0)
    merges = steps.merge_inside(sums, pairs, np.zeros(3), found, [1, 1, 0, 0], 1)
    assert steps.labels_after(4, merges, np.inf).tolist() == [0, 1, 1, 1]
    assert len(steps.merge_inside(sums, pairs, np.zeros(3), found, [1, 1, 0, 0], 3).price) == 1
    assert len(steps.merge_inside(sums, pairs, np.zeros(3), found, [0, 0, 0, 0], 1, 0.0).price) == 0


def test_a_small_part_of_a_plane_counts_as_all_of_it():
    sums, pairs = strip(np.array([0, 0.3]))
    sums[0, :4] *= 0.01
    found = steps.Components(np.zeros(2, np.int32), np.array([1], np.int32), 0, 0.0)
    alone = steps.merge_inside(sums, pairs, np.zeros(1), found, [0, 0], 1).price[0]
    part = steps.merge_inside(sums, pairs, np.zeros(1), found, [1, 0], 1).price[0]
    assert part == pytest.approx(1 - np.cos(0.3))
    assert alone < 0.02 * part


def test_prices_leave_no_fewer_than_wanted():
    prices = [np.array([1.0, 2.0, 2.0]), np.array([2.0, 5.0])]
    for nodes, target, below in ((10, 10, 0), (10, 9, 1), (10, 7, 1), (10, 6, 4), (10, 5, 5), (10, 1, 5)):
        price = steps.common_price(prices, nodes, target)
        assert sum((each < price).sum() for each in prices) == below


def test_what_does_not_fit_is_refused():
    sums, pairs = strip(np.zeros(3))
    found = steps.Components(np.zeros(3, np.int32), np.array([1], np.int32), 0, 0.0)
    with pytest.raises(ValueError, match="`border` must have one value for each node"):
        steps.merge_inside(sums, pairs, np.zeros(2), found, [0, 0], 1)
    with pytest.raises(ValueError, match="pair 0 names node 7"):
        steps.merge_inside(sums, pairs + 7, np.zeros(2), found, [0, 0, 0], 1)
