"""Makes the texts of the panel: numbers, warnings, reports."""

import re
import textwrap

import bpy

from ... import float_loss, messages
from ...language import count as _count
from ...language import noun, own, said
from ...outcome import EXACT
from ..scene import mesh_io

_STAY = "\N{NO-BREAK SPACE}"
_ONE_LINE = 46  # letters that hold the whole report


def wrapped(message: str, width: int) -> list:
    """Return lines of at most `width` letters. Words joined by no-break spaces are split only if they are longer."""
    message = re.sub(r"(?<=\d) (?=(?:[a-zµ]{1,2}|[%'\"])(?: |$))", _STAY, message)  # a number keeps its unit
    parts = (part if len(part) <= width else part.replace(_STAY, " ") for part in message.split(" "))
    return textwrap.wrap(" ".join(parts), width)


def fitted(told: str, measure, room: float) -> list:
    """Return lines no wider than `room`, except single words. measure: returns the width of a text."""
    lines: list = []
    for word in told.split(" "):
        longer = f"{lines[-1]} {word}" if lines else word
        if lines and measure(longer) <= room:
            lines[-1] = longer
        else:
            lines.append(word)
    return lines


def beside(told: str, measure, wanted: float, right: float, left: float) -> tuple[list, float]:
    """Return (lines, x) of a text that should begin at `wanted` and must lie between `left` and `right`.

    measure: returns the width of a text. A line that is too wide breaks between statements, at " · ".
    """
    lines, room = [], right - left
    for part in told.split(" · "):
        if lines and measure(f"{lines[-1]} · {part}") <= room:
            lines[-1] += f" · {part}"
        else:
            lines.append(part)
    return lines, max(left, min(wanted, right - max(map(measure, lines))))


def shortened(name: str, most: int) -> str:
    """Return a name of at most `most` letters: its beginning and its end."""
    end = (most - 1) // 2
    return name if len(name) <= most else f"{name[: most - 1 - end]}\N{HORIZONTAL ELLIPSIS}{name[len(name) - end :]}"


def scan_lines(mesh, numbers: dict) -> tuple:
    """Return (size, shape) of a scan, always two lines. Parts and holes are known after Partition."""
    triangles = len(mesh.loops) - 2 * len(mesh.polygons)
    if not describes(mesh, numbers):
        return _count(triangles, "triangle"), said("Not partitioned yet")
    holes = said("closed") if numbers["closed"] else _count(numbers["border_loops"], "hole")
    return _count(numbers["triangles"], "triangle"), f"{_count(numbers['components'], 'part')} · {holes}"


_DEFECTS = {
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
    "inner_faces": noun("inner face"),
    "stitched_vertices": noun("stitched vertex"),
    "smoothed_vertices": noun("smoothed vertex"),
}  # unused vertices are not a defect
_OPENINGS = {"filled_holes": noun("hole"), "cut_handles": noun("tunnel")}


def lost_detail(scan, unit) -> list:
    """Return a list with a warning if float32 is too coarse at the scan's place. unit: the scene's settings."""
    lost = mesh_io.lost_detail(scan)
    return [] if lost is None else [float_loss.warning(lost, unit.system, unit.scale_length)]


def repair_lines(numbers: dict, system: str, scale: float) -> list:
    """Return lines about the repairs of the mesh before the partition. The scan itself is unchanged."""
    repairs, lines = numbers.get("repairs", {}), []
    closed = [_count(repairs[name], one) for name, one in _OPENINGS.items() if repairs.get(name)]
    if closed:
        told = said("{holes} and {tunnels}", holes=closed[0], tunnels=closed[-1]) if len(closed) > 1 else closed[0]
        below = length(numbers["closed_below"], system, scale) if numbers.get("closed_below") else ""
        text = own("Closed: {openings}, up to {length} around") if below else own("Closed: {openings}")
        lines.append(said(text, openings=told, length=below))
    if numbers.get("kept_open"):
        lines.append(said("Kept open: {openings}", openings=_count(numbers["kept_open"], "opening")))
    defects = [_count(number, _DEFECTS[name]) for name, number in repairs.items() if number and name in _DEFECTS]
    if defects:
        lines.append(said("Mended: {defects}", defects=", ".join(defects)))
    return lines


def has_openings(numbers: dict) -> bool:
    """Return whether openings were closed, or kept open by the user."""
    return any(numbers.get("repairs", {}).get(name) for name in _OPENINGS) or bool(numbers.get("kept_open"))


def short_progress(told: str) -> str:
    """Return the progress without the stage. The sidebar is too narrow for the stage; the status bar has it."""
    found = re.search(r"\d+%.*", told)
    return found[0] if found else told


