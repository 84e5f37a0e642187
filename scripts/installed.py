"""Tries iSimp as installed, with a result that is the same on every system; part of scripts/try_install.sh.

python installed.py package              the package alone, in any Python
python installed.py next ZIP FOLDER      makes the zip of a next version of a zip, to upgrade to
python installed.py STEP ZIP             in Blender or bpy, each in a new process: install, upgrade, remove, look
"""

import contextlib
import hashlib
import importlib
import os
import re
import sys
import tempfile
import zipfile
from pathlib import Path

EARLIEST = (1980, 1, 1, 0, 0, 0)
MARK = "isimp_engine/next.txt"  # only the next version has this file
SIDE = 24


def scan():
    """A bumpy open box: vertices and triangles, of whole numbers alone, so that every system has the same."""
    import numpy as np

    i, j = np.meshgrid(np.arange(SIDE), np.arange(SIDE), indexing="ij")
    height = np.where((i > SIDE // 3) & (j > SIDE // 4), 256, 0) + (i * i * 7 + j * 13) % 5
    vertices = np.stack([i * 64, j * 64, height], -1).reshape(-1, 3) / 64.0
    corner = (i[:-1, :-1] * SIDE + j[:-1, :-1]).ravel()
    one = np.stack([corner, corner + SIDE, corner + SIDE + 1], -1)
    two = np.stack([corner, corner + SIDE + 1, corner + 1], -1)
    return vertices, np.concatenate([one, two]).astype(np.int32)


def answer(engine) -> str:
    """A fingerprint of the whole job, by four methods."""
    found = hashlib.sha256()
    mesh = engine.clean(*scan())
    for method in ("lloyd", "hierarchy", "naive", "hybrid"):
        part = engine.partition(mesh, engine.PartitionOptions(proxies=12, seed=1, method=method))
        polygons = engine.polygonize(mesh, part)
        for array in (part.face_region, polygons.loops, polygons.loop_start, polygons.vertices):
            found.update(array.tobytes())
    return found.hexdigest()[:12]


def package() -> None:
    import isimp_engine as engine

    print(f"isimp {engine.__version__}, Python {sys.version.split()[0]}: answer {answer(engine)}")


def next_version(archive: Path, folder: Path) -> Path:
    """The same zip, with its wheel, as the version after it. The version is in the name of the zip."""
    version = re.match(r"isimp-(\d+\.\d+)(\.\d+)", archive.name)
    if version is None:
        raise SystemExit(f"{archive.name}: its name has no version")
    after = f"{version[1]}.999"

    def renamed(text: str) -> str:
        return re.sub(rf"(?<![\d.]){re.escape(version[1] + version[2])}((\.|-)dev\.?\d+)?(?!\d)", after, text)

    def stated(name: str, data: bytes) -> bytes:
        """A file that states the version."""
        text = re.sub(r'(?<="version": \()\d+, \d+, \d+(?=\))', after.replace(".", ", "), renamed(data.decode()))
        if after not in text.replace(", ", "."):
            raise SystemExit(f"{archive.name}: {name} doesn't state the version of the zip")
        return text.encode()

    def rewritten(source: Path, target: Path) -> Path:
        with zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as new:
            inner = ""
            for name in old.namelist():
                data = old.read(name)
                if name.endswith(".whl"):
                    with tempfile.TemporaryDirectory() as scratch:
                        wheel = Path(scratch, Path(name).name)
                        wheel.write_bytes(data)
                        data = rewritten(wheel, Path(scratch, "next.whl")).read_bytes()
                elif name.endswith("RECORD"):  # without sums, which change
                    files = [line.split(",")[0] for line in renamed(data.decode()).splitlines()]
                    data = "".join(f"{file},,\n" for file in [*files, MARK]).encode()
                elif name.endswith(("METADATA", "blender_manifest.toml", "isimp/__init__.py")) or name == "__init__.py":
                    data = stated(name, data)
                if "isimp_engine/__init__.py" in name:
                    inner = name.removesuffix("isimp_engine/__init__.py")
                    new.writestr(zipfile.ZipInfo(inner + MARK, EARLIEST), b"next")
                new.writestr(zipfile.ZipInfo(renamed(name), EARLIEST), data)
        return target

    folder.mkdir(parents=True, exist_ok=True)
    return rewritten(archive, folder / renamed(archive.name))


def engine_there() -> Path | None:
    """The place of the engine's package on the path or in the add-on."""
    importlib.invalidate_caches()
    for name in ("isimp_engine", "isimp.isimp_engine"):
        try:
            spec = importlib.util.find_spec(name)
        except ImportError:
            continue
        if spec and spec.origin:
            return Path(spec.origin).parent
    return None


def work() -> str:
    """The main job by its operators; the answer is the number of faces made."""
    import bpy

    vertices, triangles = scan()
    mesh = bpy.data.meshes.new("scan")
    mesh.from_pydata(vertices.tolist(), [], triangles.tolist())
    thing = bpy.data.objects.new("scan", mesh)
    bpy.context.scene.collection.objects.link(thing)
    bpy.context.view_layer.objects.active = thing
    thing.select_set(True)
    for operator, options in (("partition", {"proxies": 12}), ("mesh", {})):
        done = getattr(bpy.ops.isimp, operator)(**options)
        if done != {"FINISHED"}:
            raise SystemExit(f"isimp.{operator}: {done}")
    return f"{len(bpy.context.object.data.polygons)} polygons"


class Extension:
    """Install from Disk of Blender 4.2 and later."""

    def __init__(self):
        import bpy

        with contextlib.suppress(RuntimeError):  # bpy leaves it off
            bpy.ops.preferences.addon_enable(module="bl_pkg")
        self._ops = bpy.ops.extensions

    def install(self, archive: str) -> None:
        self._ops.package_install_files(filepath=archive, repo="user_default", enable_on_install=True)

    def remove(self) -> None:
        import bpy

        repos = [repo.module for repo in bpy.context.preferences.extensions.repos]
        bpy.ops.preferences.addon_disable(module="bl_ext.user_default.isimp")
        self._ops.package_uninstall(repo_index=repos.index("user_default"), pkg_id="isimp")


class Legacy:
    """Add-ons > Install of Blender 3.4 to 4.1."""

    def install(self, archive: str) -> None:
        import bpy

        bpy.ops.preferences.addon_install(filepath=archive, overwrite=True)
        bpy.ops.preferences.addon_enable(module="isimp")

    def remove(self) -> None:
        import bpy

        bpy.ops.preferences.addon_enable(module="isimp")  # enabled, as it is when a user removes it
        with contextlib.suppress(RuntimeError):  # at its end it redraws a window, and there is none
            bpy.ops.preferences.addon_remove(module="isimp")


def left_in(folder: Path) -> list[str]:
    found = (path for path in folder.rglob("*") if path.is_file() and "__pycache__" not in path.parts)
    return sorted(path.relative_to(folder).as_posix() for path in found if "isimp" in path.as_posix())


def in_blender(step: str, archive: str) -> None:
    """One step; each has a process of its own, as a user starts Blender again after an upgrade."""
    import bpy

    way = Extension() if bpy.app.version >= (4, 2) else Legacy()
    if step == "remove":
        way.remove()
        print("SAID removed")
        return
    if step == "look":
        left = left_in(Path(os.environ["ISIMP_TRIED"]))  # Blender's folder of the user, bare before
        wheels = [path for path in left if "extensions/.local/" in path]
        if left and left == wheels and bpy.app.version == (4, 2, 0):
            # Its uninstall leaves wheels alone, and its start checks them only where an extension is enabled.
            print("SAID the engine's files are left, as of any extension until 4.2.0 installs another one")
        elif left:
            raise SystemExit(f"left behind: {', '.join(left[:5])}")
        else:
            print("SAID nothing left")
        return
    way.install(archive)
    is_next = (engine_there() / "next.txt").exists()
    if is_next != (step == "upgrade"):
        raise SystemExit(f"{step}: the engine is {'not ' * (not is_next)}the next one")
    made = work()
    if step == "install":
        print(f"SAID Blender {bpy.app.version_string}, Python {sys.version.split()[0]}: {made}")
    else:
        print("SAID upgraded")


if __name__ == "__main__":
    arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    if arguments[0] == "package":
        package()
    elif arguments[0] == "next":
        print(next_version(Path(arguments[1]), Path(arguments[2])))
    else:
        in_blender(*arguments)
