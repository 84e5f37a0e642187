"""Makes a repository of extensions that Blender 4.2 and later can subscribe to.

    scripts/extension_repository.py OUT ZIPS

ZIPS has a folder for each channel, such as stable and latest, with zips of the extension, one for each platform. OUT
gets the same folders with the zips and an index.json. Blender's own program makes the index, `blender_ext.py
server-generate`, if $ISIMP_BLENDER_EXT or a Python package bpy in .venv-bpy-* has it; else this script does, with the
same content.
"""

import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import tomllib

ROOT = Path(__file__).resolve().parent.parent
# The manifest's fields that an index repeats, in Blender's order.
FIELDS = ("schema_version", "id", "name", "tagline", "version", "type", "maintainer", "license")
OPTIONAL = "blender_version_min", "blender_version_max", "website", "copyright", "permissions", "tags", "platforms"


def blenders_program() -> Path | None:
    if given := os.environ.get("ISIMP_BLENDER_EXT"):
        return Path(given)
    return max(ROOT.glob(".venv-bpy-*/**/bl_pkg/cli/blender_ext.py"), default=None)


def row_of(archive: Path) -> dict[str, object]:
    """The entry of a zip: its manifest, size, checksum and address relative to the index."""
    with zipfile.ZipFile(archive) as file:
        (name,) = (name for name in file.namelist() if re.fullmatch(r"(\w+/)?blender_manifest\.toml", name))
        manifest = tomllib.loads(file.read(name).decode("utf-8"))
    row = {name: manifest[name] for name in FIELDS} | {name: manifest[name] for name in OPTIONAL if name in manifest}
    tags = {tag for wheel in manifest.get("wheels", []) for tag in wheel.split("-")[-3].split(".")}
    if tags:  # py3 is Python "3", cp311 is "3.11"
        row["python_versions"] = sorted(re.sub(r"(?:py|cp)(\d)(\d*)", r"\1.\2", tag).rstrip(".") for tag in tags)
    data = archive.read_bytes()
    digest = f"sha256:{hashlib.sha256(data).hexdigest()}"
    return row | {"archive_size": len(data), "archive_hash": digest, "archive_url": f"./{archive.name}"}


def index_of(folder: Path) -> dict[str, object]:
    """The content of index.json, for version 1 of Blender's API."""
    return {"version": "v1", "blocklist": [], "data": [row_of(archive) for archive in sorted(folder.glob("*.zip"))]}


def make(folder: Path) -> None:
    program = blenders_program()
    if program:
        subprocess.run([sys.executable, program, "server-generate", "--repo-dir", folder], check=True)
    else:
        (folder / "index.json").write_text(json.dumps(index_of(folder), indent=2) + "\n", encoding="utf-8")


def main(out: Path, zips: Path) -> None:
    channels = sorted(path for path in zips.iterdir() if path.is_dir()) if zips.is_dir() else []
    for channel in channels:
        target = out / channel.name
        shutil.rmtree(target, ignore_errors=True)
        shutil.copytree(channel, target)
        make(target)
        print(target / "index.json")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*map(Path, sys.argv[1:]))
