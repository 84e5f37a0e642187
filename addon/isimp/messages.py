"""Makes the messages to the user.

They use the words of the panel, and no number of a step or a face that the user has not entered. This module does not
import Blender.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from . import recipe as rcp
from .language import count, own, said
from .outcome import StepFailed

SCAN_EDITED = own("The scan was edited since Partition: its regions were found again, and may differ")
COMPARE_KEYS = own("Drag: move the line   C: plain, regions or texture   Middle mouse: turn the view   Esc: end")
REGIONS_CHANGED = own("The regions have changed since Mesh: press Mesh again, then Keep Texture.")
NO_FACE = own("No face is selected: select one in Edit Mode (Tab, then 3), or give its number.")
RESULT_TOOL = own("This is the result, and has no regions to edit: press Swap to go to the scan")


def partitioned(numbers: dict[str, Any]) -> str:
    triangles, regions = count(numbers["triangles"], "triangle"), count(numbers["regions"], "region")
    more = numbers["regions"] - numbers.get("asked", numbers["regions"])
    if more <= 0:
        return said("{triangles} in {regions}", triangles=triangles, regions=regions)
    text = own("{triangles} in {regions}, {more} more than requested, as its parts need them")
    return said(text, triangles=triangles, regions=regions, more=f"{more:,}")


def meshed(numbers: dict[str, Any], width: int = 0) -> str:
    """Return the report of Mesh. width: width of the widest image of the texture, pixels; 0 without a texture."""
    triangles, polygons = count(numbers["triangles"], "triangle"), count(numbers["polygons"], "polygon")
    text = own("{triangles} -> {polygons}, closed") if numbers["closed"] else own("{triangles} -> {polygons}, open")
    told = said(text, triangles=triangles, polygons=polygons)
    return said("{made}, texture of {width} px", made=told, width=f"{width:,}") if width else told


def changed(before: dict[str, Any], numbers: dict[str, Any]) -> str:
    """Return the report of an edit: the numbers of regions before and after."""
    now = count(numbers["regions"], "region")
    return f"{count(before['regions'], 'region')} -> {now}" if "regions" in before else now


def evened(numbers: dict[str, Any]) -> str:
    return said("Even borders: {regions}", regions=count(numbers["regions"], "region"))


def kept_open(numbers: dict[str, Any]) -> str:
    repairs = numbers.get("repairs", {})
    closed = repairs.get("filled_holes", 0) + repairs.get("cut_handles", 0)
    kept = count(numbers.get("kept_open", 0), "opening")
    return said("{openings} kept open, {closed} closed", openings=kept, closed=f"{closed:,}")


def several(number: int) -> str:
    return said("{scans} done", scans=count(number, "scan"))


def listed(names: list[str], most: int = 3) -> str:
    """Return the names of objects, at most the first `most`."""
    named = ", ".join(f"'{name}'" for name in names[:most])
    return said("{names} and others", names=named) if len(names) > most else named


def skipped(names: list[str]) -> str:
    """Return the warning about selected scans without regions."""
    return said("Not done, as they have no regions yet: {names}", names=listed(names))


def textured(report: dict[str, Any]) -> str:
    charts = count(report["charts"], "chart")
    return said("Texture of {size} x {size} pixels, {charts}", size=f"{report['size']:,}", charts=charts)


def hidden(name: str) -> str:
    return said("'{name}' can't be seen: its collection is hidden. Show it in the Outliner", name=name)


def shared(names: list[str]) -> str:
    """Return the note about linked duplicates of a scan."""
    if len(names) == 1:
        return said("'{name}' has the same mesh, and so the same regions", name=names[0])
    others = count(len(names), "other object")
    return said("{others} have the same mesh, and so the same regions", others=others)


def compared(is_result: bool, faces: int) -> str:
    if is_result:
        return said("Result: {polygons}", polygons=count(faces, "polygon"))
    return said("Scan: {faces}", faces=count(faces, "face"))


def locked(numbers: dict[str, Any]) -> str:
    number = numbers.get("locked", 0)
    return said("{regions} locked", regions=count(number, "region")) if number else said("No region is locked")


def left_out(numbers: dict[str, Any]) -> str:
    number = numbers.get("regions_left_out", 0)
    return said("{regions} left out", regions=count(number, "region")) if number else said("No region is left out")


def is_kept(why: str) -> str:
    """Return the note that settings and Mesh do not change a result. why: the reason, as in `kept`."""
    text = own("This result was {why}: changed settings do not change it, and Mesh makes a new object")
    return said(text, why=said(why))


def kept(name: str, why: str, is_hidden: bool, made: str) -> str:
    """Return the warning that Mesh kept a result because it was edited by hand or copied."""
    text = own("'{name}' was {why} and is kept. The new polygons are '{made}'")
    if is_hidden:
        text = own("'{name}' was {why} and is kept, hidden. The new polygons are '{made}'")
    return said(text, name=name, why=said(why), made=made)


def hand_edits(recipe: rcp.Recipe | None, regularises: bool = False) -> int:
    """Return how many edits a partition of the whole scan would drop. regularises: whether Mesh regularises first."""
    if recipe is None or not recipe.steps:
        return 0
    steps = recipe.without_mesh().steps
    dropped = steps[len(recipe.then(rcp.Partition()).steps) - 1 :]
    return sum(1 for step in dropped if step.enabled and not _comes_again(step, regularises))


def _comes_again(step: rcp.Step, regularises: bool) -> bool:
    """Return whether Partition or Mesh makes a step like this one again."""
    if isinstance(step, rcp.Regularise):
        return regularises
    return isinstance(step, rcp.Partition) and not step.faces


def lost(number: int) -> str:
    """Return the warning about steps of a recipe that name faces which this scan lacks."""
    if number == 1:
        return said("1 step is off: this scan has no face at its place")
    return said("{number} steps are off: this scan has no face at their places", number=number)


def dropped(number: int) -> str:
    edits = count(number, "edit")
    if number == 1:
        return said("{edits} by hand was dropped: Ctrl-Z brings it back", edits=edits)
    return said("{edits} by hand were dropped: Ctrl-Z brings them back", edits=edits)


def will_drop(number: int) -> str:
    return said("Partition starts over: {edits} by hand will be dropped", edits=count(number, "edit"))


#: patterns of the engine's reasons, and the messages for a user who has clicked the face that they name
_REASONS = (
    (
        r"round parts can't be had with a bound: .*",
        own("round parts can't be had with a bound: choose another way to set the number of regions"),
    ),
    *(
        (text, text)
        for text in (
            own("no region is chosen for the up direction: select a face and press Regularise"),
            own("the region for the up direction was left out: select another face"),
            own("level and upright need an up direction: choose an axis for Up"),
        )
    ),
    (r"face \d+ is in no round part", own("this region is in no round part")),
    (
        r"a cell of the round part at face \d+ is locked: unlock it first",
        own("a cell of this round part is locked: unlock it first"),
    ),
    (
        "the faces given determine no round surface: .*",
        own("these regions determine no round surface: choose more regions of one round part"),
    ),
    (r"the region of face \d+ is locked: unlock it first", own("this region is locked: press L over it, or Unlock")),
    (
        r"the region of face \d+ is the only one of its part that is not locked: it can't be deleted",
        own("this is the only region of its loose part that is not locked: it can't be deleted"),
    ),
    (
        r"the region of face \d+ is the only one of its part: it can't be deleted",
        own("this is the only region of its loose part: it can't be deleted"),
    ),
    (
        r"the region of face \d+ is that face alone: there is nothing to split",
        own("this region is a single face: there is nothing to split"),
    ),
    (
        r"face \d+ lies in a part that was left out",
        own("this part was left out, as it is small: set Ignore Parts Below to 0 and press Partition"),
    ),
    (
        r"face \d+ was left out by the repair of the mesh: it has no area or is a duplicate",
        own("this face is in no region: it has no area, is a duplicate, or lies in an opening that was closed"),
    ),
    (
        r"the regions of .* share no edge: only neighbours can be merged",
        own("only neighbouring regions can be merged"),
    ),
    (
        r"faces? .* are in one region: there is nothing to merge",
        own("this is one region: there is nothing to merge"),
    ),
    (
        r"the region of face \d+ is square to the plane that it should have",
        own("this region is at right angles to the plane that it should have"),
    ),
    (
        r"all faces are in one .*",
        own("this is one region: select faces of two or more"),
    ),
    (r"the line does not cut the region of face \d+.*", own("the line does not cross this region")),
    (
        r"there is nothing to paint: no face was given that is not locked or of the region already",
        own("all these faces are in that region already, or locked"),
    ),
    (
        r"the faces to erase touch no other region that could take them and is not locked",
        own("no other region next to these faces could take them and is not locked"),
    ),
    (
        r"the faces to erase touch no other region that could take them",
        own("no other region next to these faces could take them"),
    ),
)


def plain(value: float) -> str:
    return f"{value:.4g}"


def reason(told: str, length: Callable[[float], str] = plain) -> str:
    """Return a reason of the engine in the words of the panel. length: returns the text of a length."""
    told = told.rstrip(".")
    found = re.search(r"proxies must be in \[1, (\d+)\], got (-?\d+)", told)
    if found:
        most = count(int(found[1]), "region")
        return said("at most {regions} are possible, one for each triangle", regions=most)
    found = re.search(r"the region of face \d+ needs ([\d.e+-]+), allowed ([\d.e+-]+)$", told)
    if found:
        needed, allowed = (length(float(number)) for number in found.groups())
        return said("this region needs {needed}, allowed {allowed}", needed=needed, allowed=allowed)
    found = re.search(r"there is no face (\d+): the mesh has (\d+) faces", told)
    if found:
        return said("there is no face {face}: the mesh has {count} faces", face=found[1], count=found[2])
    for pattern, words in _REASONS:
        found = re.search(pattern, told)
        if found:
            return told[: found.start()] + said(words) + told[found.end() :]
    return told.replace("proxies", "regions").replace("proxy", "region")


def failed(error: StepFailed, names_step: bool, length: Callable[[float], str] = plain) -> str:
    """Return why a step failed. names_step: the message has the step's number, as the user may not know the step."""
    why = reason(error.reason, length)
    if names_step:
        return said("Step {number}, {step}: {why}", number=error.index + 1, step=line(error.step), why=why)
    return why[:1].upper() + why[1:]


