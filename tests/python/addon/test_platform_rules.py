"""The rules of extensions.blender.org for extensions."""

import zipfile

import pytest
from test_addon_zip import build_addon, fake_wheel

from conftest import contents, script

rules = script("platform_rules")


@pytest.fixture(scope="module")
def extension(tmp_path_factory):
    folder = tmp_path_factory.mktemp("extension")
    build_addon.main(["--wheel", str(fake_wheel(folder, "manylinux_2_31_x86_64")), "--out", str(folder)])
    (path,) = folder.glob("*-extension-*.zip")
    return path


def changed(path, name, change):
    """The same zip with one file changed, or added."""
    out = path.with_name("changed.zip")
    files = contents(path)
    with zipfile.ZipFile(out, "w") as made:
        for each, data in (files | {name: change(files.get(name, b"").decode()).encode()}).items():
            made.writestr(each, data)
    return out


def found(path):
    with zipfile.ZipFile(path) as archive:
        return list(rules.faults(archive))


def test_the_extension_keeps_to_the_rules(extension):
    assert found(extension) == []
    assert rules.main([str(extension)]) == 0


MANIFEST = "isimp/blender_manifest.toml"


@pytest.mark.parametrize(
    ("name", "change", "said"),
    [
        (MANIFEST, lambda text: text.replace("SPDX:GPL", "GPL"), "must begin with SPDX:"),
        (MANIFEST, lambda text: text.replace('name = "iSimp"', 'name = "iSimp for Blender"'), "the word Blender"),
        (MANIFEST, lambda text: text.replace("reports, presets", "reports, presets."), "no full stop"),
        (MANIFEST, lambda text: text.replace("clipboard = ", "camera = "), "clipboard is used"),
        (MANIFEST, lambda text: text.replace("files = ", "disk = "), "no permission 'disk'"),
        (MANIFEST, lambda text: text.replace("wheels/isimp", "wheels/other"), "is not in the zip"),
        ("isimp/blender/net.py", lambda _: "import urllib.request\n", "uses the network"),
        ("isimp/blender/run.py", lambda _: "from subprocess import run\n", "starts programs"),
        ("isimp/blender/path.py", lambda _: "import sys\nsys.path.append('x')\n", "sys.path must not be used"),
        ("isimp/big.png", lambda _: "x" * 300_000, "pictures take"),
        ("other/file.txt", lambda _: "", "must hold one folder"),
    ],
)
def test_each_fault_is_named(extension, capsys, name, change, said):
    assert rules.main([str(changed(extension, name, change))]) == 1
    assert said in capsys.readouterr().out
