"""What the command says of a mesh, in words."""

from collections.abc import Iterator
from typing import Any

_REPAIRS = {
    "non_finite_faces": "dropped for a corner that is not finite",
    "repeated_index_faces": "dropped for naming a vertex twice",
    "duplicate_faces": "dropped for having the vertices of another",
    "welded_vertices": "welded to another at the same place",
    "flipped_faces": "turned over, so that each part faces one way",
    "cut_edges": "cut open, where no orientation fits both sides",
    "split_edges": "taken apart for having three or more faces",
    "split_vertices": "copied for further fans of faces",
    "subdivided_edges": "halved for having the same ends as another",
    "turned_edges": "turned, so that faces without area have some",
    "unused_vertices": "dropped for being in no face",
    "filled_holes": "covered",
    "cut_handles": "cut",
}
_THINGS = {"vertices": "vertex", "edges": "edge", "holes": "hole", "handles": "handle"}


def count(number: int, thing: str) -> str:
    """`1 face`, `1,204 faces`, `2 vertices`, `0 parts`."""
    if number == 1:
        return f"1 {thing}"
    return f"{number:,} {'vertices' if thing == 'vertex' else thing + 's'}"


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


def found(partition: dict[str, Any]) -> str:
    """`167 regions found at a tolerance of 0.00125, noise 2.1e-05`."""
    text = f"{count(partition['regions'], 'region')} found at a tolerance of {partition['tolerance']:.3g}"
    text += f", noise {partition['noise']:.2g}"
    return text + (", the number of planes it is made of" if partition["snapped"] else "")
