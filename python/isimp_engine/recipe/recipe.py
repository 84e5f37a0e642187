"""The ordered steps that lead from a scan to its result, as plain values that can be saved and replayed.

Standard library only.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, field, fields, replace
from functools import reduce
from typing import Any

from .checks import RecipeError, check, short
from .engine_options import CLEAN, MESHING, PARTITION, REGULARISE, TEXTURE
from .language import own, said
from .places import Places, faces_of, times
from .plane_steps import AlignPlanes, Regularise
from .round_steps import RoundSegments
from .step import Step
from .steps import LockRegions, Mesh, PaintFaces, Partition, Texture, UnlockRegions, gone_from, step_from_dict

VERSION = 1
_LENGTHS = {
    name: option
    for table in (CLEAN, MESHING, PARTITION, REGULARISE, TEXTURE)
    for name, option in table.items()
    if option.unit == "length"
}
_PLACES = {"keep_openings", "more", "line"}  # settings in the scan's coordinates; each part of `more` has a size too


@dataclass(frozen=True)
class Recipe:
    """An ordered list of steps. All methods return a new recipe."""

    steps: tuple[Step, ...] = ()
    #: places of the faces that the steps name, in a recipe that was written; None: the numbers are of one scan
    places: Places | None = field(default=None, compare=False)
    #: sentences about settings that the steps had when they were read, and that this version does not have
    gone: tuple[str, ...] = field(default=(), compare=False)

    def then(self, *steps: Step) -> Recipe:
        """The recipe with more steps, in place of a Mesh step at its end and its texture.

        A partition of all faces replaces the steps after the last lock. Regularise replaces an earlier one, unless
        planes were set by hand after it, as these may follow snapped planes.
        """
        return reduce(Recipe._then, steps, self)

    def _then(self, step: Step) -> Recipe:
        if isinstance(step, Texture):
            return Recipe((*self._without(Texture).steps, step))
        steps = self.without_mesh().steps
        if isinstance(step, Partition) and not step.faces:
            steps = steps[: self._last_lock() + 1]
        elif isinstance(step, Partition) and steps and getattr(steps[-1], "faces", ()) == step.faces:
            steps = steps[:-1] if isinstance(steps[-1], Partition) else steps  # the same part once more
        elif isinstance(step, Regularise):
            hand = max((k for k, old in enumerate(steps) if isinstance(old, AlignPlanes)), default=-1)
            steps = tuple(old for k, old in enumerate(steps) if k < hand or not isinstance(old, Regularise))
        elif isinstance(step, RoundSegments) and steps and isinstance(steps[-1], RoundSegments):
            steps = steps[:-1] if steps[-1].face == step.face else steps  # the same round part once more
        elif isinstance(step, Mesh) and Recipe(steps).snap_sizes():
            step = replace(step, planar=True)  # else corners are off the planes
        return Recipe((*steps, step))

    def _last_lock(self) -> int:
        """The index of the last step that changes which regions are locked; -1 if none is locked after it."""
        locked: set[int] = set()
        last = -1
        for index, step in self.active():
            if isinstance(step, UnlockRegions):
                locked -= set(step.faces)
            elif isinstance(step, LockRegions):  # LeaveOutRegions is a subclass
                locked |= set(step.faces)
            elif isinstance(step, PaintFaces) and step.lock:
                locked.add(step.faces[0] if step.onto < 0 else step.onto)
            else:
                continue
            last = index
        return last if locked else -1

    def locks_before(self, index: int) -> bool:
        """Whether regions are locked before a step, so that a partition there keeps them."""
        return Recipe(self.steps[:index])._last_lock() >= 0

    def replaced(self, index: int, step: Step) -> Recipe:
        """The recipe with another step in the place of one."""
        text, steps = own("there is no step {number}: the recipe has {steps}"), len(self.steps)
        check(not 0 <= index < steps, said(text, number=index + 1, steps=steps))
        return Recipe((*self.steps[:index], step, *self.steps[index + 1 :]))

    def changed(self, index: int, step: Step) -> Recipe:
        """The recipe after a setting of one of its steps was changed.

        Locked regions stay unchanged: the changed partition of all faces follows the last lock.
        """
        last = self._last_lock()
        if isinstance(step, Partition) and not step.faces and last > index:
            return Recipe((*self.steps[: last + 1], step, *self.steps[last + 1 :]))
        return self.replaced(index, step)

    def scaled(self, factor: float) -> Recipe:
        """The recipe for a scan that is larger by a factor. `snap_sizes` is of the larger one already."""
        steps = tuple(_scaled(step, factor) for step in self.steps)
        return Recipe(steps, self.places and self.places.scaled(factor), self.gone)

    def whole(self) -> tuple[int, Partition | None]:
        """The last partition of all faces, which sets the openings to close, and its index; (-1, None) if none."""
        found = [(index, step) for index, step in self.active() if isinstance(step, Partition) and not step.faces]
        return found[-1] if found else (-1, None)

    def snap_sizes(self) -> float | None:
        """The step of the sizes, scene units; None: they are not snapped."""
        found = [step.snap_sizes for _, step in self.active() if isinstance(step, Regularise)]
        return (found[-1] or None) if found else None

    def regularised(self, step: Regularise) -> Recipe:
        """The recipe with planes snapped at its end; unchanged if they are snapped already."""
        active = self.without_mesh().active()
        return self if active and isinstance(active[-1][1], Regularise) else self.then(step)

    def ends_in_mesh(self) -> bool:
        """Whether its outcome has polygons."""
        active = [step for _, step in self.active() if not isinstance(step, Texture)]
        return bool(active) and isinstance(active[-1], Mesh)

    def texture(self) -> Texture | None:
        """The texture that its outcome has."""
        active = self.active()
        return active[-1][1] if active and isinstance(active[-1][1], Texture) else None

    def without_mesh(self) -> Recipe:
        """The recipe without the Mesh step at its end and its texture, if it has them."""
        return self._without(Texture)._without(Mesh)

    def _without(self, kind: type[Step]) -> Recipe:
        """The recipe without the step of this kind at its end, if it has one."""
        return Recipe(self.steps[:-1]) if self.steps and isinstance(self.steps[-1], kind) else self

    def layers(self) -> frozenset[str]:
        """The names of the scan's own layers that its steps use."""
        return frozenset().union(*(step.layers() for _, step in self.active() if isinstance(step, Partition)))

    def active(self) -> tuple[tuple[int, Step], ...]:
        """The steps that are switched on, each with its index."""
        return tuple((index, step) for index, step in enumerate(self.steps) if step.enabled)

    def prefix_keys(self) -> tuple[str, ...]:
        """A key for each active step that depends on it and all active ones before it, and on nothing else."""
        digest, keys = hashlib.blake2b(digest_size=16), []
        for _, step in self.active():
            digest.update(json.dumps(step.to_dict(), sort_keys=True).encode())
            keys.append(digest.hexdigest())
        return tuple(keys)

    def to_json(self, indent: int | None = None) -> str:
        text = json.dumps(Recipe(self.steps).to_values(), indent=indent)
        if self.places is None:
            return text
        # Each place on a line of its own would be most of the text.
        before, after = (",\n" + " " * indent, "\n}") if indent else (", ", "}")
        return f'{text.removesuffix(after)}{before}"places": {json.dumps(self.places.to_dict())}{after}'

    def to_values(self) -> dict[str, Any]:
        """The value of the JSON text."""
        values = {"isimp_recipe": VERSION, "steps": [step.to_dict() for step in self.steps]}
        return values if self.places is None else values | {"places": self.places.to_dict()}

    def faces(self) -> tuple[int, ...]:
        """The faces that its steps name, in rising order."""
        return tuple(sorted({face for step in self.steps for face in faces_of(step)}))

    @staticmethod
    def from_json(text: str) -> Recipe:
        """The recipe that `to_json` made. Raises RecipeError, which names the problem and the step."""
        return Recipe.from_values(parsed(text, said("not a recipe")))

    @staticmethod
    def from_values(values: Any) -> Recipe:
        """The recipe in the value of a JSON text."""
        check(
            not isinstance(values, dict) or "isimp_recipe" not in values, said("not a recipe: it has no 'isimp_recipe'")
        )
        version = values["isimp_recipe"]
        known = isinstance(version, int) and version <= VERSION
        check(
            not known,
            said(
                "the recipe has version {version}, this version of iSimp reads up to {known}: update iSimp",
                version=short(version),
                known=VERSION,
            ),
        )
        steps = values.get("steps")
        check(not isinstance(steps, list), said("not a recipe: 'steps' must be a list"))
        places = None if values.get("places") is None else Places.from_values(values["places"])
        return Recipe(tuple(numbered_step(number, step) for number, step in enumerate(steps, 1)), places, gone(steps))


