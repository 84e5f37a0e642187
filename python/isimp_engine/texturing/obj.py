"""Texture coordinates, materials and colours of OBJ files."""

import math
import os
import shlex
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import FileError, Job, _read_columns, triangulate
from . import images, named, udim
from .layers import NORMAL, TextureLayer, channel, scaled_colors, to_srgb
from .look import COLOR, Fault, Look, Material
from .soup import TexturedSoup, corner_places

# The number of words that follow each option of a texture map.
_MAP_OPTIONS = {"-blendu": 1, "-blendv": 1, "-boost": 1, "-cc": 1, "-clamp": 1, "-texres": 1, "-bm": 1, "-imfchan": 1}
_MAP_OPTIONS |= {"-type": 1, "-mm": 2, "-colorspace": 1}
_UP_TO_THREE = ("-o", "-s", "-t")
# Numbers and maps in addition to the colour. A map counts alone, without its number, except for emission above 1.
_NUMBERS = {"Pr": "roughness", "Pm": "metallic", "Ke": "emission"}
_MAPS = {f"map_{word}": name for word, name in _NUMBERS.items()} | {"norm": NORMAL}
_OTHER_MAPS = ("map_", "bump", "disp", "decal", "refl")  # begin the words of maps that are not read
_LARGEST = 1e30  # largest of such numbers


def read(path: Path, job: Job | None, threads: int) -> TexturedSoup:
    look, materials, libraries = _read(path, job, threads, named.refuse)
    triangles, polygon = triangulate(look.vertices, look.loops, look.loop_start, job=job)
    places = corner_places(look.loops, look.loop_start, triangles, polygon)
    pictures, shown = images.Pictures(), list[Any]()
    for m in materials.values():
        if m.map is not None:
            shown.append(pictures.load(m.map, m.place))
        else:
            shown.append(None if look.colors is not None else m.plain())
    names, layers = list(materials), _layers(materials, pictures)
    files = [*libraries, *(file for m in materials.values() for file in m.files())]
    uv = np.zeros((len(triangles), 3, 2)) if look.uv is None else look.uv[places]
    material = look.material[polygon]
    return TexturedSoup(look.vertices, triangles, uv, material, shown, look.colors, names, files, layers)


def read_look(path: Path, stands: Path, job: Job | None, fault: Fault) -> Look:
    """As `reading.read_look`. stands: the path of the scan, if `path` is an unpacked copy of it."""
    found, materials, _ = _read(path, job, 0, fault, stands)
    for name, m in materials.items():
        maps = {COLOR: (m.map, m.place)} if m.map is not None else {}
        found.materials.append(Material(name, m.diffuse, dict(m.numbers), maps | m.maps))
        found.skipped.extend(word for word in m.skipped if word not in found.skipped)
    return found


def linked(path: Path, lines: list[bytes]) -> list[Path]:
    """The material files that some lines of a scan name, and the files of their images, as far as they exist."""
    fault: Fault = lambda text: None  # noqa: E731
    words = [line.split(None, 1) for line in lines]
    names = [_text(rest[0]) for word, *rest in filter(None, words) if word == b"mtllib" and rest]
    libraries = _library_files(path, names, fault)
    materials = [m for file in libraries for m in read_mtl(file, named.root_of(path), fault).values()]
    return [*libraries, *(file for m in materials for file in m.files())]


def _read(
    path: Path, job: Job | None, threads: int, fault: Fault, stands: Path | None = None
) -> tuple[Look, dict[str, "_Material"], list[Path]]:
    """Return the look without its materials, the materials by name, and their files."""
    vertices, loops, loop_start, vertex, _, uv, names, uses, skipped = _read_columns(path, [], job, threads)
    path = stands or path
    libraries = _library_files(path, names if uses else [], fault)  # without a material no image is shown
    used = dict.fromkeys(name for face, name in uses if face < len(loop_start))  # in the order of their first use
    materials = _materials(path, used, libraries, fault)
    number = {name: i for i, name in enumerate(materials)}
    begin = [0, *(face for face, _ in uses), len(loop_start)]
    material = np.repeat([-1, *(number.get(name, -1) for _, name in uses)], np.diff(begin)).astype(np.int32)
    return Look(vertices, loops, loop_start, uv, material, _colors(vertex), skipped=skipped), materials, libraries


def _layers(materials: dict[str, "_Material"], pictures: images.Pictures) -> dict[str, TextureLayer]:
    """The layers that any of the materials has in addition to its colour."""
    strength = max([1.0, *(max(m.numbers["emission"]) for m in materials.values() if "emission" in m.numbers)])
    found = {}
    for name in _MAPS.values():
        shown = [m.layer(name, strength, pictures) for m in materials.values()]
        if any(picture is not None for picture in shown):
            found[name] = TextureLayer(shown, strength=strength if name == "emission" else 1.0)
    return found


def _text(word: bytes) -> str:
    return word.strip().decode("utf-8", "surrogateescape")


