"""The files that people download: wheels for all Pythons and for one, checksums, headers."""

import hashlib
import importlib.util
import json
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path, PurePosixPath

import pytest
import tomllib

import isimp_engine as engine
from conftest import assert_record_is_right, contents, script
from isimp_engine import _carried

ROOT = Path(__file__).parents[3]


wheels, headers = script("wheels"), script("headers")
LINUX = "manylinux_2_17_x86_64.manylinux2014_x86_64"


def module_name(python, platform=LINUX):
    return {
        LINUX: f"isimp_engine/_core.cpython-{python}-x86_64-linux-gnu.so",
        "win_amd64": f"isimp_engine/_core.cp{python}-win_amd64.pyd",
    }[platform]


def made_wheel(folder, python, platform=LINUX, version="0.1.0", readme="the same"):
    wheel = folder / f"isimp-{version}-cp{python}-cp{python}-{platform}.whl"
    info = f"isimp-{version}.dist-info"
    with zipfile.ZipFile(wheel, "w") as archive:
        archive.writestr("isimp_engine/__init__.py", readme)
        module = zipfile.ZipInfo(module_name(python, platform))
        module.external_attr = 0o100755 << 16
        archive.writestr(module, f"module {python}")
        archive.writestr("isimp.libs/libgomp.so.1", "library")
        tags = "".join(f"Tag: cp{python}-cp{python}-{part}\n" for part in platform.split("."))
        archive.writestr(f"{info}/WHEEL", f"Wheel-Version: 1.0\nRoot-Is-Purelib: false\n{tags}")
        archive.writestr(f"{info}/METADATA", f"Name: isimp\nVersion: {version}\n")
        archive.writestr(f"{info}/RECORD", "wrong")
    return wheel


@pytest.mark.parametrize("platform", [LINUX, "win_amd64"])
def test_a_fat_wheel_has_the_module_of_every_python(tmp_path, platform):
    parts = [made_wheel(tmp_path, python, platform) for python in (311, 313, 310)]
    fat = wheels.fatten(parts, tmp_path / "fat")
    assert fat.name == f"isimp-0.1.0-py3-none-{platform}.whl"
    files = contents(fat)
    assert {name for name in files if "_core" in name} == {module_name(p, platform) for p in (310, 311, 313)}
    about = files["isimp-0.1.0.dist-info/WHEEL"].decode().splitlines()
    assert [line for line in about if line.startswith("Tag:")] == [
        f"Tag: py3-none-{part}" for part in platform.split(".")
    ]
    assert "Root-Is-Purelib: false" in about
    assert_record_is_right(fat)


def test_a_fat_wheel_splits_into_the_wheels_it_was_made_of(tmp_path):
    parts = [made_wheel(tmp_path, python) for python in (310, 311)]
    made = wheels.split(wheels.fatten(parts, tmp_path / "fat"), tmp_path / "thin")
    assert [path.name for path in made] == [path.name for path in parts]
    for before, after in zip(parts, made, strict=True):
        old, new = contents(before), contents(after)
        assert old.keys() == new.keys()
        same = {name for name in old if old[name] == new[name]}
        assert old.keys() - same <= {"isimp-0.1.0.dist-info/RECORD"}
        assert_record_is_right(after)
    with zipfile.ZipFile(made[0]) as archive:  # a module stays executable, as auditwheel leaves it
        assert archive.getinfo(module_name(310)).external_attr >> 16 & 0o777 == 0o755


def test_bills_of_materials_stay_and_that_of_auditwheel_names_one_wheel(tmp_path):
    parts = []
    for python in (310, 311):
        wheel = made_wheel(tmp_path, python)
        with zipfile.ZipFile(wheel, "a") as archive:
            archive.writestr("isimp-0.1.0.dist-info/sboms/auditwheel.cdx.json", wheel.name)
            archive.writestr("isimp-0.1.0.dist-info/sboms/isimp.cdx.json", "the same")
        parts.append(wheel)
    one, two = (wheels.fatten(order, tmp_path / name) for name, order in (("a", parts), ("b", parts[::-1])))
    assert one.read_bytes() == two.read_bytes()
    assert contents(one)["isimp-0.1.0.dist-info/sboms/auditwheel.cdx.json"] == parts[0].name.encode()
    build = script("build_addon")
    build.main(["--wheel", str(one), "--out", str(tmp_path)])
    (legacy,) = tmp_path.glob("*-legacy-*.zip")
    assert {"isimp/sboms/auditwheel.cdx.json", "isimp/sboms/isimp.cdx.json"} < contents(legacy).keys()
    for archive in tmp_path.glob("*.zip"):
        texts = {name for name in contents(archive) if name.startswith(("isimp/LICENSE", "isimp/licences/"))}
        assert len(texts) == 1 + len(list((ROOT / "licences").iterdir()))


