"""Chooses the seam of each round surface, and adds the vertices where borders cross it. Numpy only."""

from dataclasses import replace

import numpy as np

from .meeting import Curve, settle
from .shapes import Array, Plane, Sphere, Surface, Torus, Turned, square_to, unit

_WAYS = 72  # directions to try for a seam
_ROUND = 2 * np.pi
Loop = list[tuple[int, bool]]


def ring(loop: Loop, curves: list[Curve]) -> Array:
    """Return the points of a loop in its direction; the last equals the first."""
    parts = [curves[k].points if forward else curves[k].points[::-1] for k, forward in loop]
    return np.concatenate([parts[0][:1], *(part[1:] for part in parts)])


def turns_of(shape: Turned, points: Array) -> int:
    """Return the winding number of a ring of points about the axis."""
    return int(np.rint(np.diff(np.unwrap(shape.angle(points)))[...].sum() / _ROUND))


def framed(shape: Turned, loops: list[Loop], curves: list[Curve], middle: Array) -> Turned:
    """Return the surface with its seam, or the origin of its angles, in a suitable place.

    middle: a point in the middle of the face.
    """
    rings = [ring(loop, curves) for loop in loops]
    if isinstance(shape, Sphere):
        shape = _sphere(shape, rings, middle)
    around = [points for points in rings if turns_of(shape, points)]
    if around or not rings:
        return shape.turned(_free_way(shape, around, [p for p in rings if not turns_of(shape, p)]))
    out = shape.polar(middle[None])[2][0]
    return shape.turned(-out)


def _sphere(shape: Sphere, rings: list[Array], middle: Array) -> Sphere:
    """Return the sphere with poles and seam outside a part below half a sphere; else with a pole in a hole."""
    if not rings:
        return shape
    out = unit(middle - shape.point)
    every = np.concatenate(rings) - shape.point
    if float((every @ out).min()) > 0.17 * shape.radius:
        axis = square_to(out)
        return replace(shape, axis=axis, x=-out)
    largest = max(rings, key=lambda p: float(np.linalg.norm(np.ptp(p, axis=0))))
    axis = unit(_area(largest))
    return replace(shape, axis=axis, x=square_to(axis))


def _area(p: Array) -> Array:
    away = p - p.mean(axis=0)
    return np.asarray(np.cross(away[:-1], away[1:]).sum(axis=0))


def _free_way(shape: Turned, around: list[Array], holes: list[Array]) -> Array:
    """Return the direction of the seam: away from holes, and such that each border crosses it once."""
    ways = (np.arange(_WAYS) + 0.5) * _ROUND / _WAYS
    score = np.zeros(_WAYS)
    for points in [*around, *holes]:
        angle = np.unwrap(shape.angle(points))
        for k, way in enumerate(ways):
            level = np.floor((angle - way) / _ROUND)
            crossings = int((np.diff(level) != 0).sum())
            score[k] -= 10 * (crossings - (1 if any(points is p for p in around) else 0))
    for points in holes:
        angle = shape.angle(points)
        for k, way in enumerate(ways):
            score[k] += float(np.abs(np.angle(np.exp(1j * (angle - way)))).min())
    way = ways[int(score.argmax())]
    return np.asarray(np.cos(way) * shape.x + np.sin(way) * shape.y)


def cut(shape: Turned, loops: list[Loop], curves: list[Curve], exact: float) -> None:
    """Add vertices where borders that enclose a surface cross its seam."""
    for loop in loops:
        points = ring(loop, curves)
        if turns_of(shape, points):
            seam: Surface = Plane(shape.point, shape.y)
            angle = shape.angle
        elif isinstance(shape, Torus) and _turns_v(shape, points):
            # The seam is the largest circle.
            seam = Plane(shape.point, shape.axis)
            angle = shape.along
        else:
            continue
        for k in {number for number, _ in loop}:
            _cut(curves[k], angle, seam, exact)


def _turns_v(shape: Torus, points: Array) -> int:
    return int(np.rint(np.diff(np.unwrap(shape.along(points))).sum() / _ROUND))


def _cut(curve: Curve, angle: object, seam: Surface, exact: float) -> None:
    values = angle(curve.points)  # type: ignore[operator]
    step = np.diff(values)
    at = np.flatnonzero((np.abs(step) < np.pi) & ((values[:-1] < 0) != (values[1:] < 0)))
    for k in at[::-1].tolist():
        share = values[k] / (values[k] - values[k + 1])
        place = curve.points[k] + share * (curve.points[k + 1] - curve.points[k])
        place = settle(place[None], [*curve.sides, seam], [])[0]
        _insert(curve, k, place, exact)


def _insert(curve: Curve, k: int, place: Array, exact: float) -> None:
    """Insert a break between the points k and k + 1, or at one of them if it is very near."""
    for near in (k, k + 1):
        if float(np.linalg.norm(curve.points[near] - place)) <= exact:
            if near not in curve.breaks:
                curve.points[near] = place
                curve.breaks = sorted([*curve.breaks, near])
            _begin_at(curve, near)
            return
    curve.points = np.insert(curve.points, k + 1, place, axis=0)
    curve.breaks = sorted([b + (b > k) for b in curve.breaks] + [k + 1])
    curve.ids = {i + (i > k): v for i, v in curve.ids.items()}
    _begin_at(curve, k + 1)


def _begin_at(curve: Curve, k: int) -> None:
    """Rotate a closed curve without other breaks to begin at this break, so that it needs no other vertex."""
    closed = np.array_equal(curve.points[0], curve.points[-1])
    if (
        not closed
        or curve.straight
        or curve.breaks != sorted({0, k, len(curve.points) - 1})
        or k in (0, curve.breaks[-1])
    ):
        return
    if not curve.ids:
        return  # it was rotated already, for the surface at its other side
    curve.points = np.concatenate([curve.points[k:], curve.points[1 : k + 1]])
    curve.breaks, curve.ids = [0, len(curve.points) - 1], {}
