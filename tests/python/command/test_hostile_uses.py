"""Wrong values, odd names, full disks and signals end in one line, and leave nothing behind."""

import errno
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
import tilesets
from batches import ODD, scan, whys
from commands import ENVIRONMENT, called
from isimp_engine import batch, drafts, exporting, recipes, tiles
from isimp_engine.cli.ending import Terminated, terminable
from isimp_engine.cli.files import Outputs
from isimp_engine.texturing.obj import is_nameable
from isimp_engine.texturing.writing import refusal
from isimp_engine.tiles import store
from test_texture import ramp, result, write_plane_obj

posix = pytest.mark.skipif(sys.platform == "win32", reason="needs signals, pipes and devices as POSIX has them")
HUGE = 10**400


# Recipes and exporters


@pytest.mark.parametrize(
    "step",
    [
        {"step": "partition", "detail": HUGE},
        {"step": "partition", "smooth": HUGE},
        {"step": "partition", "angle": HUGE},
        {"step": "partition", "keep_openings": [[HUGE, 0, 0]]},
        {"step": "regularise", "angle": HUGE},
        {"step": "regularise", "direction": [HUGE, 0, 0]},
        {"step": "even_borders", "strength": HUGE},
        {"step": "add_worst", "times": HUGE},
        {"step": "texture", "occlusion": True, "occlusion_distance": HUGE},
        {"step": "texture", "size": HUGE},
    ],
)
def test_numbers_of_400_digits_are_refused_with_their_step(step):
    steps = [{"step": "partition", "detail": 0.01}, {"step": "mesh"}, step]
    with pytest.raises(recipes.RecipeError, match=r"^step 3: ") as caught:
        recipes.parsed({"isimp_recipe": 1, "steps": steps})
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize("error", ["ImportError('no memory for it')", "SystemError('no memory for it')"])
def test_a_package_that_can_not_be_loaded_is_named_before_the_work(tmp_path, monkeypatch, error):
    (tmp_path / "OCP.py").write_text(f"raise {error}\n")
    monkeypatch.syspath_prepend(tmp_path)
    for name in [name for name in sys.modules if name.split(".")[0] == "OCP"]:
        monkeypatch.delitem(sys.modules, name)
    said = r"a\.step: the package cadquery-ocp-novtk, which is needed to write it, can't be loaded \(no memory for it\)"
    with pytest.raises(engine.FileError, match=said):
        exporting.require("a.step")


# Names of outputs


def test_names_that_obj_files_can_not_hold_are_refused_before_the_work(tmp_path):
    for name in ("a\nb", "a\rb", "a\tb", " ", " a", '"q"', "a\\b", "-o 1", "-bm x"):
        assert not is_nameable(f"{name}.png")
        assert "OBJ files can't name files so" in refusal(tmp_path / f"{name}.obj")
        assert refusal(tmp_path / f"{name}.glb") == ""
    path = write_plane_obj(tmp_path, lambda p: p)
    done = called("simplify", path, tmp_path / "a\nb.obj", "--proxies", 1, "--texture", 16)
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 1)
    assert "OBJ files can't name files so" in done.stderr


def test_textured_outputs_of_odd_names_are_read_back(tmp_path):
    soup = engine.TexturedSoup(*shapes.plane(2), uv=shapes.plane(2)[0][:, :2], images=[ramp()])
    _, _, poly, made = result(soup, np.zeros(len(soup.triangles)), size=16)
    names = [
        "a b",
        'q"',
        "a  b",
        "ünï",
        "a\x0bb",
        "#x",
        "a'b",
        "-x",
        "scan:1",
        "a#b",
        "日本",
        "\udcff",
        "%s",
        "a" * 240,
    ]
    for name in names:
        engine.write_textured(tmp_path / f"{name}.obj", poly, made)
        assert engine.read_textured(tmp_path / f"{name}.obj").has_texture, name
    assert not [path for path in os.listdir(tmp_path) if path.startswith(".")]


def test_a_scan_with_a_name_of_240_letters_is_one_of_a_batch(tmp_path):
    scan(tmp_path / "in" / f"{'a' * 240}.ply")
    outcome = batch.run(tmp_path / "in", tmp_path / "out", options={"proxies": 6}, labels=False)
    assert whys(outcome) == {}