def test_wheels_that_do_not_belong_together_are_refused(tmp_path):
    first = made_wheel(tmp_path, 310)
    for other in (made_wheel(tmp_path, 311, "win_amd64"), made_wheel(tmp_path, 311, version="0.1.1")):
        with pytest.raises(SystemExit, match="one version and one platform are wanted"):
            wheels.fatten([first, other], tmp_path / "fat")
    with pytest.raises(SystemExit, match=r"isimp_engine/__init__\.py differs from that of another wheel"):
        wheels.fatten([first, made_wheel(tmp_path, 311, readme="another")], tmp_path / "fat")


def test_a_wheel_without_a_module_is_refused(tmp_path):
    wheel = made_wheel(tmp_path, 310)
    files = {name: (data, 0o644) for name, data in contents(wheel).items() if "_core" not in name}
    bare = wheels.write(tmp_path / "bare", "isimp-0.1.0", "py3-none", LINUX, files)
    for act in (lambda: wheels.split(bare, tmp_path), lambda: wheels.fatten([bare], tmp_path)):
        with pytest.raises(SystemExit, match="no module isimp_engine/_core"):
            act()


def test_a_zip_has_the_pythons_of_its_blenders_alone(tmp_path, capsys):
    build = script("build_addon")
    parts = [made_wheel(tmp_path, python) for python in (310, 311, 312, 313, 314)]
    build.main(["--wheel", str(wheels.fatten(parts, tmp_path / "fat")), "--out", str(tmp_path)])
    zips = {kind: next(tmp_path.glob(f"isimp-*-{kind}-*.zip")) for kind in build.PYTHONS}
    (inner,) = [name for name in contents(zips["extension"]) if name.endswith(".whl")]
    (tmp_path / Path(inner).name).write_bytes(contents(zips["extension"])[inner])
    assert_record_is_right(tmp_path / Path(inner).name)
    assert wheels.pythons(contents(tmp_path / Path(inner).name)) == ["311", "313", "314"]
    names = [name.removeprefix("isimp/") for name in contents(zips["legacy"])]
    assert wheels.pythons(names) == ["310", "311"]
    assert "isimp.libs/libgomp.so.1" in names
    assert capsys.readouterr().err == ""


def test_no_zip_is_made_for_blenders_whose_pythons_are_not_there(tmp_path, capsys):
    build = script("build_addon")
    fat = wheels.fatten([made_wheel(tmp_path, 313)], tmp_path / "fat")
    build.main(["--wheel", str(fat), "--out", str(tmp_path)])
    assert list(tmp_path.glob("*-extension-*.zip"))
    assert not list(tmp_path.glob("*-legacy-*.zip"))
    assert "no legacy zip" in capsys.readouterr().err


def test_sha256sum_accepts_the_checksums(tmp_path):
    (tmp_path / "a.whl").write_bytes(b"wheel")
    (tmp_path / "gone.zip.sha256").write_text("old")
    assert [path.name for path in wheels.checksums(tmp_path)] == ["a.whl.sha256"]
    assert (tmp_path / "a.whl.sha256").read_text() == f"{hashlib.sha256(b'wheel').hexdigest()}  a.whl\n"
    assert not (tmp_path / "gone.zip.sha256").exists()
    wheels.main(["checksums", str(tmp_path)])  # again: no checksum of a checksum
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.whl", "a.whl.sha256"]


