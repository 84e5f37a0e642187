"""The packed add-on, installed in Debian's Blender as a user would, and the batch example as a command.

Set ISIMP_ZIPS to a folder of zips to try those; without it the package that is installed here is packed.
"""

import csv
import math
import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[4]


@pytest.fixture(scope="module")
def zips(tmp_path_factory):
    """The packed add-on."""
    if shutil.which("blender") is None:
        pytest.skip("needs blender")
    if given := os.environ.get("ISIMP_ZIPS"):
        return sorted(Path(given).glob("isimp-*.zip"))
    folder = tmp_path_factory.mktemp("zips")
    build = [sys.executable, str(ROOT / "scripts" / "build_addon.py"), "--out", str(folder)]
    made = subprocess.run(build, capture_output=True, text=True)
    if made.returncode:
        pytest.skip(made.stderr.strip())
    return [Path(line) for line in made.stdout.splitlines() if line.endswith(".zip")]


@pytest.fixture(scope="module")
def installed(zips, tmp_path_factory):
    """A folder of user scripts with the add-on in it."""
    folder = tmp_path_factory.mktemp("scripts")
    with zipfile.ZipFile(one_of(zips, "legacy")) as archive:
        archive.extractall(folder / "addons")
    return folder


def one_of(zips, kind):
    found = [path for path in zips if f"-{kind}-" in path.name]
    return found[0] if found else pytest.skip(f"needs the {kind} zip")


def kind_for_blender():
    """The kind of zip that the Blender here takes."""
    said = subprocess.run(["blender", "--version"], capture_output=True, text=True).stdout
    version = tuple(map(int, re.search(r"Blender (\d+)\.(\d+)", said).groups()))
    return "extension" if version >= (4, 2) else "legacy"


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


def test_without_an_engine_the_addon_reports_it(installed, tmp_path):
    shutil.copytree(installed / "addons" / "isimp", tmp_path / "addons" / "isimp")
    shutil.rmtree(tmp_path / "addons" / "isimp" / "isimp_engine")
    script = "import bpy; bpy.ops.isimp.partition(proxies=6)"
    done = blender("--addons", "isimp", "--python-expr", script, scripts=tmp_path)
    assert "The iSimp engine does not load: install the zip for this system" in done.stdout + done.stderr


def test_without_numpy_the_addon_names_the_remedy(installed):
    hide = "import sys; sys.modules['numpy'] = None"
    script = (
        "import bpy; print('panel', bpy.types.ISIMP_PT_without_numpy.bl_category);"
        "from isimp.blender import without_numpy as w; drawn = [];"
        "row = type('Row', (), {'label': lambda self, text, icon: drawn.append(text)})();"
        "w._draw_problem(bpy.context, row); print('preferences', ' '.join(drawn));"
        "assert w.IsimpPreferencesWithoutNumpy.is_registered;"
        "import addon_utils; addon_utils.disable('isimp'); print('off', hasattr(bpy.types, 'ISIMP_PT_without_numpy'))"
    )
    done = blender("--python-expr", hide, "--addons", "isimp", "--python-expr", script, scripts=installed)
    said = done.stdout + done.stderr
    assert "Traceback" not in said, said
    assert "numpy is missing in Blender's Python: install python3-numpy and start Blender again" in said
    assert "panel iSimp\n" in said
    assert "preferences numpy is missing in Blender's" in said
    assert "off False\n" in said


def test_numpy_that_is_installed_later_is_found_without_a_new_start(installed):
    hide = "import sys; sys.modules['numpy'] = None"
    script = (
        "import sys, addon_utils; addon_utils.disable('isimp'); del sys.modules['numpy']; addon_utils.enable('isimp');"
        "import bpy; bpy.ops.isimp.partition(proxies=6);"
        "from isimp import session; print('problem', session.ENGINE_PROBLEM, '.')"
    )
    done = blender("--python-expr", hide, "--addons", "isimp", "--python-expr", script, scripts=installed)
    assert "problem  ." in done.stdout, done.stdout + done.stderr


