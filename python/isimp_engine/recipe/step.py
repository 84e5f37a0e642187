"""The base of all steps of recipes. Standard library only."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, ClassVar

from .checks import check_face, indices
from .options import Option

#: The name of each kind of step in saved recipes; steps.py has all of them
KINDS: dict[type[Step], str] = {}


def engine_options(step: Step, table: dict[str, Option]) -> dict[str, Any]:
    """The settings of a step that are the engine's options, by the same names and as the engine has them."""
    names = [field.name for field in dataclasses.fields(step) if field.name in table]
    return {name: table[name].given(getattr(step, name)) for name in names}


def unlabelled(table: dict[str, Option]) -> frozenset[str]:
    """The options that the panel does not show."""
    return frozenset(name for name, option in table.items() if not option.label)


def count_faces(faces: tuple[int, ...]) -> str:
    return f"face {faces[0]}" if len(faces) == 1 else f"{len(faces)} faces"


@dataclass(frozen=True)
class Step:
    """Base of all steps: a step that is switched off has no effect."""

    enabled: bool = dataclasses.field(default=True, kw_only=True)

    #: settings that are not saved where they have their defaults, as steps of earlier versions lack them
    late: ClassVar[frozenset[str]] = frozenset()

    #: whether its faces are an area, such as a stroke of a brush, and not one face of each region
    is_stroke: ClassVar[bool] = False

    @property
    def kind(self) -> str:
        return KINDS[type(self)]

    #: its line in the list of steps; the step is the one argument of the format
    described: ClassVar[str]

    def describe(self) -> str:
        """The step's line in the list of steps."""
        return self.described.format(self)

    def to_dict(self) -> dict[str, Any]:
        values = {"step": KINDS[type(self)], **dataclasses.asdict(self)}
        if self.enabled:
            del values["enabled"]
        defaults = {field.name: field.default for field in dataclasses.fields(self) if field.name in self.late}
        return {name: value for name, value in values.items() if name not in defaults or value != defaults[name]}


@dataclass(frozen=True)
class AtFace(Step):
    """Base of steps at a face of the scan."""

    face: int = 0

    def __post_init__(self) -> None:
        check_face(self.face)


@dataclass(frozen=True)
class AtFaces(Step):
    """Base of steps at faces of the scan."""

    faces: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "faces", indices(self.faces))

    @property
    def named(self) -> str:
        return count_faces(self.faces)