# Drafts and full disks


def test_a_draft_follows_no_link_and_takes_no_file_of_before(tmp_path):
    kept = tmp_path / "kept"
    kept.write_text("kept")
    (tmp_path / f".a.{os.getpid()}.txt").symlink_to(kept)
    (tmp_path / f".a.{os.getpid()}-1.txt").write_text("old")
    with drafts.whole(tmp_path / "a.txt") as draft:
        draft.write_text("new")
    assert (tmp_path / "a.txt").read_text() == "new"
    assert kept.read_text() == "kept"
    assert (tmp_path / f".a.{os.getpid()}-1.txt").read_text() == "old"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is full")
def test_a_full_disk_is_named_with_the_file(tmp_path):
    with pytest.raises(OSError, match="No space left") as caught:
        drafts.save_array(Path("/dev/full"), np.arange(10))
    assert caught.value.errno == errno.ENOSPC
    values = np.arange(12.0).reshape(3, 4).T
    drafts.save_array(tmp_path / "a.npy", values)
    np.testing.assert_array_equal(np.load(tmp_path / "a.npy"), values)
    with Outputs() as outputs, pytest.raises(OSError, match=r"l\.npy") as caught:
        outputs.write(tmp_path / "l.npy", lambda part: (_ for _ in ()).throw(OSError("7 requested and 6 written")))
    assert caught.value.strerror == "7 requested and 6 written"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is full")
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_full_stream_is_an_error_once(tmp_path, unbuffered):
    command = [sys.executable, "-m", "isimp_engine", "info", str(scan(tmp_path / "a.ply")), "--mesh-only"]
    environment = ENVIRONMENT | {"PYTHONUNBUFFERED": unbuffered}
    with open("/dev/full", "w") as full:  # noqa: PTH123
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, env=environment, text=True)
        assert (done.returncode, done.stderr) == (3, "isimp: stdout: No space left on device\n")
        command[-2] = "missing.ply"
        assert subprocess.run(command, stderr=full, env=environment).returncode == 3


@posix
def test_a_child_on_a_full_disk_is_a_row_with_the_reason(tmp_path):
    scan(tmp_path / "in" / "full.ply")
    for pictures in (False, True):
        outcome = batch.run(tmp_path / "in", tmp_path / "out", work=ODD, pictures=pictures, retry_failed=True)
        assert whys(outcome) == {"full.ply": f"no space is left on the disk of {tmp_path}/out/.isimp-batch/parts"}


# Signals