def left_out(numbers: dict) -> str:
    """Return the line about faces outside regions; empty if there are none."""
    faces = numbers.get("left_out", 0)
    text = own("{faces} ignored (grey): tiny parts or damaged faces")
    return said(text, faces=_count(faces, "face")) if faces else ""


def describes(mesh, numbers: dict) -> bool:
    """Return whether the numbers belong to the mesh in its present state, judged by its number of faces."""
    return "components" in numbers and numbers.get("faces") == len(mesh.polygons)


def report_rows(
    numbers: dict, system: str, scale: float, previewed: dict | None, width: int, snaps: bool = False
) -> list:
    """Return (row, icon, whether it is a warning) of the report in the panel, in rows of `width` letters.

    First the numbers of polygons and triangles, present or expected, and the distance from the scan; warnings follow.
    The number of rows without warnings is fixed, so that the buttons below do not move. `report_lines` has the rest.
    """
    told = _short(numbers, system, scale, previewed, snaps)
    icons = ["CHECKMARK"]
    rows = [(part, icons.pop() if icons else "BLANK1", False) for part in wrapped(told, width)]
    rows += [("", "BLANK1", False)] * ((1 if width >= _ONE_LINE else 2) - len(rows))
    for line, alert in report_lines(numbers, system, scale, previewed, snaps=snaps):
        if alert:
            icons = ["ERROR"]
            rows += [(part, icons.pop() if icons else "BLANK1", True) for part in wrapped(line, width)]
    return rows


def _short(numbers: dict, system: str, scale: float, previewed: dict | None, snaps: bool) -> str:
    """Return the report in one line: the numbers of polygons and triangles, and the distance from the scan."""
    made = numbers if "polygons" in numbers else previewed or {}
    if "polygons" not in made:
        counts = numbers.get("expected", {})
        if "polygons" not in counts:
            return ""
        about = own("About {polygons}, or more") if snaps else own("About {polygons}")
        return said(about, polygons=_count(counts["polygons"], "polygon"))
    told = [_count(made["polygons"], "polygon")]
    if "corners" in made:
        told.append(_count(made["corners"] - 2 * made["polygons"], "triangle"))
    if "away_mean" in made:
        told.append(said("{mean} off", mean=amount(made, "away_mean", system, scale)))
    return f"{_STAY}· ".join(told)  # no row begins with a dot


def report_lines(
    numbers: dict,
    system: str,
    scale: float,
    previewed: dict | None = None,
    snaps: bool = False,
) -> list:
    """Return (line, whether it is a warning) of the report of Mesh; before Mesh, the expected number of polygons.

    snaps: see `messages.expected`.
    """
    if "polygons" not in numbers:
        return [(line, False) for line in [messages.expected(numbers, previewed, snaps)] if line]
    made = _count(numbers["polygons"], "polygon")
    lines = [(f"{made} · {said('closed')}" if numbers["closed"] and numbers["manifold"] else made, False)]
    lines += [(line, False) for line in [messages.why_more(numbers)] if line]
    if numbers.get("cluttered"):
        regions, taken = _count(numbers["cluttered"], "region"), _count(numbers.get("clutter_polygons", 0), "polygon")
        lines.append((said("Clutter: {regions} with {polygons}", regions=regions, polygons=taken), False))
    if "away_max" in numbers:
        mean, most = (amount(numbers, name, system, scale) for name in ("away_mean", "away_max"))
        lines.append((said("{mean} from the scan on average, {most} at most", mean=mean, most=most), False))
    lines.append((_flatness(numbers, system, scale), False))
    if "cut_if_planar" in numbers:
        share = f"{100 * numbers['cut_if_planar']:.0f} %"
        lines.append((said("Exactly Flat Faces left off: it would cut {share} of the polygons", share=share), False))
    lines += [(line, False) for line in [not_flat(numbers), planes_let_go(numbers)] if line]
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


def planes_let_go(numbers: dict) -> str:
    """Return the line about planes that the user asked for and that are not held; empty if there are none."""
    if not numbers.get("let_go") or not (numbers.get("held") or "planes" in numbers):
        return ""
    return said("{gone} not held, for better polygons", gone=_count(numbers["let_go"], "plane"))


def _flatness(numbers: dict, system: str, scale: float) -> str:
    """Return the line about flatness. Polygons within a millionth of the diagonal count as exactly flat."""
    if numbers["planarity_max"] <= EXACT * numbers.get("diagonal", 0.0):
        return said("Exactly flat")
    flat, worst = (amount(numbers, name, system, scale) for name in ("planarity_mean", "planarity_max"))
    return said("Flat within {flat} on average, {worst} at most", flat=flat, worst=worst)


def planes_line(numbers: dict, system: str, scale: float) -> str:
    """Return the line about snapped and held planes of regions."""
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
    """Return the text of the button that selects defective polygons; empty if there are none."""
    defective = {polygon for found in numbers.get("flaws", {}).values() for polygon in found}
    return said("Select {polygons}", polygons=_count(len(defective), "defective polygon")) if defective else ""


