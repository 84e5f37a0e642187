"""Texture coordinates, materials and colours of OBJ files."""

import shlex
from pathlib import Path, PureWindowsPath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import FileError, Job, read_polygons, triangulate
from . import images, udim
from .layers import NORMAL, TextureLayer, channel, scaled_colors, to_srgb
from .soup import TexturedSoup, corner_places

# How many words follow the options of a texture map.
_MAP_OPTIONS = {"-blendu": 1, "-blendv": 1, "-boost": 1, "-cc": 1, "-clamp": 1, "-texres": 1, "-bm": 1, "-imfchan": 1}
_MAP_OPTIONS |= {"-type": 1, "-mm": 2, "-colorspace": 1}
_UP_TO_THREE = ("-o", "-s", "-t")
# Numbers and maps beside the colour. A map counts alone, without its number, but for emission above 1.
_NUMBERS = {"Pr": "roughness", "Pm": "metallic", "Ke": "emission"}
_MAPS = {f"map_{word}": name for word, name in _NUMBERS.items()} | {"norm": NORMAL}


def read(path: Path, job: Job | None, threads: int) -> TexturedSoup:
    vertices, loops, loop_start = read_polygons(path, job, threads=threads)
    triangles, polygon = triangulate(vertices, loops, loop_start, job)
    places = corner_places(loops, loop_start, triangles, polygon)
    text = path.read_text(encoding="utf-8", errors="surrogateescape").replace("\\\n", " ").replace("\\\r\n", " ")
    rows = _Rows(path, text)
    corner_uv = rows.corner_uv(len(loops))
    materials = rows.materials()
    material = np.asarray(rows.material_of(materials), dtype=np.int32)
    colors = rows.colors(len(vertices))
    pictures: list[Any] = []
    for m in materials.values():
        if m.map is not None:
            pictures.append(m.image())
        else:
            pictures.append(None if colors is not None else m.plain())
    names, layers = list(materials), _layers(materials)
    files = [*rows.library_files(), *(file for m in materials.values() for file in m.files())]
    return TexturedSoup(
        vertices, triangles, corner_uv[places], material[polygon], pictures, colors, names, files, layers
    )


def _layers(materials: dict[str, "_Material"]) -> dict[str, TextureLayer]:
    """What any of the materials has beside its colour."""
    strength = max([1.0, *(max(m.numbers["emission"]) for m in materials.values() if "emission" in m.numbers)])
    found = {}
    for name in _MAPS.values():
        pictures = [m.layer(name, strength) for m in materials.values()]
        if any(picture is not None for picture in pictures):
            found[name] = TextureLayer(pictures, strength=strength if name == "emission" else 1.0)
    return found


class _Material:
    """What an MTL file says of a material."""

    def __init__(self, place: str) -> None:
        self.place, self.diffuse = place, (0.8, 0.8, 0.8)
        self.map: Path | None = None
        self.numbers: dict[str, tuple[float, float, float]] = {}
        self.maps: dict[str, tuple[Path, str]] = {}  # with the places where they are named

    def files(self) -> list[Path]:
        named = (self.map, *(file for file, _ in self.maps.values()))
        return [file for path in named if path is not None for file in udim.files(path).values()]

    def layer(self, name: str, strength: float) -> Any:
        """The image of a layer, or its number as a pixel; None if the file does not say."""
        numbers = self.numbers.get(name)
        if name in self.maps:
            image = images.load(*self.maps[name])
            if name == NORMAL:
                return image
            if name != "emission":
                return udim.each(image, lambda one: channel(one, 0))
            factor = max(1.0, *(numbers or (1.0,))) / strength
            return udim.each(image, lambda one: scaled_colors(one, factor))
        if numbers is None or (name == "emission" and not any(numbers)):
            return None
        if name != "emission":
            return images.rgba(np.full((1, 1), numbers[0]))
        return images.rgba(to_srgb(np.reshape(np.divide(numbers, strength), (1, 1, 3))))

    def image(self) -> Any:
        return images.load(self.map, self.place) if self.map is not None else None

    def plain(self) -> NDArray[np.uint8]:
        """A pixel of the diffuse colour. Colours of OBJ files are stored values, as those of images are."""
        rgb = np.round(np.clip(self.diffuse, 0, 1) * np.float64(255)).astype(np.uint8)
        return np.append(rgb, np.uint8(255)).reshape(1, 1, 4)


