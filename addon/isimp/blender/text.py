"""Texts of the panel: numbers, warnings, reports."""

import math
import re
import textwrap

import bpy

from .. import afar, messages
from ..language import count as _count
from ..language import noun, own, said
from . import mesh_io

_STAY = "\N{NO-BREAK SPACE}"
_REPORT = 200  # letters of a report, its lines filled up
_LEAST_ROWS = 5
_CAUSES = (None, 2, 1, 0)  # told of why there are more polygons than regions: all, or so many


def wrapped(message: str, width: int) -> list:
    """Lines of at most `width` letters; words joined by no-break spaces are split only if they are longer."""
    message = re.sub(r"(?<=\d) (?=(?:[a-zµ]{1,2}|[%'\"])(?: |$))", _STAY, message)  # a number keeps its unit
    parts = (part if len(part) <= width else part.replace(_STAY, " ") for part in message.split(" "))
    return textwrap.wrap(" ".join(parts), width)


def fitted(told: str, measure, room: float) -> list:
    """Lines of some words, none wider than `room` but for a single word. measure: how wide some words are."""
    lines: list = []
    for word in told.split(" "):
        longer = f"{lines[-1]} {word}" if lines else word
        if lines and measure(longer) <= room:
            lines[-1] = longer
        else:
            lines.append(word)
    return lines


def beside(told: str, measure, wanted: float, right: float, left: float) -> tuple[list, float]:
    """(lines, where they begin) of words that should begin at `wanted` and must lie between `left` and `right`.

    measure: how wide some words are. Lines break between statements, at " · ", and only where one line has no room.
    """
    lines, room = [], right - left
    for part in told.split(" · "):
        if lines and measure(f"{lines[-1]} · {part}") <= room:
            lines[-1] += f" · {part}"
        else:
            lines.append(part)
    return lines, max(left, min(wanted, right - max(map(measure, lines))))


def scan_lines(mesh, numbers: dict) -> tuple:
    """(size, shape) of a scan, always two lines. Parts and holes are known after Partition."""
    triangles = len(mesh.loops) - 2 * len(mesh.polygons)
    if not describes(mesh, numbers):
        return _count(triangles, "triangle"), said("Not partitioned yet")
    holes = said("closed") if numbers["closed"] else _count(numbers["border_loops"], "hole")
    return _count(numbers["triangles"], "triangle"), f"{_count(numbers['components'], 'part')} · {holes}"


_FAULTS = {
    "non_finite_faces": noun("invalid face"),
    "repeated_index_faces": noun("invalid face"),
    "duplicate_faces": noun("duplicate face"),
    "welded_vertices": noun("unwelded vertex"),
    "flipped_faces": noun("reversed face"),
    "cut_edges": noun("unorientable edge"),
    "split_edges": noun("non-manifold edge"),
    "split_vertices": noun("non-manifold vertex"),
    "subdivided_edges": noun("double edge"),
    "turned_edges": noun("zero-area face"),
}  # vertices that no face uses are none
_OPENINGS = {"filled_holes": noun("hole"), "cut_handles": noun("tunnel")}


def lost_detail(scan, unit) -> list:
    """A warning if float32 is too coarse at the scan's place. unit: the scene's settings."""
    lost = mesh_io.lost_detail(scan)
    return [] if lost is None else [afar.told(lost, unit.system, unit.scale_length)]


def repair_lines(numbers: dict, system: str, scale: float) -> list:
    """The repairs of the mesh that the regions were made of, as lines. The scan itself is unchanged."""
    repairs, lines = numbers.get("repairs", {}), []
    closed = [_count(repairs[name], one) for name, one in _OPENINGS.items() if repairs.get(name)]
    if closed:
        told = said("{holes} and {tunnels}", holes=closed[0], tunnels=closed[-1]) if len(closed) > 1 else closed[0]
        below = length(numbers["closed_below"], system, scale) if numbers.get("closed_below") else ""
        text = own("Closed: {openings} up to {length} round") if below else own("Closed: {openings}")
        lines.append(said(text, openings=told, length=below))
    if numbers.get("kept_open"):
        lines.append(said("Kept open: {openings}", openings=_count(numbers["kept_open"], "opening")))
    faults = [_count(number, _FAULTS[name]) for name, number in repairs.items() if number and name in _FAULTS]
    if faults:
        lines.append(said("Mended: {faults}", faults=", ".join(faults)))
    return lines


