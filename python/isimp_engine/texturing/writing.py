"""Polygons with their texture as files."""

import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import FileError, Job, PolygonMesh
from ..drafts import deliver, draft_of
from ..exporting import TEXTURED
from . import images, obj
from .baking import Texture
from .glb import Contents, contents, filled
from .gltf_layers import Shown
from .layers import NORMAL

Put = Callable[[Path, bytes], object]


#: Names of the further layers in MTL files. They have no word for occlusion: it dims the ambient light.
_MAPS = {"roughness": "map_Pr", "metallic": "map_Pm", "emission": "map_Ke", "occlusion": "map_Ka"}


def companions(path: Path) -> list[Path]:
    """The files that can accompany an output: OBJ has a material file and images, glTF images.

    Files of a result with tiles or several materials have more in their names.
    """
    kind = path.suffix.lower()
    if kind == ".gltf":
        return [path.with_suffix(".png"), *(_beside(path, name) for name in (NORMAL, "surface", "emission"))]
    if kind == ".obj":
        return [path.with_suffix(".mtl"), path.with_suffix(".png"), *(_beside(path, n) for n in (NORMAL, *_MAPS))]
    return []


def refusal(path: Path) -> str:
    """The reason why an output can't have this name; empty: it can. An OBJ file names its companions."""
    if path.suffix.lower() != ".obj" or all(obj.is_nameable(file.name) for file in companions(path)):
        return ""
    return f"{path}: OBJ files can't name files so; choose a name without line breaks, tabs, quotes and backslashes"


def _beside(path: Path, layer: str) -> Path:
    return path.with_name(f"{path.stem}_{layer}.png")


@dataclass(frozen=True, eq=False)
class _Sheet:
    """One tile of a texture: its images, and the names of its files and its material."""

    material: str  # name of the result's material
    prefix: str  # beginning of the names of its images: the output's name, and that of the material
    udim: str  # ".1001", "" if the material has one tile
    column: int  # column of the tile in UDIM
    row: int
    color: NDArray[np.uint8]
    normal: NDArray[np.uint8] | None
    layers: dict[str, NDArray[Any]]

    def name(self, layer: str = "", udim: str | None = None) -> str:
        return f"{self.prefix}{'_' + layer if layer else ''}{self.udim if udim is None else udim}.png"

    @property
    def any_udim(self) -> str:
        """The text in MTL files for the number of any tile."""
        return ".<UDIM>" if self.udim else ""


