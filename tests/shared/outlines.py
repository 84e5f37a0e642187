"""Directed edges of polygons, and where the outlines of polygons run on the scan that they were made of."""

import numpy as np


def edges_of(loops):
    """Directed edges (E, 2), the corner each starts at being its index, and the corner that follows."""
    if isinstance(loops, np.ndarray):  # all of one size
        sizes, corners = np.full(len(loops), loops.shape[1]), loops.ravel()
    else:
        sizes, corners = np.array([len(loop) for loop in loops]), np.concatenate(loops)
    following = np.arange(len(corners)) + 1
    ends = np.cumsum(sizes)
    following[ends - 1] = ends - sizes
    return np.stack([corners, corners[following]], 1), following, np.repeat(np.arange(len(loops)), sizes)


def twins(edges):
    """The edge that runs the other way along each of the directed edges (E, 2), -1 where there is none."""
    key, back = (edges[:, i].astype(np.int64) << 32 | edges[:, 1 - i] for i in (0, 1))
    rank = np.argsort(key)
    at = np.minimum(np.searchsorted(key[rank], back), len(key) - 1)
    return np.where(key[rank][at] == back, rank[at], -1)


class Outlines:
    """The borders of regions, and outlines along them."""

    def __init__(self, triangles, triangle_region):
        edges, following, owner = edges_of(triangles)
        twin = twins(edges)
        region = triangle_region[owner]
        inner = (twin >= 0) & (region == region[twin])
        outer = np.flatnonzero(~inner)
        after = following[outer]  # around the end of each edge, within the region, to the next on its border
        while inner[after].any():
            after = np.where(inner[after], following[twin[after]], after)
        self._end = dict(zip(outer.tolist(), edges[outer, 1].tolist(), strict=True))
        self._next = dict(zip(outer.tolist(), after.tolist(), strict=True))
        self._starts = {}  # by region and vertex: the edges from there on the region's border
        for edge, r, vertex in zip(outer.tolist(), region[outer].tolist(), edges[outer, 0].tolist(), strict=True):
            self._starts.setdefault((r, vertex), []).append(edge)

    def along_border(self, region, start, end, every):
        """The vertices from start to before end along a region's border; None if there is a corner between."""
        for first in self._starts.get((region, start), ()):
            edge, path = first, [start]
            while self._end[edge] not in every and len(path) < len(self._end):
                path.append(self._end[edge])
                edge = self._next[edge]
            if self._end[edge] == end:
                return path
        return None

    def outline(self, region, corners, every):
        """A polygon's outline on the scan by vertices, how much it runs along its region's border, whether all does.

        How much: edges along it, minus edges against it. `every`: the vertices that are some polygon's corners.
        """
        line, along, known = [], 0, True
        for start, end in zip(corners, corners[1:] + corners[:1], strict=True):
            path = self.along_border(region, start, end, every)
            along += (path is not None) - (self.along_border(region, end, start, every) is not None)
            line += path or [start]
            known = known and path is not None
        return line, along, known
