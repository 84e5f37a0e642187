"""Messages to the user.

They use the words of the panel. They name no step and no face by a number that the user has not given. This module does
not import Blender.
"""

from __future__ import annotations

import re
from typing import Any

from . import recipe as rcp
from .outcome import StepFailed

EDITED = "This result was edited by hand: changed settings do not change it, and Mesh makes a new object beside it"
SCAN_EDITED = "The scan was edited since Partition: its regions were found again, and may differ"
COMPARE_KEYS = "Drag: move the line   C: plain, regions or texture   Middle mouse: turn the view   Esc: end"
RESULT_TOOL = "This is the result, and has no regions to edit: press Swap to go to the scan"


def count(number: int, one: str) -> str:
    """A number with its noun: "1 region", "1,280 regions"."""
    many = f"{one[:-2]}ices" if one.endswith("vertex") else f"{one}s"
    return f"{number:,} {one if number == 1 else many}"


def partitioned(numbers: dict[str, Any]) -> str:
    told = f"{count(numbers['triangles'], 'triangle')} in {count(numbers['regions'], 'region')}"
    more = numbers["regions"] - numbers.get("asked", numbers["regions"])
    return f"{told}, {more:,} more than requested, as its parts need them" if more > 0 else told


def meshed(numbers: dict[str, Any]) -> str:
    closed = "closed" if numbers["closed"] else "open"
    return f"{count(numbers['triangles'], 'triangle')} -> {count(numbers['polygons'], 'polygon')}, {closed}"


def changed(before: dict[str, Any], numbers: dict[str, Any]) -> str:
    """What an edit has done."""
    now = count(numbers["regions"], "region")
    return f"{count(before['regions'], 'region')} -> {now}" if "regions" in before else now


def evened(numbers: dict[str, Any]) -> str:
    return f"The borders of {count(numbers['regions'], 'region')} are even"


def kept_open(numbers: dict[str, Any]) -> str:
    repairs = numbers.get("repairs", {})
    closed = repairs.get("filled_holes", 0) + repairs.get("cut_handles", 0)
    return f"{count(numbers.get('kept_open', 0), 'opening')} kept open, {closed:,} closed"


def several(number: int) -> str:
    return f"{count(number, 'scan')} done"


def skipped(names: list[str]) -> str:
    """Selected scans that Mesh can't do."""
    named = ", ".join(f"'{name}'" for name in names[:3]) + (" and others" if len(names) > 3 else "")
    return f"Not done, as they have no regions yet: {named}"


def hidden(name: str) -> str:
    return f"'{name}' can't be seen: its collection is hidden. Show it in the Outliner"


def shared(names: list[str]) -> str:
    """Linked duplicates of a scan."""
    who = f"'{names[0]}' has" if len(names) == 1 else f"{count(len(names), 'other object')} have"
    return f"{who} the same mesh, and so the same regions"


def compared(is_result: bool, faces: int) -> str:
    return f"Result: {count(faces, 'polygon')}" if is_result else f"Scan: {count(faces, 'face')}"


def locked(numbers: dict[str, Any]) -> str:
    number = numbers.get("locked", 0)
    return f"{count(number, 'region')} locked" if number else "No region is locked"


def kept(edited: str, made: str) -> str:
    """Mesh was pressed again after the result was edited by hand."""
    return f"'{edited}' was edited by hand and is kept, hidden. The new polygons are '{made}'"


def hand_edits(recipe: rcp.Recipe | None) -> int:
    """How many edits by hand a partition of the whole scan would drop."""
    if recipe is None or not recipe.steps:
        return 0
    steps = recipe.without_mesh().steps
    left = recipe.then(rcp.Partition()).steps[:-1]
    return sum(
        1 for step in steps[len(left) :] if step.enabled and not (isinstance(step, rcp.Partition) and not step.faces)
    )


def dropped(number: int) -> str:
    verb = "was" if number == 1 else "were"
    back = "it" if number == 1 else "them"
    return f"{count(number, 'edit')} by hand {verb} dropped: Ctrl-Z brings {back} back"


def will_drop(number: int) -> str:
    return f"Partition starts anew: {count(number, 'edit')} by hand will be dropped"


#: An engine's reason, and the words of the person who pointed at the place that it names
_REASONS = (
    (r"the region of face \d+ is locked: unlock it first", "this region is locked: press L over it, or Unlock"),
    (
        r"the region of face \d+ is the only one of its part( that is not locked)?: it can't be deleted",
        r"this is the only region of its loose part\1: it can't be deleted",
    ),
    (
        r"the region of face \d+ is that face alone: there is nothing to split",
        "this region is a single face: there is nothing to split",
    ),
    (
        r"face \d+ lies in a part that was left out",
        "this part was left out, as it is small: set Leave Out to 0 and press Partition",
    ),
    (
        r"face \d+ was left out by the repair of the mesh: it has no area or is a duplicate",
        "this face is in no region: it has no area, is a duplicate, or lies in an opening that was closed",
    ),
    (
        r"the regions of .* share no edge: only neighbours can be merged",
        "these regions share no edge: only neighbours can be merged",
    ),
    (r"faces? .* are in one region: there is nothing to merge", "this is one region: there is nothing to merge"),
    (r"the line does not cut the region of face \d+.*", "the line does not cross this region"),
    (
        r"there is nothing to paint: no face was given that is not locked or of the region already",
        "all these faces are in that region already, or locked",
    ),
    (
        r"the faces to erase touch no other region that could take them( and is not locked)?",
        r"no other region beside these faces could take them\1",
    ),
)