def unchanged(why: str) -> str:
    """Return the message of a failed operation that changed nothing."""
    return said("{why}. Nothing was changed.", why=why.rstrip("."))


def no_step(index: int, steps: int) -> str:
    return said("There is no step {number}: the recipe has {steps}.", number=index + 1, steps=steps)


_LINES = {
    rcp.AddProxy: own("Add a region"),
    rcp.DeleteProxy: own("Delete a region"),
    rcp.MergeRegions: own("Merge two regions"),
    rcp.SplitRegion: own("Split a region"),
    rcp.CutRegion: own("Cut a region"),
    rcp.Improve: own("Improve"),
    rcp.EvenBorders: own("Even out all borders"),
    rcp.ExplodeRound: own("Explode a round part"),
    rcp.Regularise: own("Regularise"),
    rcp.Mesh: own("Mesh"),
    rcp.Texture: own("Keep Texture"),
}
_OF_FACES = {
    rcp.EraseFaces: own("Erase {faces} from a region"),
    rcp.SmoothFaces: own("Smooth the borders in {faces}"),
}
_OF_REGIONS = {
    rcp.RoundRegions: own("Make {regions} round"),
    rcp.LockRegions: own("Lock {regions}"),
    rcp.UnlockRegions: own("Unlock {regions}"),
    rcp.LeaveOutRegions: own("Leave out {regions}"),
}
_OF_PLANES = {
    "level": own("Make {regions} level"),
    "upright": own("Make {regions} upright"),
    "parallel": own("Make {regions} parallel"),
    "perpendicular": own("Make {regions} perpendicular"),
    "coplanar": own("Make {regions} coplanar"),
    "free": own("Free {regions}"),
}
_OF_TIMES = {
    rcp.AddWorst: own("Add {number} at the largest error"),
    rcp.DeleteLeast: own("Delete {number} of least error"),
    rcp.MergeCheapest: own("Merge {number} of least error"),
}