def test_the_error_of_a_python_without_a_module_lists_the_others():
    names = ["_core.cpython-310-x86_64-linux-gnu.so", "_core.cpython-311-x86_64-linux-gnu.so", "_core.pyi"]
    said = _carried.problem(names, [".cpython-399-x86_64-linux-gnu.so", ".abi3.so", ".so"])
    running = "{}.{}".format(*sys.version_info)
    assert "has its engine for Python 3.10, 3.11 on x86_64-linux-gnu" in said
    assert f"this is Python {running} on {sys.platform}" in said
    assert _carried.problem(names, [".cpython-311-x86_64-linux-gnu.so"]) == ""
    assert _carried.problem(["_core.pyi", "_core.py"], [".so"]) == ""


def test_a_file_with_another_checksum_is_not_used(tmp_path):
    (tmp_path / "boost.whl").write_bytes(b"not Boost")
    with pytest.raises(headers.Missing, match=r"boost\.whl: its SHA-256 is .*, not 00, so it is not used"):
        headers.checked(tmp_path, "boost", "00")
    right = hashlib.sha256(b"not Boost").hexdigest()
    assert headers.checked(tmp_path, "boost", right) == tmp_path / "boost.whl"


@pytest.mark.parametrize(
    ("name", "path", "needed"),
    [
        ("boost-headers", "version.hpp", True),
        ("boost-headers", "mpl/if.hpp", True),
        ("boost-headers", "asio/buffer.hpp", False),
        ("openmesh", "Core/Mesh/ArrayKernel.cc", True),
        ("openmesh", "Core/Mesh/CMakeLists.txt", False),
        ("libcgal-dev", "version.h", True),
    ],
)
def test_the_files_taken_from_each_package(name, path, needed):
    assert headers.wanted(name, PurePosixPath(path)) == needed


def test_headers_and_licences_are_gathered(tmp_path):
    top = tmp_path / "tree" / headers.FOLDERS["cmeel-eigen"]
    (top / "src").mkdir(parents=True)
    (top / "src" / "Core.h").write_text("core")
    (tmp_path / "tree" / "LICENSE").write_text("licence")
    (tmp_path / "tree" / "other.txt").write_text("other")
    headers.gather("cmeel-eigen", tmp_path / "tree", tmp_path / "made")
    made = {path.relative_to(tmp_path / "made").as_posix() for path in (tmp_path / "made").rglob("*") if path.is_file()}
    assert made == {"include/Eigen/src/Core.h", "licences/cmeel-eigen-LICENSE"}


def test_a_build_that_may_not_fetch_lists_missing_headers(tmp_path):
    """Only the part of CMake that searches for headers, in a project of its own that compiles nothing."""
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.24)\nproject(lacking LANGUAGES NONE)\n"
        f"include({(ROOT / 'cmake' / 'dependencies.cmake').as_posix()})\n"
    )
    arguments = ["-DISIMP_FETCH=OFF", "-DISIMP_HEADERS=none", "-DCMAKE_FIND_ROOT_PATH=/none", "-DISIMP_BUNDLED=ON"]
    try:
        done = subprocess.run(
            ["cmake", "-S", tmp_path, "-B", tmp_path / "build", *arguments], capture_output=True, text=True
        )
    except FileNotFoundError:
        pytest.skip("needs cmake")
    assert done.returncode
    said = " ".join(done.stderr.split())
    assert "were not found. Install CGAL, Boost and Eigen" in said
    assert "ISIMP_FETCH=ON" in said


@pytest.fixture
def fetched(monkeypatch):
    monkeypatch.setitem(sys.modules, "headers", headers)  # the program's, not the tests' module of that name
    return script("python_headers")


def test_headers_of_another_python_include_the_suffix_of_its_modules(tmp_path, monkeypatch, capsys, fetched):
    tree = tmp_path / "tree" / "usr" / "include"
    (tree / "python3.14").mkdir(parents=True)
    (tree / "x86_64-linux-gnu" / "python3.14").mkdir(parents=True)
    (tree / "python3.14" / "Python.h").touch()

    class Apt:
        def __init__(self, state, suite):
            assert suite == "sid"

        def download_any(self, name, folder):
            assert name == "libpython3.14-dev"
            return [folder / "file.deb"]

    monkeypatch.setattr(fetched, "Apt", Apt)
    monkeypatch.setattr(fetched, "unpack", lambda file, scratch: tmp_path / "tree")
    for _ in range(2):  # the second time nothing is fetched
        assert fetched.main(["3.14", str(tmp_path / "headers")]) == 0
        suffix, _, folders = capsys.readouterr().out.strip().partition("=")
        assert wheels.pythons([f"isimp_engine/_core{suffix}"]) == ["314"]
        assert all((Path(folder) / "x86_64-linux-gnu").exists() for folder in folders.split(",")[1:])
        assert (Path(folders.split(",")[0]) / "Python.h").exists()
        tree.mkdir(exist_ok=True)


