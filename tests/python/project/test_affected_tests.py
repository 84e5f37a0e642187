"""scripts/affected_tests.py names the tests of changed files by place."""

import re
import subprocess
from fnmatch import fnmatch
from pathlib import Path

import pytest

from conftest import script

ROOT = Path(__file__).parents[3]


@pytest.fixture
def affected():
    return script("affected_tests")


@pytest.mark.parametrize(
    ("changed", "tests"),
    [
        ("native/src/partition/density/noise.cpp", ["engine/test_partition.py"]),
        ("native/src/regular/align_planes.cpp", ["engine/test_align_planes.py"]),
        ("native/include/isimp/meshing/options.h", ["engine", "project"]),
        ("python/isimp_engine/batch/run.py", ["batch"]),
        ("python/isimp_engine/exporting/dxf.py", ["command"]),
        ("python/isimp_engine/recipes.py", ["command"]),
        ("python/isimp_engine/replay/faces.py", ["addon", "command", "engine"]),
        ("python/isimp_engine/reports/page.py", ["command"]),
        ("python/isimp_engine/texturing/baking.py", ["command", "engine"]),
        ("addon/isimp/pick.py", ["addon"]),
        ("addon/isimp/blender/work/scene_outcome.py", []),
        ("bench/generators/scanned.py", ["addon/test_addon_presets.py", "engine/test_planar.py"]),
        ("tests/shared/polygon_judge.py", ["engine/test_promises.py"]),
        ("tests/python/engine/test_mesh.py", ["engine/test_mesh.py"]),
        ("tests/python/engine/test_removed.py", []),
        ("tests/cpp/mesh/test_mesh.cpp", []),
        ("docs/manual.md", ["project"]),
    ],
)
def test_a_changed_file_names_tests_that_are_there(affected, changed, tests):
    found = affected.python_tests(ROOT / changed)
    assert sorted(str(path.relative_to(ROOT / "tests" / "python")) for path in found) == tests
    assert all(path.exists() for path in found)


def test_labels_are_the_modules_of_sources_and_of_c_tests(affected):
    sources = ["native/src/partition/density/noise.cpp", "tests/cpp/mesh/test_io.cpp", "native/bindings/bind_mesh.cpp"]
    assert affected.labels([ROOT / source for source in sources]) == "^(mesh|partition)(-|$)"
    assert affected.labels([]) == ""
    assert affected.labels([ROOT / "tests/cpp/shared/shapes.cpp", ROOT / "tests/cpp/mesh/test_io.cpp"]) == "."


def test_every_module_has_a_folder_of_tests():
    modules = {path.name for path in (ROOT / "native" / "src").iterdir()}
    assert modules <= {path.name for path in (ROOT / "tests" / "cpp").iterdir() if any(path.glob("test_*.cpp"))}


@pytest.mark.skipif(not (ROOT / ".git").exists(), reason="needs a checkout")
def test_untracked_files_count_as_changed(affected, monkeypatch, tmp_path):
    monkeypatch.setattr(affected, "ROOT", tmp_path)
    subprocess.run(["git", "init", "-q", tmp_path], check=True)
    (tmp_path / "new.py").touch()
    assert affected.changed_since(affected.EMPTY) == {tmp_path / "new.py"}


@pytest.mark.parametrize("kind", ["data", "fuzz", "slow"])
def test_every_pattern_of_a_kind_names_c_tests_that_are_there(kind):
    folder = ROOT / "tests" / "cpp"
    sources = "".join(path.read_text() for path in folder.rglob("test_*.cpp"))
    names = {f"{suite}.{name}" for suite, name in re.findall(r"^TEST(?:_F|_P)?\((\w+), (\w+)\)", sources, re.MULTILINE)}
    (patterns,) = re.findall(
        rf"^set\({kind} (.*?)\)$", (folder / "CMakeLists.txt").read_text(), re.MULTILINE | re.DOTALL
    )
    for pattern in re.findall(r'"([^"]+)"', patterns):
        plain = pattern.removeprefix("*/").removesuffix("/*")
        assert any(fnmatch(name, plain) for name in names), pattern