def has_openings(numbers: dict) -> bool:
    """Whether openings were closed, or kept open one by one."""
    return any(numbers.get("repairs", {}).get(name) for name in _OPENINGS) or bool(numbers.get("kept_open"))


def short_progress(told: str) -> str:
    """How far some work is, without its stage: the sidebar has no room for that, and the status bar tells it."""
    found = re.search(r"\d+%.*", told)
    return found[0] if found else told


def left_out(numbers: dict) -> str:
    """Which faces are in no region; empty if all are in one."""
    faces = numbers.get("left_out", 0)
    text = own("{faces} left out, grey on the scan: small parts or defects")
    return said(text, faces=_count(faces, "face")) if faces else ""


def describes(mesh, numbers: dict) -> bool:
    """Whether the numbers belong to the mesh in its present state, judged by its number of faces."""
    return "components" in numbers and numbers.get("faces") == len(mesh.polygons)


def report_rows(
    numbers: dict, system: str, scale: float, previewed: dict | None, width: int, snaps: bool = False
) -> list:
    """(row, icon, whether it is a warning) of `report_lines`, in rows of `width` letters.

    There are always as many rows as a report has in general, so that what is below it stays where it is: rows are
    left empty, and minor causes are left out. Only warnings and a bound take more.
    """
    room = max(_LEAST_ROWS, math.ceil(_REPORT / width))
    rows: list = []
    for causes in _CAUSES:
        rows = []
        for line, alert in report_lines(numbers, system, scale, previewed, causes, snaps):
            icons = ["ERROR" if alert else "CHECKMARK"]
            for part in wrapped(line, width):
                rows.append((part, icons.pop() if icons else "BLANK1", alert))
        if sum(not alert for _, _, alert in rows) <= room:
            break
    return rows + [("", "BLANK1", False)] * (room - len(rows))


def report_lines(
    numbers: dict,
    system: str,
    scale: float,
    previewed: dict | None = None,
    causes: int | None = None,
    snaps: bool = False,
) -> list:
    """(line, whether it is a warning) for the report of Mesh; before it, how many polygons it will make.

    causes: how many are told of why there are more polygons than regions; None for all. snaps: see `messages.expected`.
    """
    if "polygons" not in numbers:
        return [(line, False) for line in [messages.expected(numbers, previewed, causes, snaps)] if line]
    flat, worst = (amount(numbers, name, system, scale) for name in ("planarity_mean", "planarity_max"))
    made = _count(numbers["polygons"], "polygon")
    lines = [(f"{made} · {said('closed')}" if numbers["closed"] and numbers["manifold"] else made, False)]
    lines += [(line, False) for line in [messages.why_more(numbers, causes)] if line]
    if "away_max" in numbers:
        mean, most = (amount(numbers, name, system, scale) for name in ("away_mean", "away_max"))
        lines.append((said("{mean} off the scan, at most {most}", mean=mean, most=most), False))
    lines.append((said("Flat to {flat}, worst {worst}", flat=flat, worst=worst), False))
    if numbers.get("let_go"):
        gone = _count(numbers["let_go"], "plane")
        lines.append((said("{gone} not held, for better polygons", gone=gone), True))
    if "cut_if_planar" in numbers:
        share = f"{100 * numbers['cut_if_planar']:.0f} %"
        lines.append((said("Planar Exactly left off: it would cut {share} of the polygons", share=share), False))
    if not numbers["manifold"]:
        lines.append((said("Non-manifold: polygons share an edge or vertex that they should not"), True))
    elif not numbers["closed"]:
        lines.append((said("Open, like the scan"), False))
    if "scan_distance" in numbers:
        away, allowed = (amount(numbers, name, system, scale) for name in ("scan_distance", "scan_distance_allowed"))
        too_far = numbers["scan_distance"] > numbers["scan_distance_allowed"]
        text = own("Scan within {away}, above the allowed {allowed}") if too_far else own("Scan within {away}")
        lines.append((said(text, away=away, allowed=allowed), too_far))
    added = numbers["regions"] - numbers.get("regions_before", numbers["regions"])
    if added > 0:
        lines.append((said("{regions} added to keep the bound", regions=_count(added, "region")), False))
    return lines


