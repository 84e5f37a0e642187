"""Islands that are coplanar with the wall around them become part of it, with their rims."""

import json
import pathlib

import numpy as np
import pytest

import isimp_engine as engine
import shapes
from isimp_engine.cli import main

RIM_REGIONS = 9  # regions of a groove: its bottom, four sides on the wall's side and four on the pane's


def slab(depth: int = 1, noise: float = 0.0, set_back: int = 0) -> tuple[engine.Mesh, engine.Partition]:
    """The slab of `shapes`, with each plane of each part a region."""
    clean, triangles, label = shapes.slab_with_pane(depth, set_back)
    mesh = engine.Mesh(clean + noise * np.random.default_rng(2).standard_normal(clean.shape), triangles)
    return mesh, engine.partition_from(mesh, label)


def front(mesh: engine.Mesh, part: engine.Partition) -> int:
    """The region of the wall that has the pane."""
    middle = np.asarray(mesh.vertices)[mesh.triangles].mean(axis=1)
    return int(part.face_region[np.argmin(np.abs(middle - (3, 3, 8)).sum(1))])


@pytest.mark.parametrize(("depth", "noise"), [(1, 0.0), (2, 0.03)])
def test_a_pane_behind_a_groove_becomes_part_of_its_wall(depth: int, noise: float) -> None:
    mesh, part = slab(depth, noise)
    plain = engine.regularise(mesh, part)
    assert np.array_equal(plain.face_region, part.face_region)
    assert plain.report["islands_merged"] == 0
    merged = engine.regularise(mesh, part, engine.RegulariseOptions(merge_islands=depth + 0.5))
    assert merged.report["islands_merged"] == RIM_REGIONS + 1
    assert merged.region_count == part.region_count - RIM_REGIONS - 1 == 6
    wall, before = front(mesh, merged), front(mesh, plain)
    assert np.array_equal(merged.region_normal[wall], plain.region_normal[before])
    assert merged.region_offset[wall] == plain.region_offset[before]
    assert merged.error == pytest.approx(engine.partition_from(mesh, merged.face_region).error)
    assert merged.report["rms_added"] > plain.report["rms_added"], "the rim is off the wall"
    poly = engine.polygonize(mesh, merged, engine.MeshingOptions(planar=True))
    assert np.diff([*poly.loop_start, len(poly.loops)]).tolist() == [4] * 6, "a box"
    assert poly.report["closed"]


def test_a_box_that_does_not_touch_the_wall_stays() -> None:
    large, triangles = shapes.cube(10)
    small, faces = shapes.cube(4)
    small = small * [0.5, 0.5, 0.1] + [12, 4, 2.9]
    mesh = engine.clean(np.concatenate([large * [10, 10, 3], small]), np.concatenate([triangles, faces + len(large)]))
    part = engine.partition(mesh, engine.PartitionOptions(proxies=12, leave_out=0))
    found = engine.regularise(mesh, part, engine.RegulariseOptions(merge_islands=0.2))
    assert found.report["islands_merged"] == 0
    assert np.array_equal(found.face_region, part.face_region)


@pytest.mark.parametrize(("allowed", "set_back"), [(1.5, 0), (9.0, 1)])
def test_a_deeper_rim_and_a_pane_set_back_stay(allowed: float, set_back: int) -> None:
    mesh, part = slab(2, set_back=set_back)
    kept = engine.regularise(mesh, part, engine.RegulariseOptions(merge_islands=allowed))
    assert kept.report["islands_merged"] == 0
    assert np.array_equal(kept.face_region, part.face_region)


def test_what_a_person_has_set_stays() -> None:
    mesh, part = slab()
    options = engine.RegulariseOptions(merge_islands=1.5)
    middle = np.asarray(mesh.vertices)[mesh.triangles].mean(axis=1)
    pane = int(np.argmin(np.abs(middle - (16, 14, 8)).sum(1)))
    groove = int(np.argmin(np.abs(middle - (9.5, 14, 7)).sum(1)))
    for face in (pane, groove):
        locked = engine.lock_regions(mesh, part, [face])
        assert engine.regularise(mesh, locked, options).report["islands_merged"] == 0
    free = engine.align_planes(mesh, part, [groove], "free")
    assert engine.regularise(mesh, free, options).report["islands_merged"] == 0
    wall = int(part.region_seed[front(mesh, part)])
    by_hand = engine.regularise(mesh, engine.align_planes(mesh, part, [wall], "level"), options)
    assert by_hand.report["islands_merged"] == RIM_REGIONS + 1
    assert by_hand.region_held[by_hand.face_region[wall]] == 2
    other = engine.lock_regions(mesh, part, [int(np.argmin(middle[:, 2]))])
    kept = engine.regularise(mesh, other, options)
    assert kept.region_locked.sum() == 1
    assert kept.region_locked[kept.face_region[int(np.argmin(middle[:, 2]))]] == 1


def test_nothing_is_merged_across_a_barrier() -> None:
    mesh, part = slab()
    triangles, middle = np.asarray(mesh.triangles), np.asarray(mesh.vertices)[mesh.triangles].mean(axis=1)
    on_pane = (middle[:, 2] == 8) & (np.abs(middle[:, :2] - (16, 14)) < 6).all(axis=1)
    edges = np.sort(triangles[on_pane][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    rim, count = np.unique(edges, axis=0, return_counts=True)
    guided = engine.partition_from(mesh, part.face_region, barriers=rim[count == 1])
    options = engine.RegulariseOptions(merge_islands=1.5)
    assert engine.regularise(mesh, part, options).report["islands_merged"] > 0
    assert engine.regularise(mesh, guided, options).report["islands_merged"] == 0


def test_command(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    mesh, part = slab()
    scan, report = tmp_path / "slab.off", tmp_path / "report.json"
    lines = ["OFF", f"{len(mesh.vertices)} {len(mesh.triangles)} 0"]
    lines += [" ".join(map(repr, row)) for row in mesh.vertices.tolist()]
    lines += [f"3 {a} {b} {c}" for a, b, c in mesh.triangles.tolist()]
    scan.write_text("\n".join(lines))
    arguments = ["simplify", str(scan), str(tmp_path / "out.obj"), "--proxies", str(part.region_count), "--quiet"]
    arguments += ["--merge-islands", "1.5"]
    assert main(arguments) == 2
    assert "--merge-islands needs --regularise" in capsys.readouterr().err
    assert main([*arguments, "--regularise", "--planar", "--report", str(report)]) == 0
    told = json.loads(report.read_text())
    assert told["options"]["regularise"]["merge_islands"] == 1.5
    assert told["output"]["polygons"] == 6
