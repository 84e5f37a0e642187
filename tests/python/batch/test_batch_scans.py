"""The scans of a batch, the refused ones, and the number that has room at once."""

import json
import os
from concurrent.futures import Future
from pathlib import Path

import pytest

import meshfiles
import shapes
from batches import ODD, scan, whys
from commands import called
from isimp_engine import batch, machine
from isimp_engine.children import local, process

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="a batch needs fork")


def found(inputs, **keywords):
    return {scan.name: scan.output for scan in batch.scans.find_scans(inputs, **keywords)}


def test_scans_of_a_folder(scans):
    (scans / "notes.txt").touch()
    scan(scans / ".hidden.ply")
    scan(scans / ".hidden" / "d.ply")
    scan(scans / "LOUD.PLY")
    (scans / "sub" / "loop").symlink_to(scans)
    (scans / "broken.ply").symlink_to(scans / "nowhere")
    os.mkfifo(scans / "pipe.ply")
    odd = found(scans)
    assert odd.keys() >= {"broken.ply", "pipe.ply"}, "they are rows, not left out without a word"
    for name in ("broken.ply", "pipe.ply"):
        (scans / name).unlink()
    names = {"LOUD.PLY": "LOUD.obj", "a.ply": "a.obj", "b.ply": "b.obj", "sub/c.ply": "sub/c.obj"}
    assert found(scans) == names
    assert found([scans], besides=scans / "sub").keys() == names.keys() - {"sub/c.ply"}


def test_same_names_stay_apart(scans):
    meshfiles.obj(scans / "a.obj", *shapes.cube(1))
    meshfiles.obj(scans / "A.stl", *shapes.cube(1))
    names = found(scans, suffix=".ply")
    assert names == {
        "A.stl": "A.stl.ply",
        "a.obj": "a.obj.ply",
        "a.ply": "a.ply.ply",
        "b.ply": "b.ply",
        "sub/c.ply": "sub/c.ply",
    }
    scan(scans / "a.ply.stl")
    with pytest.raises(batch.BatchError, match=r"would both be written to 'a\.ply\.ply'"):
        found(scans, suffix=".ply")


def test_files_beside_results_stay_apart_too(tmp_path):
    for name in ("a", "a_normal"):
        scan(tmp_path / "in" / f"{name}.ply")
    with pytest.raises(batch.BatchError, match=r"a\.ply and .*a_normal\.ply would both be written to .*a_normal\.png"):
        batch.run(tmp_path / "in", tmp_path / "out", options={"texture": 64})
    assert not (tmp_path / "out").exists()
    outcome = batch.run(tmp_path / "in", tmp_path / "out", options={"proxies": 6})
    assert not outcome.failed, "without a texture there are no such files"


def test_a_picture_of_a_scan_is_not_replaced(tmp_path):
    scans, textures = tmp_path / "in", tmp_path / "textures"
    scans.mkdir()
    textures.mkdir()
    meshfiles.obj(scans / "wall.obj", *shapes.cube(1))
    (scans / "wall.obj").write_text("mtllib wall.mtl\n" + (scans / "wall.obj").read_text())
    (scans / "wall.mtl").write_text("newmtl wall\nmap_Kd ../textures/wall.png\n")
    (textures / "wall.png").write_bytes(b"precious")
    with pytest.raises(batch.BatchError, match=r"would replace wall\.png of the scan .*wall\.obj: give another"):
        batch.run(scans, textures, options={"texture": 64})
    assert [path.name for path in textures.iterdir()] == ["wall.png"]


def test_wrong_names_in_a_scan_are_a_matter_of_its_row(tmp_path):
    scan(tmp_path / "in" / "a.ply")
    for k, uri in enumerate(["gone.bin", "../up.bin", "a\0b", "\ud800", "x" * 5000, "http://host/a.bin", 7]):
        (tmp_path / "in" / f"{k}.gltf").write_text(json.dumps({"buffers": [{"uri": uri}]}))
    for k, text in enumerate(["[]", "{", "[" * 100_000, '{"buffers": 3}']):
        (tmp_path / "in" / f"odd{k}.gltf").write_text(text)
    (tmp_path / "in" / "cut.glb").write_bytes(b"glTF\2\0\0\0")
    (tmp_path / "in" / "o.obj").write_bytes(b"mtllib\nmtllib \0.mtl ../../a.mtl /dev/zero\nmtllib m.mtl\n")
    (tmp_path / "in" / "m.mtl").write_bytes(
        b'newmtl a\nmap_Kd "x\nmap_Kd /dev/zero\nmap_Kd \0<UDIM>.png\nnorm ../../../a.png'
    )
    (tmp_path / "in" / "p.ply").write_bytes(b"ply\ncomment TextureFile\ncomment TextureFile \0 \xff.png\nend_header\n")
    outcome = batch.run(tmp_path / "in", tmp_path / "out", options={"texture": 64}, pictures=False)
    assert len(outcome.rows) == 15
    assert len(whys(outcome)) == 15, "a.ply has no texture"
    linked = {each.name: each.linked for each in batch.scans.find_scans(tmp_path / "in")}
    assert linked["0.gltf"] == (("gone.bin", 0, 0),)
    assert [name for name, _, _ in linked["o.obj"]] == ["m.mtl"]


