"""Scans in the form of the add-on's session, made from arrays."""

import numpy as np

from isimp.session import Scan


def scan_of(vertices, triangles):
    """A scan whose faces are the triangles; in single precision, as in Blender."""
    count = len(triangles)
    vertices = np.asarray(vertices, np.float32)
    return Scan(vertices, np.asarray(triangles, np.int32), np.arange(count, dtype=np.int32), count)


def square():
    """A square of 20 x 20 cells of side .1 about zero, in the plane z = 0."""
    line = np.linspace(-1, 1, 21)
    x, y = np.meshgrid(line, line, indexing="ij")
    at = np.arange(441).reshape(21, 21)
    a, b, c, d = at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]
    triangles = np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3).astype(np.int32)
    return scan_of(np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3), triangles)