def amount(numbers: dict, name: str, system: str, scale: float) -> str:
    """Return a length of the numbers in the scene's units, or in percent of the diagonal if the scene has no units."""
    if system == "NONE" and numbers.get("diagonal"):
        return f"{100 * numbers[name] / numbers['diagonal']:.2g} %"
    return length(numbers[name], system, scale)


def length(value: float, system: str, scale: float, digits: int = 2) -> str:
    """Return a length with its unit. Blender's own texts have the unusual units "um" and "mil"."""
    if system == "NONE":
        return f"{value:.3g}"
    if system == "METRIC" and 0 < abs(value * scale) < 1e-3:
        return f"{1e6 * value * scale:.3g} \N{MICRO SIGN}m"
    if system == "IMPERIAL" and 0 < abs(value * scale) < 0.0254:
        return said("{number} in", number=f"{value * scale / 0.0254:.2g}")
    return bpy.utils.units.to_string(system, "LENGTH", value * scale, precision=digits, compatible_unit=True)


def in_scene(value: float, digits: int = 2) -> str:
    """Return a length in the units of the current scene."""
    unit = bpy.context.scene.unit_settings
    return length(value, unit.system, unit.scale_length, digits)


_ROUND = {
    "cylinder": noun("cylinder"),
    "cone": noun("cone"),
    "sphere": noun("sphere"),
    "revolution": noun("turned part"),
    "extrusion": noun("extrusion"),
}
_NOT_ROUND = {
    "": own("No round part found: try a larger Smallest Feature"),
    "noise": own("No round part found: noise hides how surfaces bend. Try a larger Smallest Feature"),
    "flat": own("No round part found: no surface bends"),
    "free": own("No round part found: surfaces bend, but not as cylinders, cones, spheres or turned parts"),
}
_WIDE = ("cylinder", "sphere")  # have one diameter


def round_parts(numbers: dict, asked: bool) -> str:
    """Return the line about the round parts and planes of a partition; empty if it has none, unless `asked`.

    Lengths have the units of the current scene.
    """
    parts = numbers.get("round", [])
    if not parts:
        return said(_NOT_ROUND[numbers.get("not_round", "")]) if asked else ""
    kinds = [part[0] for part in parts]
    told = ", ".join(_count(kinds.count(kind), _ROUND[kind]) for kind in _ROUND if kind in kinds)
    if len(parts) == 1:
        kind, radius, segments, *_ = parts[0]
        if kind in _WIDE:
            told = said("{part} Ø {diameter}", part=told, diameter=in_scene(2 * radius, 3))
        told = f"{told}, {_count(segments, 'segment')}"
    if any(len(part) < 6 for part in parts):  # by an earlier version
        return told
    planes = numbers["regions"] - sum(len(part[5]) for part in parts)
    return f"{told}; {_count(planes, 'plane')}" if planes else told


_SIZES = {
    "distance": own("Distance {value}"),
    "diameter": own("Diameter {value}"),
    "axis": own("Axis to plane {value}"),
    "axes": own("Axis to axis {value}"),
    "angle": own("Angle {value}"),
}


def size(row: list) -> str:
    """Return the line about a size: its value, and the uncertainty or, where it was snapped, the measured value."""
    _, kind, value, sure, measured, snapped, _ = row

    def shown(number: float) -> str:
        return f"{number:.4g}°" if kind == "angle" else in_scene(number, 5)

    told = said(_SIZES[kind], value=shown(value))
    if snapped == "yes":
        return said("{size}, measured {value}", size=told, value=shown(measured))
    return told if sure is None else f"{told} ± {shown(sure)}"


def more_sizes(number: int) -> str:
    """Return the line about sizes that are not listed."""
    return said("{sizes} more in the report", sizes=_count(number, noun("size")))


def not_flat(numbers: dict) -> str:
    """Return the line about polygons that were not made exactly flat as asked; empty if there are none."""
    if not numbers.get("not_flat"):
        return ""
    return said("{some} of {all} not exactly flat", some=f"{numbers['not_flat']:,}", all=f"{numbers['polygons']:,}")


def number_rows(numbers: dict) -> list:
    """Return (name, value) of the last step's numbers, the most important first."""
    rows = [(said("Regions"), f"{numbers['regions']:,}")] if "regions" in numbers else []
    if "polygons" in numbers:
        each = f"{numbers['corners'] / max(1, numbers['polygons']):.1f}"
        corners = said("{number} ({each} each)", number=f"{numbers['corners']:,}", each=each)
        rows += [(said("Polygons"), f"{numbers['polygons']:,}"), (said("Corners"), corners)]
        rows += [(said("Vertices"), f"{numbers['vertices']:,}")]
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