def test_headers_of_a_python_that_debian_lacks_are_reported_missing(tmp_path, monkeypatch, capsys, fetched):
    monkeypatch.setattr(fetched, "Apt", lambda *_: (_ for _ in ()).throw(fetched.Missing("no mirror of Debian")))
    assert fetched.main(["3.14", str(tmp_path / "headers")]) == 1
    assert "no mirror of Debian" in capsys.readouterr().err


def test_every_package_states_its_checksum_and_licence():
    rows = [*headers.OF_PYPI, *headers.OF_DEBIAN]
    assert {name for name, _, _ in rows} == headers.FOLDERS.keys()
    assert all(len(sha256) == 64 for _, _, sha256 in rows)
    named = [line.split(" | ")[0].strip("| ") for line in headers.LICENCES.splitlines() if line.startswith("| ")][1:]
    assert named == ["CGAL", "Boost", "Eigen", "fast_float", "OpenMesh"]


def test_the_bill_of_materials_lists_the_fetched_headers():
    template = (ROOT / "cmake" / "sbom.cdx.json.in").read_text(encoding="utf-8")
    bill = json.loads(template.replace("@PROJECT_VERSION@@ISIMP_TRIAL@", "0.1.0"))
    assert bill["metadata"]["component"]["version"] == "0.1.0"
    components = bill["components"]
    assert [bill["dependencies"][0]["dependsOn"]] == [[each["bom-ref"] for each in components]]
    hashed = {each["purl"].rpartition("/")[2]: each["hashes"][0]["content"] for each in components if "hashes" in each}
    assert hashed == {f"{name}@{version}": sha256 for name, version, sha256 in [*headers.OF_PYPI, *headers.OF_DEBIAN]}
    stated = dict(line.strip("| ").split(" | ")[:2] for line in headers.LICENCES.splitlines() if line.startswith("| "))
    for each in components[: len(hashed)]:
        assert stated[each["name"]].startswith(each["version"])


def test_every_licence_of_the_bill_of_materials_has_its_text():
    bill = (ROOT / "cmake" / "sbom.cdx.json.in").read_text(encoding="utf-8")
    texts = [path.stem for path in (ROOT / "licences").glob("*.txt")]
    stated = {name for found in re.findall(r'"expression": "([^"]+)"', bill) for name in found.split(" AND ")}
    for name in stated - {"GPL-3.0-or-later"}:  # that is LICENSE
        assert any(text.startswith(name.replace(" ", "-")) for text in texts), name
    assert len(texts) == len(stated - {"GPL-3.0-or-later"}) + 2  # two of BSD-3-Clause, and that of GCC's libraries


def test_two_wheels_of_one_tree_are_equal(tmp_path, monkeypatch):
    """All of a wheel but the compiled module, by the build's own settings."""
    pytest.importorskip("scikit_build_core")
    build = "import sys; from scikit_build_core.build import build_wheel as b; b(sys.argv[1], {'wheel.cmake': 'false'})"
    made = []
    for name, epoch in (("a", "1700000000"), ("b", "1700000000"), ("c", "1800000000")):
        monkeypatch.setenv("SOURCE_DATE_EPOCH", epoch)
        (tmp_path / name).mkdir()
        subprocess.run([sys.executable, "-c", build, tmp_path / name], cwd=ROOT, check=True, capture_output=True)
        (wheel,) = (tmp_path / name).glob("*.whl")
        made.append(wheel)
    assert made[0].read_bytes() == made[1].read_bytes()
    with zipfile.ZipFile(made[0]) as first, zipfile.ZipFile(made[2]) as later:
        assert {entry.date_time[0] for entry in first.infolist()} == {2023}
        assert {entry.date_time[0] for entry in later.infolist()} == {2027}
        licences = {Path(name).name for name in first.namelist() if "/licenses/" in name}
    assert licences == {"LICENSE", *(path.name for path in (ROOT / "licences").iterdir())}


