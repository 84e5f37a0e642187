"""The steps of a recipe, as plain values.

Steps name input faces (the user's own polygons), never region numbers: numbers change when an earlier step changes.
Standard library only.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from .checks import RecipeError, check, check_choice, check_face, check_options, indices, must, numbers, short
from .engine_fields import CleanFields, MeshingFields, PartitionFields, TextureFields
from .engine_options import CLEAN, GONE, MESHING, PARTITION, TEXTURE
from .language import own, said
from .options import COUNTS
from .plane_steps import AlignPlanes, Regularise
from .round_steps import ExplodeRound, RoundRegions, RoundSegments
from .step import KINDS, AtFace, AtFaces, Step, count_faces, unlabelled

METHODS = PARTITION["method"].choices
#: settings of a Partition for barriers, and the layer of the scan (`Scan.layers`) that has them
MARKS = {"seams": ".seam", "sharp": ".sharp", "materials": ".material", "face_sets": ".face_set"}
MOST_ROUNDS = 1000  #: rounds of smoothing; borders stop after far fewer
_LARGEST = (1 << 31) - 1  # whole number of the engine, except seeds
_LARGEST_SEED = (1 << 63) - 1


@dataclass(frozen=True)
class Partition(PartitionFields, CleanFields):
    """Split the scan into regions, which replace all others except locked ones.

    `count_by` selects which of COUNTS is used; the others are ignored.
    """

    count_by: str = ""  #: empty: the one that is given, "detail" if none is
    proxies: int | None = None
    triangles: int | None = None  #: that the polygons make at most
    detail: float | None = None  #: smallest visible shape, as a share of the size
    tolerance: float | None = None  #: the same in scene units
    bound: float | None = None  #: largest distance of a vertex from its region's plane, scene units
    adaptivity: float = 0.25  #: smaller regions where the scan is rough
    close_openings: bool = True  #: close holes and tunnels of a noisy scan that the regions can't show,
    keep_openings: tuple[tuple[float, ...], ...] = ()  #: except the openings at these places; scan coordinates
    weights: str = ""  #: vertex group or attribute; higher values give smaller regions; none if empty
    influence: float = 1.0  #: strength of the weights, in [0, 2]
    seams: bool = False  #: no region crosses an edge that is marked as a seam,
    sharp: bool = False  #: nor one that is marked as sharp,
    materials: bool = False  #: nor one between two materials,
    face_sets: bool = False  #: nor one between two face sets,
    angle: float = 180.0  #: nor one with a larger angle between its faces, in degrees,
    borders: str = ""  #: nor one between different values of this attribute of faces; none if empty
    faces: tuple[int, ...] = ()  #: split only these; empty: all
    more: tuple[tuple[float, ...], ...] = ()  #: x, y, z, size of parts with smaller regions; see `isimp_engine.parts`
    late = unlabelled(PARTITION) | {"keep_openings", "curved", "more"}
    is_stroke = True

    def __post_init__(self) -> None:
        self._settle_count()
        check_choice(self.count_by not in COUNTS, "count_by", ", ".join(COUNTS), self.count_by)
        check_options(self, {name: option for name, option in PARTITION.items() if name not in COUNTS})
        for name in COUNTS:
            must(PARTITION[name].holds(getattr(self, name)), name, PARTITION[name].words, getattr(self, name))
        check_options(self, CLEAN)
        must(0 <= self.influence <= 2, "influence", "in [0, 2]", self.influence)
        must(0 <= self.angle <= 180, "angle", own("in [0, 180] degrees"), self.angle)
        object.__setattr__(self, "faces", indices(self.faces) if len(self.faces) else ())
        places = tuple(numbers(place, said("a place of keep_openings")) for place in self.keep_openings)
        check(any(len(place) != 3 for place in places), said("each place of keep_openings must have 3 numbers"))
        object.__setattr__(self, "keep_openings", places)
        parts = tuple(numbers(part, said("a part of more")) for part in self.more)
        check(any(len(part) != 4 for part in parts), said("each part of more must have 4 numbers: a place and a size"))
        object.__setattr__(self, "more", parts)

    def keeping(self, place: Iterable[float], keep: bool) -> Partition:
        """The step with one more opening kept open, or without the kept place that is nearest to this one."""
        place, places = numbers(place, "place"), self.keep_openings
        if keep:
            places = (*places, *({place} - set(places)))
        elif places:
            nearest = min(range(len(places)), key=lambda index: math.dist(places[index], place))
            places = places[:nearest] + places[nearest + 1 :]
        return dataclasses.replace(self, keep_openings=places)

    def without_nearest(self, place: Iterable[float]) -> tuple[tuple[float, ...], ...]:
        """The parts of `more` without the one that is nearest to a place."""
        here = numbers(place, "place")
        nearest = min(self.more, key=lambda part: math.dist(part[:3], here), default=None)
        return tuple(part for part in self.more if part is not nearest)

    def _settle_count(self) -> None:
        given = [name for name in COUNTS if getattr(self, name) is not None]
        if not self.count_by:
            check(
                len(given) > 1,
                said("{names} each set the number of regions: give one of them, or count_by", names=", ".join(given)),
            )
            object.__setattr__(self, "count_by", given[0] if given else "detail")
        for name, value in COUNTS.items():
            if name not in given:
                object.__setattr__(self, name, value)

    def layers(self) -> frozenset[str]:
        """The names of the scan's own layers that it needs: see `Scan.layers`."""
        marks = {layer for name, layer in MARKS.items() if getattr(self, name)}
        return frozenset(marks | ({self.weights, self.borders} - {""}))

    def describe(self) -> str:
        what = f"Partition {count_faces(self.faces)}" if self.faces else "Partition"
        if self.count_by == "proxies":
            return f"{what} into {self.proxies}"
        if self.count_by == "triangles":
            return f"{what} for {self.triangles} triangles"
        return f"{what} at {self.count_by} {getattr(self, self.count_by):.6g}"