def test_scans_of_patterns_lists_and_several_places(scans, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert found("in/*.ply") == {"a.ply": "a.obj", "b.ply": "b.obj"}
    assert found(str(scans / "**" / "[bc].ply")) == {"b.ply": "b.obj", "sub/c.ply": "sub/c.obj"}
    assert found([scans / "a.ply", scans / "sub" / "c.ply"]).keys() == {"a.ply", "sub/c.ply"}
    assert found(scans / "sub" / "c.ply").keys() == {"c.ply"}
    scan(tmp_path / "more" / "a.ply")
    assert found([scans, "more"]).keys() == {"in/a.ply", "in/b.ply", "in/sub/c.ply", "more/a.ply"}
    (scans / "list.txt").write_text("a.ply\n# not b\n\n  sub/c.ply\n")
    assert found(scans / "list.txt").keys() == {"a.ply", "sub/c.ply"}
    (scans / "list.txt").write_text("a.ply\n../more/a.ply\na.ply\n")
    assert found(scans / "list.txt").keys() == {"in/a.ply", "more/a.ply"}


def test_a_missing_scan_of_a_list_is_a_row(scans, tmp_path):
    (scans / "list.txt").write_text("a.ply\ngone.ply\n")
    outcome = batch.run(scans / "list.txt", tmp_path / "out")
    assert [row["status"] for row in outcome.rows] == ["ok", "failed"]
    assert whys(outcome)["gone.ply"] == "there is no such file"


def test_names_of_any_kind(tmp_path):
    names = ["a b.ply", "<b>&.ply", "ü.ply", "new\nline.ply", "$x;'.ply"]
    for name in names:
        scan(tmp_path / "in" / name)
    raw = os.fsdecode(os.fsencode(tmp_path / "in") + b"/\xff.ply")
    scan(Path(raw))
    outcome = batch.run(tmp_path / "in", tmp_path / "out")
    assert not outcome.failed
    assert len(outcome.rows) == 6
    assert {row["name"] for row in batch.table.read_rows(tmp_path / "out")} == {*names, Path(raw).name}
    assert all(Path(row["output"]).is_file() for row in outcome.rows)
    text = (tmp_path / "out" / "results.html").read_text()
    assert "<b>" not in text
    assert '<a href="%FF.obj">' in text
    assert batch.run(tmp_path / "in", tmp_path / "out").before == 6


def test_what_is_wrong_with_the_whole_is_2_and_changes_nothing(scans, tmp_path):
    out, recipe = tmp_path / "out", tmp_path / "r.json"
    recipe.write_text("{}")
    (tmp_path / "empty").mkdir()
    (tmp_path / "file").touch()
    for arguments, words in [
        ((scans, out, "--proxies", 0), ["--proxies must be at least 1, got 0"]),
        ((scans, out, "--leave-out", 1), ["--leave-out must be in [0, 1), got 1"]),
        ((scans, out, "--detail", "nan"), ["--detail must be in (0, 1], got nan"]),
        ((scans, out, "--method", "magic"), ["--method must be one of"]),
        ((scans, out, "--format", "fbx"), ["'fbx'", "ply, obj"]),
        ((scans, out, "--jobs", 0), ["jobs", "at least 1, got 0"]),
        ((scans, out, "--time-limit", 0), ["time limit", "above 0, got 0"]),
        ((scans, out, "--memory-limit", "nan"), ["memory limit", "above 0, got nan"]),
        ((scans, out, "--recipe", recipe), [recipe, "not a recipe"]),
        ((scans, scans), [scans, "is the folder of the scans"]),
        ((scans, tmp_path / "file"), ["is a file"]),
        ((scans / "*.ply", scans), [scans, "is the folder of the scans"]),
        ((scans / "a.ply", scans, "--format", "ply"), ["would replace the scan"]),
        ((tmp_path / "empty", out), ["there is no scan"]),
        ((tmp_path / "nowhere", out), ["there is no such file or folder"]),
        ((scans,), ["required: OUTPUT_FOLDER"]),
    ]:
        done = called("batch", *arguments)
        assert done.returncode == 2, arguments
        assert done.stdout == ""
        assert all(str(word) in done.stderr.splitlines()[-1] for word in words), done.stderr
        assert "Traceback" not in done.stderr
    assert not out.exists()
    assert sorted(path.name for path in scans.iterdir()) == ["a.ply", "b.ply", "sub"]
    with pytest.raises(batch.BatchError, match=r"no option 'proxy'; there are .*proxies"):
        batch.run(scans, out, options={"proxy": 3})
    with pytest.raises(batch.BatchError, match="proxies"):
        batch.run(scans, out, options={"proxies": "many"})
    with pytest.raises(batch.BatchError, match=r"--clutter must be one of keep, leave-out, box, got 'drop'"):
        batch.run(scans, out, options={"clutter": "drop"})
    with pytest.raises(batch.BatchError, match=r"--detail and --proxies each set the number"):
        batch.run(scans, out, options={"proxies": 3, "detail": 0.1})


def test_options_of_one_file_are_refused_for_a_batch():
    done = called("batch", "in", "out", "--weights", "w.npy")
    assert done.returncode == 2
    assert "--weights" in done.stderr


# Room for them


def test_faces_are_estimated_by_header_and_size(tmp_path):
    vertices, triangles = shapes.cube(10)
    for kind, write in meshfiles.TRIANGLES.items():
        write(tmp_path / kind, vertices, triangles.tolist())
        assert 0.3 * len(triangles) <= batch.scans.estimated_faces(tmp_path / kind) <= 4 * len(triangles), kind
    for name in ("a.gltf", "b.gltf", "c.gltf", "d.gltf", "e.gltf"):
        meshfiles.gltf(tmp_path / name, vertices, triangles)
    assert len(triangles) <= batch.scans.estimated_faces(tmp_path / "a.gltf") <= 4 * len(triangles), "its own alone"
    lie = tmp_path / "lie.ply"
    lie.write_bytes(b"ply\nformat binary_little_endian 1.0\nelement face 4000000000\nend_header\n")
    assert batch.scans.estimated_faces(lie) < 10
    assert batch.scans.estimated_faces(tmp_path / "nowhere.ply") == 0
    assert batch.scans.needed_mb(0, 0) > 10
    assert batch.scans.needed_mb(10**6, 2 * 10**7) > 200


def test_as_many_at_once_as_cores_and_memory_allow(tmp_path, monkeypatch):
    monkeypatch.setattr(machine, "cores", lambda: 8)
    monkeypatch.setattr(machine, "memory_mb", lambda: 1000 / 0.9)
    with local.Local(tmp_path, None, process.Limits(), ODD) as workers:
        assert workers.threads(100, 1) == 8, "one alone has all cores"
        assert workers.threads(100, 2) == 4
        assert workers.threads(100, 100) == 1
        assert workers.threads(450, 100) == 4, "memory for two of them"
        assert workers.threads(5000, 100) == 8, "more than there is: it is tried alone"
        monkeypatch.setattr(workers, "_submit", lambda *_: Future())
        workers.start(0, {}, 700)
        assert workers.threads(400, 5) == 0
        assert workers.threads(300, 5) == 2
    with local.Local(tmp_path, 2, process.Limits(mb=300), ODD) as workers:
        monkeypatch.setattr(workers, "_submit", lambda *_: Future())
        for number in range(2):
            assert workers.threads(5000, 100) == 4, "a limit bounds what is needed"
            workers.start(number, {}, 5000)
        assert workers.threads(1, 100) == 0, "two jobs were requested"
    with local.Local(tmp_path, None, process.Limits(), ODD, threads=4) as workers:
        monkeypatch.setattr(workers, "_submit", lambda *_: Future())
        for number in range(2):
            assert workers.threads(1, 100)
            workers.start(number, {}, 1)
        assert workers.threads(1, 100) == 0, "two of four threads keep eight cores busy"