def _scaled(step: Step, factor: float) -> Step:
    names = {each.name for each in fields(step)}
    values = {name: _LENGTHS[name].given(getattr(step, name)) for name in names & _LENGTHS.keys()}
    values |= {name: getattr(step, name) for name in names & _PLACES}
    return replace(step, **{name: times(value, factor) for name, value in values.items() if value})


def parsed(text: str, problem: str) -> Any:
    """The value of a JSON text. Raises RecipeError, which begins with the problem and names the place."""
    try:
        return json.loads(text)
    except ValueError as error:
        raise RecipeError(said("{problem}: it is not JSON ({error})", problem=problem, error=error)) from None
    except RecursionError:
        raise RecipeError(said("{problem}: its brackets are nested too deeply", problem=problem)) from None


def gone(steps: list[Any]) -> tuple[str, ...]:
    """A sentence about each setting of saved steps that this version does not have."""
    text = own("step {number}: {name} has no effect: this version of iSimp does not have it")
    found = [(number, name) for number, values in enumerate(steps, 1) for name in gone_from(values)]
    return tuple(said(text, number=number, name=name) for number, name in found)


def numbered_step(number: int, values: Any) -> Step:
    """As `step_from_dict`, with the number of the step in the message."""
    try:
        return step_from_dict(values)
    except RecipeError as error:
        raise RecipeError(said("step {number}: {error}", number=number, error=error)) from None