class _Rows:
    """The lines of an OBJ file that say what it shows."""

    def __init__(self, path: Path, text: str) -> None:
        self.path = path
        self.faces: list[str] = []
        self.uv_before: list[int] = []  # texture coordinates before each face: what negative numbers count back from
        self.uses: list[tuple[int, str]] = []  # the face from which on a material is used
        self.libraries: list[str] = []
        uv: list[list[str]] = []
        self.vertices: list[str] = []
        for line in text.splitlines():
            word, _, rest = line.lstrip().replace("\t", " ").partition(" ")
            if word in ("f", "fo"):
                self.faces.append(rest.partition("#")[0])
                self.uv_before.append(len(uv))
            elif word == "vt":
                uv.append(rest.split()[:2])
            elif word == "v":
                self.vertices.append(rest)
            elif word == "usemtl":
                self.uses.append((len(self.faces), rest.strip()))
            elif word == "mtllib":
                self.libraries.append(rest.strip())
        try:
            self.uv = np.array([(*pair, "0")[:2] for pair in uv], dtype=np.float64).reshape(-1, 2)
        except ValueError:
            raise FileError(f'{path}: a line that begins with "vt" does not have two numbers') from None

    def corner_uv(self, corners: int) -> NDArray[np.float64]:
        """(L, 2) of each corner; zeros where a corner has none."""
        numbers = self._uv_numbers()
        if len(numbers) != corners:
            raise FileError(f"{self.path}: its faces have {corners} corners, {len(numbers)} of them could be read")
        bad = (numbers < 0) | (numbers > len(self.uv))
        if bad.any():
            raise FileError(
                f"{self.path}: a face uses texture coordinate {numbers[bad][0]}, but there are {len(self.uv)}"
            )
        return np.vstack([np.zeros((1, 2)), self.uv])[numbers]

    def _uv_numbers(self) -> NDArray[np.int64]:
        """(L,) the number of the texture coordinate of each corner, 0 for none."""
        words = " ".join(self.faces).split()
        if not words:
            return np.zeros(0, dtype=np.int64)
        slashes = words[0].count("/")
        joined = " ".join(words)
        if slashes and "//" not in joined and "-" not in joined and all(w.count("/") == slashes for w in words):
            try:
                return np.array(joined.replace("/", " ").split(), dtype=np.int64).reshape(-1, slashes + 1)[:, 1]
            except ValueError:
                raise FileError(f"{self.path}: a face has a corner that is not made of whole numbers") from None
        numbers: list[int] = []
        for face, before in zip(self.faces, self.uv_before, strict=True):
            for word in face.split():
                parts = word.split("/")
                try:
                    number = int(parts[1]) if len(parts) > 1 and parts[1] else 0
                except ValueError:
                    raise FileError(f"{self.path}: a face has the corner {word!r}, which is no number") from None
                numbers.append(number if number >= 0 else before + 1 + number)
        return np.array(numbers, dtype=np.int64)

    def colors(self, count: int) -> NDArray[np.uint8] | None:
        """(V, 4) where all vertices have three more numbers, their colours from 0 to 1."""
        if not self.vertices or len(self.vertices[0].split()) not in (6, 7):
            return None
        try:
            numbers = np.array([row.split()[-3:] for row in self.vertices], dtype=np.float64)
        except ValueError:
            return None
        if numbers.shape != (count, 3):
            return None
        if numbers.max(initial=0) > 1.001:  # some programs write them from 0 to 255
            numbers = numbers / 255
        rgb = np.round(np.clip(np.nan_to_num(numbers), 0, 1) * 255).astype(np.uint8)
        return np.hstack([rgb, np.full((count, 1), 255, dtype=np.uint8)])

    def materials(self) -> dict[str, _Material]:
        """The materials that faces use, in the order of their first use."""
        known: dict[str, _Material] = {}
        if not self.uses:  # without a material no image is shown
            return {}
        for file in self.library_files():
            known |= read_mtl(file)
        used = dict.fromkeys(name for (face, name) in self.uses if face < len(self.faces))
        for name in used:
            if name not in known and self.libraries:
                raise FileError(f"{self.path}: uses the material {name!r}, which {self.libraries[-1]} does not have")
        return {name: known.get(name, _Material(str(self.path))) for name in used}

    def library_files(self) -> list[Path]:
        """The material files, if any face has a material."""
        files: list[Path] = []
        for names in self.libraries if self.uses else ():
            whole = self.path.parent / names
            files += [whole] if whole.is_file() else [self.path.parent / name for name in names.split()]
        for file in files:
            if not file.is_file():
                raise FileError(f"{self.path}: its material file {file} does not exist; put it there")
        return files

    def material_of(self, materials: dict[str, _Material]) -> NDArray[np.int64]:
        """(Q,) of each face, -1 before the first is named."""
        number = {name: i for i, name in enumerate(materials)}
        result = np.full(len(self.faces), -1)
        for face, name in self.uses:
            result[face:] = number.get(name, -1)
        return result


def read_mtl(path: Path) -> dict[str, _Material]:
    """The materials of an MTL file by name."""
    found: dict[str, _Material] = {}
    material = _Material(str(path))
    text = path.read_text(encoding="utf-8", errors="surrogateescape")
    for row, line in enumerate(text.splitlines(), start=1):
        word, _, rest = line.strip().replace("\t", " ").partition(" ")
        place = f"{path}, line {row}"
        if word == "newmtl":
            material = found[rest.strip()] = _Material(place)
        elif word == "Kd" or word in _NUMBERS:
            try:
                red, green, blue = (float(x) for x in (rest.split() * 3)[:3])
            except ValueError:
                raise FileError(f"{place}: expected three numbers after {word}, got {rest!r}") from None
            if word == "Kd":
                material.diffuse = (red, green, blue)
            else:
                material.numbers[_NUMBERS[word]] = (red, green, blue)
        elif word in _MAPS and rest.strip():
            material.maps[_MAPS[word]] = _map_file(path.parent, rest.strip(), place), place
        elif word == "map_Kd" and rest.strip():
            material.map, material.place = _map_file(path.parent, rest.strip(), place), place
    return found


def _map_file(folder: Path, text: str, place: str) -> Path:
    """The file of a texture map, past the map's options. A name from another machine is looked for here too."""
    words = text.split(" ")
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
    path = folder / name.replace("\\", "/")
    beside = folder / PureWindowsPath(name).name
    return beside if udim.exists(beside) and not udim.exists(path) else path


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
