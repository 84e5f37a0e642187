"""Computes intersections of surfaces: places of vertices, and points along edges between two surfaces. Numpy only."""

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from .outlines import Chain
from .shapes import Array, Plane, Surface, Turned, circle_of, unit

_PARTS = 8  # parts of each edge of a polygon along a curve
_CUT = 0.1  # smaller singular values do not move a point: planes are nearly parallel, or surfaces touch
_TURNS = 25
_TOUCH = 0.5  # largest sine of the angle between surfaces that may touch along an edge, at the polygons
_TOUCHES = 0.06  # largest sine of that angle at the settled points
_AS_NEAR = 1.5  # a line or circle replaces points if its distance is at most this multiple of theirs
_NEAR = 0.4  # share of the mean step: a point of a curve nearer to the point before is left out
_FAR = 0.75  # share of the shortest edge at a vertex that it may move


@dataclass
class Curve:
    """Points along a chain; the edges of the solid run from break to break."""

    points: Array
    breaks: list[int]
    straight: bool
    sides: list[Surface]
    ids: dict[int, int] = field(default_factory=dict)  #: index of a point at a break -> vertex of the polygons


def touch(a: Surface, b: Surface, points: Array) -> bool:
    """Return whether two surfaces touch along points near both, instead of crossing."""
    if isinstance(a, Plane) and isinstance(b, Plane):
        return False
    sine = np.linalg.norm(np.cross(a.normal(points), b.normal(points)), axis=1)
    if float(np.median(sine)) > _TOUCH:
        return False
    there = settle(points, [a, b], [(a, b)])
    sine = np.linalg.norm(np.cross(a.normal(there), b.normal(there)), axis=1)
    return float(np.median(sine)) < _TOUCHES


def settle(points: Array, surfaces: list[Surface], touching: list[tuple[Surface, Surface]]) -> Array:
    """Return points moved to the intersection of all surfaces. The normals of touching surfaces agree there."""
    at = np.array(points, float)
    for _ in range(_TURNS):
        rows, away = [], []
        for surface in surfaces:
            rows.append(surface.normal(at))
            away.append(surface.distance(at))
        for a, b in touching:
            for row, far in _agreement(a, b, at):
                rows.append(row)
                away.append(far)
        j, r = np.stack(rows, axis=1), np.stack(away, axis=1)
        u, s, vt = np.linalg.svd(j, full_matrices=False)
        good = s > _CUT
        inverse = np.where(good, 1 / np.where(good, s, 1.0), 0.0)
        by = -np.einsum("nkj,nk,nik,ni->nj", vt, inverse, u, r)
        at += by
        if float(np.abs(by).max(initial=0.0)) < 1e-13 * (1 + float(np.abs(at).max(initial=0.0))):
            break
    return at


def _agreement(a: Surface, b: Surface, at: Array) -> list[tuple[Array, Array]]:
    """Return rows of the linear system for equal normals, scaled to lengths by the radius of curvature."""
    step = 1e-5 * (1 + float(np.abs(at).max(initial=0.0)))
    sign = np.sign((a.normal(at) * b.normal(at)).sum(axis=1))[:, None]

    def difference(p: Array) -> Array:
        return np.asarray(a.normal(p) - sign * b.normal(p))

    slopes = np.stack([(difference(at + step * e) - difference(at - step * e)) / 2 / step for e in np.eye(3)], axis=2)
    size = np.maximum(np.linalg.norm(slopes, axis=(1, 2)), 1e-12)[:, None]
    now = difference(at) / size
    return [(slopes[:, k] / size, now[:, k]) for k in range(3)]


def meet_at(place: Array, surfaces: list[Surface], touching: list[tuple[Surface, Surface]], reach: float) -> Array:
    """Return the place of a vertex: where all surfaces meet, else where round surfaces do, else the given place."""
    alone: list[Surface] = [s for s in surfaces if isinstance(s, Turned)]
    for some, both in ((surfaces, touching), (alone, [])):
        found = settle(place[None], some, both)[0] if some else place
        if float(np.linalg.norm(found - place)) <= _FAR * reach:
            return found
    return place


def along(chain: Chain, places: Array, ends: dict[int, Array], sides: list[Surface], flat: float) -> Curve:
    """Return the curve of a chain between two surfaces. flat: a corner nearer to a straight line is left out."""
    corners = places[chain.vertices]
    round_sides = [side for side in sides if isinstance(side, Turned)]
    if not round_sides:
        points = settle(corners, sides, []) if sides else corners.copy()
        reach = np.linalg.norm(np.diff(corners, axis=0), axis=1)
        near = np.minimum(np.append(reach, reach[-1]), np.insert(reach, 0, reach[0]))
        stays = np.linalg.norm(points - corners, axis=1) > _FAR * near
        points[stays] = corners[stays]
        return _straight(chain, points, ends, sides, flat)
    if len(sides) == 1:  # an open border
        fine = _finer(settle(corners, sides, []))
        curve = Curve(settle(fine, sides, []), list(range(0, len(fine), _PARTS)), False, sides)
        _pin(curve, chain, ends)
        return curve
    touching = [(sides[0], sides[1])] if touch(sides[0], sides[1], corners) else []
    points = _spread(settle(_finer(corners), sides, touching))
    if touching:
        points = _smooth(points, sides, chain.closed)
    curve = Curve(points, [0, len(points) - 1], False, sides)
    _pin(curve, chain, ends)
    return curve


