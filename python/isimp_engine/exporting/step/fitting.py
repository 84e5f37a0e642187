"""Fits the surfaces of faces to the scan: planes and round parts. Numpy only."""

from dataclasses import replace
from typing import Any

import numpy as np

from .shapes import Array, Cone, Cylinder, Plane, Sphere, Spun, Torus, Turned, basis, square_to, unit

_KNOTS = (4, 6, 8, 12, 16, 24, 32)  # numbers of intervals of a profile to try
_GOOD = 1.1  # a profile with fewer intervals may be further from the scan by this factor
_STIFF = 1e-4  # weight of the second differences of a profile
_BEYOND = 0.06  # share of the length of a profile that is added at its ends
_BINS = 200  # number of bins along a profile
_ONE = 3e-4  # share of the size of two parts: with a smaller deviation they are one surface
_ONE_AXIS = float(np.cos(np.radians(3)))  # parts whose axes differ by more are two surfaces
_TURNS = 8  # iterations of a fit


def plane_of(points: Array, normal: Array) -> Plane:
    """Return the plane of least squares, with a normal on the side of the given one."""
    middle = points.mean(axis=0)
    if len(points) < 3:
        return Plane(middle, unit(normal))
    found = np.linalg.svd(points - middle, full_matrices=False)[2][2]
    return Plane(middle, found if found @ normal >= 0 else -found)


def round_of(patch: Any, points: Array, shift: Array, open_ends: list[float]) -> Turned | str:
    """Return the surface of a round part, or the reason why there is none.

    patch: a CurvedProxy. points: points of the scan on it. open_ends: places along the axis of the borders that enclose
    it. A revolution with fewer than two of them ends on its axis.
    """
    point, axis = np.asarray(patch["point"]) - shift, unit(np.asarray(patch["axis"], float))
    x, radius = square_to(axis), float(patch["radius"])
    if patch["kind"] == "cylinder":
        return Cylinder(point, axis, x, radius)
    if patch["kind"] == "sphere":
        return Sphere(point, axis, x, radius)
    if patch["kind"] == "cone":
        slope = float(patch["slope"])
        if slope == 0:
            return Cylinder(point, axis, x, radius)
        return Cone(point, axis if slope > 0 else -axis, x, radius, abs(slope))
    if patch["kind"] == "extrusion":
        return "it is an extrusion"
    profile = np.asarray(patch["profile"], float).reshape(-1, 2)
    start = Turned(point, axis, x)
    if len(points) < 12:
        points = _on_circles(start, profile)
    torus = _torus(start, points)
    if torus is not None and torus.small < 0.95 * torus.large:
        spun = None if _is_ring(profile) else _spun(start, points, profile, open_ends)
        if spun is None or rms(torus, points) <= 1.15 * rms(spun, points):
            return torus
        return spun
    if _is_ring(profile):
        return "its profile is a ring other than a circle"
    return _spun(start, points, profile, open_ends)


def rms(surface: Any, points: Array) -> float:
    """Return the deviation of points from a surface, without the furthest twentieth."""
    far = np.sort(np.abs(surface.distance(points)))
    far = far[: max(1, int(0.95 * len(far)))]
    return float(np.sqrt((far**2).mean()))


def joined(
    a: Turned, b: Turned, points_a: Array, points_b: Array, ends_a: list[float], ends_b: list[float]
) -> tuple[Turned, list[float]] | None:
    """Return one surface for two parts, and its open ends; None if they belong to different surfaces.

    ends_a, ends_b: open ends, see `round_of`.
    """
    if type(a) is not type(b):
        return None
    every, ends = np.concatenate([points_a, points_b]), []
    if isinstance(a, Spun) and isinstance(b, Spun):
        if abs(float(a.axis @ b.axis)) < _ONE_AXIS:
            return None
        ends = _ends_of_both(a, b, ends_a, ends_b)
        best: Turned = _spun(a, every, _profile_of_both(a, b, points_a, points_b), ends)
    else:
        best = _refined(a if len(points_a) >= len(points_b) else b, every)
    own = max(rms(a, points_a), rms(b, points_b))
    far = max(rms(best, points_a), rms(best, points_b))
    size = float(np.linalg.norm(np.ptp(every, axis=0)))
    return (best, ends) if far <= max(1.2 * own, _ONE * size) else None


def _ends_of_both(a: Spun, b: Spun, ends_a: list[float], ends_b: list[float]) -> list[float]:
    """Return the open ends along the axis of `a`, without the common end of both parts."""
    sign, shift = float(np.sign(a.axis @ b.axis)), float((b.point - a.point) @ a.axis)
    other = [sign * z + shift for z in ends_b]
    if not ends_a or not other:
        return [*ends_a, *other]
    k, m = min(
        ((k, m) for k in range(len(ends_a)) for m in range(len(other))), key=lambda p: abs(ends_a[p[0]] - other[p[1]])
    )
    return [*ends_a[:k], *ends_a[k + 1 :], *other[:m], *other[m + 1 :]]


