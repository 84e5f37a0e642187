"""The whole way on real and known meshes, which are not part of the repository; skipped where they are absent."""

import json

import numpy as np
import pytest

import isimp_engine as engine
from isimp_engine.cli import main

SCANS = [
    "scan/bunny_69k.ply",
    "scan/rockerarm_20k.ply",
    "building/fandisk_13k.ply",
    "building/frankfurt_tile_49k.ply",
    "nasty/cgal_bones_4k_26comp.ply",
    "nasty/openscad_nonmanifold_1k.ply",
    "nasty/easy3d_degenerate_8.ply",
    "known/cube20_nan.ply",
    "known/nm_fin_cube.ply",
]


@pytest.mark.parametrize("name", SCANS)
def test_a_scan_becomes_a_manifold_with_a_label_for_each_face(data, tmp_path, name):
    out, labels, report = tmp_path / "o.ply", tmp_path / "l.npy", tmp_path / "r.json"
    flags = ["--quiet", "--labels", str(labels), "--report", str(report)]
    faces = len(engine.reading.read_polygons(data / name)[2])
    assert main(["simplify", str(data / name), str(out), "--proxies", str(min(200, faces)), *flags]) == 0
    said, values = json.loads(report.read_text()), np.load(labels)
    assert said["input"]["faces"] == faces == len(values)
    assert said["regions"] == max(min(200, faces), said["partition"]["proxies_needed"])
    assert set(range(said["regions"])) <= set(values), "no region is of patches alone"
    assert max(values) < said["regions"]
    assert said["output"]["manifold"] is True
    assert said["output"]["closed"] == said["mesh"]["closed"] or said["partition"]["parts_left_out"]
    vertices, loops, loop_start = engine.reading.read_polygons(out)
    assert (len(vertices), len(loops), len(loop_start)) == tuple(
        said["output"][key] for key in ("vertices", "corners", "polygons")
    )


@pytest.mark.parametrize(("name", "regions"), [("cube20", 6), ("lhouse", 11), ("washer", 10), ("two_cubes", 12)])
def test_known_planes_are_found_from_any_face_order(data, name, regions):
    vertices, triangles = engine.read(data / f"known/{name}.ply")
    truth = np.loadtxt(data / f"known/{name}.lab", dtype=int)
    for seed in range(5):
        order = np.random.default_rng(seed).permutation(len(triangles))
        part = engine.partition(engine.Mesh(vertices, triangles[order]), engine.PartitionOptions(proxies=regions))
        pairs = set(zip(part.face_region.tolist(), truth[order].tolist(), strict=True))
        assert len(pairs) == regions == part.region_count, f"order {seed}"


@pytest.mark.parametrize("name", ["known/empty.ply", "scan"])
def test_unusable_input_is_named(data, tmp_path, capsys, name):
    assert main(["simplify", str(data / name), str(tmp_path / "o.ply")]) == 3
    assert capsys.readouterr().err.startswith(f"isimp: {data / name}: ")
    assert list(tmp_path.iterdir()) == []
