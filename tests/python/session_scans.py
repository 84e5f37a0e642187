"""Scans in the form of the add-on's session, made from arrays."""

import numpy as np

from isimp.session import Scan


def scan_of(vertices, triangles):
    """A scan whose faces are the triangles; in single precision, as in Blender."""
    count = len(triangles)
    vertices = np.asarray(vertices, np.float32)
    return Scan(vertices, np.asarray(triangles, np.int32), np.arange(count, dtype=np.int32), count)
