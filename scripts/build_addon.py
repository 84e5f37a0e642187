"""Packs the add-on for Blender, with the engine in it.

For each platform there are two zips: an extension for Blender 4.2 and later, and a legacy zip for Blender 3.4 to 4.1.

    scripts/build_addon.py [--wheel WHEEL ...] [--out dist]

The version is that of CMakeLists.txt. The engine comes from wheels, one for each platform, that hold the module for all
Pythons (scripts/package.sh), or, without --wheel, from the package installed for the Python that runs this. A zip gets
the modules for the Pythons of its Blenders.
Blender 4.2.0 takes the wheel of the highest name for any Python, so a zip never has two.
"""

import argparse
import importlib.metadata
import re
import sys
import tempfile
import zipfile
from pathlib import Path

sys.path.append(str(Path(__file__).parent))  # wherever this file is loaded from
import wheels

ROOT = Path(__file__).resolve().parent.parent
ADDON = ROOT / "addon" / "isimp"
RECIPE = ROOT / "python" / "isimp_engine" / "recipe"
PLATFORMS = {  # platforms of wheels, and their names in Blender
    r"(many)?linux.*_x86_64": "linux-x64",
    r"(many)?linux.*_aarch64": "linux-arm64",
    r"macosx_.*_arm64": "macos-arm64",
    r"macosx_.*_x86_64": "macos-x64",
    r"win_amd64": "windows-x64",
    r"win_arm64": "windows-arm64",
}
PYTHONS = {  # Pythons of the Blenders of each zip
    "extension": ["311", "313", "314"],  # 4.2 to 5.0; 5.1 and 5.2, Debian's 4.3; Debian's 5.2
    "legacy": ["310", "311"],  # 3.4 to 4.0; 4.1, Debian's 3.4
}
LEGACY_ONLY = "blender/operators/install.py"  # an extension may not start programs
EARLIEST = (1980, 1, 1, 0, 0, 0)  # the date of every file, so that the same input gives the same zip


def add(archive: zipfile.ZipFile, name: str, data: bytes) -> None:
    entry = zipfile.ZipInfo(name, EARLIEST)
    entry.external_attr = 0o644 << 16
    archive.writestr(entry, data, zipfile.ZIP_DEFLATED)


def version() -> str:
    """The version of the project, as wheels have it. CMakeLists.txt is the one place that states it."""
    stated = r'project\(isimp VERSION ([0-9]+\.[0-9]+\.[0-9]+)[^"]*"((?:\.dev[0-9]+)?)"'
    return "".join(re.search(stated, (ROOT / "CMakeLists.txt").read_text()).groups())


def blenders_version() -> str:
    """The same in the form of Blender, which requires semantic versions: 0.1.0-dev.3 for 0.1.0.dev3."""
    return re.sub(r"\.dev([0-9]+)$", r"-dev.\1", version())


def with_version(name: str, data: bytes) -> bytes:
    """The file with the project's version, if it is one of the two that state a version to Blender."""
    if name == "__init__.py":
        old, new = b'"version": (0, 0, 0),', f'"version": ({", ".join(version().split(".")[:3])}),'.encode()
    elif name == "blender_manifest.toml":
        old, new = b'version = "0.0.0"', f'version = "{blenders_version()}"'.encode()
    else:
        return data
    if data.count(old) != 1:
        raise SystemExit(f"addon/isimp/{name} must contain {old.decode()!r} once: the version is written there")
    return data.replace(old, new)


def addon_files() -> dict[str, bytes]:
    """The add-on's own files, by their path in it."""
    files = (path for path in ADDON.rglob("*") if path.is_file() and "__pycache__" not in path.parts)
    names = {path.relative_to(ADDON).as_posix(): path for path in sorted(files)}
    names = {name: path for name, path in names.items() if name != "recipe.py"}  # it loads the next ones
    names |= {f"recipe/{path.name}": path for path in sorted(RECIPE.glob("*.py"))}
    licences = [ROOT / "LICENSE", *sorted((ROOT / "licences").glob("*.txt"))]
    return {name: with_version(name, path.read_bytes()) for name, path in names.items()} | {
        path.relative_to(ROOT).as_posix(): path.read_bytes() for path in licences
    }


def platform_of(wheel: Path) -> str:
    tag = wheel.stem.split("-")[-1]
    for pattern, platform in PLATFORMS.items():
        if any(re.fullmatch(pattern, part) for part in tag.split(".")):
            return platform
    raise SystemExit(f"{wheel.name}: Blender has no name for the platform {tag}")


