"""Moves planes, axes and radii to sizes that are multiples of a step, where their uncertainty allows it."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ._core import Job, Mesh, Partition, _hold_planes
from .planes import BY_HAND, SNAPPED
from .sizes import ANGLE, CLEAR, EXACT, LEAST, SURE, Array, Measured, Planes, Round

_ONE_LINE = 1e-7  # share of the diagonal: distance of two axes that are one


def snap_sizes(mesh: Mesh, part: Partition, step: float, *, job: Job | None = None) -> Partition:
    """Move parallel planes, axes and radii so that sizes are multiples of a step; angles, of 5 degrees.

    A size moves to a multiple that its measured value is from by its uncertainty at most (`size_rows`), if the step is
    ten times as large as that. Angles are to the planes of the two largest directions at right angles. Planes set by
    `align_planes` stay. step: scene units, above 0. Returns the partition with its planes held; the bound is 0, as
    after an edit.
    """
    measured, diagonal = Measured(mesh, part), float(mesh.report["diagonal"])
    lines = _lines(measured.round, _ONE_LINE * diagonal)
    planes, origin = [], np.asarray(mesh.origin, np.float64)
    for group in _directions(measured, lines):
        of_planes = _members(group, measured.planes, EXACT * diagonal)
        here = [line for line in lines if line.takes(group.normal)]
        places = _on_lattice([*of_planes, *(line.member(group.normal) for line in here)], step)
        for member, place in zip(of_planes, places, strict=False):
            for region in member.regions:
                normal = group.signs[region] * group.normal
                planes.append((region, tuple(normal), group.signs[region] * place + float(normal @ origin)))
        for line, place in zip(here, places[len(of_planes) :], strict=True):
            line.move(group.normal, place)
    return _hold_planes(mesh, part, planes, _held(measured.round, lines, step, origin), job=job)


@dataclass(frozen=True)
class _Member:
    """A plane or an axis: its place along a direction, by the vertices of the scan, or if they are few of the model."""

    best: float
    variance: float
    regions: tuple[int, ...] = ()

    @classmethod
    def of(cls, model: float, found: Sequence[tuple[float, float]], regions: Sequence[int] = ()) -> "_Member":
        """found: place and variance of each of its parts."""
        best, variance = _pooled(found)
        return cls(best if np.isfinite(variance) else model, variance, tuple(regions))


@dataclass(frozen=True)
class _Group:
    """Planes of one direction."""

    normal: Array
    signs: dict[int, float]  #: by region: 1, or -1 where it faces the other way
    held: bool

    def has(self, direction: Array) -> bool:
        """Whether a direction is that of the planes."""
        return bool(np.linalg.norm(np.cross(self.normal, direction)) <= EXACT)


@dataclass
class _Line:
    """The common axis of round parts."""

    parts: list[Round]
    axis: Array
    shift: Array = field(default_factory=lambda: np.zeros(3))
    used: list[Array] = field(default_factory=list)  #: directions along which it has its place

    def takes(self, normal: Array) -> bool:
        """Whether it has a place along a direction that does not depend on its other places."""
        return all(abs(normal @ other) <= EXACT for other in [self.axis, *self.used])

    def member(self, normal: Array) -> _Member:
        return _Member.of(
            float(normal @ self.parts[0].point),
            [(float(normal @ part.best), part.shift(normal)) for part in self.parts],
        )

    def move(self, normal: Array, place: float) -> None:
        self.shift = self.shift + (place - normal @ self.parts[0].point) * normal
        self.used.append(normal)


def _pooled(found: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """The mean of values by their variances, and its variance; infinite if no value is known."""
    known = [(value, variance) for value, variance in found if np.isfinite(variance)]
    if not known:
        return 0.0, np.inf
    weights = np.array([1 / max(variance, 1e-300) for _, variance in known])
    return float(np.average([value for value, _ in known], weights=weights)), float(1 / weights.sum())


def _lines(parts: Sequence[Round], apart: float) -> list[_Line]:
    lines: list[_Line] = []
    for part in parts:
        if not part.has_axis:
            continue
        for line in lines:
            beside = np.cross(part.point - line.parts[0].point, line.axis)
            if np.linalg.norm(np.cross(part.axis, line.axis)) <= EXACT and np.linalg.norm(beside) <= apart:
                line.parts.append(part)
                break
        else:
            lines.append(_Line([part], part.axis))
    return lines


def _directions(measured: Measured, lines: list[_Line]) -> list[_Group]:
    """Held planes by direction, the most vertices first, turned to multiples of ANGLE.

    Axes turn with their planes.
    """
    planes, known = measured.planes, set(measured.large)
    groups = _grouped([_Group(planes.normal[r], {r: 1.0}, planes.held[r] > 0) for r in measured.large
                       if planes.held[r] != BY_HAND])  # fmt: skip
    small = [r for r in measured.flat if planes.held[r] == SNAPPED and r not in known]
    for group in groups:  # small regions stay on the planes of large ones
        if group.held and small:
            away = np.linalg.norm(np.cross(planes.normal[small], group.normal), axis=1)
            mine = [small[k] for k in np.flatnonzero(away <= EXACT)]
            group.signs.update({r: float(np.sign(group.normal @ planes.normal[r])) for r in mine})
    groups.sort(key=lambda group: -sum(planes.count[r] for r in group.signs))
    frame, found = _frame(groups, planes), []
    for group in groups:
        normal = _turned(group, planes, frame)
        if normal is None:
            found += [group] if group.held else []
            continue
        for line in lines:
            if group.has(line.axis):
                line.axis = normal * np.sign(group.normal @ line.axis)
        found.append(replace(group, normal=normal, held=True))
    return _grouped(found)


def _grouped(groups: list[_Group]) -> list[_Group]:
    """Groups of one direction as one."""
    found: list[_Group] = []
    for group in groups:
        mine = [other for other in found if other.held and group.held and other.has(group.normal)]
        if not mine:
            found.append(replace(group, signs=dict(group.signs)))
            continue
        sign = float(np.sign(mine[0].normal @ group.normal))
        mine[0].signs.update({region: sign * own for region, own in group.signs.items()})
    return found


def _frame(groups: list[_Group], planes: Planes) -> list[Array]:
    """Three directions at right angles: that of most vertices, the next one square to it, and their normal; or none."""
    for group in groups[1:]:
        lead = groups[0].normal
        rise = float(group.normal @ lead)
        square = group.normal - rise * lead
        if abs(rise) <= EXACT or (abs(rise) < 0.5 and _may_turn(group, planes, _unit(square), lead)):
            return [lead, _unit(square), np.cross(lead, _unit(square))]
    return []


def _turned(group: _Group, planes: Planes, frame: list[Array]) -> Array | None:
    """The direction square to one of a frame and at a multiple of ANGLE to the others; None if that is too far."""
    for k in sorted(range(len(frame)), key=lambda k: abs(group.normal @ frame[k])):
        square, x, y = frame[k], frame[k - 2], frame[k - 1]
        rise = float(group.normal @ square)
        flat = _unit(group.normal - rise * square)
        angle = float(np.degrees(np.arctan2(flat @ y, flat @ x)))
        to = ANGLE * round(angle / ANGLE)
        normal = flat if abs(angle - to) <= EXACT else _at(to, x, y)
        tips = abs(rise) <= EXACT or _may_turn(group, planes, normal, square)
        turns = abs(angle - to) <= EXACT or _may_turn(group, planes, normal, np.cross(square, flat))
        if tips and turns:
            return normal
    return None


def _at(degrees: float, x: Array, y: Array) -> Array:
    """Exactly along x or y at right angles."""
    turns, rest = divmod(degrees, 90)
    for _ in range(int(turns) % 4):
        x, y = y, -x
    return x if rest == 0 else _unit(np.cos(np.radians(rest)) * x + np.sin(np.radians(rest)) * y)


def _may_turn(group: _Group, planes: Planes, to: Array, along: Array) -> bool:
    """Whether planes may turn along a direction to a normal: by no more than their uncertainty."""
    away, variance = _pooled([(float(along @ (to - sign * planes.best[r])), planes.turn(r, along)) for r, sign in
                              group.signs.items()])  # fmt: skip
    sure = SURE * np.sqrt(variance)
    return bool(np.isfinite(sure) and abs(away) <= sure and CLEAR * sure <= np.radians(ANGLE))


def _members(group: _Group, planes: Planes, one: float) -> list[_Member]:
    """The planes of a group; regions on one plane are one member."""
    at = {r: sign * planes.offset[r] for r, sign in group.signs.items()}
    runs: list[list[int]] = []
    for r in sorted(at, key=lambda r: at[r]):
        if runs and at[r] - at[runs[-1][-1]] <= one:
            runs[-1].append(r)
        else:
            runs.append([r])
    return [
        _Member.of(
            float(np.mean([group.normal @ planes.foot(r) for r in run])),  # a turned plane keeps its middle
            [(float(group.normal @ planes.mean[r]), planes.shift(r)) for r in run if planes.count[r] >= LEAST],
            run,
        )
        for run in runs
    ]


def _on_lattice(members: Sequence[_Member], step: float) -> list[float]:
    """The places of members along their direction, so that as many distances as possible are multiples of a step.

    Sets of members grow by the distance that is known best. Each distance in a set is within its uncertainty of a
    multiple. The set as a whole moves least, and a member alone is where the vertices are.
    """
    best, variance = np.array([m.best for m in members]), np.array([m.variance for m in members])
    apart = best[:, None] - best
    sure = SURE * np.sqrt(variance[:, None] + variance)
    near = np.abs(apart - step * np.round(apart / step)) <= sure
    sets = [[k] for k in range(len(members))]
    pairs = np.argwhere(np.triu(near & (CLEAR * sure <= step), 1))
    for a, b in pairs[np.argsort(sure[tuple(pairs.T)], kind="stable")].tolist():
        if sets[a] is not sets[b] and near[np.ix_(sets[a], sets[b])].all():
            sets[a] += sets[b]
            for k in sets[b]:
                sets[k] = sets[a]
    places: list[float] = best.tolist()
    for some in sets:
        if len(some) > 1:
            whole = step * np.round((best[some] - best[some[0]]) / step)
            first, _ = _pooled(list(zip((best[some] - whole).tolist(), variance[some].tolist(), strict=True)))
            for k, multiple in zip(some, whole.tolist(), strict=True):
                places[k] = first + multiple
    return places


def _held(parts: Sequence[Round], lines: list[_Line], step: float, origin: Array) -> list[Any]:
    """Number, point, axis and radius of each round part, for `_hold_planes`."""
    places = {part.patch["number"]: (part.point, part.axis) for part in parts}
    for line in lines:
        for part in line.parts:
            places[part.patch["number"]] = part.point + line.shift, line.axis * np.sign(line.axis @ part.axis)
    held = []
    for part in parts:
        equal = [p for p in parts if (p.patch["kind"], p.patch["radius"]) == (part.patch["kind"], part.patch["radius"])]
        radius, variance = _pooled([(p.radius, np.inf if p.spread is None else p.spread[0, 0]) for p in equal])
        whole, sure = step * np.round(2 * radius / step), 2 * SURE * np.sqrt(variance)
        moves = whole > 0 and abs(2 * radius - whole) <= sure and CLEAR * sure <= step
        point, axis = places[part.patch["number"]]
        radius = whole / 2 if moves else part.patch["radius"]
        held.append((part.patch["number"], tuple(point + origin), tuple(axis), float(radius)))
    return held


def _unit(v: Array) -> Array:
    made: Array = v / np.linalg.norm(v)
    return made