class _Material:
    """The content of an MTL file for one material."""

    def __init__(self, place: str) -> None:
        self.place, self.diffuse = place, (0.8, 0.8, 0.8)
        self.map: Path | None = None
        self.skipped: list[str] = []  # words of maps and of transparency, which are not read
        self.numbers: dict[str, tuple[float, float, float]] = {}
        self.maps: dict[str, tuple[Path, str]] = {}  # with the places where they are named

    def files(self) -> list[Path]:
        named = (self.map, *(file for file, _ in self.maps.values()))
        return [file for path in named if path is not None for file in udim.files(path).values()]

    def layer(self, name: str, strength: float, pictures: images.Pictures) -> Any:
        """The image of a layer, or its number as a pixel; None if the file has neither."""
        numbers = self.numbers.get(name)
        if name in self.maps:
            image = pictures.load(*self.maps[name])
            if name == NORMAL:
                return image
            if name != "emission":
                return udim.each(image, lambda one: pictures.changed(one, 0, lambda one: channel(one, 0)))
            factor = max(1.0, *(numbers or (1.0,))) / strength
            change = lambda one: scaled_colors(one, factor)  # noqa: E731
            return udim.each(image, lambda one: pictures.changed(one, ("colors", factor), change))
        if numbers is None or (name == "emission" and not any(numbers)):
            return None
        if name != "emission":
            return images.rgba(np.full((1, 1), numbers[0]))
        return images.rgba(to_srgb(np.reshape(np.divide(numbers, strength), (1, 1, 3))))

    def plain(self) -> NDArray[np.uint8]:
        """A pixel of the diffuse colour. Colours of OBJ files are stored values, as in images."""
        rgb = np.round(np.clip(self.diffuse, 0, 1) * np.float64(255)).astype(np.uint8)
        return np.append(rgb, np.uint8(255)).reshape(1, 1, 4)


def _library_files(path: Path, libraries: list[str], fault: Fault) -> list[Path]:
    root, files = named.root_of(path), list[Path]()
    for names in libraries:
        for name in [names] if (path.parent / names).is_file() else names.split():
            with named.faults(fault):
                file = named.file(name, path.parent, root, str(path))
                if not file.is_file():
                    raise FileError(f"{path}: its material file {file} does not exist; put it there")
                files.append(file)
    return files


def _materials(path: Path, used: Iterable[str], libraries: list[Path], fault: Fault) -> dict[str, _Material]:
    known: dict[str, _Material] = {}
    for file in libraries:
        known |= read_mtl(file, named.root_of(path), fault)
    for name in used:
        if name not in known and libraries:
            fault(f"{path}: uses the material {name!r}, which {libraries[-1]} does not have")
    return {name: known.get(name, _Material(str(path))) for name in used}


def _colors(vertex: dict[str, NDArray[np.float64]]) -> NDArray[np.uint8] | None:
    """(V, 4) where all vertices have three more numbers, their colours from 0 to 1."""
    if not vertex:
        return None
    numbers = np.stack([vertex["red"], vertex["green"], vertex["blue"]], axis=1)
    if numbers.max(initial=0) > 1.001:  # some programs write them from 0 to 255
        numbers = numbers / 255
    rgb = np.round(np.clip(np.nan_to_num(numbers), 0, 1) * 255).astype(np.uint8)
    return np.hstack([rgb, np.full((len(rgb), 1), 255, dtype=np.uint8)])


def read_mtl(path: Path, root: Path, fault: Fault = named.refuse) -> dict[str, _Material]:
    """The materials of an MTL file by name. root: see `named`. fault: gets each line that can't be used."""
    found: dict[str, _Material] = {}
    material = _Material(str(path))
    for row, line in enumerate(path.read_bytes().removeprefix(b"\xef\xbb\xbf").splitlines(), start=1):
        word, rest = (*map(_text, line.split(None, 1)), "", "")[:2]
        place = f"{path}, line {row}"
        if word == "newmtl":
            material = found[rest] = _Material(place)
            continue
        with named.faults(fault):
            _set(material, word, rest, path.parent, root, place)
    return found


def _set(material: _Material, word: str, rest: str, folder: Path, root: Path, place: str) -> None:
    """Sets what a line of an MTL file says of its material."""
    if word == "Kd":
        material.diffuse = _three_numbers(word, rest, place)
    elif word in _NUMBERS:
        material.numbers[_NUMBERS[word]] = _three_numbers(word, rest, place)
    elif word in _MAPS and rest:
        material.maps[_MAPS[word]] = named.image(map_name(rest, place), folder, root, place), place
    elif word == "map_Kd" and rest:
        material.map, material.place = named.image(map_name(rest, place), folder, root, place), place
    elif (rest and word.startswith(_OTHER_MAPS)) or (word == "d" and _is_number(rest) and float(rest) < 1):
        material.skipped.append(word)


def _three_numbers(word: str, text: str, place: str) -> tuple[float, float, float]:
    try:
        red, green, blue = (float(x) for x in (text.split() * 3)[:3])
    except ValueError:
        red = green = blue = math.inf
    if not all(abs(x) <= _LARGEST for x in (red, green, blue)):
        raise FileError(f"{place}: expected three numbers after {word}, got {text[:40]!r}")
    return red, green, blue


def map_name(text: str, place: str = "") -> str:
    """The name of the file of a texture map, past the map's options."""
    words = text.replace("\t", " ").split(" ")
    while words and words[0] in (*_MAP_OPTIONS, *_UP_TO_THREE):
        option, count = words.pop(0), 3
        if option in _MAP_OPTIONS:
            del words[: _MAP_OPTIONS[option]]
            continue
        while count and words and _is_number(words[0]):
            words.pop(0)
            count -= 1
    name = " ".join(words).strip()
    if name.startswith('"'):
        try:
            name = shlex.split(name)[0]
        except ValueError:
            raise FileError(f"{place}: the name of the image has an opening quotation mark only") from None
    return name


def is_nameable(name: str) -> bool:
    """Whether a file of this name is found again if OBJ and MTL files refer to it."""
    line = b"map_Kd " + os.fsencode(name)
    return [line] == line.splitlines() and map_name(_text(line.split(None, 1)[-1])) == name and "\\" not in name


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