@dataclass(frozen=True)
class AddProxy(AtFace):
    """Add a region at a face of the scan."""

    described = "Add proxy at face {0.face}"


@dataclass(frozen=True)
class DeleteProxy(AtFace):
    """Delete the region at a face of the scan."""

    described = "Delete proxy at face {0.face}"


@dataclass(frozen=True)
class MergeRegions(AtFace):
    """Merge the region of one face into a neighbouring region."""

    described = "Merge the region at face {0.other} into that at face {0.face}"

    other: int = 0  #: a face of the region that is merged into it

    def __post_init__(self) -> None:
        super().__post_init__()
        check_face(self.other)


@dataclass(frozen=True)
class SplitRegion(AtFace):
    """Split a region in two where its halves differ most."""

    described = "Split the region at face {0.face}"


@dataclass(frozen=True)
class CutRegion(AtFace):
    """Cut a region along a line, swept along a direction such as the view; scan coordinates."""

    described = "Cut the region at face {0.face}"

    line: tuple[tuple[float, ...], ...] = ()  #: points, at least 2
    direction: tuple[float, ...] = ()  #: empty: the region's normal

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "line", tuple(numbers(point, said("a point of line")) for point in self.line))
        object.__setattr__(self, "direction", numbers(self.direction, "direction"))
        check(len(self.line) < 2, said("line must have at least 2 points, got {number}", number=len(self.line)))
        check(any(len(point) != 3 for point in self.line), said("each point of line must have 3 numbers"))
        check(
            len(self.direction) not in (0, 3),
            said("direction must have 3 numbers, got {number}", number=len(self.direction)),
        )


@dataclass(frozen=True)
class PaintFaces(AtFaces):
    """Make faces a new region, or part of the region of the face `onto`."""

    onto: int = -1  #: below 0: a new region
    lock: bool = False  #: lock the painted region

    is_stroke = True

    def describe(self) -> str:
        where = "a new region" if self.onto < 0 else f"the region at face {self.onto}"
        return f"Paint {self.named} into {where}" + (", locked" if self.lock else "")