def reason(said: str) -> str:
    """A reason of the engine in the words of the panel."""
    said = said.rstrip(".")
    found = re.search(r"proxies must be in \[1, (\d+)\], got (-?\d+)", said)
    if found:
        most = int(found[1])
        return f"at most {count(most, 'region')} are possible, one for each triangle"
    for pattern, words in _REASONS:
        said, times = re.subn(pattern, words, said)
        if times:
            return said
    return said.replace("proxies", "regions").replace("proxy", "region")


def failed(error: StepFailed, names_step: bool) -> str:
    """Why a step failed. names_step: the user looks at the list of steps, or does not know which one it was."""
    said = reason(error.reason)
    return f"Step {error.index + 1}, {line(error.step)}: {said}" if names_step else said[:1].upper() + said[1:]


_LINES = {
    rcp.AddProxy: "Add a region",
    rcp.DeleteProxy: "Delete a region",
    rcp.MergeRegions: "Merge two regions",
    rcp.SplitRegion: "Split a region",
    rcp.CutRegion: "Cut a region",
}


def line(step: rcp.Step) -> str:
    """A step's line in the list of steps."""
    if type(step) in _LINES:
        return _LINES[type(step)]
    if isinstance(step, rcp.Partition):
        return _partition_line(step)
    faces = count(len(getattr(step, "faces", ())), "face")
    if isinstance(step, rcp.PaintFaces):
        return f"Paint {faces} into {'a new' if step.onto < 0 else 'a'} region" + (", locked" if step.lock else "")
    if isinstance(step, rcp.EraseFaces):
        return f"Erase {faces} from a region"
    if isinstance(step, rcp.GrowRegion):
        verb = "Shrink" if isinstance(step, rcp.ShrinkRegion) else "Grow"
        return f"{verb} a region by {count(step.rings, 'ring')}"
    if isinstance(step, rcp.LockRegions):
        verb = "Unlock" if isinstance(step, rcp.UnlockRegions) else "Lock"
        return f"{verb} {count(len(step.faces), 'region')}"
    return step.describe()


def _partition_line(step: rcp.Partition) -> str:
    what = f"Partition {count(len(step.faces), 'face')}" if step.faces else "Partition"
    if step.count_by == "proxies":
        return f"{what} into {step.proxies:,}"
    if step.count_by == "detail":
        return f"{what}, detail {100 * (step.detail or 0):.3g} %"
    return f"{what}, {step.count_by} {getattr(step, step.count_by):.4g}"


_WHY = {
    "split_for_holes": "holes",
    "split_for_handles": "handles",
    "split_for_pinches": "pinched borders",
    "split_for_closed": "closed shapes",
    "split_for_unconnected": "loose pieces",
}


def why_more(numbers: dict[str, Any]) -> str:
    """Why there are more polygons than regions; empty if there are not. The figures add up to the difference.

    What no other cause explains is the repair of polygons that were not flat. It splits regions and adds diagonals, and
    removes some of both later, so its own counts do not add up.
    """
    more, split = numbers["polygons"] - numbers["regions"], numbers.get("split", {})
    if more <= 0 or not split:
        return f"{more:,} more than regions" if more > 0 else ""
    causes = {f"with {cause}": split.get(name, 0) for name, cause in _WHY.items()}
    causes["cut off to be planar"] = split.get("cut_to_be_planar", 0)
    causes["fewer without area"] = gone = split.get("without_area", 0)
    causes["not flat"] = more + 2 * gone - sum(causes.values())
    said = sorted(((number, cause) for cause, number in causes.items() if number > 0), reverse=True)
    return f"{more:,} more than regions: " + ", ".join(f"{number:,} {cause}" for number, cause in said)


def expected(numbers: dict[str, Any]) -> str:
    """How many polygons Mesh will about make, and why; empty where that is not known or they are there."""
    counts = numbers.get("expected", {})
    if "polygons" in numbers or not {"polygons", "regions"} <= counts.keys():
        return ""
    why = why_more({"polygons": counts["polygons"], "regions": counts["regions"], "split": counts})
    return f"Mesh will make about {count(counts['polygons'], 'polygon')}" + (f", {why}" if why else "")


def summary(regions: int, polygons: int | None, away: str) -> str:
    """The line in the corner of the viewport."""
    if polygons is None:
        return count(regions, "region")
    return f"{count(regions, 'region')} -> {count(polygons, 'polygon')}" + (f", {away} off the scan" if away else "")
