"""The ordered steps that lead from a scan to its result, as plain values that can be saved and replayed.

Steps name input faces (the user's own polygons), never region numbers: numbers change when an earlier step changes.
Standard library only.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from dataclasses import dataclass

VERSION = 1
METHODS = ("hierarchy", "teleport", "lloyd", "queued", "naive", "hybrid")
COUNTS = ("detail", "tolerance", "proxies")  #: ways to say how many regions, each the name of a setting
SEEDINGS = ("random", "farthest", "hierarchical")


class RecipeError(ValueError):
    """A recipe can't be used; the message says which step and why."""


def _check(wrong: bool, message: str) -> None:
    if wrong:
        raise RecipeError(message)


def _check_face(face: int) -> None:
    _check(face < 0, f"face must be at least 0, got {face}")


@dataclass(frozen=True)
class Step:
    """What every step has: it can be switched off, and then does nothing."""

    enabled: bool = dataclasses.field(default=True, kw_only=True)

    @property
    def kind(self) -> str:
        return KINDS[type(self)]

    def describe(self) -> str:
        """What the step does, in the user's words."""
        raise NotImplementedError

    def to_dict(self) -> dict:
        values = {"step": self.kind, **dataclasses.asdict(self)}
        if self.enabled:
            del values["enabled"]
        return values


@dataclass(frozen=True)
class Partition(Step):
    """Split the scan into regions; whatever was there before is replaced.

    Of the settings named in COUNTS the one that `count_by` names says how many; the others rest.
    """

    count_by: str = "proxies"
    proxies: int = 200
    detail: float = 0.005  #: what shows at this share of the size
    tolerance: float = 1.0  #: the same in scene units
    noise: float = -1.0  #: standard deviation of the scan's noise, scene units; below 0: estimated
    snap: bool = True  #: take the number of planes where the scan clearly is made of so many
    seed: int = 1
    iterations: int = 20
    method: str = "hierarchy"
    seeding: str = "random"
    leave_out: float = 0.001
    weights: str = ""  #: vertex group or face attribute that says where more regions go; none if empty
    influence: float = 1.0  #: how much it does, in [0, 2]

    def __post_init__(self):
        _check(self.count_by not in COUNTS, f"count_by must be one of {', '.join(COUNTS)}, got {self.count_by!r}")
        _check(not 0 < self.detail <= 1, f"detail must be in (0, 1], got {self.detail}")
        wrong = not (math.isfinite(self.tolerance) and self.tolerance > 0)
        _check(wrong, f"tolerance must be above 0, got {self.tolerance}")
        _check(not math.isfinite(self.noise), f"noise must be a length, or below 0, got {self.noise}")
        _check(self.proxies < 1, f"proxies must be at least 1, got {self.proxies}")
        _check(self.seed < 0, f"seed must be at least 0, got {self.seed}")
        _check(self.iterations < 1, f"iterations must be at least 1, got {self.iterations}")
        _check(self.method not in METHODS, f"method must be one of {', '.join(METHODS)}, got {self.method!r}")
        _check(self.seeding not in SEEDINGS, f"seeding must be one of {', '.join(SEEDINGS)}, got {self.seeding!r}")
        _check(not 0 <= self.leave_out < 1, f"leave_out must be in [0, 1), got {self.leave_out}")
        _check(not 0 <= self.influence <= 2, f"influence must be in [0, 2], got {self.influence}")

    def describe(self) -> str:
        if self.count_by == "proxies":
            return f"Partition into {self.proxies}"
        return f"Partition at {self.count_by} {getattr(self, self.count_by):.6g}"


@dataclass(frozen=True)
class AddProxy(Step):
    """Start a new region at a face of the scan."""

    face: int = 0

    def __post_init__(self):
        _check_face(self.face)

    def describe(self) -> str:
        return f"Add proxy at face {self.face}"


@dataclass(frozen=True)
class DeleteProxy(Step):
    """Take away the region that holds a face of the scan."""

    face: int = 0

    def __post_init__(self):
        _check_face(self.face)

    def describe(self) -> str:
        return f"Delete proxy at face {self.face}"


