import base64
import hashlib
import importlib.util
import os
import signal
import zipfile
from pathlib import Path

import pytest

import batches
import isimp_engine as engine
import meshfiles
import shapes

ROOT = Path(__file__).resolve().parents[2]

# In the background Ctrl-C is ignored, and under nohup the end of a terminal, in the commands that tests run too.
signal.signal(signal.SIGINT, signal.default_int_handler)
if hasattr(signal, "SIGHUP"):
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


def script(name):
    """A program of scripts/, as a module."""
    spec = importlib.util.spec_from_file_location(f"scripts_{name}", ROOT / "scripts" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def contents(archive):
    """The files of a zip or a wheel by name."""
    with zipfile.ZipFile(archive) as file:
        return {name: file.read(name) for name in file.namelist()}


def assert_record_is_right(wheel):
    files = contents(wheel)
    record = next(name for name in files if name.endswith("/RECORD"))
    rows = dict(line.split(",", 1) for line in files[record].decode().splitlines())
    assert rows.keys() == files.keys()
    for name, row in rows.items():
        if name == record:
            assert row == ","
        else:
            digest = base64.urlsafe_b64encode(hashlib.sha256(files[name]).digest()).rstrip(b"=").decode()
            assert row == f"sha256={digest},{len(files[name])}"


@pytest.fixture
def generate():
    return script("generate")


@pytest.fixture
def cube():
    """The unit cube of 192 faces."""
    return engine.Mesh(*shapes.cube())


@pytest.fixture(scope="session")
def sheet():
    """An open, curved sheet of 7200 faces."""
    return engine.Mesh(*shapes.bumpy())


@pytest.fixture
def scan(tmp_path):
    """A file of 800 faces."""
    path = tmp_path / "scan.ply"
    vertices, triangles = shapes.bumpy(20)
    meshfiles.ply_binary(path, vertices, triangles.tolist())
    return path


@pytest.fixture
def scans(tmp_path):
    """A folder of three scans, one of them in a folder of its own."""
    for name in ("a.ply", "b.ply", "sub/c.ply"):
        batches.scan(tmp_path / "in" / name)
    return tmp_path / "in"


@pytest.fixture
def log(tmp_path, monkeypatch):
    """The names of the scans that odd_work began, in order."""
    path = tmp_path / "log"
    monkeypatch.setenv("ODD_WORK_LOG", str(path))
    return lambda: sorted(line.split()[0] for line in path.read_text().splitlines()) if path.exists() else []


@pytest.fixture(scope="session")
def data():
    """The folder of real meshes, named by ISIMP_DATA or next to the repository; without it the test is skipped."""
    folder = Path(os.environ.get("ISIMP_DATA", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"no real meshes: {folder} is absent (set ISIMP_DATA)")
    return folder