def line(step: rcp.Step) -> str:
    """Return a step's line in the list of steps."""
    if type(step) in _LINES:
        return said(_LINES[type(step)])
    if isinstance(step, rcp.Partition):
        return _partition_line(step)
    faces = len(getattr(step, "faces", ()))
    if type(step) in _OF_FACES:
        return said(_OF_FACES[type(step)], faces=count(faces, "face"))
    if isinstance(step, rcp.AlignPlanes):
        return said(_OF_PLANES[step.to], regions=count(faces, "region"))
    if type(step) in _OF_TIMES:
        return said(_OF_TIMES[type(step)], number=f"{step.times:,}")
    if isinstance(step, rcp.PaintFaces):
        return _paint_line(step, count(faces, "face"))
    if isinstance(step, rcp.GrowRegion):  # ShrinkRegion is a subclass
        text = (
            own("Shrink a region by {rings}") if isinstance(step, rcp.ShrinkRegion) else own("Grow a region by {rings}")
        )
        return said(text, rings=count(step.rings, "ring"))
    if isinstance(step, rcp.RoundSegments):
        return said("{number} segments for a round part", number=step.segments)
    if isinstance(step, rcp.LeaveOutRegions) and step.box:
        return said("Replace {regions} by boxes", regions=count(faces, "region"))
    if type(step) in _OF_REGIONS:
        return said(_OF_REGIONS[type(step)], regions=count(faces, "region"))
    return step.describe()