def test_the_right_zip_over_the_wrong_one_works_at_once(installed, tmp_path):
    """An older Blender unpacks the extension as it is: without an engine outside of its wheel."""
    place = tmp_path / "addons" / "isimp"
    shutil.copytree(installed / "addons" / "isimp", place, ignore=shutil.ignore_patterns("isimp_engine"))
    (place / "wheels").mkdir()
    script = f"""
import addon_utils, bpy, shutil
from isimp.blender.scene import targets
print("before", targets.install_problem())
addon_utils.disable("isimp")
shutil.rmtree({str(place)!r})
shutil.copytree({str(installed / "addons" / "isimp")!r}, {str(place)!r}, copy_function=shutil.copyfile)
addon_utils.enable("isimp")
from isimp.blender.scene import targets
print("after", targets.install_problem(), ".")
bpy.ops.mesh.primitive_cube_add()
bpy.ops.isimp.partition(proxies=6)
addon_utils.disable("isimp")
shutil.rmtree({str(place)!r})
shutil.copytree({str(installed / "addons" / "isimp")!r}, {str(place)!r}, copy_function=shutil.copyfile)
addon_utils.enable("isimp")
print("again", targets.install_problem())
"""
    done = blender("--addons", "isimp", "--python-exit-code", "1", "--python-expr", script, scripts=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "before The iSimp engine does not load: install the zip for this system (this zip is for Blender 4.2" in (
        done.stdout
    )
    assert "after  .\n" in done.stdout
    assert "again Another version of iSimp was installed: start Blender again\n" in done.stdout


def test_switched_on_in_saved_preferences_it_is_there_in_the_background(installed, tmp_path):
    """Blender registers it at its start, when there are no key maps yet; later it has all of them."""
    environment = os.environ | {"BLENDER_USER_SCRIPTS": str(installed), "BLENDER_USER_CONFIG": str(tmp_path)}
    environment.pop("PYTHONPATH", None)
    keep = "import bpy; bpy.ops.preferences.addon_enable(module='isimp'); bpy.ops.wm.save_userpref()"
    look = "import bpy; from isimp import blender; print('all', all(cls.is_registered for cls in blender._CLASSES))"
    menu = "print('menu', any('isimp' in f.__module__ for f in bpy.types.VIEW3D_MT_object.draw._draw_funcs))"
    off = "import addon_utils; addon_utils.disable('isimp')"
    for script in (keep, f"{look}; {menu}; {off}"):
        command = ["blender", "-b", "--python-exit-code", "1", "--python-expr", script]
        done = subprocess.run(command, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
        assert "Traceback" not in done.stdout + done.stderr, done.stdout + done.stderr
    assert "all True\n" in done.stdout
    assert "menu True\n" in done.stdout


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


def test_the_loop_of_the_manual_does_all_scans_and_lists_those_that_fail(installed, tmp_path):
    (loop,) = re.findall(r"^for scan in .*?^done$", (ROOT / "docs" / "manual.md").read_text(), re.MULTILINE | re.DOTALL)
    scans = {"a.off": OFF, "b.off": "OFF\n4", "c.off": OFF.replace("0 0 1\n3", "0 0 2\n3", 1)}
    (tmp_path / "scans").mkdir()
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    for name, text in scans.items():
        (tmp_path / "scans" / name).write_text(text)
    (tmp_path / "recipe.json").write_text('{"isimp_recipe": 1, "steps": [{"step": "partition", "proxies": 4}]}')
    environment = os.environ | {"BLENDER_USER_SCRIPTS": str(installed)}
    subprocess.run(["sh", "-c", loop.replace(".ply", ".off")], cwd=tmp_path, env=environment, check=True)
    with (tmp_path / "results.csv").open(newline="") as file:
        polygons = {Path(row["scan"]).name: row["polygons"] for row in csv.DictReader(file)}
    assert polygons == {"a.off": "4", "b.off": "", "c.off": "4"}
    assert (tmp_path / "failed.txt").read_text().split() == ["scans/b.off"]
    assert sorted(path.name for path in (tmp_path / "out").glob("*.obj")) == ["a.obj", "c.obj"]


def test_a_student_gets_from_the_zip_to_polygons_in_eight_actions(zips, tmp_path):
    if shutil.which("xvfb-run") is None:
        pytest.skip("needs xvfb-run (Debian: xvfb)")
    scan = tmp_path / "scan.obj"
    scan.write_text(ball())
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    environment |= {"ISIMP_SITE": "", "ISIMP_ZIP": str(one_of(zips, kind_for_blender())), "ISIMP_SCAN": str(scan)}
    environment |= {"BLENDER_USER_SCRIPTS": str(tmp_path / "scripts"), "BLENDER_USER_CONFIG": str(tmp_path / "config")}
    environment["BLENDER_USER_RESOURCES"] = str(tmp_path / "user")
    here = Path(__file__).parent
    out = Path(os.environ.get("ISIMP_WINDOW_OUT", ROOT / "out" / "window"))
    out.mkdir(parents=True, exist_ok=True)
    blender = ["blender", "--factory-startup", "--enable-event-simulate", "-p", "0", "0", "900", "900"]
    script = ["--python", str(here / "drive.py"), "--", str(here / "student.py"), str(out)]
    command = ["xvfb-run", "-a", "-s", "-screen 0 900x900x24", *blender, *script]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    actions = 7 if kind_for_blender() == "extension" else 8  # an extension needs no tick
    assert f"{actions}. Press **Mesh**." in done.stdout
    assert "Traceback" not in done.stdout + done.stderr


def ball(rings=40):
    """A sphere with flat caps, as text of an OBJ file."""
    lines = []
    for ring in range(rings + 1):
        for step in range(2 * rings):
            polar, turn = math.pi * (0.15 + 0.7 * ring / rings), math.pi * step / rings
            place = math.sin(polar) * math.cos(turn), math.sin(polar) * math.sin(turn), math.cos(polar)
            lines.append("v {:.6f} {:.6f} {:.6f}".format(*(max(-0.8, min(0.8, value)) for value in place)))
    for ring in range(rings):
        for step in range(2 * rings):
            a, b = 2 * rings * ring + step + 1, 2 * rings * ring + (step + 1) % (2 * rings) + 1
            lines += [f"f {a} {a + 2 * rings} {b}", f"f {b} {a + 2 * rings} {b + 2 * rings}"]
    return "\n".join(lines) + "\n"
