"""The packed add-on, installed in Debian's Blender as a user would, and the batch example as a command."""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[4]


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """A folder of user scripts with the add-on in it."""
    if shutil.which("blender") is None:
        pytest.skip("needs blender")
    folder = tmp_path_factory.mktemp("scripts")
    build = [sys.executable, str(ROOT / "scripts" / "build_addon.py"), "--out", str(folder)]
    made = subprocess.run(build, capture_output=True, text=True)
    if made.returncode:
        pytest.skip(made.stderr.strip())
    with zipfile.ZipFile(next(name for name in made.stdout.splitlines() if "-legacy-" in name)) as archive:
        archive.extractall(folder / "addons")
    return folder


def blender(*arguments, scripts, cwd=ROOT):
    environment = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "ISIMP_SITE")}
    command = ["blender", "-b", "--factory-startup", *arguments]
    return subprocess.run(
        command, env=environment | {"BLENDER_USER_SCRIPTS": str(scripts)}, capture_output=True, text=True, cwd=cwd
    )


def test_the_installed_addon_works_with_the_engine_it_brings(installed):
    script = (
        "import bpy, sys; bpy.ops.mesh.primitive_cube_add(); bpy.ops.isimp.partition(proxies=6); bpy.ops.isimp.mesh();"
        "import isimp.session; print('engine at', isimp.session.engine.__file__);"
        "print('polygons', len(bpy.context.object.data.polygons))"
    )
    done = blender("--addons", "isimp", "--python-exit-code", "1", "--python-expr", script, scripts=installed)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "polygons 6" in done.stdout
    assert f"engine at {installed / 'addons' / 'isimp' / 'isimp_engine'}" in done.stdout


def test_without_an_engine_the_addon_says_so(installed, tmp_path):
    shutil.copytree(installed / "addons" / "isimp", tmp_path / "addons" / "isimp")
    shutil.rmtree(tmp_path / "addons" / "isimp" / "isimp_engine")
    script = "import bpy; bpy.ops.isimp.partition(proxies=6)"
    done = blender("--addons", "isimp", "--python-expr", script, scripts=tmp_path)
    assert "The iSimp engine does not load: install the zip for this system" in done.stdout + done.stderr


OFF = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n"


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        (["scan.off", "out.obj", "--proxies", "4"], 0, "scan: 4 faces -> 4 polygons"),
        (["scan.off", "out.xyz"], 2, "can't write 'out.xyz'"),
        (["none.off", "out.obj"], 3, "there is no file"),
    ],
)
def test_batch_as_a_command(installed, tmp_path, arguments, code, said):
    (tmp_path / "scan.off").write_text(OFF)
    batch = ("--python", str(ROOT / "examples" / "batch.py"), "--", *arguments)
    done = blender(*batch, scripts=installed, cwd=tmp_path)
    assert (done.returncode, said in done.stdout + done.stderr) == (code, True), done.stdout + done.stderr
    assert (tmp_path / "out.obj").exists() == (code == 0)
    assert "Traceback" not in done.stdout + done.stderr