def _paint_line(step: rcp.PaintFaces, faces: str) -> str:
    text = own("Paint {faces} into a new region") if step.onto < 0 else own("Paint {faces} into a region")
    told = said(text, faces=faces)
    return said("{step}, locked", step=told) if step.lock else told


def _partition_line(step: rcp.Partition) -> str:
    what = said("Partition")
    if step.faces:
        what = said("Partition {faces}", faces=count(len(step.faces), "face"))
    if step.count_by == "proxies":
        return said("{what} into {number}", what=what, number=f"{step.proxies:,}")
    if step.count_by == "triangles":
        return said("{what}, at most {number} triangles", what=what, number=f"{step.triangles:,}")
    if step.count_by == "detail":
        return said("{what}, detail {number} %", what=what, number=f"{100 * (step.detail or 0):.3g}")
    text = own("{what}, tolerance {number}") if step.count_by == "tolerance" else own("{what}, bound {number}")
    return said(text, what=what, number=f"{getattr(step, step.count_by):.4g}")


#: Names of the stages in progress lines of the add-on and the engine
STAGES = (
    own("Adding"),
    own("Adding a region"),
    own("Adding regions"),
    own("Aligning planes"),
    own("Baking"),
    own("Carrying back"),
    own("Cells"),
    own("Cleaning"),
    own("Closing holes"),
    own("Counting polygons"),
    own("Cutting"),
    own("Cutting off a part"),
    own("Cutting round parts"),
    own("Decimating"),
    own("Deleting"),
    own("Deleting a region"),
    own("Deleting regions"),
    own("Enclosing"),
    own("Erasing"),
    own("Evening out"),
    own("Finding details"),
    own("Finding round parts"),
    own("Fitting planes"),
    own("Flooding"),
    own("Growing"),
    own("Improving"),
    own("Joining polygons"),
    own("Locking"),
    own("Making round"),
    own("Making the texture"),
    own("Measuring"),
    own("Merging"),
    own("Meshing"),
    own("Painting"),
    own("Partitioning"),
    own("Reading the mesh"),
    own("Regularising"),
    own("Relaxing"),
    own("Repairing"),
    own("Seeding"),
    own("Shrinking"),
    own("Smoothing"),
    own("Splitting"),
    own("Teleporting"),
    own("Walls"),
)

