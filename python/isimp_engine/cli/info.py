"""Say what a mesh is, and what would be repaired before it is simplified. Nothing is written."""

import argparse
import json
from collections.abc import Iterator
from typing import Any

from .. import Job
from . import words
from .loading import clean_mesh, facts, load


def run(arguments: argparse.Namespace) -> None:
    source = load(arguments.input, Job(), arguments.clean.threads)
    mesh, repaired, repaired_at = clean_mesh(source, arguments.clean, Job())
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    report = {
        "input": {"path": str(source.path), "vertices": len(source.vertices), "faces": source.faces}
        | {"triangles": len(source.triangles)},
        "repair": repaired,
        "repaired_at": repaired_at,
        "mesh": facts(mesh) | {"box": [low.tolist(), high.tolist()]},
    }
    print(json.dumps(report, indent=2, allow_nan=False) if arguments.json else "\n".join(lines(report)))


def lines(report: dict[str, Any]) -> Iterator[str]:
    source, mesh = report["input"], report["mesh"]
    cut = (
        "" if source["faces"] == source["triangles"] else f" (cut into {words.count(source['triangles'], 'triangle')})"
    )
    yield str(source["path"])
    yield f"  {words.count(source['faces'], 'face')}{cut}, {words.count(source['vertices'], 'vertex')}"
    yield f"  {words.shape(mesh)}, Euler characteristic {mesh['euler']}"
    sides = " x ".join(f"{high - low:.6g}" for low, high in zip(*mesh["box"], strict=True))
    yield f"  size {sides}, diagonal {mesh['diagonal']:.6g}, area {mesh['area']:.6g}"
    if mesh["zero_area_faces"]:
        yield f"  {words.count(mesh['zero_area_faces'], 'face')} without area"
    repairs = list(words.repairs(report["repair"], report["repaired_at"]))
    yield "  nothing to repair" if not repairs else "  to repair:"
    yield from (f"    {line}" for line in repairs)