@dataclass(frozen=True)
class EraseFaces(AtFaces):
    """Erase faces from the region of the first of them; its neighbours take them."""

    described = "Erase {0.named} from the region at face {0.faces[0]}"
    is_stroke = True


@dataclass(frozen=True)
class SmoothFaces(AtFaces):
    """Smooth the region borders inside some faces. The first face may be in a locked region."""

    described = "Smooth the borders in {0.named}"

    rounds: int = 10

    is_stroke = True

    def __post_init__(self) -> None:
        super().__post_init__()
        must(1 <= self.rounds <= MOST_ROUNDS, "rounds", f"in [1, {MOST_ROUNDS:,}]", self.rounds)


@dataclass(frozen=True)
class GrowRegion(AtFace):
    """Grow a region by rings of faces."""

    described = "Grow the region at face {0.face} by {0.rings}"

    rings: int = 1

    def __post_init__(self) -> None:
        super().__post_init__()
        must(self.rings >= 1, "rings", own("at least 1"), self.rings)


@dataclass(frozen=True)
class ShrinkRegion(GrowRegion):
    """Shrink a region by rings of faces."""

    described = "Shrink the region at face {0.face} by {0.rings}"


@dataclass(frozen=True)
class LockRegions(AtFaces):
    """Protect the regions of some faces from all later steps."""

    described = "Lock the regions at {0.named}"


@dataclass(frozen=True)
class UnlockRegions(LockRegions):
    """Allow later steps to change the regions of some faces again."""

    described = "Unlock the regions at {0.named}"


@dataclass(frozen=True)
class LeaveOutRegions(LockRegions):
    """Make no polygons of the regions of some faces, and protect them from all later steps."""

    box: bool = False  #: a box replaces each group of adjacent regions

    def describe(self) -> str:
        what = "Replace by boxes" if self.box else "Leave out"
        return f"{what} the regions at {self.named}"


@dataclass(frozen=True)
class AddWorst(Step):
    """Add regions at the places of largest error."""

    described = "Add {0.times} at the largest error"

    times: int = 1

    def __post_init__(self) -> None:
        must(self.times >= 1, "times", own("at least 1"), self.times)


@dataclass(frozen=True)
class DeleteLeast(AddWorst):
    """Delete the regions whose removal adds least error."""

    described = "Delete {0.times} of least error"


@dataclass(frozen=True)
class MergeCheapest(AddWorst):
    """Merge the neighbouring regions whose union adds least error."""

    described = "Merge {0.times} of least error"


@dataclass(frozen=True)
class Improve(Step):
    """Move regions to places where they lower the error more, until it no longer falls."""

    described = "Improve"


@dataclass(frozen=True)
class EvenBorders(Step):
    """Make all borders between regions short and straight."""

    described = "Even out all borders"

    strength: float = 1.0

    def __post_init__(self) -> None:
        must(0 <= self.strength <= 1, "strength", "in [0, 1]", self.strength)


@dataclass(frozen=True)
class Mesh(MeshingFields):
    """Turn the regions into polygons."""

    described = "Mesh"
    late = unlabelled(MESHING)

    def __post_init__(self) -> None:
        check_options(self, MESHING)
        must(self.chord_tolerance > 0, "chord_tolerance", own("above 0"), self.chord_tolerance)


@dataclass(frozen=True)
class Texture(TextureFields):
    """Show the scan's images on the polygons of the Mesh step before it."""

    late = unlabelled(TEXTURE)

    def __post_init__(self) -> None:
        check_options(self, TEXTURE)

    def describe(self) -> str:
        return f"Texture {self.size:,}" if self.size else "Texture"


