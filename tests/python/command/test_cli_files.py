"""The files that the command is given and writes: pipes, devices, links, permissions, names of any bytes."""

import json
import os
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

import isimp_engine as engine
import shapes
from commands import ENVIRONMENT, called, check_line, isimp

posix = pytest.mark.skipif(sys.platform == "win32", reason="needs files as POSIX has them")


def simplify(scan, out, *more, run=called, **keywords):
    return run("simplify", scan, out, "--proxies", 9, *more, **keywords)


def test_a_report_to_stdout_is_alone_there(scan, tmp_path):
    done = simplify(scan, tmp_path / "o.ply", "--report", "-", cwd=tmp_path, run=isimp)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["regions"] == 9
    assert "9 polygons" in done.stderr
    assert sorted(os.listdir(tmp_path)) == ["o.ply", "scan.ply"]
    done = simplify(scan, tmp_path / "o.ply", "--report", "./-", "--quiet", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, "")
    assert json.loads((tmp_path / "-").read_text())["regions"] == 9


def test_labels_are_not_written_to_stdout(scan, tmp_path):
    check_line(simplify(scan, tmp_path / "o.ply", "--labels", "-", cwd=tmp_path), 2, "--labels", "stdout")


@posix
def test_devices_pipes_and_links_to_them_are_not_replaced(scan, tmp_path):
    null, pipe = tmp_path / "null.ply", tmp_path / "pipe.ply"
    null.symlink_to("/dev/null")
    assert simplify(scan, null).returncode == 0
    assert null.readlink() == Path("/dev/null")
    os.mkfifo(pipe)
    read = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_bytes()), daemon=True)
    reader.start()
    assert simplify(scan, pipe, "--report", "/dev/null", "--labels", "/dev/null", run=isimp).returncode == 0
    reader.join(timeout=30)
    assert pipe.is_fifo()
    assert simplify(scan, tmp_path / "o.ply").returncode == 0
    assert read == [(tmp_path / "o.ply").read_bytes()]


@posix
def test_a_scan_may_come_through_a_pipe(scan, tmp_path):
    pipe = tmp_path / "pipe.ply"
    os.mkfifo(pipe)
    writer = threading.Thread(target=pipe.write_bytes, args=(scan.read_bytes(),), daemon=True)
    writer.start()
    vertices, triangles = engine.read(pipe)
    writer.join(timeout=30)
    np.testing.assert_array_equal(vertices, engine.read(scan)[0])
    np.testing.assert_array_equal(triangles, engine.read(scan)[1])


@posix
def test_what_is_replaced_keeps_its_permissions_and_links_lead_where_they_did(scan, tmp_path):
    out, link, report = tmp_path / "o.ply", tmp_path / "link.ply", tmp_path / "r.json"
    for path in (out, report):
        path.write_text("old")
        path.chmod(0o600)
    link.symlink_to("o.ply")
    assert simplify(scan, link, "--report", report).returncode == 0
    assert [path.stat().st_mode & 0o777 for path in (out, report)] == [0o600, 0o600]
    assert link.readlink() == Path("o.ply")
    mesh = engine.Mesh(*engine.read(scan))
    polygons = engine.polygonize(mesh, engine.partition(mesh, engine.PartitionOptions(proxies=9)))
    written = out.read_bytes()
    out.write_text("old")
    engine.write(link, polygons)
    assert link.readlink() == Path("o.ply")
    assert out.stat().st_mode & 0o777 == 0o600
    assert out.read_bytes() == written


@posix
def test_a_read_only_output_is_refused_before_the_work(scan, tmp_path):
    out = tmp_path / "o.ply"
    out.write_text("precious")
    out.chmod(0o444)
    check_line(simplify(scan, out), 2, out, "read-only")
    check_line(simplify(scan, tmp_path / "p.ply", "--report", out), 2, out, "read-only")
    mesh = engine.Mesh(*engine.read(scan))
    polygons = engine.polygonize(mesh, engine.partition(mesh))
    with pytest.raises(engine.FileError, match=r"o\.ply: it is read-only"):
        engine.write(out, polygons)
    assert out.read_text() == "precious"
    assert sorted(os.listdir(tmp_path)) == ["o.ply", "scan.ply"]


def test_a_hard_link_of_the_input_is_the_input(scan, tmp_path):
    other = tmp_path / "other.ply"
    other.hardlink_to(scan)
    check_line(simplify(scan, other), 2, other, "INPUT and all outputs must be different files")
    assert other.samefile(scan)