@posix
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_signal_to_simplify_leaves_no_hidden_file(tmp_path, number):
    code = """
import sys, time
from isimp_engine import cli
from isimp_engine.cli import files
def wait(self):
    print("ready", flush=True)
    time.sleep(60)
files.Outputs.commit = wait
sys.exit(cli.main(sys.argv[1:]))
"""
    path = scan(tmp_path / "a.ply")
    command = [sys.executable, "-c", code, "simplify", path, tmp_path / "o.obj", "--proxies", 6, "--quiet"]
    command += ["--labels", tmp_path / "l.npy"]
    with subprocess.Popen(
        [*map(str, command)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=ENVIRONMENT, text=True
    ) as process:
        assert process.stdout.readline() == "ready\n"
        assert len(os.listdir(tmp_path)) == 3
        process.send_signal(number)
        said = process.communicate(timeout=30)[1]
    assert (process.returncode, said) == (143, "isimp: terminated, nothing was written\n")
    assert os.listdir(tmp_path) == ["a.ply"]


@posix
def test_a_signal_between_two_outputs_is_too_late(tmp_path, monkeypatch):
    deliver = drafts.deliver

    def signalled(draft, place):
        signal.raise_signal(signal.SIGTERM)
        deliver(draft, place)

    monkeypatch.setattr("isimp_engine.cli.files.deliver", signalled)
    with terminable(), Outputs() as outputs:
        for name in ("a", "b"):
            outputs.write_text(tmp_path / name, name)
        outputs.commit()
    assert sorted(os.listdir(tmp_path)) == ["a", "b"]
    with pytest.raises(Terminated), terminable():
        signal.raise_signal(signal.SIGTERM)


@posix
@pytest.mark.parametrize(("number", "kind"), [(signal.SIGTERM, Terminated), (signal.SIGINT, KeyboardInterrupt)])
def test_a_signal_in_a_destructor_is_not_lost(number, kind, capfd):
    class Last:
        def __del__(self):
            signal.raise_signal(number)

    def work():
        with terminable():
            Last()
            for _ in range(1000):  # the thread of the second signal does not end a sleep of this one
                time.sleep(0.01)

    with pytest.raises(kind):
        work()
    assert capfd.readouterr().err == ""


# Folders of scans and tiles


@posix
def test_a_link_to_itself_is_a_row_of_the_batch_alone(scans, tmp_path):
    (scans / "self.obj").symlink_to("self.obj")
    outcome = batch.run(scans, tmp_path / "out", work=ODD)
    assert len(outcome.rows) == 4
    assert list(whys(outcome)) == ["self.obj"]


needs_fork = pytest.mark.skipif(not hasattr(os, "fork"), reason="tiles need fork")


@pytest.fixture
def tile(tmp_path):
    return tilesets.write(tmp_path / "in", tilesets.cut(*shapes.cube(1), 1))


@needs_fork
@pytest.mark.parametrize(
    ("kind", "said"), [("pipe", "is no file"), ("device", "is no file"), ("nowhere", "there is no such file")]
)
def test_tiles_that_are_no_files_are_refused(tmp_path, tile, kind, said):
    if kind == "pipe":
        os.mkfifo(tile / "c.obj")
    else:
        (tile / "c.obj").symlink_to("/dev/zero" if kind == "device" else "nowhere")
    with pytest.raises(tiles.TileFailed, match=rf"^{tile}/c\.obj: {said}$"):
        tiles.run(tile, tmp_path / "o.obj", proxies=6)


@needs_fork
def test_a_damaged_tile_is_named_once(tmp_path, tile):
    (tile / "b.obj").write_text("v 0 0 0\nf 1 2 3\n")
    with pytest.raises(tiles.TileFailed) as caught:
        tiles.run(tile, tmp_path / "o.obj", proxies=6)
    assert str(caught.value).startswith(f"{tile}/b.obj: face 0")
    assert str(caught.value).count("b.obj") == 1


@needs_fork
def test_tiles_without_an_area_or_with_huge_numbers_are_named(tmp_path, tile):
    vertices, triangles = shapes.cube(1)
    for size in (0, 1e200):
        meshfiles.obj(tile / "tile_00.obj", vertices * size, triangles.tolist())
        with pytest.raises(tiles.TileFailed, match="no tile has a face"):
            tiles.run(tile, tmp_path / "o.obj", proxies=6)


def test_numbers_that_are_not_finite_are_no_values_of_a_step(tmp_path):
    with pytest.raises(
        engine.InvalidInput, match="numbers are not finite, since coordinates or a length that was given"
    ):
        store.save_values(tmp_path, {"error": float("inf")})


@pytest.mark.parametrize("content", [b"", b"noise" * 30, b"\x93NUMPY", b"PK\x03\x04" + bytes(30)])
def test_damaged_arrays_of_a_work_folder_are_named(tmp_path, content):
    (tmp_path / "a.npy").write_bytes(content)
    for mapped in (False, True):
        with pytest.raises(engine.FileError, match=r"a\.npy: is damaged; the next run begins with") as caught:
            store.load(tmp_path, "a", mapped=mapped)
        assert "pickle" not in str(caught.value)


@needs_fork
@pytest.mark.parametrize(("name", "content"), [("values.json", b""), ("triangles.npy", None)])
def test_a_damaged_work_folder_is_named_once_and_then_made_again(tmp_path, tile, name, content):
    work, command = tmp_path / "work", ["tiles", tile, tmp_path / "o.obj", "--proxies", 6, "--quiet", "--work"]
    assert called(*command, work).returncode == 0
    damaged = work / "thin" / "000000" / name
    damaged.unlink() if content is None else damaged.write_bytes(content)
    for path in work.glob("mesh*"):
        (path / "000000" / "values.json").unlink()
    done = called(*command, work)
    assert done.returncode == 3
    assert len(done.stderr.splitlines()) == 1
    assert f"{name}: is damaged; the next run begins with an empty work folder" in done.stderr
    assert called(*command, work).returncode == 0
    assert json.loads((work / "thin" / "000000" / "values.json").read_text())