def _profile_of_both(a: Spun, b: Spun, points_a: Array, points_b: Array) -> Array:
    """Return both profiles as one, in the half plane of `a`."""
    sign, shift = float(np.sign(a.axis @ b.axis)), float((b.point - a.point) @ a.axis)
    parts = []
    for spun, points in ((a, points_a), (b, points_b)):
        t = spun.along(points)
        parts.append(spun.at(np.linspace(float(np.quantile(t, 0.01)), float(np.quantile(t, 0.99)), 60)))
    one, two = parts[0], parts[1] * [1.0, sign] + [0.0, shift]
    ways = [(one[::m], two[::n]) for m in (1, -1) for n in (1, -1)]
    one, two = min(ways, key=lambda pair: float(np.linalg.norm(pair[0][-1] - pair[1][0])))
    beyond = (two - one[-1]) @ (one[-1] - one[-2]) > 0  # the first profile is used where both overlap
    first = int(beyond.argmax()) if beyond.any() else 0
    return np.concatenate([one, two[first:]])


def _is_ring(profile: Array) -> bool:
    steps = np.linalg.norm(np.diff(profile, axis=0), axis=1)
    return len(profile) > 8 and float(np.linalg.norm(profile[0] - profile[-1])) <= 3 * float(np.median(steps))


def _on_circles(start: Turned, profile: Array) -> Array:
    angle = np.arange(12) * np.pi / 6
    out = np.cos(angle)[:, None] * start.x + np.sin(angle)[:, None] * start.y
    places = start.point + profile[:, None, :1] * out[None] + profile[:, None, 1:] * start.axis
    return places.reshape(-1, 3)


def _torus(start: Turned, points: Array) -> Torus | None:
    rho, z, _ = start.polar(points)
    solved = np.linalg.lstsq(np.stack([2 * rho, 2 * z, np.ones_like(z)], 1), rho**2 + z**2, rcond=None)[0]
    small = solved[2] + solved[0] ** 2 + solved[1] ** 2
    if not small > 0 or not solved[0] > 0:
        return None
    first = Torus(start.point + solved[1] * start.axis, start.axis, start.x, float(solved[0]), float(np.sqrt(small)))
    found = _refined(first, points)
    return found if isinstance(found, Torus) and found.small > 0 and found.large > 0 else None