@posix
@pytest.mark.parametrize("closed", ["2>&-", "<&- >&- 2>&-"])
def test_closed_streams_change_nothing_else(scan, tmp_path, closed):
    line = f'exec "$0" -m isimp_engine simplify "$1" "$2" --proxies 9 {closed}'
    for name, status in (("o.ply", 0), ("o.fbx", 2)):
        command = ["sh", "-c", line, sys.executable, scan, tmp_path / name]
        assert subprocess.run(command, env=ENVIRONMENT, timeout=60).returncode == status
    assert engine.reading.read_polygons(tmp_path / "o.ply")[2].shape == (9,)


@posix
def test_names_may_be_any_bytes(scan, tmp_path):
    missing = os.fsencode(tmp_path) + b"/miss\xff.ply"
    with pytest.raises(engine.FileError, match="miss\udcff"):
        engine.read(missing)
    check_line(isimp("info", os.fsdecode(missing)), 3, "miss\\udcff.ply: there is no such file")
    odd = scan.rename(tmp_path / os.fsdecode(b"scan\xff.ply"))
    out, report = tmp_path / os.fsdecode(b"o\xfe.ply"), tmp_path / "r.json"
    done = simplify(odd, out, "--report", report, run=isimp, errors="surrogateescape")
    assert done.returncode == 0, done.stderr
    assert str(odd) in done.stdout
    assert json.loads(report.read_text())["input"]["path"] == str(odd)


@pytest.mark.parametrize("name", ["\ud800.ply", "a\0b.ply"])
def test_names_that_no_file_can_have_are_refused(name):
    with pytest.raises(engine.FileError, match="no file can have this name"):
        engine.read(name)
    with pytest.raises(TypeError, match=r"path must be a str, bytes or os\.PathLike, got a int"):
        engine.read(3)


@pytest.mark.parametrize(("row", "vertex"), [(0, 10**9), (2, -1), (1, 2**62), (2, 441)])
def test_cuts_at_vertices_that_are_not_there_name_the_row(scan, tmp_path, row, vertex):
    edges = np.array([[0, 1], [1, 2], [2, 3]])
    edges[row, 1] = vertex
    np.save(tmp_path / "e.npy", edges)
    done = simplify(scan, tmp_path / "o.ply", "--cuts", tmp_path / "e.npy")
    check_line(
        done, 2, f"e.npy: row {row} (the first is 0) names vertex {vertex}; the vertices of the scan are 0 to 440"
    )


def test_marked_edges_far_out_of_range_match_no_edge():
    mesh = engine.Mesh(*shapes.cube())
    base = int(mesh.source_vertex.max()) + 1
    a, b = sorted(mesh.triangles[0, :2].tolist())
    for edges in ([[a, 2**62]], [[a - 1, b + base]], [[-1, b]]):
        assert len(engine.guides.marked_edges(mesh, np.array(edges))) == 0
    assert len(engine.guides.marked_edges(mesh, np.array([[a, b]]))) == 1


@pytest.mark.parametrize("flag", ["--weights", "--borders", "--cuts", "--part"])
def test_an_archive_of_arrays_is_no_array(scan, tmp_path, flag):
    np.savez(tmp_path / "z.npz", a=np.ones(800))
    check_line(simplify(scan, tmp_path / "o.ply", flag, tmp_path / "z.npz"), 2, "z.npz: is not a .npy file of numbers")


@pytest.mark.parametrize("weights", [np.full(800, 1e308), np.full(800, 1e-300), 10.0 ** np.linspace(-300, 300, 800)])
def test_weights_whose_sums_are_no_numbers_are_refused(scan, tmp_path, weights):
    np.save(tmp_path / "w.npy", weights)
    done = simplify(scan, tmp_path / "o.ply", "--weights", tmp_path / "w.npy", "--report", tmp_path / "r.json")
    check_line(done, 2, "the largest weight, that of face", "must be in [1e-30, 1e+30]")


@pytest.mark.parametrize("scale", [1e30, 1e-30])
def test_the_largest_and_smallest_weights_give_numbers(scan, tmp_path, scale):
    np.save(tmp_path / "w.npy", scale * np.linspace(0, 1, 800))
    report = tmp_path / "r.json"
    done = simplify(scan, tmp_path / "o.ply", "--weights", tmp_path / "w.npy", "--report", report)
    assert done.returncode == 0, done.stderr
    assert 0 < json.loads(report.read_text())["error"] / scale < 10


def test_options_refuse_half_characters_as_invalid_input():
    for field in ("method", "backend", "seeding"):
        with pytest.raises(engine.InvalidInput, match=f"PartitionOptions.{field} must be .*ud800"):
            engine.PartitionOptions(**{field: "\ud800"})