def installed_wheel(folder: Path) -> Path:
    """Packs the installed package into a wheel again."""
    try:
        package = importlib.metadata.distribution("isimp")
    except importlib.metadata.PackageNotFoundError:
        raise SystemExit(
            f"isimp is not installed for {sys.executable}: run its pip install . or give --wheel"
        ) from None
    kept = [file for file in package.files if file.parts[0] != ".." and "__pycache__" not in file.parts]
    if not any(file.parts[0] == "isimp_engine" and file.suffix in (".so", ".pyd") for file in kept):
        raise SystemExit("isimp is installed for development only: build a wheel and give --wheel")
    tag = re.search(r"^Tag: (.+)$", package.read_text("WHEEL"), re.MULTILINE).group(1)
    left_out = {"RECORD", "INSTALLER", "REQUESTED", "direct_url.json"}
    files = {file.as_posix(): (file.locate().read_bytes(), 0o644) for file in kept if file.name not in left_out}
    python, abi, platform = tag.split("-")
    return wheels.write(folder, f"isimp-{package.version}", f"{python}-{abi}", platform, files)


def wheel_for(kind: str, wheel: Path, folder: Path) -> Path | None:
    """The wheel for a kind of zip: the modules that its Blenders need; None if the wheel has none of them.

    A wheel of a single Python is taken whole.
    """
    if wheel.name.split("-")[2] != "py3":
        return wheel
    there = wheels.pythons(wheels.read(wheel))
    if not set(there) & set(PYTHONS[kind]):
        print(f"no {kind} zip: {wheel.name} has modules for Python {', '.join(there)} alone", file=sys.stderr)
        return None
    return wheels.slim(wheel, PYTHONS[kind], folder / kind)


def engine_of(name: str) -> bool:
    """Whether a file of a wheel is the engine's: the package, and the libraries that auditwheel adds."""
    return name.startswith(("isimp_engine/", "isimp.libs/", "isimp_engine.libs/"))


def pack_legacy(target: Path, wheel: Path) -> None:
    """Everything under isimp/, the engine as a package inside, its libraries next to it, where it searches for them."""
    with zipfile.ZipFile(target, "w") as archive, zipfile.ZipFile(wheel) as source:
        for name, data in addon_files().items():
            if name != "blender_manifest.toml":
                add(archive, f"isimp/{name}", data)
        for name in sorted(filter(engine_of, source.namelist())):
            add(archive, f"isimp/{name}", source.read(name))
        for name in sorted(name for name in source.namelist() if "/sboms/" in name):
            add(archive, f"isimp/sboms/{Path(name).name}", source.read(name))


def pack_extension(target: Path, wheel: Path, website: str | None) -> None:
    """Everything under isimp/, which Blender strips, and the wheel named in the manifest.

    A Blender before 4.2 unpacks the zip as it is: without that folder the files would lie among other add-ons.
    """
    site = f'website = "{website}"\n' if website else ""
    with zipfile.ZipFile(target, "w") as archive:
        for name, data in addon_files().items():
            if name == LEGACY_ONLY:
                continue
            if name == "blender_manifest.toml":
                named = f'{site}platforms = ["{platform_of(wheel)}"]\nwheels = ["./wheels/{wheel.name}"]\n'.encode()
                head, tables, rest = data.partition(b"\n[")  # a table ends the part that these belong to
                add(archive, f"isimp/{name}", head + b"\n" + named + tables + rest)
            else:
                add(archive, f"isimp/{name}", data)
        add(archive, f"isimp/wheels/{wheel.name}", wheel.read_bytes())


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--wheel", type=Path, nargs="+", help="wheels of the package, one for each platform")
    parser.add_argument("--out", type=Path, default=ROOT / "dist", help="where the zips go (default dist)")
    parser.add_argument("--website", help="address of the project, for the extension's manifest")
    options = parser.parse_args(argv)
    options.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        given = options.wheel or [installed_wheel(Path(folder))]
        platforms = [platform_of(wheel) for wheel in given]
        if len(set(platforms)) != len(platforms):
            raise SystemExit(
                f"one wheel for each platform is wanted, got {', '.join(sorted(platforms))}; see wheels.py"
            )
        for wheel, platform in zip(given, platforms, strict=True):
            for kind in PYTHONS:
                own = wheel_for(kind, wheel, Path(folder))
                target = options.out / f"isimp-{version()}-{kind}-{platform}.zip"
                if own and kind == "extension":
                    pack_extension(target, own, options.website)
                elif own:
                    pack_legacy(target, own)
                if own:
                    print(target)


if __name__ == "__main__":
    main()