def _refined(surface: Any, points: Array) -> Any:
    """Return the surface of the same kind with the least squares of distances; distant points have lower weights."""
    if len(points) > 20000:
        points = points[:: len(points) // 20000 + 1]
    lengths = [name for name in ("radius", "slope", "large", "small") if hasattr(surface, name)]
    size = float(np.linalg.norm(np.ptp(points, axis=0)))

    def moved(base: Any, by: Array) -> Any:
        x, y = base.x, base.y
        axis = unit(base.axis + (by[3] * x + by[4] * y) / size)
        values = {name: getattr(base, name) + by[5 + k] for k, name in enumerate(lengths)}
        return replace(base, point=base.point + by[:3], axis=axis, x=unit(x - (x @ axis) * axis), **values)

    count, step = 5 + len(lengths), 1e-6 * size
    for _ in range(_TURNS):
        far = surface.distance(points)
        width = 2.5 * max(float(np.median(np.abs(far))) * 1.4826, 1e-12 * size)
        weight = np.minimum(1.0, width / np.maximum(np.abs(far), _least(size)))
        slopes = np.stack(
            [
                (moved(surface, step * one).distance(points) - moved(surface, -step * one).distance(points)) / 2 / step
                for one in np.eye(count)
            ],
            axis=1,
        )
        root = np.sqrt(weight)
        by = np.linalg.lstsq(slopes * root[:, None], -far * root, rcond=1e-6)[0]
        surface = moved(surface, by)
        if float(np.abs(by).max()) < 1e-10 * size:
            break
    return surface


def _least(size: float) -> float:
    return 1e-15 * size


def _spun(start: Turned, points: Array, profile: Array, open_ends: list[float]) -> Spun:
    rho, z, _ = start.polar(points)
    t, corners = _along(profile, rho, z)
    low, high = float(min(t.min(), 0.0)), float(max(t.max(), corners[-1]))
    at_axis = _pole_ends(profile, corners, open_ends, low, high)
    t, rho, z = _means(t, rho, z, low, high)
    margin, place = _BEYOND * (high - low), np.stack([rho, z], axis=1)
    for _ in range(3):  # each round updates the parameters of the points along the profile
        first, last, tt, rr = float(t.min()) - margin, float(t.max()) + margin, t, place
        if at_axis[0]:
            tt, rr, pole = _mirrored(tt, rr, True)
            first = pole - margin
        if at_axis[1]:
            tt, rr, pole = _mirrored(tt, rr, False)
            last = pole + margin
        found = _best(start, tt, rr, first, last)
        t = found.nearest(place[:, 0], place[:, 1])
    roots = [_root(found, at_low) if is_on else None for at_low, is_on in zip((True, False), at_axis, strict=True)]
    return replace(found, low=roots[0], high=roots[1])


def _along(profile: Array, rho: Array, z: Array) -> tuple[Array, Array]:
    """Return the arc lengths of points and of corners along a profile. Its end edges extend beyond its ends."""
    edges = np.diff(profile, axis=0)
    size = np.linalg.norm(edges, axis=1)
    corners = np.concatenate([[0.0], np.cumsum(size)])
    best, found = np.full(len(rho), np.inf), np.zeros(len(rho))
    for k in np.flatnonzero(size > 0).tolist():
        way = edges[k] / size[k]
        s = (rho - profile[k, 0]) * way[0] + (z - profile[k, 1]) * way[1]
        s = np.clip(s, -np.inf if k == 0 else 0.0, np.inf if k == len(size) - 1 else size[k])
        far = np.hypot(profile[k, 0] + s * way[0] - rho, profile[k, 1] + s * way[1] - z)
        nearer = far < best
        best[nearer], found[nearer] = far[nearer], corners[k] + s[nearer]
    return found, corners


def _pole_ends(profile: Array, corners: Array, open_ends: list[float], low: float, high: float) -> list[bool]:
    """Return for both ends of the profile whether it is on the axis: an end without an enclosing border."""
    most = float(profile[:, 0].max())
    near = [profile[0, 0] < 0.45 * most, profile[-1, 0] < 0.45 * most]
    if len(open_ends) >= 2:
        return [False, False]
    if not open_ends:
        return [bool(n) for n in near]
    place = float(corners[int(np.abs(profile[:, 1] - open_ends[0]).argmin())])
    at_low = abs(place - low) > abs(place - high)  # the border is at the other end
    return [bool(at_low and near[0]), bool(not at_low and near[1])]


def _means(t: Array, rho: Array, z: Array, low: float, high: float) -> tuple[Array, Array, Array]:
    """Return the medians of the points in bins along the profile, or the points themselves if they are few."""
    if len(t) <= 2 * _BINS:
        order = np.argsort(t, kind="stable")
        return t[order], rho[order], z[order]
    place = np.clip(((t - low) / (high - low) * _BINS).astype(int), 0, _BINS - 1)
    rows = []
    for k in range(_BINS):
        mine = np.flatnonzero(place == k)
        if len(mine) >= 3:
            rows.append([np.median(t[mine]), np.median(rho[mine]), np.median(z[mine])])
    table = np.array(rows)
    return table[:, 0], table[:, 1], table[:, 2]


def _mirrored(t: Array, place: Array, at_low: bool) -> tuple[Array, Array, float]:
    """Return the points with their mirror images beyond the axis, so that the profile crosses it at right angles."""
    order = np.argsort(t, kind="stable")
    t, place = t[order], place[order]
    end = 0 if at_low else -1
    pole = float(t[end]) - float(place[end, 0]) if at_low else float(t[end]) + float(place[end, 0])
    return np.concatenate([t, 2 * pole - t]), np.concatenate([place, place * [-1.0, 1.0]]), pole


def _best(start: Turned, t: Array, place: Array, first: float, last: float) -> Spun:
    inside = (t >= first) & (t <= last)
    t, place = t[inside], place[inside]
    tried = []
    for knots in _KNOTS:
        step = (last - first) / knots
        rows = basis(t, first, step, knots + 3)
        stiff = np.diff(np.eye(knots + 3), 2, axis=0) * np.sqrt(_STIFF * len(t) / knots)
        poles = np.linalg.lstsq(np.vstack([rows, stiff]), np.vstack([place, np.zeros((len(stiff), 2))]), rcond=None)[0]
        spun = Spun(start.point, start.axis, start.x, poles, first, step, last)
        far = np.linalg.norm(rows @ poles - place, axis=1)
        tried.append((float(np.sqrt((far**2).mean())), spun))
    least = min(far for far, _ in tried)
    return next(spun for far, spun in tried if far <= _GOOD * least + 1e-12)


def _root(spun: Spun, at_low: bool) -> float | None:
    """Return the parameter where the profile crosses the axis near an end; None if it does not."""
    t = np.linspace(spun.first, spun.last, 4001)
    rho = spun.at(t)[:, 0]
    cross = np.flatnonzero((rho[:-1] < 0) != (rho[1:] < 0))
    if not len(cross):
        return None
    k = int(cross[0] if at_low else cross[-1])
    a, b = float(t[k]), float(t[k + 1])
    for _ in range(60):
        middle = (a + b) / 2
        if (spun.at(np.array([middle]))[0, 0] < 0) == (spun.at(np.array([a]))[0, 0] < 0):
            a = middle
        else:
            b = middle
    return (a + b) / 2
