"""Numbers as the panel words them."""

import textwrap

import bpy


def wrapped(message: str, width: int = 34) -> list:
    return textwrap.wrap(message, width)


def _count(number: int, one: str) -> str:
    return f"{number:,} {one}{'' if number == 1 else 's'}"


def scan_lines(mesh, numbers: dict) -> list:
    """What the add-on sees in a scan; parts and holes once it has looked at it."""
    triangles = len(mesh.loops) - 2 * len(mesh.polygons)
    lines = [_count(triangles, "triangle")]
    if "components" in numbers and numbers.get("faces") == len(mesh.polygons):
        holes = "closed" if numbers["closed"] else _count(numbers["border_loops"], "hole")
        lines = [f"{_count(numbers['triangles'], 'triangle')} · {_count(numbers['components'], 'part')} · {holes}"]
        mended = sum(numbers.get("repairs", {}).values())
        if mended:
            lines.append(f"{_count(mended, 'fault')} mended for the result")
    return lines


def length(value: float, system: str, scale: float) -> str:
    if system == "NONE":
        return f"{value:.3g}"
    return bpy.utils.units.to_string(system, "LENGTH", value * scale, precision=2, compatible_unit=True)


def number_rows(numbers: dict, system: str, scale: float) -> list:
    """(name, value) of what the last step did, in the order they matter."""
    if not numbers:
        return []
    rows = [("Regions", f"{numbers['regions']:,}")]
    if "polygons" in numbers:
        rows.append(("Polygons", f"{numbers['polygons']:,}"))
        rows.append(("Corners each", f"{numbers['corners'] / max(1, numbers['polygons']):.1f}"))
        for name, key in (("Flat to", "planarity_mean"), ("Worst", "planarity_max")):
            share = 100 * numbers[key] / numbers["diagonal"] if numbers["diagonal"] else 0.0
            rows.append((name, f"{length(numbers[key], system, scale)} ({share:.2g} %)"))
        rows.append(("Surface", "closed" if numbers["closed"] else "open"))
    rows.append(("Error", f"{numbers['error']:.4g}"))
    if numbers.get("left_out"):
        rows.append(("Left out", _count(numbers["left_out"], "face")))
    rows.append(("Seconds", f"{numbers['seconds']:.2f}"))
    return rows