def sheets(made: Texture, stem: str) -> list[_Sheet]:
    """The tiles of a texture, in order."""
    apart = made.materials_apart
    if len(made.tile_material) == 1 and not apart:
        return [_Sheet("texture", stem, "", 0, 0, made.image, made.normal, made.layers)]
    found: list[_Sheet] = []
    names = _unique([safe(name) if name else "none" for name in made.tile_name], made.tile_material)
    for t, of in enumerate(made.tile_material):
        number = made.tile_material[:t].count(of)
        alone = made.tile_material.count(of) == 1
        udim = "" if alone else f".{1001 + number}"
        prefix = f"{stem}-{names[t]}" if apart else stem
        single = len(made.tile_material) == 1
        color, normal, layers = made.image, made.normal, dict(made.layers)
        if not single:
            color, normal = color[t], None if normal is None else normal[t]
            layers = {name: image[t] for name, image in layers.items()}
        material = names[t] if apart else "texture"
        found.append(_Sheet(material, prefix, udim, number % 10, number // 10, color, normal, layers))
    return found


def _unique(names: list[str], of: tuple[int, ...]) -> list[str]:
    """The same names, with numbers appended to names that several materials have."""
    owner: dict[str, int] = {}
    for i, name in enumerate(names):
        while owner.setdefault(names[i], of[i]) != of[i]:
            names[i] = f"{name}_{of[i]}"
    return names


def safe(name: str) -> str:
    """A material's name as a part of a file's name and a word of an MTL file."""
    return re.sub(r"[^\w.-]+", "_", name).strip("._") or "material"


def files_of(path: Path, poly: PolygonMesh, made: Texture, job: Job | None = None) -> dict[Path, bytes]:
    """The contents of all files of an output, by name."""
    kind = path.suffix.lower()
    if kind not in TEXTURED:
        raise FileError(f"{path}: a texture can be written to {' or '.join(TEXTURED)} only")
    if why := refusal(path):
        raise FileError(why)
    tiles = sheets(made, path.stem)
    files = {}
    if kind != ".obj":
        made_of = _gltf(path, poly, made, tiles, job)
        files[path] = made_of.glb(path) if kind == ".glb" else made_of.gltf()
        if kind == ".gltf":
            files |= {path.with_name(name + ".png"): data for name, data in made_of.pictures}
        return files
    mtl = path.with_suffix(".mtl")
    files[path] = _obj(mtl.name, poly, made, tiles)
    first = {sheet.material: sheet for sheet in reversed(tiles)}
    files[mtl] = b"".join(_mtl(first[name], made.factors) for name in dict.fromkeys(s.material for s in tiles))
    for sheet in tiles:
        shown = {"": sheet.color} | ({} if sheet.normal is None else {NORMAL: sheet.normal}) | sheet.layers
        files |= {path.with_name(sheet.name(name)): images.png(image, path) for name, image in shown.items()}
    return files


def write_textured(
    path: str | PathLike[str], poly: PolygonMesh, made: Texture, *, job: Job | None = None
) -> list[Path]:
    """Write polygons with their texture; returns the files that were written.

    OBJ keeps the n-gons and has an MTL file and PNG images of the same name; images of several tiles are UDIM images
    (`model.1001.png`, in the MTL file `model.<UDIM>.png`), and images of materials kept apart have the material's name
    (`model-red.png`). GLB and glTF have triangles, which FB_ngon_encoding groups to n-gons, and a material for each
    tile. GLB holds its images, for glTF they are PNG files; the coordinates are the scan's, though glTF takes
    y for up.
    Each file is replaced only when all are complete. Raises FileError (another extension, or the place can't be
    written).
    """
    place = Path(path)
    files = files_of(place, poly, made, job)
    drafts: list[tuple[Path, Path]] = []
    try:
        for file, content in files.items():
            draft, target = draft_of(file)
            if draft != target:
                drafts.append((draft, target))
            draft.write_bytes(content)
        while drafts:
            deliver(*drafts[0])
            drafts.pop(0)
    except OSError as error:
        raise FileError(f"{place}: can't be written: {error.strerror or error}") from None
    finally:
        for draft, _ in drafts:
            draft.unlink(missing_ok=True)
    return list(files)


def _ends(poly: PolygonMesh) -> NDArray[np.int64]:
    return np.append(poly.loop_start, len(poly.loops)).astype(np.int64)


def _obj(library: str, poly: PolygonMesh, made: Texture, tiles: list[_Sheet]) -> bytes:
    """A normal for each polygon, so that it is shaded flat: the normal map is made for this."""
    of = np.zeros(len(poly.loop_start), dtype=np.int32) if made.tile is None else made.tile
    ends = _ends(poly)
    shift = np.array([(sheet.column, sheet.row) for sheet in tiles])[np.repeat(of, np.diff(ends))]
    lines = [f"mtllib {library}"]
    lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in poly.vertices.tolist()]
    lines += [f"vt {u:.9g} {v:.9g}" for u, v in (made.uv + shift).tolist()]
    lines += [f"vn {x:.7g} {y:.7g} {z:.7g}" for x, y, z in made.polygon_normal.tolist()]
    loops, last = poly.loops.tolist(), ""
    for q in range(len(ends) - 1):
        if (material := tiles[of[q]].material) != last:
            lines.append(f"usemtl {material}")
            last = material
        corners = (f"{loops[i] + 1}/{i + 1}/{q + 1}" for i in range(ends[q], ends[q + 1]))
        lines.append("f " + " ".join(corners))
    return os.fsencode("\n".join(lines) + "\n")


def _mtl(sheet: _Sheet, factors: dict[str, float]) -> bytes:
    more = {name: sheet.name(name, sheet.any_udim) for name in sheet.layers}
    ambient = 1 if "occlusion" in more else 0
    lines = [f"newmtl {sheet.material}", f"Ka {ambient} {ambient} {ambient}", "Kd 1 1 1", "Ks 0 0 0", "illum 1"]
    lines += [
        f"{word} {factors[name]:.9g}" for name, word in (("roughness", "Pr"), ("metallic", "Pm")) if name in factors
    ]
    if "emission" in more:
        lines.append("Ke" + f" {factors['emission']:.9g}" * 3)
    lines.append(f"map_Kd {sheet.name('', sheet.any_udim)}")
    if sheet.normal is not None:
        normal = sheet.name(NORMAL, sheet.any_udim)
        lines += [f"map_Bump {normal}", f"norm {normal}"]
    lines += [f"{word} {more[name]}" for name, word in _MAPS.items() if name in more]
    return os.fsencode("\n".join(lines) + "\n")


def _gltf(path: Path, poly: PolygonMesh, made: Texture, tiles: list[_Sheet], job: Job | None) -> Contents:
    corners, triangles, polygon = filled(poly, job)
    of = np.repeat(np.arange(len(poly.loop_start)), np.diff(_ends(poly)))
    tile = np.zeros(len(triangles), dtype=np.int32) if made.tile is None else made.tile[polygon]
    faces = [triangles[tile == t] for t in range(len(tiles))]
    shown = [_shown(path, sheet, made.factors) for sheet in tiles]
    return contents(path.stem, corners, faces, made.polygon_normal[of], made.uv, made.polygon_tangent[of], shown)


def _shown(path: Path, sheet: _Sheet, factors: dict[str, float]) -> Shown:
    layers, surface = sheet.layers, None
    if layers.keys() & {"occlusion", "roughness", "metallic"}:
        full = np.full(sheet.color.shape[:2], 255, dtype=np.uint8)
        channels = [layers.get(name, full) for name in ("occlusion", "roughness", "metallic")]
        surface = images.png(np.stack(channels, axis=2), path)
    emission = images.png(layers["emission"], path) if "emission" in layers else None
    normal = None if sheet.normal is None else images.png(sheet.normal, path)
    name = sheet.prefix + sheet.udim
    return Shown(name, images.png(sheet.color, path), normal, surface, emission, frozenset(layers), factors)