_WHY = {
    "split_for_holes": own("{number} with holes"),
    "split_for_handles": own("{number} with handles"),
    "split_for_pinches": own("{number} with pinched borders"),
    "split_for_closed": own("{number} with closed shapes"),
    "split_for_unconnected": own("{number} with loose pieces"),
}

_FEWER = own("{number} fewer without area")


def why_more(numbers: dict[str, Any]) -> str:
    """Return why there are more polygons than regions; empty if there are not. The figures add up to the difference.

    The remainder after all counted causes is attributed to bent regions. Their repair splits regions and
    later joins some again, so its own count does not add up.
    """
    more, split = numbers["polygons"] - numbers["regions"], numbers.get("split", {})
    if more <= 0 or not split:
        return said("{more} more than regions", more=f"{more:,}") if more > 0 else ""
    causes = {cause: split.get(name, 0) for name, cause in _WHY.items()}
    causes[own("{number} corners cut to keep faces flat")] = split.get("cut_to_be_planar", 0)
    causes[own("{number} cut to be convex")] = split.get("cut_to_be_convex", 0)
    causes[_FEWER] = gone = split.get("without_area", 0)
    causes[own("{number} split because they bend")] = more + 2 * gone - sum(causes.values())
    found = sorted(((number, cause) for cause, number in causes.items() if number > 0), reverse=True)
    told = ", ".join(said(cause, number=f"{number:,}") for number, cause in found)
    return said("{more} more than regions: {causes}", more=f"{more:,}", causes=told)


def expected(
    numbers: dict[str, Any],
    previewed: dict[str, Any] | None = None,
    snaps: bool = False,
) -> str:
    """Return how many polygons Mesh will make, and why; empty if that is unknown or they exist.

    previewed: the numbers of their preview, which are exact; None: the estimate of the partition is used.
    snaps: whether polygons become exactly planar or convex or planes are snapped, which the estimate ignores.
    """
    if "polygons" in numbers:
        return ""
    counts = numbers.get("expected", {})
    if previewed and "polygons" in previewed:
        polygons = count(previewed["polygons"], "polygon")
        told, why = said("Mesh will make {polygons}", polygons=polygons), why_more(previewed)
    elif {"polygons", "regions"} <= counts.keys():
        why = why_more({"polygons": counts["polygons"], "regions": counts["regions"], "split": counts})
        text = own("Mesh will make about {polygons} or more") if snaps else own("Mesh will make about {polygons}")
        told = said(text, polygons=count(counts["polygons"], "polygon"))
    else:
        return ""
    return f"{told}, {why}" if why else told


def moved(numbers: dict[str, Any]) -> str:
    """Return the line about edits on other regions than when they were made; empty without any."""
    edits = len(numbers.get("moved", ()))
    return said("{edits} on other regions now", edits=count(edits, "edit")) if edits else ""


def magenta(regions: int) -> str:
    """Return the legend of defective polygons over the scan; empty without any."""
    return said("magenta: defects in {regions}", regions=count(regions, "region")) if regions else ""


def summary(regions: int, polygons: int | None, away: str) -> str:
    """Return the text in the corner of the viewport."""
    if polygons is None:
        return count(regions, "region")
    told = f"{count(regions, 'region')} -> {count(polygons, 'polygon')}"
    return said("{numbers}, {away} off the scan", numbers=told, away=away) if away else told
