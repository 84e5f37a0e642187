"""Makes OpenCASCADE's objects for curves and surfaces. Works with the packages OCP of OpenCASCADE 7 and 8."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from OCP.Geom import (
    Geom_BSplineCurve,
    Geom_Circle,
    Geom_ConicalSurface,
    Geom_CylindricalSurface,
    Geom_Ellipse,
    Geom_Line,
    Geom_Plane,
    Geom_SphericalSurface,
    Geom_SurfaceOfRevolution,
    Geom_ToroidalSurface,
)
from OCP.Geom2d import Geom2d_Line
from OCP.Geom2dAPI import Geom2dAPI_Interpolate
from OCP.GeomAPI import GeomAPI_Interpolate
from OCP.gp import gp_Ax1, gp_Ax2, gp_Ax3, gp_Dir, gp_Dir2d, gp_Pnt, gp_Pnt2d

try:  # OpenCASCADE 7
    from OCP.TColgp import TColgp_Array1OfPnt as _Points
    from OCP.TColgp import TColgp_HArray1OfPnt as _KeptPoints
    from OCP.TColgp import TColgp_HArray1OfPnt2d as _KeptPoints2
    from OCP.TColStd import TColStd_Array1OfInteger as _Integers
    from OCP.TColStd import TColStd_Array1OfReal as _Numbers
    from OCP.TColStd import TColStd_HArray1OfReal as _KeptNumbers
except ImportError:
    from OCP.collections import Array1_double as _Numbers
    from OCP.collections import Array1_gp_Pnt as _Points
    from OCP.collections import Array1_int as _Integers
    from OCP.collections import HArray1_double as _KeptNumbers
    from OCP.collections import HArray1_gp_Pnt as _KeptPoints
    from OCP.collections import HArray1_gp_Pnt2d as _KeptPoints2

from .shapes import Array, Cone, Cylinder, Plane, Sphere, Spun, Surface, Torus, circle_of, square_to, unit


class NoFace(Exception):
    """A face or an edge can't be made; the message has the reason."""


@contextmanager
def refused() -> Iterator[None]:
    """Raises NoFace for OpenCASCADE's own errors, which have no common class."""
    try:
        yield
    except Exception as error:
        if not type(error).__module__.startswith("OCP."):
            raise
        raise NoFace(f"OpenCASCADE refuses it: {type(error).__name__}") from error


def point(p: Array) -> Any:
    return gp_Pnt(float(p[0]), float(p[1]), float(p[2]))


def direction(v: Array) -> Any:
    return gp_Dir(float(v[0]), float(v[1]), float(v[2]))


def _filled(kind: Any, values: Sequence[Any]) -> Any:
    array = kind(1, len(values))
    for k, value in enumerate(values):
        array.SetValue(k + 1, value)
    return array


def surface_of(shape: Surface) -> Any:
    """Return OpenCASCADE's surface of a shape, with the same parameters."""
    if isinstance(shape, Plane):
        x = square_to(shape.normal_)
        return Geom_Plane(gp_Ax3(point(shape.point), direction(shape.normal_), direction(x)))
    frame = gp_Ax3(point(shape.point), direction(shape.axis), direction(shape.x))
    if isinstance(shape, Cylinder):
        return Geom_CylindricalSurface(frame, shape.radius)
    if isinstance(shape, Cone):
        return Geom_ConicalSurface(frame, float(np.arctan(shape.slope)), shape.radius)
    if isinstance(shape, Sphere):
        return Geom_SphericalSurface(frame, shape.radius)
    if isinstance(shape, Torus):
        return Geom_ToroidalSurface(frame, shape.large, shape.small)
    assert isinstance(shape, Spun)
    return Geom_SurfaceOfRevolution(_profile(shape), gp_Ax1(point(shape.point), direction(shape.axis)))


def _profile(shape: Spun) -> Any:
    places = shape.point + shape.poles_[:, :1] * shape.x + shape.poles_[:, 1:] * shape.axis
    knots = shape.first + shape.step * np.arange(-3, len(places) + 1)
    curve = Geom_BSplineCurve(
        _filled(_Points, [point(p) for p in places]),
        _filled(_Numbers, knots.tolist()),
        _filled(_Integers, [1] * len(knots)),
        3,
    )
    low = shape.first if shape.low is None else shape.low
    high = shape.last if shape.high is None else shape.high
    curve.Segment(low, high)
    for end, number in ((shape.low, 1), (shape.high, curve.NbPoles())):
        if end is not None:  # moves the end exactly onto the axis
            pole = curve.Pole(number)
            away = np.array([pole.X(), pole.Y(), pole.Z()]) - shape.point
            curve.SetPole(number, point(shape.point + (away @ shape.axis) * shape.axis))
    return curve


def line(a: Array, b: Array) -> tuple[Any, float, float]:
    """Return a line and its parameters at two points."""
    return Geom_Line(point(a), direction(unit(b - a))), 0.0, float(np.linalg.norm(b - a))


