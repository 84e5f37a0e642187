"""Polygons of several parts of a scan as one mesh: they share the vertices of common chains."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .borders import found_in


class Part(NamedTuple):
    """The polygons of a part."""

    vertices: NDArray[np.float64]  #: (W, 3)
    home: NDArray[np.float64]  #: (W, 3) places of the scan's vertices that they stand for
    keys: NDArray[np.uint64]  #: (W,) names of these
    loops: NDArray[np.int32]  #: (L,) vertices, polygon after polygon
    sizes: NDArray[np.int32]  #: (Q,) of each polygon
    region: NDArray[np.int32]  #: (Q,)
    vector_area: NDArray[np.float64]  #: (Q, 3) of the piece of surface that each stands for
    moments: NDArray[np.float64]  #: (Q, 10)


class Added(NamedTuple):
    """Vertices inside chords of a part, in order along each, that the last part may make corners."""

    key: NDArray[np.uint64]  #: (N,) names of their places
    polygon: NDArray[np.int64]  #: (N,) whose chord it is
    after: NDArray[np.int64]  #: (N,) the corner at which the chord begins


class Joined(NamedTuple):
    """The polygons of all parts, by region."""

    vertices: NDArray[np.float64]  #: (W, 3)
    home: NDArray[np.float64]  #: (W, 3)
    loops: NDArray[np.int32]  #: (L,)
    starts: NDArray[np.int32]  #: (Q,)
    region: NDArray[np.int32]  #: (Q,)
    vector_area: NDArray[np.float64]  #: (Q, 3)
    moments: NDArray[np.float64]  #: (Q, 10)
    part: NDArray[np.int32]  #: (Q,) the part of each polygon
    polygon: NDArray[np.int32]  #: (Q,) its number in that part


def joined(parts: list[Part], added: list[Added], chain: NDArray[np.uint64], place: NDArray[np.float64]) -> Joined:
    """The polygons of all parts as one mesh.

    added: of all parts but the last, where there is one more. chain: (N,) names of the scan's places whose vertices the
    parts share, rising; place: (N, 3) where these vertices are.
    """
    first = np.cumsum([0] + [len(part.vertices) for part in parts])
    vertices, home, keys = (np.concatenate([part[k] for part in parts]) for k in range(3))
    at, known = found_in(chain, keys)
    number = np.where(known, at, len(chain) + np.arange(len(keys)))
    loops = np.concatenate([number[part.loops + o] for part, o in zip(parts, first, strict=False)])
    sizes = np.concatenate([part.sizes for part in parts])
    if len(parts) > len(added):
        loops, sizes = _with_added(loops, sizes, parts, added, chain)
    places, homes = np.concatenate([place, vertices]), np.empty((len(chain) + len(keys), 3))
    homes[number[::-1]] = home[::-1]
    region, areas, moments = (np.concatenate([part[k] for part in parts]) for k in range(5, 8))
    of = np.repeat(np.arange(len(parts), dtype=np.int32), [len(part.sizes) for part in parts])
    polygon = np.concatenate([np.arange(len(part.sizes), dtype=np.int32) for part in parts])
    order = np.argsort(region, kind="stable")
    begin, size = (np.cumsum(sizes) - sizes)[order], sizes[order]
    starts = np.cumsum(size) - size
    used, corner = np.unique(loops[np.repeat(begin - starts, size) + np.arange(len(loops))], return_inverse=True)
    return Joined(
        places[used],
        homes[used],
        corner.astype(np.int32),
        starts.astype(np.int32),
        region[order],
        areas[order],
        moments[order],
        of[order],
        polygon[order],
    )


def _with_added(
    loops: NDArray[np.int64],
    sizes: NDArray[np.int32],
    parts: list[Part],
    added: list[Added],
    chain: NDArray[np.uint64],
) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """The loops with the vertices inside chords that are corners of the last part."""
    first = np.cumsum([0] + [len(part.sizes) for part in parts])
    key, after = (np.concatenate([each[k] for each in added]) for k in (0, 2))
    polygon = np.concatenate([each.polygon + o for each, o in zip(added, first, strict=False)])
    chosen = np.isin(key, parts[-1].keys)
    key, polygon, after = key[chosen], polygon[chosen], after[chosen]
    begin = np.cumsum(sizes) - sizes
    longer = np.insert(loops, begin[polygon] + after + 1, found_in(chain, key)[0])
    return longer, sizes + np.bincount(polygon, minlength=len(sizes)).astype(np.int32)