@pytest.mark.parametrize("website", [None, "https://a.example/isimp/"])
def test_the_page_of_an_index_has_no_relative_link(tmp_path, website):
    page = script("index_page")
    for name in ("README.md", "pyproject.toml", "CMakeLists.txt"):
        shutil.copy(ROOT / name, tmp_path / name)
    page.main(tmp_path, website)
    text = (tmp_path / "README.md").read_text(encoding="utf-8")
    links = re.findall(r"\]\(([^)]+)\)", text)
    assert links
    assert all(link.startswith("https://") for link in links)
    urls = tomllib.loads((tmp_path / "pyproject.toml").read_text(encoding="utf-8"))["project"].get("urls", {})
    if website:
        assert f"({website}blob/v{engine.__version__}/docs/install.md)" in text
        assert "![A scan of the Stanford bunny" in text
        assert urls["Issues"] == f"{website}issues"
    else:
        assert "![" not in text
        assert "Installing has more." in " ".join(text.split())
        assert urls == {}


def test_nothing_compiled_has_the_date_or_the_place_of_its_build():
    sources = [*(ROOT / "native").rglob("*.[ch]*"), *(ROOT / "cuda").rglob("*.[ch]*")]
    assert len(sources) > 100
    assert not [path for path in sources if re.search(r"__DATE__|__TIME__|__TIMESTAMP__", path.read_text("utf-8"))]


def test_the_sdist_has_the_headers_that_git_ignores():
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["scikit-build"]
    assert "third_party" in settings["sdist"]["include"]
    assert "/third_party/" in (ROOT / ".gitignore").read_text(encoding="utf-8").splitlines()


def test_release_notes_are_the_section_of_the_version():
    notes = script("release_notes")
    sections = {"Unreleased": "new", "0.2.0.1": "not it", "0.2.0 - 2026-01-01": "two", "0.1.0": "one"}
    changelog = "# Changelog\n\n" + "\n".join(f"## {name}\n\n- {line}\n" for name, line in sections.items())
    assert notes.section(changelog, "0.2.0") == "- two"
    assert notes.section(changelog, "0.1.0") == "- one"
    with pytest.raises(SystemExit, match=r"no section 0\.3\.0: rename Unreleased"):
        notes.section(changelog, "0.3.0")


def test_links_between_pages_lead_somewhere():
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")]
    wrong = []
    for page in pages:
        text = page.read_text(encoding="utf-8")
        for link in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"```.*?```", "", text, flags=re.DOTALL)):
            name, _, anchor = link.partition("#")
            if ":" in name:
                continue
            target = (page.parent / name) if name else page
            found = target.exists() and (not anchor or anchor in anchors(target))
            wrong += [] if found else [f"{page.name}: {link}"]
    assert wrong == []


def anchors(page):
    """The anchors of the headings, as the sites of Git and MkDocs make them."""
    heads = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).strip().replace(" ", "-") for head in heads}


def test_every_page_is_in_the_site():
    site = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    listed = set(re.findall(r": (\w+\.md)$", site, re.MULTILINE))
    assert listed == {page.name for page in (ROOT / "docs").glob("*.md")}


def test_the_site_builds_without_a_warning(tmp_path):
    if importlib.util.find_spec("mkdocs") is None or importlib.util.find_spec("material") is None:
        pytest.skip("needs mkdocs-material")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "-f", ROOT / "mkdocs.yml", "-d", tmp_path]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_workflows_run_scripts_that_are_there():
    for workflow in (ROOT / ".github" / "workflows").glob("*.yml"):
        for name in re.findall(r"scripts/\w+\.(?:sh|py)", workflow.read_text(encoding="utf-8")):
            assert (ROOT / name).exists(), f"{workflow.name}: {name}"


