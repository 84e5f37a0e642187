"""Polygons with their texture as files."""

from collections.abc import Callable
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .._core import FileError, Job, PolygonMesh, triangulate
from ..drafts import deliver, draft_of
from . import images
from .baking import Texture
from .glb import glb
from .gltf_layers import Shown
from .layers import HEIGHT, NORMAL

KINDS = (".obj", ".glb")
Put = Callable[[Path, bytes], object]


#: What MTL files call the further layers. They have no word for occlusion: it dims the ambient light.
_MAPS = {"roughness": "map_Pr", "metallic": "map_Pm", "emission": "map_Ke", "occlusion": "map_Ka", HEIGHT: "disp"}


def companions(path: Path, height: bool = False) -> list[Path]:
    """The files that can stand beside an output: OBJ has a material file and images, GLB has no place for heights."""
    if path.suffix.lower() != ".obj":
        return [_beside(path, HEIGHT)] if height else []
    return [path.with_suffix(".mtl"), path.with_suffix(".png"), *(_beside(path, n) for n in (NORMAL, *_MAPS))]


def _beside(path: Path, layer: str) -> Path:
    return path.with_name(f"{path.stem}_{layer}.png")


def files_of(path: Path, poly: PolygonMesh, made: Texture, job: Job | None = None) -> dict[Path, bytes]:
    """The contents of all files of an output, by name."""
    kind = path.suffix.lower()
    if kind not in KINDS:
        raise FileError(f"{path}: a texture can be written to {' or '.join(KINDS)} only")
    image = images.png(made.image, path)
    normal = None if made.normal is None else images.png(made.normal, path)
    if kind == ".glb":
        files = {path: _glb(path, poly, made, image, normal, job)}
        if HEIGHT in made.layers:
            files[_beside(path, HEIGHT)] = images.png(made.layers[HEIGHT], path)
        return files
    mtl, png, *_ = companions(path)
    more = {} if normal is None else {NORMAL: normal}
    more |= {name: images.png(layer, path) for name, layer in made.layers.items()}
    names = {name: _beside(path, name).name for name in more}
    texts = {path: _obj(mtl.name, poly, made), mtl: _mtl(png.name, names, made.factors), png: image}
    return texts | {_beside(path, name): data for name, data in more.items()}


def write_textured(path: str | PathLike[str], poly: PolygonMesh, made: Texture, job: Job | None = None) -> list[Path]:
    """Write polygons with their texture; returns the files that were written.

    OBJ keeps the n-gons and has an MTL file and PNG images of the same name beside it. GLB has triangles and holds its
    images; the coordinates are the scan's, though glTF takes y for up. A height map is a file beside it, as glTF has
    no word for it.
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


def _obj(library: str, poly: PolygonMesh, made: Texture) -> bytes:
    """A normal for each polygon, so that it is shaded flat: that is what the normal map is made for."""
    lines = [f"mtllib {library}"]
    lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in poly.vertices.tolist()]
    lines += [f"vt {u:.9g} {v:.9g}" for u, v in made.uv.tolist()]
    lines += [f"vn {x:.7g} {y:.7g} {z:.7g}" for x, y, z in made.polygon_normal.tolist()]
    lines.append("usemtl texture")
    loops, ends = poly.loops.tolist(), _ends(poly).tolist()
    for q in range(len(ends) - 1):
        corners = (f"{loops[i] + 1}/{i + 1}/{q + 1}" for i in range(ends[q], ends[q + 1]))
        lines.append("f " + " ".join(corners))
    return ("\n".join(lines) + "\n").encode()


def _mtl(image: str, more: dict[str, str], factors: dict[str, float]) -> bytes:
    ambient = 1 if "occlusion" in more else 0
    lines = ["newmtl texture", f"Ka {ambient} {ambient} {ambient}", "Kd 1 1 1", "Ks 0 0 0", "illum 1"]
    lines += [
        f"{word} {factors[name]:.9g}" for name, word in (("roughness", "Pr"), ("metallic", "Pm")) if name in factors
    ]
    if "emission" in more:
        lines.append("Ke" + f" {factors['emission']:.9g}" * 3)
    lines.append(f"map_Kd {image}")
    if NORMAL in more:
        lines += [f"map_Bump {more[NORMAL]}", f"norm {more[NORMAL]}"]
    if HEIGHT in more:
        lines.append(f"# height above the polygon: (value of disp, from 0 to 1, - 0.5) * {factors[HEIGHT]:.9g}")
    lines += [f"{word} {more[name]}" for name, word in _MAPS.items() if name in more]
    return ("\n".join(lines) + "\n").encode()


def _glb(path: Path, poly: PolygonMesh, made: Texture, image: bytes, normal: bytes | None, job: Job | None) -> bytes:
    # Every corner is a vertex of its own, since the two sides of an edge have their own normals and UVs.
    each = np.arange(len(poly.loops), dtype=np.int32)
    corners = poly.vertices[poly.loops]
    triangles, _ = triangulate(corners, each, poly.loop_start, job)
    of = np.repeat(np.arange(len(poly.loop_start)), np.diff(_ends(poly)))
    layers, surface = made.layers, None
    if layers.keys() & {"occlusion", "roughness", "metallic"}:
        full = np.full(made.image.shape[:2], 255, dtype=np.uint8)
        channels = [layers.get(name, full) for name in ("occlusion", "roughness", "metallic")]
        surface = images.png(np.stack(channels, axis=2), path)
    emission = images.png(layers["emission"], path) if "emission" in layers else None
    shown = Shown(image, normal, surface, emission, frozenset(layers), made.factors)
    return glb(path.stem, corners, triangles, made.uv, made.polygon_normal[of], made.polygon_tangent[of], shown)