KINDS |= {
    Partition: "partition",
    AddProxy: "add_proxy",
    DeleteProxy: "delete_proxy",
    MergeRegions: "merge_regions",
    SplitRegion: "split_region",
    CutRegion: "cut_region",
    PaintFaces: "paint",
    EraseFaces: "erase",
    SmoothFaces: "smooth",
    GrowRegion: "grow",
    ShrinkRegion: "shrink",
    LockRegions: "lock",
    LeaveOutRegions: "leave_out",
    UnlockRegions: "unlock",
    AddWorst: "add_worst",
    DeleteLeast: "delete_least",
    MergeCheapest: "merge_cheapest",
    Improve: "improve",
    EvenBorders: "even_borders",
    RoundRegions: "round",
    RoundSegments: "segments",
    ExplodeRound: "explode",
    Regularise: "regularise",
    AlignPlanes: "align",
    Mesh: "mesh",
    Texture: "texture",
}
#: Settings that steps saved by earlier versions lack, with the values of that time. A saved step has all settings
#: of its version, so one that has the first of these but not the second is one; people write fewer.
_EARLIER: dict[str, tuple[set[str], dict[str, Any]]] = {
    "partition": (
        {"seed", "leave_out"},
        {"smooth": 0.0, "metric": "normals", "close_openings": False, "stitch": 0.0, "grid": 0.0},
    ),
    "mesh": ({"chord_tolerance", "flatten"}, {"join_junctions": 0.0, "straight_rims": 0.0}),
}
#: Settings that a recipe written by a person may lack, with the engine's defaults, where the panel has others
_ABSENT: dict[str, dict[str, Any]] = {"partition": {"adaptivity": 0.0}}
_ACCEPTS: dict[str, type | tuple[type, ...]] = {
    "bool": bool,
    "int": int,
    "str": str,
    "float": (float, int),
    "list": (list, tuple),
}
_CALLED = {
    "bool": own("true or false"),
    "int": own("a whole number"),
    "str": own("a text"),
    "float": own("a number"),
    "list": own("a list"),
}


def step_from_dict(values: Any) -> Step:
    """The step that `Step.to_dict` made. Raises RecipeError, which names the problem."""
    if not isinstance(values, dict) or "step" not in values:
        raise RecipeError(said("not a step: {values}", values=short(values)))
    values = dict(values)
    kind = values.pop("step")
    cls = next((cls for cls, name in KINDS.items() if name == kind), None)
    if cls is None:
        raise RecipeError(said("{kind} is not a step of this version", kind=short(kind)))
    fields = {field.name: field for field in dataclasses.fields(cls)}
    values = {name: value for name, value in values.items() if name not in GONE.get(str(kind), ())}
    for name, value in values.items():
        if name not in fields:
            raise RecipeError(said("{kind} has no setting {name}", kind=kind, name=short(name)))
        wanted = "list" if fields[name].type.startswith("tuple") else fields[name].type.removesuffix(" | None")
        _check_value(said("{name} of {step}", name=name, step=kind), wanted, value, name == "seed")
    names, meant = _EARLIER.get(kind, (set(), {}))
    meant = _ABSENT.get(kind, {}) | (meant if names <= values.keys() else {})
    return cls(**(meant | values))


def gone_from(values: Any) -> tuple[str, ...]:
    """The settings in a saved step that had an effect in an earlier version, and have none in this one."""
    known = GONE.get(str(values.get("step")), {}) if isinstance(values, dict) else {}
    return tuple(name for name, without in known.items() if values.get(name, without) != without)


def _check_value(what: str, wanted: str, value: Any, is_seed: bool) -> None:
    """Refuses a value of another type, or beyond the limits of the engine or Blender."""
    if not isinstance(value, _ACCEPTS[wanted]) or (wanted != "bool" and isinstance(value, bool)):
        must(False, what, _CALLED[wanted], value)
    if isinstance(value, str) and not _is_name(value):
        text = own("{name} contains characters that are not valid in a name, got {value}")
        raise RecipeError(said(text, name=what, value=short(value)))
    most = _LARGEST if wanted == "int" and not is_seed else _LARGEST_SEED
    if isinstance(value, int) and abs(value) > most:
        raise RecipeError(said("{name} must be at most {most}, got {value}", name=what, most=most, value=short(value)))


def _is_name(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:  # half of a pair, which JSON can write
        return False
    return "\0" not in text
