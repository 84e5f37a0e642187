"""The files that a scan's file names, found without reading the scan: buffers, materials and images."""

import json
from contextlib import suppress
from pathlib import Path
from urllib.parse import unquote

from .._core import FileError
from ..reading import GLTF, is_compressed, kind_of
from . import named, obj, ply
from .gltf_file import MAGIC
from .gltf_values import Item

_HEAD = 1 << 16  # bytes at the beginning of an OBJ or PLY file in which it names others
_JSON = 1 << 28  # most bytes of a JSON that is read


def buffers(path: Path) -> list[Path]:
    """The buffers of a glTF file, missing ones too. A file that can't be read names none."""
    return _of_gltf(path, "buffers", named.folder_of(path)) if _names_files(path, GLTF) else []


def looks(path: Path) -> list[Path]:
    """The images of a glTF, OBJ or PLY file, and its material files; as above."""
    if _names_files(path, GLTF):
        return _of_gltf(path, "images", named.root_of(path))
    with suppress(OSError, FileError):
        if _names_files(path, (".obj", ".ply")):
            with path.open("rb") as file:
                lines = file.read(_HEAD).splitlines()
            return obj.linked(path, lines) if kind_of(path) == ".obj" else ply.linked(path, lines)
    return []


def _names_files(path: Path, kinds: tuple[str, ...]) -> bool:
    """Whether a file can name others: a compressed one is read without others, and a pipe can be read only once."""
    return kind_of(path) in kinds and not is_compressed(path) and path.is_file()


def _of_gltf(path: Path, kind: str, root: Path) -> list[Path]:
    with suppress(OSError, FileError, ValueError, RecursionError):
        with path.open("rb") as file:
            text = file.read(20)
            if text[:4] == MAGIC:
                text = file.read(min(int.from_bytes(text[12:16], "little"), _JSON))
            else:
                text += file.read(_JSON)
        items = Item(json.loads(text), str(path)).items(kind)
        uris = [(item.text("uri"), item.place) for item in items if "uri" in item]
        return [named.file(unquote(uri), path.parent, root, at) for uri, at in uris if not uri.startswith("data:")]
    return []