def test_a_repository_of_extensions_lists_the_zips_of_each_platform(tmp_path, monkeypatch):
    repository, build = script("extension_repository"), script("build_addon")
    for platform in (LINUX, "win_amd64"):
        fat = wheels.fatten([made_wheel(tmp_path, 311, platform)], tmp_path / "fat")
        build.main(["--wheel", str(fat), "--out", str(tmp_path / "zips" / "stable"), "--website", "https://a.example"])
    for legacy in (tmp_path / "zips" / "stable").glob("*-legacy-*.zip"):
        legacy.unlink()
    monkeypatch.delenv("ISIMP_BLENDER_EXT", raising=False)
    program = repository.blenders_program()
    monkeypatch.setattr(repository, "blenders_program", lambda: None)
    repository.main(tmp_path / "site", tmp_path / "zips")
    index = json.loads((tmp_path / "site" / "stable" / "index.json").read_text(encoding="utf-8"))
    assert [row["platforms"] for row in index["data"]] == [["linux-x64"], ["windows-x64"]]
    for row in index["data"]:
        data = (tmp_path / "site" / "stable" / row["archive_url"]).read_bytes()
        assert row["archive_hash"] == f"sha256:{hashlib.sha256(data).hexdigest()}"
        assert (row["id"], row["archive_size"], row["python_versions"]) == ("isimp", len(data), ["3"])
        assert row["website"] == "https://a.example"
    if program:  # Blender's own index is the same, in another order
        monkeypatch.setattr(repository, "blenders_program", lambda: program)
        repository.make(tmp_path / "site" / "stable")
        theirs = json.loads((tmp_path / "site" / "stable" / "index.json").read_text(encoding="utf-8"))
        theirs["data"].sort(key=lambda row: row["archive_url"])
        assert theirs == index


@pytest.mark.parametrize("version", ["0.1.0", "0.2.0", "1.10.3.dev4"])
def test_the_next_version_of_a_zip_has_its_own_version_everywhere(tmp_path, monkeypatch, version):
    installed, build = script("installed"), script("build_addon")
    monkeypatch.setattr(build, "version", lambda: version)
    wheel = wheels.fatten([made_wheel(tmp_path, 311, version=version)], tmp_path / "fat")
    build.main(["--wheel", str(wheel), "--out", str(tmp_path)])
    zips = {kind: next(tmp_path.glob(f"isimp-*-{kind}-*.zip")) for kind in ("extension", "legacy")}
    later = "1.10.999" if version.startswith("1.") else version[:4] + "999"
    for kind, archive in zips.items():
        after = installed.next_version(archive, tmp_path / "next")
        assert after.name == archive.name.replace(version, later) != archive.name
        names = contents(after)
        if kind == "extension":
            assert f'version = "{later}"'.encode() in names["isimp/blender_manifest.toml"]
            (inner,) = [name for name in names if name.endswith(".whl")]
            assert inner in f"isimp/wheels/{wheel.name}".replace(version, later)
            (tmp_path / "inner.whl").write_bytes(names[inner])
            files = contents(tmp_path / "inner.whl")
            assert installed.MARK in files
            assert files[f"isimp-{later}.dist-info/METADATA"] == f"Name: isimp\nVersion: {later}\n".encode()
        else:
            assert f"isimp/{installed.MARK}" in names
            assert f'"version": ({later.replace(".", ", ")})'.encode() in names["isimp/__init__.py"]


def test_a_zip_of_another_version_than_its_name_is_not_upgraded(tmp_path, monkeypatch):
    installed, build = script("installed"), script("build_addon")
    monkeypatch.setattr(build, "version", lambda: "0.2.0")
    wheel = wheels.fatten([made_wheel(tmp_path, 311, version="0.1.0")], tmp_path / "fat")
    build.main(["--wheel", str(wheel), "--out", str(tmp_path)])
    with pytest.raises(SystemExit, match="METADATA doesn't state the version of the zip"):
        installed.next_version(next(tmp_path.glob("isimp-*-extension-*.zip")), tmp_path / "next")


def test_a_module_with_its_own_library_shows_one_name():
    """Debian's Blender crashed when it shared weak names of the C++ library with the one that was linked in."""
    bindings = (ROOT / "native" / "bindings" / "CMakeLists.txt").read_text(encoding="utf-8")
    assert "-Wl,--version-script=${PROJECT_SOURCE_DIR}/cmake/module.map" in bindings
    assert "{ global: PyInit__core; local: *; };" in (ROOT / "cmake" / "module.map").read_text(encoding="utf-8")
