"""Checks extensions against the rules of extensions.blender.org, as far as a program can: platform_rules.py ZIP...

Blender's own `extension validate` checks the manifest's form (scripts/validate_extension.sh). This checks the rest:
prefixes of licences, permissions with reasons, one folder, wheels that are there and named as on an index, small
pictures, no network, no change of sys.path, no program started. Prints a line for each fault; exits 1 if there is one.
"""

import ast
import re
import sys
import zipfile
from collections.abc import Iterator

import tomllib

NETWORK = {"socket", "ssl", "http", "urllib", "ftplib", "smtplib", "requests", "xmlrpc", "aiohttp", "httpx"}
PROGRAMS = {"subprocess", "pip", "ensurepip"}
PERMISSIONS = {"files", "network", "clipboard", "camera", "microphone"}
WHEEL = r"[A-Za-z0-9_.]+-[0-9][A-Za-z0-9_.+]*-(cp3\d+|py3)(\.cp3\d+)*-(cp3\d+|abi3|none)(\.cp3\d+)*-[a-z0-9_.]+\.whl"
REASON = 64  # letters of a permission's reason at most
PICTURES = 200_000  # bytes of all pictures together


def faults(archive: zipfile.ZipFile) -> Iterator[str]:
    names = [name for name in archive.namelist() if not name.endswith("/")]
    folders = {name.split("/")[0] for name in names}
    if len(folders) != 1 or not all("/" in name for name in names):
        yield f"the zip must hold one folder, it has {', '.join(sorted(folders))}"
        return
    (folder,) = folders
    if f"{folder}/blender_manifest.toml" not in names:
        yield "there is no blender_manifest.toml"
        return
    manifest = tomllib.loads(archive.read(f"{folder}/blender_manifest.toml").decode())
    sources = {name: archive.read(name).decode() for name in names if name.endswith(".py")}
    yield from _of_manifest(manifest, {name.removeprefix(f"{folder}/") for name in names}, "".join(sources.values()))
    for name, text in sources.items():
        yield from _of_source(name, text)
    pictures = sum(archive.getinfo(name).file_size for name in names if name.endswith((".png", ".jpg", ".webp")))
    if pictures > PICTURES:
        yield f"pictures take {pictures:,} bytes, more than {PICTURES:,}"
    if f"{folder}/LICENSE" not in names:
        yield "there is no LICENSE"


def _of_manifest(manifest: dict, names: set, text: str) -> Iterator[str]:
    for licence in manifest.get("license", ["none"]):
        if not licence.startswith("SPDX:"):
            yield f"the licence '{licence}' must begin with SPDX:"
    if "blender" in manifest.get("name", "").lower():
        yield "the name must not have the word Blender"
    if manifest.get("tagline", "").endswith("."):
        yield "the tagline must not end with a full stop"
    permissions = manifest.get("permissions", {})
    for name, reason in permissions.items():
        if name not in PERMISSIONS:
            yield f"there is no permission '{name}'"
        if not reason or len(reason) > REASON or reason.endswith("."):
            yield f"the reason of the permission '{name}' must have at most {REASON} letters, and no full stop"
    if "network" in permissions:
        yield "the permission network is not needed"
    if "clipboard" in text and "clipboard" not in permissions:
        yield "the clipboard is used: it needs a permission"
    declared = {wheel.removeprefix("./") for wheel in manifest.get("wheels", [])}
    yield from (f"the wheel {wheel} is not in the zip" for wheel in sorted(declared - names))
    there = {name for name in names if name.endswith(".whl")}
    yield from (f"the wheel {wheel} is not in the manifest" for wheel in sorted(there - declared))
    for wheel in sorted(there):
        if not re.fullmatch(WHEEL, wheel.rpartition("/")[2]):
            yield f"the wheel {wheel} is not named as on an index"


def _of_source(name: str, text: str) -> Iterator[str]:
    for node in ast.walk(ast.parse(text, name)):
        imported = []
        if isinstance(node, ast.Import):
            imported = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            imported = [node.module or ""]
        for module in imported:
            top = module.split(".")[0]
            if top in NETWORK and module != "urllib.parse":
                yield f"{name}:{node.lineno}: {module} uses the network"
            if top in PROGRAMS:
                yield f"{name}:{node.lineno}: {module} starts programs"
        if isinstance(node, ast.Attribute) and ast.unparse(node) in {"sys.path", "os.system"}:
            yield f"{name}:{node.lineno}: {ast.unparse(node)} must not be used"


def main(paths: list) -> int:
    bad = 0
    for path in paths:
        with zipfile.ZipFile(path) as archive:
            for fault in faults(archive):
                print(f"{path}: {fault}")
                bad += 1
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