def circle(points: Array, within: float) -> tuple[Any, float, float] | None:
    """Return the circle through ordered points, and its parameters at the ends; None if there is no such circle."""
    found = circle_of(points)
    if found is None:
        return None
    centre, normal, radius = found
    away = points - centre
    flat = away @ normal
    far = np.hypot(np.linalg.norm(away - flat[:, None] * normal, axis=1) - radius, flat)
    if float(far.max()) > within or len(points) < 4:
        return None
    x = unit(away[0] - flat[0] * normal)
    y = np.cross(normal, x)
    angle = np.unwrap(np.arctan2(away @ y, away @ x))
    if angle[-1] < angle[0]:
        y, normal, angle = -y, -normal, -angle
    whole = np.allclose(points[0], points[-1], rtol=0, atol=1e-12 * (1 + radius))
    last = 2 * np.pi if whole else float(angle[-1])
    if (np.diff(angle) <= 0).any() or last > 2 * np.pi + 1e-9:
        return None
    return Geom_Circle(gp_Ax2(point(centre), direction(normal), direction(x)), radius), 0.0, last


def ellipse(points: Array, cylinder: Cylinder, plane: Plane, within: float) -> tuple[Any, float, float] | None:
    """Return the ellipse where a plane cuts a cylinder, and its parameters; None if the points are not on it."""
    cosine = float(plane.normal_ @ cylinder.axis)
    if abs(cosine) < 0.05:
        return None
    centre = cylinder.point + cylinder.axis * float((plane.point - cylinder.point) @ plane.normal_) / cosine
    normal = plane.normal_ * np.sign(cosine)
    x = cylinder.axis - (cylinder.axis @ normal) * normal
    if float(np.linalg.norm(x)) < 1e-9:
        return None
    x, large = unit(x), cylinder.radius / abs(cosine)
    y = np.cross(normal, x)
    away = points - centre
    angle = np.unwrap(np.arctan2(away @ y / cylinder.radius, away @ x / large))
    if angle[-1] < angle[0]:
        normal, y, angle = -normal, -y, -angle
    on = centre + large * np.cos(angle)[:, None] * x + cylinder.radius * np.sin(angle)[:, None] * y
    if float(np.linalg.norm(on - points, axis=1).max()) > within or (np.diff(angle) <= 0).any():
        return None
    first, last = float(angle[0]), float(angle[-1])
    if np.array_equal(points[0], points[-1]):
        last = first + 2 * np.pi
    return Geom_Ellipse(gp_Ax2(point(centre), direction(normal), direction(x)), large, cylinder.radius), first, last


def spline(points: Array) -> tuple[Any, float, float]:
    """Return a spline through points, and its parameters at the ends."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    kept = np.concatenate([[True], steps > 1e-3 * float(steps.mean())])
    kept[-1] = True
    if not kept[-2] or steps[-1] <= 1e-3 * float(steps.mean()):
        kept[-2] = len(points) == 2
    kept[0] = True
    points = points[kept]
    if len(points) == 2:
        return line(points[0], points[1])
    t = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    made = GeomAPI_Interpolate(
        _filled(_KeptPoints, [point(p) for p in points]), _filled(_KeptNumbers, t.tolist()), False, 1e-12
    )
    made.Perform()
    return made.Curve(), 0.0, float(t[-1])


def flat_curve(uv: Array, t: Array, straight: float) -> Any:
    """Return the curve through parameters of a surface; a line if it is straight with unit speed."""
    way = (uv[-1] - uv[0]) / (t[-1] - t[0])
    on = uv[0] + (t - t[0])[:, None] * way
    if abs(float(np.hypot(*way)) - 1) < 1e-9 and float(np.abs(on - uv).max()) < straight:
        begin = uv[0] - t[0] * way
        return Geom2d_Line(gp_Pnt2d(float(begin[0]), float(begin[1])), gp_Dir2d(float(way[0]), float(way[1])))
    points = _filled(_KeptPoints2, [gp_Pnt2d(float(a), float(b)) for a, b in uv])
    made = Geom2dAPI_Interpolate(points, _filled(_KeptNumbers, t.tolist()), False, 1e-13)
    made.Perform()
    return made.Curve()


def flat_line(u: float, v: float, along_u: bool) -> Any:
    """Return the line of constant v, or of constant u, with the other as its parameter."""
    way = gp_Dir2d(1, 0) if along_u else gp_Dir2d(0, 1)
    return Geom2d_Line(gp_Pnt2d(0.0 if along_u else u, v if along_u else 0.0), way)


def places(curve: Any, t: Array) -> Array:
    """Return points of a curve in space."""
    found = [curve.Value(float(x)) for x in t]
    return np.array([[p.X(), p.Y(), p.Z()] for p in found])


def places_on(surface: Any, curve: Any, t: Array) -> Array:
    """Return points of a curve on a surface."""
    found = []
    for x in t:
        uv = curve.Value(float(x))
        p = surface.Value(uv.X(), uv.Y())
        found.append([p.X(), p.Y(), p.Z()])
    return np.array(found)
