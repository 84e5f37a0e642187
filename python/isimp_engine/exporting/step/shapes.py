"""Surfaces of faces: distance and normal of points, and OpenCASCADE's parameters. Numpy only."""

from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_TINY = 1e-300
T = TypeVar("T", bound="Turned")


def unit(v: Array) -> Array:
    return np.asarray(v / max(float(np.linalg.norm(v)), _TINY))


def square_to(axis: Array) -> Array:
    """Return a unit vector at right angles to another."""
    return unit(np.cross(axis, np.eye(3)[int(np.abs(axis).argmin())]))


@dataclass(frozen=True)
class Plane:
    """A plane by a point on it and its unit normal."""

    point: Array
    normal_: Array

    def distance(self, p: Array) -> Array:
        return np.asarray((p - self.point) @ self.normal_)

    def normal(self, p: Array) -> Array:
        return np.broadcast_to(self.normal_, p.shape)


@dataclass(frozen=True)
class Turned:
    """A surface about an axis, with parameters u, the angle from `x`, and v, along the profile. They set the normal."""

    point: Array
    axis: Array
    x: Array

    kind = ""

    @property
    def y(self) -> Array:
        return np.cross(self.axis, self.x)

    def polar(self, p: Array) -> tuple[Array, Array, Array]:
        """Return distances from the axis, places along it, and unit vectors away from it."""
        away = p - self.point
        z = away @ self.axis
        flat = away - z[:, None] * self.axis
        rho = np.linalg.norm(flat, axis=1)
        return rho, z, flat / np.maximum(rho, _TINY)[:, None]

    def angle(self, p: Array) -> Array:
        away = p - self.point
        return np.arctan2(away @ self.y, away @ self.x)

    def turned(self: T, x: Array) -> T:
        """Return the same surface with angles measured from another direction."""
        return replace(self, x=unit(x - (x @ self.axis) * self.axis))

    def split(self, rho: Array, z: Array) -> tuple[Array, Array, Array]:
        """Return the signed distance, and the components of the normal away from the axis and along it."""
        raise NotImplementedError

    def along(self, p: Array) -> Array:
        """Return the parameter v."""
        raise NotImplementedError

    def distance(self, p: Array) -> Array:
        rho, z, _ = self.polar(p)
        return self.split(rho, z)[0]

    def normal(self, p: Array) -> Array:
        rho, z, out = self.polar(p)
        _, away, up = self.split(rho, z)
        return np.asarray(away[:, None] * out + up[:, None] * self.axis)

    def poles(self) -> tuple[float | None, float | None]:
        """Return the least and the largest v where the surface meets its axis; None for an end that doesn't."""
        return None, None


@dataclass(frozen=True)
class Cylinder(Turned):
    """A cylinder."""

    radius: float

    kind = "cylinder"

    def split(self, rho: Array, z: Array) -> tuple[Array, Array, Array]:
        return rho - self.radius, np.ones_like(rho), np.zeros_like(rho)

    def along(self, p: Array) -> Array:
        return self.polar(p)[1]


@dataclass(frozen=True)
class Cone(Turned):
    """A cone: `radius` at its point, growing by `slope` > 0 along the axis."""

    radius: float
    slope: float

    kind = "cone"

    def split(self, rho: Array, z: Array) -> tuple[Array, Array, Array]:
        size = np.hypot(1.0, self.slope)
        one = np.ones_like(rho) / size
        return (rho - self.radius - self.slope * z) / size, one, -self.slope * one

    def along(self, p: Array) -> Array:
        return np.asarray(self.polar(p)[1] * np.hypot(1.0, self.slope))

    def poles(self) -> tuple[float | None, float | None]:
        return -self.radius / self.slope * float(np.hypot(1.0, self.slope)), None


def _from_circle(x: Array, z: Array, radius: float) -> tuple[Array, Array, Array]:
    """The distances of points from a circle around the origin, and the components of its normals there."""
    far = np.maximum(np.hypot(x, z), _TINY)
    return far - radius, x / far, z / far


@dataclass(frozen=True)
class Sphere(Turned):
    """A sphere; its axis is free."""

    radius: float

    kind = "sphere"

    def split(self, rho: Array, z: Array) -> tuple[Array, Array, Array]:
        return _from_circle(rho, z, self.radius)

    def along(self, p: Array) -> Array:
        rho, z, _ = self.polar(p)
        return np.arctan2(z, rho)

    def poles(self) -> tuple[float | None, float | None]:
        return -np.pi / 2, np.pi / 2


