"""The places of the faces that the steps of a recipe name, so that it can be done on other versions of its scan.

Standard library only.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from .checks import check, must, numbers
from .language import own, said
from .step import Step

_ONE = ("face", "other", "onto")  #: settings that are a face, or none below 0


@dataclass(frozen=True)
class Places:
    """Where faces of a scan are, in its coordinates."""

    size: float  #: diagonal of the scan
    count: int  #: number of its faces
    faces: tuple[int, ...]  #: numbers of the faces
    points: tuple[tuple[float, ...], ...]  #: the middle of each
    normals: tuple[tuple[float, ...], ...]  #: unit normal of each; zeros for a face without area
    widths: tuple[float, ...]  #: square root of the area of each

    def __post_init__(self) -> None:
        must(self.size >= 0, "size", own("at least 0"), self.size)
        count = len(self.faces)
        same = {len(self.points), len(self.normals), len(self.widths)} == {count}
        check(not same, said("places must have a point, a normal and a width for each of its faces"))
        three = all(len(each) == 3 for each in (*self.points, *self.normals))
        check(not three, said("each point and normal of places must have 3 numbers"))

    def scaled(self, factor: float) -> Places:
        """The places in a scan that is larger by a factor."""
        larger = {name: times(getattr(self, name), factor) for name in ("size", "points", "widths")}
        return dataclasses.replace(self, **larger)

    def to_dict(self) -> dict[str, Any]:
        return dataclasses.asdict(self)

    @staticmethod
    def from_values(values: Any) -> Places:
        """The places that `to_dict` made. Raises RecipeError."""
        names = [field.name for field in dataclasses.fields(Places)]
        right = isinstance(values, dict) and sorted(values) == sorted(names)
        right = right and all(isinstance(values[name], (list, tuple)) for name in names[2:])
        right = right and all(isinstance(face, int) for face in (values["count"], *values["faces"]))
        check(not right, said("places must have {names}", names=", ".join(names)))
        (size,) = numbers([values["size"]], "size")
        points, normals = (tuple(numbers(each, name) for each in values[name]) for name in ("points", "normals"))
        return Places(
            size, values["count"], tuple(values["faces"]), points, normals, numbers(values["widths"], "widths")
        )


def times(value: Any, factor: float) -> Any:
    """A number, or each number of nested tuples, times a factor."""
    return tuple(times(each, factor) for each in value) if isinstance(value, tuple) else value * factor


def faces_of(step: Step) -> tuple[int, ...]:
    """The faces that a step names."""
    one = (getattr(step, name, -1) for name in _ONE)
    return (*(face for face in one if face >= 0), *getattr(step, "faces", ())) if _is_click(step) else ()


def _is_click(step: Step) -> bool:
    """Whether the step uses its faces: a step with an upward direction has one for a region alone."""
    return getattr(step, "up", "region") == "region" or bool(getattr(step, "faces", ()))


def moved(step: Step, to: Callable[[int], tuple[int, ...]]) -> Step | None:
    """The step at other faces; None if one that it needs has none.

    to: the faces in the place of one, the nearest first.
    """
    if not _is_click(step):
        return step
    changes: dict[str, Any] = {}
    for name in _ONE:
        if (face := getattr(step, name, -1)) >= 0:
            found = to(face)
            if not found:
                return None
            changes[name] = found[0]
    if faces := getattr(step, "faces", ()):
        # The first one leads, so it stays the first; each face once.
        changes["faces"] = tuple(dict.fromkeys(face for old in faces for face in to(old)))
        if not changes["faces"]:
            return None
    return dataclasses.replace(step, **changes)