@dataclass(frozen=True)
class Mesh(Step):
    """Turn the regions into polygons."""

    chord_tolerance: float = 0.3
    flatten: int = 30

    def __post_init__(self):
        wrong = not (math.isfinite(self.chord_tolerance) and self.chord_tolerance > 0)
        _check(wrong, f"chord_tolerance must be above 0, got {self.chord_tolerance}")
        _check(self.flatten < 0, f"flatten must be at least 0, got {self.flatten}")

    def describe(self) -> str:
        return "Mesh"


KINDS = {Partition: "partition", AddProxy: "add_proxy", DeleteProxy: "delete_proxy", Mesh: "mesh"}
_TYPES = {kind: cls for cls, kind in KINDS.items()}
_ACCEPTS = {"bool": bool, "int": int, "str": str, "float": (float, int)}


def step_from_dict(values: dict) -> Step:
    """The step that `Step.to_dict` made. Raises RecipeError, which says what is wrong with it."""
    _check(not isinstance(values, dict) or "step" not in values, f"not a step: {values!r}")
    values = dict(values)
    kind = values.pop("step")
    _check(not isinstance(kind, str) or kind not in _TYPES, f"{kind!r} is not a step that this version knows")
    fields = {field.name: field for field in dataclasses.fields(_TYPES[kind])}
    for name, value in values.items():
        _check(name not in fields, f"{kind} has no setting {name!r}")
        wanted = fields[name].type
        fits = isinstance(value, _ACCEPTS[wanted]) and (wanted == "bool" or not isinstance(value, bool))
        _check(not fits, f"{name} of {kind} must be a {wanted}, got {value!r}")
    return _TYPES[kind](**values)


@dataclass(frozen=True)
class Recipe:
    """An ordered list of steps. All methods return a new recipe."""

    steps: tuple[Step, ...] = ()

    def then(self, step: Step) -> Recipe:
        """The recipe with one more step. A partition starts anew; nothing comes after Mesh but another Mesh."""
        if isinstance(step, Partition):
            return Recipe((step,))
        return Recipe((*self.without_mesh().steps, step))

    def ends_in_mesh(self) -> bool:
        """Whether polygons are what it gives."""
        active = self.active()
        return bool(active) and isinstance(active[-1][1], Mesh)

    def without_mesh(self) -> Recipe:
        """The recipe without the Mesh step at its end, if it has one."""
        return Recipe(self.steps[:-1]) if self.steps and isinstance(self.steps[-1], Mesh) else self

    def layers(self) -> frozenset:
        """The names of the scan's own layers that its steps use."""
        return frozenset(step.weights for _, step in self.active() if isinstance(step, Partition) and step.weights)

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
        values = {"isimp_recipe": VERSION, "steps": [step.to_dict() for step in self.steps]}
        return json.dumps(values, indent=indent)

    @staticmethod
    def from_json(text: str) -> Recipe:
        """The recipe that `to_json` made. Raises RecipeError, which says what can't be used and why."""
        try:
            values = json.loads(text)
        except ValueError as error:
            raise RecipeError(f"not a recipe: it is not JSON ({error})") from None
        _check(not isinstance(values, dict) or "isimp_recipe" not in values, "not a recipe: it has no 'isimp_recipe'")
        version = values["isimp_recipe"]
        _check(
            not isinstance(version, int) or version > VERSION,
            f"the recipe is of version {version}, this add-on reads up to {VERSION}: update the add-on",
        )
        steps = values.get("steps")
        _check(not isinstance(steps, list), "not a recipe: 'steps' must be a list")
        return Recipe(tuple(_numbered_step(number, step) for number, step in enumerate(steps, 1)))


def _numbered_step(number: int, values: dict) -> Step:
    try:
        return step_from_dict(values)
    except RecipeError as error:
        raise RecipeError(f"step {number}: {error}") from None
