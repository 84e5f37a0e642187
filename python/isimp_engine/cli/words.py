"""The sentences that the command prints about a mesh."""

from collections.abc import Iterator
from typing import Any

from ..regions import FLAT, FREE_FORM, ROUGH
from ..sizes import ANGLE

_REPAIRS = {
    "non_finite_faces": "dropped: a coordinate is not finite",
    "repeated_index_faces": "dropped: a vertex is used twice",
    "duplicate_faces": "dropped: an earlier face has the same vertices",
    "welded_vertices": "welded to others at the same position",
    "flipped_faces": "reversed, so that each component has one orientation",
    "cut_edges": "cut open: no orientation fits both sides",
    "split_edges": "split: three or more faces met there",
    "split_vertices": "split: the faces around formed several fans",
    "subdivided_edges": "halved: another edge had the same ends",
    "turned_edges": "flipped to give zero-area faces an area",
    "unused_vertices": "dropped: not used by any face",
    "stitched_vertices": "stitched to the border of another chunk",
    "inner_faces": "removed: they are of parts inside a closed one",
    "smoothed_vertices": "moved within half a cell: the mesh was cut on a grid of occupied cells",
    "filled_holes": "covered",
    "cut_handles": "cut",
}
_SIZES = 24  # lines of sizes at most
_THINGS = {"vertices": "vertex", "edges": "edge", "holes": "hole", "handles": "handle"}


def rims(out: dict[str, Any], area: float) -> str:
    """`12 straight edges at the rim, within 0.21 of the border: 0.4 % of the area added, 0.3 % lost`; else empty."""
    found = out["rims"]
    if not found["edges"] or not found["reach"]:
        return ""
    added, lost = (100 * found[name] / area for name in ("area_added", "area_lost"))
    where = f"{count(found['edges'], 'straight edge')} at the rim, within {found['reach']:.4g} of the border"
    return f"{where}: {added:.2g} % of the area added, {lost:.2g} % lost"


def clicks(found: dict[str, Any] | None) -> Iterator[str]:
    """The steps of a recipe that are left out, as the scan has no face at their places."""
    if found is not None and found["by"] == "number":
        yield "  warning: the faces of the recipe have no places, so they are right for the scan of the recipe alone"
    for each in found["lost"] if found is not None else ():
        yield f"  warning: step {each['step']} of the recipe, {each['kind']}, is left out: {each['why']}"


def count(number: int, thing: str) -> str:
    """`1 face`, `1,204 faces`, `2 vertices`, `0 parts`."""
    if number == 1:
        return f"1 {thing}"
    return f"{number:,} {'vertices' if thing == 'vertex' else thing + 's'}"


def surfaces(validity: dict[str, Any]) -> str:
    """`8 walls, 2 roofs, 1 part of the ground, 0 ceilings; a closed solid; all planar within 0.01`."""
    found = validity["surfaces"]
    named = zip(("wall", "roof", "ground", "ceiling"), found.values(), strict=True)
    parts = ", ".join(
        f"{number:,} {name}" + ("s" if number != 1 and name != "ground" else "") for name, number in named
    )
    kind = "a closed solid" if validity["solid"] else "no closed solid"
    bent, limit = validity["non_planar"], validity["planarity_limit"]
    plane = f"{count(bent, 'polygon')} non-planar by more than {limit:g}" if bent else f"all planar within {limit:g}"
    return f"{parts}; {kind}; {plane}"


def step(told: dict[str, Any]) -> str:
    """`STEP: a solid of 13 faces, valid; 1 of 2 round parts has a true surface`."""
    made = "a solid" if told["solids"] == 1 else f"{told['solids']} solids" if told["solids"] else "open, no solid"
    text = f"STEP: {made}, {count(told['faces'], 'face')}, {'valid' if told['valid'] else 'NOT valid'}"
    true, rest = len(told["true_surfaces"]), told["planes"]
    if true or rest:
        text += f"; true surfaces for {true} of {count(true + len(rest), 'round part')}"
    if rest:
        text += f" (part {rest[0]['number']}: {rest[0]['reason']})"
    return text


