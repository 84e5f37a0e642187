"""The add-on packed for Blender."""

import ast
import importlib.util
import os
import re
import shutil
import sys
import zipfile
from pathlib import Path

import pytest
import tomllib

from conftest import assert_record_is_right, contents, script

ROOT = Path(__file__).parents[3]
build_addon = script("build_addon")


def bl_info(source):
    """Read like Blender: without running anything."""
    tree = ast.parse(source)
    found = [node.value for node in tree.body if isinstance(node, ast.Assign) and node.targets[0].id == "bl_info"]
    return ast.literal_eval(found[0])


def test_blender_can_read_bl_info_without_running_anything():
    assert bl_info((ROOT / "addon" / "isimp" / "__init__.py").read_text())["blender"] == (3, 4, 0)


def test_both_zips_state_the_version_of_the_project(tmp_path):
    project = re.search(r"project\(isimp VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text()).group(1)
    build_addon.main(["--wheel", str(fake_wheel(tmp_path)), "--out", str(tmp_path)])
    made = {kind: contents(tmp_path / f"isimp-{project}-{kind}-linux-x64.zip") for kind in ("legacy", "extension")}
    for files in made.values():
        assert ".".join(map(str, bl_info(files["isimp/__init__.py"])["version"])) == project
    assert extension_manifest(made["extension"])["version"] == project
    sources = {path: path.read_text() for path in (ROOT / "addon" / "isimp").iterdir() if path.is_file()}
    assert [path for path, text in sources.items() if project in text] == []  # it is written once


@pytest.mark.parametrize("name", ["__init__.py", "blender_manifest.toml"])
def test_a_file_without_a_place_for_the_version_is_refused(name):
    with pytest.raises(SystemExit, match=f"addon/isimp/{name} must contain .*version"):
        build_addon.with_version(name, b"")


def test_the_zip_has_the_package_s_recipes_in_place_of_the_door_to_them():
    files = build_addon.addon_files()
    own = {path.name: path.read_bytes() for path in (ROOT / "python/isimp_engine/recipe").glob("*.py")}
    assert {name: files.get(f"recipe/{name}") for name in own} == own
    assert "recipe.py" not in files


def fake_wheel(folder, platform="linux_x86_64"):
    wheel = folder / f"isimp-0.1.0-cp311-cp311-{platform}.whl"
    with zipfile.ZipFile(wheel, "w") as archive:
        archive.writestr("isimp_engine/__init__.py", "from ._core import answer\n")
        archive.writestr("isimp_engine/_core.py", "answer = 42\n")
        archive.writestr("isimp-0.1.0.dist-info/RECORD", "")
    return wheel


def test_two_builds_of_the_zips_are_the_same_bytes(tmp_path, monkeypatch):
    wheel, built = fake_wheel(tmp_path), []
    for folder in ("one", "two"):
        copy = tmp_path / folder / "addon"
        shutil.copytree(ROOT / "addon" / "isimp", copy, copy_function=shutil.copyfile)  # with the dates of now
        os.utime(copy / "__init__.py", (len(built), len(built)))
        monkeypatch.setattr(build_addon, "ADDON", copy)
        build_addon.main(["--wheel", str(wheel), "--out", str(tmp_path / folder / "dist")])
        built.append({path.name: path.read_bytes() for path in (tmp_path / folder / "dist").iterdir()})
    assert len(built[0]) == 2
    assert built[0] == built[1]


def test_the_zip_for_older_blenders_holds_the_engine(tmp_path, monkeypatch):
    build_addon.main(["--wheel", str(fake_wheel(tmp_path)), "--out", str(tmp_path / "dist")])
    with zipfile.ZipFile(tmp_path / "dist" / f"isimp-{build_addon.version()}-legacy-linux-x64.zip") as archive:
        archive.extractall(tmp_path / "addons")
        names = set(archive.namelist())
    assert all(name.startswith("isimp/") for name in names)
    some = {"isimp/__init__.py", "isimp/blender/panel/main.py", "isimp/isimp_engine/_core.py", "isimp/LICENSE"}
    assert some | {f"isimp/{build_addon.LEGACY_ONLY}"} <= names
    assert not any("pycache" in name for name in names)
    inside = importlib.util.spec_from_file_location(
        "unpacked", tmp_path / "addons" / "isimp" / "isimp_engine" / "__init__.py"
    )
    module = importlib.util.module_from_spec(inside)
    monkeypatch.setitem(sys.modules, "unpacked", module)
    inside.loader.exec_module(module)
    assert module.answer == 42


def extension_manifest(files):
    return tomllib.loads(files["isimp/blender_manifest.toml"].decode())


def test_each_platform_has_an_extension_with_its_wheel(tmp_path):
    platforms = {"manylinux_2_28_x86_64": "linux-x64", "macosx_13_0_arm64": "macos-arm64", "win_amd64": "windows-x64"}
    wheels = [fake_wheel(tmp_path, platform) for platform in platforms]
    build_addon.main(["--wheel", *map(str, wheels), "--out", str(tmp_path), "--website", "https://example.org"])
    for wheel, platform in zip(wheels, platforms.values(), strict=True):
        files = contents(tmp_path / f"isimp-{build_addon.version()}-extension-{platform}.zip")
        manifest = extension_manifest(files)
        assert manifest["wheels"] == [f"./wheels/{wheel.name}"]
        assert {entry for entry in files if "wheels/" in entry} == {f"isimp/wheels/{wheel.name}"}
        assert f"isimp/{build_addon.LEGACY_ONLY}" not in files
        assert manifest["platforms"] == [platform]
        assert manifest["license"] == ["SPDX:GPL-3.0-or-later"]
        assert manifest["website"] == "https://example.org"
        assert manifest["copyright"]
        assert set(manifest["permissions"]) == {"files", "clipboard"}


def test_two_wheels_of_a_platform_are_refused_since_blender_takes_one_blindly(tmp_path):
    wheel = fake_wheel(tmp_path)
    other = wheel.with_name(wheel.name.replace("cp311", "cp313"))
    other.write_bytes(wheel.read_bytes())
    with pytest.raises(SystemExit, match="one wheel for each platform is wanted, got linux-x64, linux-x64"):
        build_addon.main(["--wheel", str(wheel), str(other), "--out", str(tmp_path)])


def test_a_trial_has_a_version_of_its_own_in_the_words_of_each(tmp_path, monkeypatch):
    stated = (ROOT / "CMakeLists.txt").read_text()
    assert stated.count('set(ISIMP_TRIAL "")') == 1  # scripts/package.sh --trial N changes this line
    shutil.copytree(ROOT / "addon", tmp_path / "addon", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "LICENSE", tmp_path)
    (tmp_path / "CMakeLists.txt").write_text(stated.replace('set(ISIMP_TRIAL "")', 'set(ISIMP_TRIAL ".dev7")'))
    project = build_addon.version()
    monkeypatch.setattr(build_addon, "ROOT", tmp_path)
    monkeypatch.setattr(build_addon, "ADDON", tmp_path / "addon" / "isimp")
    build_addon.main(["--wheel", str(fake_wheel(tmp_path)), "--out", str(tmp_path)])
    extension, legacy = (f"isimp-{project}.dev7-{kind}-linux-x64.zip" for kind in ("extension", "legacy"))
    assert extension_manifest(contents(tmp_path / extension))["version"] == f"{project}-dev.7"
    stated = bl_info(contents(tmp_path / legacy)["isimp/__init__.py"])["version"]
    assert stated == tuple(map(int, project.split(".")))


def test_the_installed_package_is_packed_into_a_wheel_that_is_complete(tmp_path):
    import isimp_engine

    try:
        wheel = build_addon.installed_wheel(tmp_path)
    except SystemExit as reason:
        pytest.skip(str(reason))
    assert_record_is_right(wheel)
    assert any(re.fullmatch(r"isimp_engine/_core\..*(so|pyd)", name) for name in contents(wheel))
    assert wheel.name.startswith(f"isimp-{isimp_engine.__version__}-cp3")


def test_an_unknown_platform_is_refused(tmp_path):
    wheel = fake_wheel(tmp_path, "plan9_mips")
    with pytest.raises(SystemExit, match="no name for the platform plan9_mips"):
        build_addon.main(["--wheel", str(wheel), "--out", str(tmp_path)])
