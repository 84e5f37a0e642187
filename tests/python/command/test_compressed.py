"""Compressed files are read by all commands as if they were unpacked, and damage is reported in one line."""

import gzip
import os

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
import tilesets
from commands import ran
from isimp_engine import reading, tiles
from isimp_engine.batch.scans import estimated_faces, find_scans


@pytest.fixture
def scan(tmp_path):
    """A PLY file, and the same as .ply.gz."""
    vertices, triangles = shapes.cube(6)
    meshfiles.ply_binary(tmp_path / "plain.ply", vertices, triangles.tolist())
    packed = tmp_path / "packed.PLY.gz"
    packed.write_bytes(gzip.compress((tmp_path / "plain.ply").read_bytes()))
    return tmp_path / "plain.ply", packed


def test_gz_gives_the_arrays_of_the_plain_file_and_leaves_nothing_behind(scan, monkeypatch, tmp_path):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    before = sorted(os.listdir(tmp_path))
    for read in (engine.read, engine.reading.read_polygons):
        for one, other in zip(read(scan[0]), read(scan[1]), strict=True):
            np.testing.assert_array_equal(one, other)
    assert sorted(os.listdir(tmp_path)) == before


@pytest.mark.parametrize("kind", [".glb", ".gltf", ".3mf"])
def test_gz_of_kinds_that_python_reads(scan, tmp_path, kind):
    made = engine.simplify(scan[0], proxies=6)
    made.write(tmp_path / f"a{kind}")
    packed = tmp_path / f"a{kind}.gz"
    packed.write_bytes(gzip.compress((tmp_path / f"a{kind}").read_bytes()))
    for one, other in zip(engine.read(packed), engine.read(tmp_path / f"a{kind}"), strict=True):
        np.testing.assert_array_equal(one, other)
    assert len(engine.simplify(packed, proxies=6).polygons.loop_start) == 6


def test_zst_is_read_where_a_package_is_there_and_else_the_line_names_it(scan, monkeypatch):
    packed = scan[0].with_suffix(".ply.zst")
    if (zstandard := reading._zstd()) is not None:
        packed.write_bytes(zstandard.compress(scan[0].read_bytes()))
        np.testing.assert_array_equal(engine.read(packed)[0], engine.read(scan[0])[0])
        whole = packed.read_bytes()
        for damaged in (whole[:100], whole[:-1], b"x" * 100):
            packed.write_bytes(damaged)
            with pytest.raises(engine.FileError, match=r"plain\.ply\.zst: its compression is damaged"):
                engine.read(packed)
        data = scan[0].read_bytes()
        packed.write_bytes(zstandard.compress(data[:999]) + zstandard.compress(data[999:]))
        np.testing.assert_array_equal(engine.read(packed)[0], engine.read(scan[0])[0])
    monkeypatch.setattr(reading, "_zstd", lambda: None)
    packed.write_bytes(b"")
    with pytest.raises(engine.FileError, match=r"plain\.ply\.zst: .* pip install 'isimp\[zstd\]'"):
        engine.read(packed)


@pytest.mark.parametrize("keep", [0.5, 0.99])
def test_a_file_that_was_cut_short_is_named(scan, keep):
    data = scan[1].read_bytes()
    scan[1].write_bytes(data[: int(len(data) * keep)])
    with pytest.raises(engine.FileError, match=r"packed\.PLY\.gz: its compression is damaged or cut short"):
        engine.read(scan[1])


def test_faults_inside_name_the_compressed_file(tmp_path):
    (tmp_path / "torn.obj.gz").write_bytes(gzip.compress(b"v 0 0 0\nf 1 2 3\n"))
    with pytest.raises(engine.FileError, match=rf"^{tmp_path}/torn\.obj\.gz: face 0 .* uses vertex 2"):
        engine.read(tmp_path / "torn.obj.gz")
    with pytest.raises(engine.FileError, match=r"not\.ply\.gz: there is no such file"):
        engine.read(tmp_path / "not.ply.gz")
    with pytest.raises(engine.FileError, match=r"a\.ply\.gz: is compressed; decompress it first"):
        engine.read_textured(tmp_path / "a.ply.gz")


def test_batches_find_compressed_scans_and_name_results_after_their_content(scan):
    found = find_scans([scan[0].parent])
    assert [(s.name, s.output) for s in found] == [("packed.PLY.gz", "packed.obj"), ("plain.ply", "plain.obj")]
    assert estimated_faces(scan[1]) == estimated_faces(scan[0]) == 432


@pytest.mark.skipif(not hasattr(os, "fork"), reason="tiles need fork")
def test_tiles_and_single_scans_may_be_compressed(tmp_path):
    folder = tilesets.write(tmp_path / "in", tilesets.cut(*shapes.cube(8), 2))
    for path in list(folder.iterdir()):
        path.with_name(path.name + ".gz").write_bytes(gzip.compress(path.read_bytes()))
        path.unlink()
    assert tiles.run(folder, tmp_path / "a.obj", proxies=6, labels=tmp_path / "l").report["regions"] == 6
    assert sorted(p.name for p in (tmp_path / "l").iterdir()) == ["tile_00.npy", "tile_01.npy"]
    meshfiles.ply_binary(tmp_path / "one.ply", *(lambda v, t: (v, t.tolist()))(*shapes.cube(8)))
    (tmp_path / "one.ply.gz").write_bytes(gzip.compress((tmp_path / "one.ply").read_bytes()))
    done = ran("tiles", tmp_path / "one.ply.gz", tmp_path / "b.obj", "--proxies", 6, "--tile-faces", 300)
    assert "768 faces in 3 tiles" in done.stdout
