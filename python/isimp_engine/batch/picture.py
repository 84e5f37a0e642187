"""Small pictures of a scan and of its model, drawn with numpy alone."""

import struct
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import triangulate

Array = NDArray[Any]

SIDE = 144  #: pixels
_SAMPLES = 60_000  # points that a picture is made of, at most
_LEAST = 6  # of them a pixel, where the surface is seen; a hole is rare then
_LIGHT = np.array([-0.35, 0.5, 0.79])  # by the axes of the camera
_BACK = (255, 255, 255)
_COLORS = np.array([[0.55, 0.69, 0.86], [0.93, 0.71, 0.49], [0.62, 0.80, 0.58], [0.85, 0.62, 0.66], [0.73, 0.66, 0.84],
                    [0.90, 0.83, 0.56], [0.56, 0.79, 0.78], [0.78, 0.75, 0.72]])  # fmt: skip


def beside(scan: tuple[Array, Array], model: tuple[Array, Array, Array, Array]) -> bytes:
    """A PNG of the scan (vertices, triangles) beside the model (vertices, loops, loop_start, region), seen alike."""
    vertices, loops, starts, region = model
    triangles, polygon = triangulate(vertices, loops, starts)
    camera = _camera(scan[0], scan[1])
    gray = np.full((1, 3), 0.8)
    colors = _COLORS[(region[polygon] * 5) % len(_COLORS)] if len(polygon) else gray
    left, right = draw(*scan, gray, camera), draw(vertices, triangles, colors, camera)
    return png(np.concatenate([left, np.full((SIDE, 4, 3), _BACK, np.uint8), right], axis=1))


def _camera(vertices: Array, triangles: Array) -> tuple[Array, Array, float]:
    """Middle, axes (right, up, towards the eye) and pixels a length: from the front, the side and above."""
    used = vertices[np.unique(triangles)] if len(triangles) else vertices
    used = used[np.isfinite(used).all(axis=1)]
    if not len(used):
        return np.zeros(3), np.eye(3), 1.0
    low, high = used.min(axis=0), used.max(axis=0)
    up = np.array([0.0, 0.0, 1.0]) if high[1] - low[1] >= high[2] - low[2] else np.array([0.0, 1.0, 0.0])
    front = np.array([0.0, -1.0, 0.0]) if up[2] else np.array([0.0, 0.0, 1.0])
    eye = front + 0.6 * up + 0.7 * np.cross(up, front)
    eye /= np.linalg.norm(eye)
    right = np.cross(up, eye)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(eye, right), eye])
    middle = (low + high) / 2
    reach = np.abs((used - middle) @ axes[:2].T).max()
    return middle, axes, (SIDE / 2 - 2) / max(float(reach), 1e-300)


def draw(vertices: Array, triangles: Array, colors: Array, camera: tuple[Array, Array, float]) -> Array:
    """(SIDE, SIDE, 3) uint8: points spread over the triangles, the nearest of each pixel kept.

    colors: (T, 3) or (1, 3), in [0, 1].
    """
    image = np.full((SIDE * SIDE, 3), _BACK, np.uint8)
    middle, axes, scale = camera
    corners = ((vertices - middle) @ axes.T * scale)[triangles]
    with np.errstate(invalid="ignore"):  # what is not finite is left out below
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    seen = np.flatnonzero(np.isfinite(lengths) & (lengths > 0))
    if not len(seen):
        return image.reshape(SIDE, SIDE, 3)
    triangle, points = _spread(corners[seen], np.abs(normals[seen, 2]) / 2)
    face = seen[triangle]
    place = np.floor(SIDE / 2 - points[:, 1]).astype(np.intp).clip(0, SIDE - 1) * SIDE
    place += np.floor(SIDE / 2 + points[:, 0]).astype(np.intp).clip(0, SIDE - 1)
    order = np.argsort(points[:, 2], kind="stable")  # the nearest is written last
    nearest = np.full(SIDE * SIDE, -1, np.intp)
    nearest[place[order]] = face[order]
    nearest = _filled(nearest.reshape(SIDE, SIDE)).ravel()
    drawn = np.flatnonzero(nearest >= 0)
    face = nearest[drawn]
    light = np.abs((normals[face] / lengths[face, None]) @ _LIGHT)
    shade = (colors if len(colors) == 1 else colors[face]) * (0.35 + 0.65 * light.clip(0, 1))[:, None]
    image[drawn] = (255 * shade).astype(np.uint8)
    return image.reshape(SIDE, SIDE, 3)


def _spread(corners: Array, areas: Array) -> tuple[Array, Array]:
    """Points on the triangles, at least _LEAST a pixel of area if _SAMPLES allow it: their triangles, their places."""
    wanted = areas * _LEAST
    total = float(wanted.sum()) + len(areas)
    share = min(1.0, _SAMPLES / total)
    sums = np.floor(np.cumsum((wanted + 1.0) * share) + 0.5).astype(np.intp)
    triangle = np.repeat(np.arange(len(areas)), np.diff(sums, prepend=0))
    k = np.arange(len(triangle))
    u, v = (k * 0.7548776662466927) % 1.0, (k * 0.5698402909980532) % 1.0  # points that keep apart: the R2 sequence
    outside = u + v > 1
    u[outside], v[outside] = 1 - u[outside], 1 - v[outside]
    a, b, c = (corners[triangle, j] for j in range(3))
    return triangle, a + u[:, None] * (b - a) + v[:, None] * (c - a)


def _filled(nearest: Array) -> Array:
    """Single pixels that no point met get the value of a neighbour, if most neighbours have one."""
    around = np.stack([np.roll(nearest, (dy, dx), (0, 1)) for dy in (-1, 0, 1) for dx in (-1, 0, 1) if dy or dx])
    hole = (nearest < 0) & ((around >= 0).sum(axis=0) >= 5)
    return np.where(hole, around.max(axis=0), nearest)


def png(image: Array) -> bytes:
    """(H, W, 3) uint8 as a PNG."""
    height, width = image.shape[:2]
    rows = np.zeros((height, 1 + 3 * width), np.uint8)
    rows[:, 0] = 1  # each byte is stored as its difference from the pixel to the left
    flat = image.reshape(height, 3 * width)
    rows[:, 1:4] = flat[:, :3]
    rows[:, 4:] = flat[:, 3:] - flat[:, :-3]
    head = struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in ((b"IHDR", head), (b"IDAT", zlib.compress(rows.tobytes(), 6)), (b"IEND", b""))
    )