def _finer(corners: Array) -> Array:
    share = np.arange(_PARTS)[:, None] / _PARTS
    parts = [a + share * (b - a) for a, b in pairwise(corners)]
    return np.concatenate([*parts, corners[-1:]])


def _smooth(points: Array, sides: list[Surface], closed: bool) -> Array:
    """Return points on a line or a circle if they are about as near to both surfaces, since settled points scatter."""
    near = _AS_NEAR * max(float(np.abs(s.distance(points)).max()) for s in sides)
    for made in (None if closed else _on_line(points), _on_circle(points)):
        if made is not None and max(float(np.abs(s.distance(made)).max()) for s in sides) <= near:
            return made
    return points


def _on_line(points: Array) -> Array:
    middle = points.mean(axis=0)
    way = np.linalg.svd(points - middle, full_matrices=False)[2][0]
    t = (points - middle) @ way
    return np.asarray(middle + np.linspace(t[0], t[-1], len(points))[:, None] * way)


def _on_circle(points: Array) -> Array | None:
    found = circle_of(points)
    if found is None:
        return None
    centre, normal, radius = found
    x = unit((points[0] - centre) - (points[0] - centre) @ normal * normal)
    y = np.cross(normal, x)
    angle = np.unwrap(np.arctan2((points - centre) @ y, (points - centre) @ x))
    angle = np.linspace(angle[0], angle[-1], len(points))
    return np.asarray(centre + radius * (np.cos(angle)[:, None] * x + np.sin(angle)[:, None] * y))


def _spread(points: Array) -> Array:
    """Return the points without points too near to the one before."""
    least = _NEAR * float(np.linalg.norm(np.diff(points, axis=0), axis=1).mean())
    kept = [0]
    for k in range(1, len(points) - 1):
        if min(float(np.linalg.norm(points[k] - points[j])) for j in (kept[-1], len(points) - 1)) >= least:
            kept.append(k)
    return points[[*kept, len(points) - 1]]


def _pin(curve: Curve, chain: Chain, ends: dict[int, Array]) -> None:
    """Move the ends to the places of their vertices; the shift decreases along the curve."""
    if chain.closed:
        curve.points[-1] = curve.points[0]
        curve.ids = {0: chain.vertices[0], len(curve.points) - 1: chain.vertices[0]}
        return
    steps = np.linalg.norm(np.diff(curve.points, axis=0), axis=1)
    share = np.concatenate([[0.0], np.cumsum(steps)]) / max(float(steps.sum()), 1e-300)
    first, last = ends[chain.vertices[0]], ends[chain.vertices[-1]]
    by_first, by_last = first - curve.points[0], last - curve.points[-1]
    curve.points += (1 - share)[:, None] * by_first + share[:, None] * by_last
    curve.points = curve.points if len(curve.points) < 3 else _again(curve)
    curve.points[0], curve.points[-1] = first, last
    curve.ids = {0: chain.vertices[0], len(curve.points) - 1: chain.vertices[-1]}


def _again(curve: Curve) -> Array:
    if len(curve.sides) < 2:
        return settle(curve.points, curve.sides, [])
    one, two = (side.normal(curve.points) for side in curve.sides)
    crossing = np.linalg.norm(np.cross(one, two), axis=1)
    sure = crossing > 3 * _CUT
    points = curve.points.copy()
    if sure.any():
        points[sure] = settle(points[sure], curve.sides, [])
    return points


def _straight(chain: Chain, points: Array, ends: dict[int, Array], sides: list[Surface], flat: float) -> Curve:
    if not chain.closed:
        points[0], points[-1] = ends[chain.vertices[0]], ends[chain.vertices[-1]]
        kept = _needed(points, 0, len(points) - 1, flat)
    else:
        points[-1] = points[0]
        third = len(points) // 3
        marks = sorted({0, third, 2 * third, len(points) - 1})
        kept = sorted({k for a, b in pairwise(marks) for k in _needed(points, a, b, flat)})
    ids = {k: chain.vertices[i] for k, i in enumerate(kept)}
    return Curve(points[kept], list(range(len(kept))), True, sides, ids)


def _needed(points: Array, first: int, last: int, flat: float) -> list[int]:
    """Return the corners of a simplified polyline, by Douglas and Peucker."""
    found, todo = {first, last}, [(first, last)]
    while todo:
        a, b = todo.pop()
        if b - a < 2:
            continue
        way = points[b] - points[a]
        length = float(np.linalg.norm(way))
        between = points[a + 1 : b] - points[a]
        share = np.clip(between @ way / max(length**2, 1e-300), 0, 1)
        far = np.linalg.norm(between - share[:, None] * way, axis=1)
        k = int(far.argmax())
        if far[k] > flat:
            found.add(a + 1 + k)
            todo += [(a, a + 1 + k), (a + 1 + k, b)]
    return sorted(found)
