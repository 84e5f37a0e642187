"""Small pictures of a scan and its model, drawn with numpy alone."""

import struct
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import triangulate

Array = NDArray[Any]

SIDE = 144  #: pixels
_SAMPLES = 80_000  # most points of a picture with the default side
_BEFORE = 4.0  # pixels: a larger step of depth counts as a hole between points, with the far side behind it
_LEAST = 5  # least mean number of points in a pixel of the surface, so that holes are rare
_LIGHT = np.array([-0.35, 0.5, 0.79])  # direction in the axes of the camera
_BACK = (255, 255, 255)
_COLORS = np.array([[0.55, 0.69, 0.86], [0.93, 0.71, 0.49], [0.62, 0.80, 0.58], [0.85, 0.62, 0.66], [0.73, 0.66, 0.84],
                    [0.90, 0.83, 0.56], [0.56, 0.79, 0.78], [0.78, 0.75, 0.72]])  # fmt: skip


def beside(scan: tuple[Array, Array], model: tuple[Array, Array, Array, Array], side: int = SIDE) -> bytes:
    """Return a PNG of a scan (vertices, triangles) next to its model (vertices, loops, loop_start, region).

    side: width and height of each of the two views, in pixels.
    """
    vertices, loops, starts, region = model
    triangles, polygon = triangulate(vertices, loops, starts)
    camera = _camera(scan[0], scan[1], side)
    gray = np.full((1, 3), 0.8)
    colors = _COLORS[(region[polygon] * 5) % len(_COLORS)] if len(polygon) else gray
    left, right = draw(*scan, gray, camera, side), draw(vertices, triangles, colors, camera, side, polygon)
    return png(np.concatenate([left, np.full((side, 4, 3), _BACK, np.uint8), right], axis=1))


def _camera(vertices: Array, triangles: Array, side: int = SIDE) -> tuple[Array, Array, float]:
    """Return centre, axes (right, up, towards the eye) and pixels per unit of a view from front, side and above."""
    mask = np.zeros(len(vertices), bool)
    mask[triangles] = True
    used = vertices[mask]
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
    return middle, axes, (side / 2 - 2) / max(float(reach), 1e-300)


def draw(
    vertices: Array,
    triangles: Array,
    colors: Array,
    camera: tuple[Array, Array, float],
    side: int = SIDE,
    polygon: Array | None = None,
) -> Array:
    """Draw an image (side, side, 3) uint8: spread points over the triangles, and keep the nearest in each pixel.

    colors: (T, 3) or (1, 3), in [0, 1]. polygon: (T,) of each triangle: polygons have one shade, thin triangles too.
    """
    image = np.full((side * side, 3), _BACK, np.uint8)
    middle, axes, scale = camera
    with np.errstate(invalid="ignore", over="ignore"):  # values that are not finite are left out below
        corners = (((vertices - middle) @ axes.T) * scale).astype(np.float32)[triangles]
        normals = _cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        areas = np.sqrt(np.einsum("ij,ij->i", normals, normals)) / 2
    seen = np.flatnonzero(np.isfinite(areas) & (areas > 0))
    if not len(seen):
        return image.reshape(side, side, 3)
    triangle, points = _spread(corners, seen, np.abs(normals[seen, 2]) / 2, _SAMPLES * side**2 // SIDE**2)
    place = np.floor(side / 2 - points[:, 1]).astype(np.intp).clip(0, side - 1) * side
    place += np.floor(side / 2 + points[:, 0]).astype(np.intp).clip(0, side - 1)
    order = np.argsort(points[:, 2])  # the nearest is written last
    nearest, depth = np.full(side * side, -1, np.intp), np.full(side * side, -np.inf, np.float32)
    nearest[place[order]], depth[place[order]] = triangle[order], points[order, 2]
    nearest = _filled(nearest.reshape(side, side), depth.reshape(side, side)).ravel()
    drawn = np.flatnonzero(nearest >= 0)
    face = nearest[drawn]
    if polygon is not None:
        normals = np.stack([np.bincount(polygon, axis) for axis in normals.T], axis=1)[polygon]
    light = np.abs(normals[face] @ _LIGHT) / np.linalg.norm(normals[face], axis=1).clip(1e-30)
    shade = (colors if len(colors) == 1 else colors[face]) * (0.35 + 0.65 * light.clip(0, 1))[:, None]
    image[drawn] = (255 * shade).astype(np.uint8)
    return image.reshape(side, side, 3)


def _cross(a: Array, b: Array) -> Array:
    """Return np.cross(a, b), in less time."""
    (x, y, z), (u, v, w) = a.T, b.T
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=1)


def _spread(corners: Array, seen: Array, areas: Array, most: int) -> tuple[Array, Array]:
    """Spread points over the triangles `seen`, _LEAST or more a pixel if `most` allows it: triangles, places."""
    wanted = areas * _LEAST + 1.0
    share = min(1.0, most / float(wanted.sum(dtype=np.float64)))
    sums = np.floor(np.cumsum(wanted, dtype=np.float64) * share + 0.5).astype(np.intp)
    triangle = np.repeat(seen, np.diff(sums, prepend=0))
    k = np.arange(len(triangle))
    u, v = (k * 0.7548776662466927) % 1.0, (k * 0.5698402909980532) % 1.0  # evenly spread points: the R2 sequence
    outside = u + v > 1
    u[outside], v[outside] = 1 - u[outside], 1 - v[outside]
    a, b, c = (corners[triangle, j] for j in range(3))
    return triangle, a + u[:, None] * (b - a) + v[:, None] * (c - a)


def _filled(nearest: Array, depth: Array) -> Array:
    """Fill holes: a pixel far behind most of its neighbours has no point of the surface, and gets a neighbour's."""
    shifts = [(dy, dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1) if dy or dx]
    around = np.stack([np.roll(depth, shift, (0, 1)) for shift in shifts])
    hole = (around > depth + _BEFORE).sum(axis=0) >= 5
    first = around.argmax(axis=0)
    y, x = np.nonzero(hole)
    filled = nearest.copy()
    shift = np.array(shifts)[first[y, x]]
    filled[y, x] = nearest[(y - shift[:, 0]) % len(nearest), (x - shift[:, 1]) % len(nearest)]
    return filled


def png(image: Array) -> bytes:
    """Encode an image (H, W, 3) uint8 as a PNG."""
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