def planes_line(numbers: dict, system: str, scale: float) -> str:
    """What has become of the planes of regions."""
    if "planes" not in numbers:
        held = numbers.get("held", 0)
        text = own("{held} of {regions} keep their planes: press Regularise again") if held else own("As scanned")
        return said(text, held=f"{held:,}", regions=_count(numbers.get("regions", 0), "region"))
    gone = numbers.get("let_go", 0)
    text = own("{regions} -> {planes} in {directions}, adds {length}")
    if gone:
        text = own("{regions} -> {planes} in {directions}, adds {length}; {gone} not held, for better polygons")
    return said(
        text,
        gone=_count(gone, "plane"),
        regions=_count(numbers["regions"], "region"),
        planes=_count(numbers["planes"], "plane"),
        directions=_count(numbers["directions"], "direction"),
        length=amount(numbers, "planes_add", system, scale),
    )


def problems(numbers: dict) -> str:
    """The text of the button that selects defective polygons; empty if there are none."""
    defective = {polygon for found in numbers.get("flaws", {}).values() for polygon in found}
    return said("Select {polygons}", polygons=_count(len(defective), "defective polygon")) if defective else ""


def amount(numbers: dict, name: str, system: str, scale: float) -> str:
    """A length of the numbers in the scene's units, or in percent of the diagonal where it has none."""
    if system == "NONE" and numbers.get("diagonal"):
        return f"{100 * numbers[name] / numbers['diagonal']:.2g} %"
    return length(numbers[name], system, scale)


def length(value: float, system: str, scale: float) -> str:
    if system == "NONE":
        return f"{value:.3g}"
    return bpy.utils.units.to_string(system, "LENGTH", value * scale, precision=2, compatible_unit=True)


def in_scene(value: float) -> str:
    """A length in the units of the scene that is shown."""
    unit = bpy.context.scene.unit_settings
    return length(value, unit.system, unit.scale_length)


_PLANES = {"none": own("None found"), "oblique": own("Oblique plane")}


def _mirrored(numbers: dict) -> str:
    """Across which axis the regions mirror, and how much does: corners after Mesh, regions before."""
    plane = said(_PLANES.get(numbers["symmetry"], numbers["symmetry"]))
    if "vertices" in numbers and "mirrored_corners" in numbers:
        some, all_ = numbers["mirrored_corners"], _count(numbers["vertices"], "corner")
    elif "mirrored_regions" in numbers:
        some, all_ = numbers["mirrored_regions"], _count(numbers["regions"], "region")
    else:
        return plane
    return said("{plane}: {some} of {all}", plane=plane, some=f"{some:,}", all=all_)


def number_rows(numbers: dict, system: str, scale: float) -> list:
    """(name, value) of the last step's numbers, the most important first."""
    rows = [(said("Regions"), f"{numbers['regions']:,}")] if "regions" in numbers else []
    if "polygons" in numbers:
        each = f"{numbers['corners'] / max(1, numbers['polygons']):.1f}"
        corners = said("{number} ({each} each)", number=f"{numbers['corners']:,}", each=each)
        rows += [(said("Polygons"), f"{numbers['polygons']:,}"), (said("Corners"), corners)]
        rows += [(said("Vertices"), f"{numbers['vertices']:,}")]
    if "symmetry" in numbers:
        rows.append((said("Symmetry"), _mirrored(numbers)))
    if "error" in numbers:
        rows.append((said("Error"), f"{numbers['error']:.4g}"))
    if numbers.get("barriers"):
        kept = f"{numbers['barriers'] - numbers.get('barriers_inside', 0):,}"
        edges = _count(numbers["barriers"], "edge")
        rows.append((said("Barriers kept"), said("{number} of {edges}", number=kept, edges=edges)))
    if numbers.get("left_out"):
        rows.append((said("Left out"), _count(numbers["left_out"], "face")))
    if "seconds" in numbers:
        rows.append((said("Seconds"), f"{numbers['seconds']:.2f}"))
    return rows