def shape(report: dict[str, Any]) -> str:
    """`2 parts, 1 of them closed, 223 border edges in 5 loops`."""
    text = count(report["components"], "part")
    if report["closed"]:
        return text + ", closed"
    if report["closed_components"]:
        text += f", {report['closed_components']:,} of them closed"
    border = f"{count(report['border_edges'], 'border edge')} in {count(report['border_loops'], 'loop')}"
    return f"{text}, open, {border}"


def repairs(counts: dict[str, int], where: dict[str, list[int]]) -> Iterator[str]:
    """One line for each repair that was needed: `12 faces dropped for ... (face 3, 77, 204, ...)`."""
    for key, number in counts.items():
        if number == 0:
            continue
        thing = _THINGS.get(key.rpartition("_")[2], "face")
        text = f"{count(number, thing)} {_REPAIRS.get(key, key.replace('_', ' '))}"
        if places := where.get(key):
            kind = "vertex" if thing == "vertex" else "face"
            text += f" ({kind} {', '.join(map(str, places[:5]))}{', ...' if number > len(places[:5]) else ''})"
        yield text


def more_than_regions(out: dict[str, Any]) -> str:
    """`61 more than regions: 40 at holes, 21 to keep them flat and apart`; "" where there are no more.

    out: counts of a result, or estimated ones, which have no boxes.
    """
    more = out["polygons"] - out["regions"] - 6 * out.get("boxes", 0)
    if more <= 0:
        return ""
    reasons = {
        "at holes": out["split_for_holes"],
        "at handles": out["split_for_handles"],
        "for closed parts": out["split_for_closed"],
        "for regions in pieces": out["split_for_unconnected"] + out["split_for_pinches"],
    }
    reasons["to keep them flat and apart"] = more - sum(reasons.values())  # splits and new edges of the repair
    why = ", ".join(f"{number:,} {reason}" for reason, number in reasons.items() if number > 0)
    return f"{more:,} more than regions: {why}"


def clutter(found: list[dict[str, Any]], treated: str) -> str:
    """`clutter: 2 regions take 35 polygons, the worst 21, at 1.2,0.4,0.9`; "" where no region takes many.

    treated: the value of --clutter.
    """
    if not found:
        return ""
    taken, worst = sum(each["polygons"] for each in found), found[0]
    at = ",".join(f"{number:.4g}" for number in worst["center"])
    does = "takes" if len(found) == 1 else "take"
    if treated != "keep":
        does = "left out, with" if treated == "leave-out" else "replaced by boxes, with"
    return f"clutter: {count(len(found), 'region')} {does} {taken:,} polygons, the worst {worst['polygons']:,}, at {at}"


def expected(counts: dict[str, int]) -> str:
    """`about 345 polygons of 300 regions`."""
    return f"about {count(counts['polygons'], 'polygon')} of {count(counts['regions'], 'region')}"


def found(partition: dict[str, Any]) -> str:
    """`167 regions found at a tolerance of 0.00125, noise 2.1e-05`."""
    text = f"{count(partition['regions'], 'region')} found at a tolerance of {partition['tolerance']:.3g}"
    text += f", noise {partition['noise']:.2g}"
    return text + (", the number of planes it is made of" if partition["snapped"] else "")


def scaled(scale: dict[str, Any]) -> str:
    """`scaled by 1.0004: size 0-35 was 39.984 and is 40`."""
    told = f"size {scale['name']} was {scale['measured']:.6g} and is {scale['length']:.6g}"
    return f"scaled by {scale['factor']:.6g}: {told}"


