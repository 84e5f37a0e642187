"""3MF files: a zip file with a model in XML, or several that refer to each other."""

import posixpath
import zipfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
from numpy.typing import NDArray

from ._core import FileError
from .file_faces import joined

_DEEP = 64  # components inside components; more are a cycle
_PLACED = 4  # the parts at their places may have this multiple of the bytes that the file may become
_LEAST = 4096  # bytes that an object counts at each of its places
_MODEL = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
_PATH = "{http://schemas.microsoft.com/3dmanufacturing/production/2015/06}path"

#: names of the units of a scene in such files
UNITS = {"m": "meter", "mm": "millimeter", "cm": "centimeter", "um": "micron", "in": "inch", "ft": "foot"}

Part = tuple[NDArray[np.float64], NDArray[np.int32]]


@dataclass
class _Object:
    """A mesh, or objects at places."""

    vertices: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))
    triangles: NDArray[np.int32] = field(default_factory=lambda: np.zeros((0, 3), np.int32))
    components: list[tuple[str, str, NDArray[np.float64]]] = field(default_factory=list)  # file, number, (4, 3)
    is_support: bool = False


class _Package:
    """The models of a file, each read once."""

    def __init__(self, path: Path, file: zipfile.ZipFile, most: int) -> None:
        """most: bytes of all parts at their places."""
        self.path, self.file, self._most, self._made = path, file, most, 0
        self.models: dict[str, tuple[dict[str, _Object], list[tuple[str, str, NDArray[np.float64]]]]] = {}

    def root(self) -> str:
        """The name of the first model."""
        for relation in ET.fromstring(self.file.read("_rels/.rels")):  # noqa: S314  (no entities beyond expat's limit)
            if relation.get("Type") == _MODEL:
                return relation.get("Target", "").lstrip("/")
        raise FileError(f"{self.path}: names no model")

    def unit(self) -> str | None:
        """The unit of the first model; None if there is no such unit."""
        with self.file.open(self.root()) as stream:
            _, element = next(ET.iterparse(stream, events=("start",)))  # noqa: S314
        name = element.get("unit", "millimeter")
        return next((unit for unit, known in UNITS.items() if known == name), None)

    def model(self, name: str) -> tuple[dict[str, _Object], list[tuple[str, str, NDArray[np.float64]]]]:
        """The objects of a model by number, and its items."""
        if name not in self.models:
            objects: dict[str, _Object] = {}
            items: list[tuple[str, str, NDArray[np.float64]]] = []
            with self.file.open(name) as stream:
                for _, element in ET.iterparse(stream):  # noqa: S314
                    word = element.tag.rpartition("}")[2]
                    if word == "object":
                        objects[element.get("id", "")] = self._object(element, name)
                        element.clear()
                    elif word == "item":
                        items.append(self._placed(element, name))
            self.models[name] = objects, items
        return self.models[name]

    def _object(self, element: ET.Element, name: str) -> _Object:
        found = _Object(is_support=element.get("type") == "support")
        vertices, triangles = list[tuple[Any, ...]](), list[tuple[Any, ...]]()
        for one in element.iter():
            word = one.tag.rpartition("}")[2]
            if word == "vertex":
                vertices.append((one.get("x"), one.get("y"), one.get("z")))
            elif word == "triangle":
                triangles.append((one.get("v1"), one.get("v2"), one.get("v3")))
            elif word == "component":
                found.components.append(self._placed(one, name))
        if vertices:
            found.vertices = np.array(vertices, dtype=np.float64)
        if triangles:
            found.triangles = np.array(triangles, dtype=np.int64).astype(np.int32)
            if found.triangles.min() < 0 or found.triangles.max() >= len(vertices):
                number = element.get("id")
                raise FileError(f"{self.path}: a triangle of object {number} uses a vertex that it does not have")
        return found

    @staticmethod
    def _placed(element: ET.Element, name: str) -> tuple[str, str, NDArray[np.float64]]:
        values = element.get("transform")
        matrix = np.eye(4, 3) if values is None else np.array(values.split(), dtype=np.float64).reshape(4, 3)
        other = element.get(_PATH)
        return posixpath.normpath(other.lstrip("/")) if other else name, element.get("objectid", ""), matrix

    def parts(self, name: str, number: str, matrix: NDArray[np.float64], deep: int = 0) -> list[Part]:
        """The meshes of an object, at their places."""
        if deep > _DEEP:
            raise FileError(f"{self.path}: object {number} is a part of itself")
        objects, _ = self.model(name)
        if number not in objects:
            raise FileError(f"{self.path}: there is no object {number!r} in {name}")
        found, made = objects[number], list[Part]()
        self._made += max(_LEAST, found.vertices.nbytes + found.triangles.nbytes)
        if self._made > self._most:
            raise FileError(
                f"{self.path}: its parts become more than {self._most:,} bytes, as no scan of its size does"
            )
        if found.is_support:
            return made
        if len(found.triangles):
            mirrored = np.linalg.det(matrix[:3]) < 0
            triangles = found.triangles[:, ::-1] if mirrored else found.triangles
            made.append((found.vertices @ matrix[:3] + matrix[3], triangles))
        for file, other, place in found.components:
            inner = place[:3] @ matrix[:3], place[3] @ matrix[:3] + matrix[3]
            made += self.parts(file, other, np.vstack(inner), deep + 1)
        return made


def read(path: Path, most: int) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Vertices (V, 3) and triangles (F, 3) of all that a file builds, in its own unit; supports are left out.

    most: bytes that the file may become; its parts may be at several places.
    """
    with zipfile.ZipFile(path) as file:
        if sum(info.file_size for info in file.infolist()) > most:
            raise FileError(f"{path}: becomes more than {most:,} bytes, as no scan of its size does")
        package = _Package(path, file, _PLACED * most)
        name = package.root()
        _, items = package.model(name)
        parts = [part for item in items for part in package.parts(*item)]
    return joined(parts)


def unit_of(path: Path) -> str | None:
    """The unit of a file's coordinates; None if it names none of UNITS."""
    with zipfile.ZipFile(path) as file:
        return _Package(path, file, 0).unit()