@dataclass(frozen=True)
class Torus(Turned):
    """A torus: `small` is the radius of its tube, `large` the radius of the tube's middle circle."""

    large: float
    small: float

    kind = "torus"

    def split(self, rho: Array, z: Array) -> tuple[Array, Array, Array]:
        return _from_circle(rho - self.large, z, self.small)

    def along(self, p: Array) -> Array:
        rho, z, _ = self.polar(p)
        return np.arctan2(z, rho - self.large)


@dataclass(frozen=True)
class Spun(Turned):
    """A smooth profile turned about the axis: a uniform cubic B-spline in (rho, z) over [first, last]."""

    poles_: Array  #: (n, 2)
    first: float
    step: float
    last: float
    low: float | None = None  #: the parameter where the profile begins on the axis
    high: float | None = None

    kind = "revolution"

    def at(self, t: Array, order: int = 0) -> Array:
        """Return (n, 2) points of the profile, or their derivatives."""
        return np.asarray(basis(t, self.first, self.step, len(self.poles_), order) @ self.poles_)

    def nearest(self, rho: Array, z: Array) -> Array:
        t = np.linspace(self.first, self.last, 40 * (len(self.poles_) - 3) + 1)
        table = self.at(t)
        best = np.empty(len(rho))
        for k in range(0, len(rho), 4096):  # a table of all at once would be large
            some = np.stack([rho[k : k + 4096], z[k : k + 4096]], axis=1)
            best[k : k + 4096] = t[((some[:, None] - table[None]) ** 2).sum(axis=2).argmin(axis=1)]
        place = np.stack([rho, z], axis=1)
        for _ in range(4):
            away, d1, d2 = self.at(best) - place, self.at(best, 1), self.at(best, 2)
            bend = (d1 * d1).sum(axis=1) + (away * d2).sum(axis=1)
            slope = (d1 * d1).sum(axis=1)
            best = best - (away * d1).sum(axis=1) / np.where(bend > 0.1 * slope, bend, np.maximum(slope, _TINY))
            best = np.clip(best, self.first, self.last)
        return best

    def split(self, rho: Array, z: Array) -> tuple[Array, Array, Array]:
        t = self.nearest(rho, z)
        d1 = self.at(t, 1)
        d1 /= np.maximum(np.linalg.norm(d1, axis=1), _TINY)[:, None]
        away = np.stack([rho, z], axis=1) - self.at(t)
        return away[:, 0] * d1[:, 1] - away[:, 1] * d1[:, 0], d1[:, 1], -d1[:, 0]

    def along(self, p: Array) -> Array:
        rho, z, _ = self.polar(p)
        return self.nearest(rho, z)

    def poles(self) -> tuple[float | None, float | None]:
        return self.low, self.high


Surface = Plane | Turned


def basis(t: Array, first: float, step: float, count: int, order: int = 0) -> Array:
    """Return (n, count) values of the basis of a uniform cubic B-spline, or of its derivatives."""
    s = (np.asarray(t) - first) / step
    k = np.clip(np.floor(s).astype(int), 0, count - 4)
    s = s - k
    if order == 0:
        parts = (1 - s) ** 3, 3 * s**3 - 6 * s**2 + 4, -3 * s**3 + 3 * s**2 + 3 * s + 1, s**3
    elif order == 1:
        parts = -3 * (1 - s) ** 2, 9 * s**2 - 12 * s, -9 * s**2 + 6 * s + 3, 3 * s**2
    else:
        parts = 6 * (1 - s), 18 * s - 12, -18 * s + 6, 6 * s
    out = np.zeros((len(s), count))
    for j, part in enumerate(parts):
        out[np.arange(len(s)), k + j] = part / 6 / step**order
    return out


def circle_of(points: Array) -> tuple[Array, Array, float] | None:
    """Return centre, unit normal and radius of the circle of least squares; None for points on a line."""
    own = points[:-1] if np.array_equal(points[0], points[-1]) else points
    if len(own) < 3:
        return None
    middle = own.mean(axis=0)
    away = own - middle
    _, size, axes = np.linalg.svd(away, full_matrices=False)
    if len(size) < 3 or size[1] < 1e-7 * size[0]:
        return None
    p = away @ axes[:2].T
    solved = np.linalg.lstsq(np.column_stack([2 * p, np.ones(len(p))]), (p**2).sum(axis=1), rcond=None)[0]
    square = solved[2] + solved[0] ** 2 + solved[1] ** 2
    return (middle + solved[:2] @ axes[:2], axes[2], float(np.sqrt(square))) if square > 0 else None