def snapped(sizes: list[dict[str, Any]], step: float) -> Iterator[str]:
    """`sizes: 22 of 34 are multiples of 1; angles, of 5 degrees`, and lines of lengths that moved and that stay."""
    moved = [row for row in sizes if row["snapped"] == "yes"]
    yield f"  sizes: {len(moved):,} of {len(sizes):,} are multiples of {step:g}; angles, of {ANGLE:g} degrees"
    lengths = [row for row in sizes if row["kind"] != "angle"]
    lengths.sort(key=lambda row: row["snapped"] != "yes")
    for row in lengths[:_SIZES]:
        sure = "" if row["uncertainty"] is None else f" (+-{row['uncertainty']:.2g})"
        told = f"{row['kind']} {row['name']}, {row['measured']:.6g}{sure}"
        yield f"    {told}: {row['value']:.6g}" if row["snapped"] == "yes" else f"    {told}: stays, {row['snapped']}"
    if len(lengths) > _SIZES:
        yield f"    and {count(len(lengths) - _SIZES, 'size')} more: the report has all"


_NOT_ROUND = {
    FLAT: "no surface bends, all regions meet at edges",
    ROUGH: "the noise hides how surfaces bend; a larger --detail finds those of rougher scans",
    FREE_FORM: "surfaces bend, but fit no cylinder, cone, sphere, surface of revolution or extrusion",
}


def round_parts(parts: list[dict[str, Any]], regions: int, why: str | None = None) -> str:
    """`round: 2 cylinders, 1 cone; 6 planes`, or `round: 1 cylinder, diameter 0.0997, 28 segments; 6 planes`."""
    if not parts:
        return f"no round parts found: {_NOT_ROUND[why or FREE_FORM]}"
    kinds = [part["kind"] for part in parts]
    named = {kind: kind for kind in ("cylinder", "cone", "sphere")}
    named |= {"revolution": "surface of revolution", "extrusion": "extrusion"}
    several = {"revolution": "surfaces of revolution"}
    found = [
        f"{number} {name if number == 1 else several.get(kind, name + 's')}"
        for kind, name in named.items()
        if (number := kinds.count(kind))
    ]
    if len(parts) == 1:
        wide = kinds[0] in ("cylinder", "sphere")
        found += [f"diameter {2 * parts[0]['radius']:.4g}"] if wide else []
        found.append(count(parts[0]["segments"], "segment"))
    planes = regions - sum(len(part["regions"]) for part in parts)
    return f"round: {', '.join(found)}" + (f"; {count(planes, 'plane')}" if planes else "")


def left_out(parts: int, area: float) -> Iterator[str]:
    if parts:
        yield f"  left out: {count(parts, 'part')}, {area:.2%} of the area"


def more_proxies(used: int, asked: int) -> Iterator[str]:
    if used > asked:
        yield f"  {used:,} proxies used, since the parts need them; {asked:,} were requested"


def polygons(out: dict[str, Any], regions: int) -> str:
    """`a.obj: 12 polygons of 10 regions, 4.5 corners each, closed, manifold`."""
    made, of = count(out["polygons"], "polygon"), count(regions, "region")
    kind = f"{'closed' if out['closed'] else 'open'}, {'manifold' if out['manifold'] else 'not manifold'}"
    return f"{out['path']}: {made} of {of}, {out['corners'] / max(out['polygons'], 1):.1f} corners each, {kind}"


def flat(out: dict[str, Any], diagonal: float, seconds: float) -> str:
    size = diagonal or 1.0  # of a scan that is one point, which is flat
    mean, worst = (f"{out[key] / size:.3%}" for key in ("planarity_mean", "planarity_max"))
    return f"  flat to {mean} of the diagonal, at worst {worst}; {seconds:.1f} s"


def defects(out: dict[str, Any]) -> Iterator[str]:
    if found := [f"{out[key]} {key}" for key in ("crossing", "flipped", "bent", "intersecting") if out[key]]:
        yield f"  not perfect: {', '.join(found)}"
