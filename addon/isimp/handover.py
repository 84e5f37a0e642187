"""Passes models to the engine's exporters and reports. Numpy only."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from .engine import engine
from .language import own, said
from .outcome import Outcome
from .sketch import polygon_edges


@dataclass(frozen=True, eq=False)
class Model:
    """Polygons of any mesh, with the attributes of the engine's PolygonMesh that exporters read."""

    vertices: np.ndarray  #: (V, 3) float64
    loops: np.ndarray  #: (L,) int32
    loop_start: np.ndarray  #: (Q,) int32
    planarity: np.ndarray = field(init=False)  #: (Q,) largest distance of a corner from the plane of its polygon
    report: dict[str, Any] = field(init=False)

    def __post_init__(self) -> None:
        closed, manifold = _topology(self.loops, self.loop_start)
        zero = dict.fromkeys(("crossing", "intersecting", "excused"), 0)
        object.__setattr__(self, "planarity", planarity(self.vertices, self.loops, self.loop_start))
        object.__setattr__(self, "report", {"closed": closed, "manifold": manifold} | zero)


def _topology(loops: np.ndarray, start: np.ndarray) -> tuple[bool, bool]:
    """Return whether the polygons are closed (two at each edge) and manifold (at most two, in opposite directions)."""
    ends = polygon_edges(loops, start)
    _, once = np.unique(ends, axis=0, return_counts=True)
    _, count = np.unique(np.sort(ends, axis=1), axis=0, return_counts=True)
    return bool((count == 2).all()), bool((once == 1).all())


def planarity(vertices: np.ndarray, loops: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Return (Q,) the largest distance of a corner from the plane of its polygon."""
    of = np.repeat(np.arange(len(start)), np.diff(start, append=len(loops)))
    places = vertices[loops]
    after = np.roll(places, -1, axis=0)
    last = np.append(start[1:], len(loops)) - 1
    after[last] = places[start]
    count = np.bincount(of, minlength=len(start))[:, None]
    middle = np.stack([np.bincount(of, places[:, k], len(start)) for k in range(3)], axis=1) / count
    crossed = np.cross(places - middle[of], after - middle[of])
    normal = np.stack([np.bincount(of, crossed[:, k], len(start)) for k in range(3)], axis=1)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    away = np.abs(np.einsum("ij,ij->i", places - middle[of], normal[of]))
    found = np.zeros(len(start))
    np.maximum.at(found, of, away)
    return found


def missing(path: Path, modules: Path) -> str:
    """Return the package that files of this kind need, and the command that installs it; empty if none is missing.

    modules: Blender's folder of packages.
    """
    package = engine.exporting.missing(path)
    if not package:
        return ""
    command = " ".join(f'"{part}"' if " " in part or part[:1] in "/\\" else part for part in pip(modules, package))
    text = own("For {kind} Blender needs the package {package}. In a terminal: {command}")
    return said(text, kind=engine.exporting.kind_of(path), package=package, command=command)


def pip(modules: Path, package: str) -> list[str]:
    """Return the command that installs a package into a folder, by the Python that runs in this program.

    `sys.executable` may be another Python, or the program itself.
    """
    name = f"python{sys.version_info[0]}.{sys.version_info[1]}"
    places = [Path(sys.prefix, "bin", name), Path(sys.prefix, "bin", "python.exe"), Path(sys.prefix, "python.exe")]
    python = next((place for place in places if place.is_file()), Path(sys.executable))
    return [str(python), "-m", "pip", "install", "--target", str(modules), package]


def export(path: Path, model: Model, crs: int | None) -> None:
    """Writes a building; see `isimp_engine.exporting`. Raises ValueError."""
    engine.exporting.write(path, model, crs=crs)


def export_step(path: Path, mesh: Any, outcome: Outcome, place: np.ndarray, unit: str) -> dict[str, Any]:
    """Writes a solid and returns its report; see `isimp_engine.exporting`. place: (4, 4) from the mesh to the world."""
    parts = {"partition": outcome.partition, "mesh": mesh}
    told: dict[str, Any] = engine.exporting.write(path, outcome.polygons, **parts, place=place, unit=unit)
    return told


def far_origin(vertices: np.ndarray) -> np.ndarray:
    """Return (3,) integers to subtract from coordinates so that float32 keeps their detail; zero along near axes."""
    known = vertices[np.isfinite(vertices).all(axis=1)]
    if not len(known):
        return np.zeros(3)
    low, high = known.min(axis=0), known.max(axis=0)
    middle = (low + high) / 2
    return np.where(np.abs(middle) > 2 * np.linalg.norm(high - low), np.rint(middle), 0.0)


def report_texts(mesh: Any, outcome: Outcome, place: np.ndarray, name: str, crs: int | None) -> dict[str, str]:
    """Return the files of a report by name; see `isimp_engine.reports`. place: (4, 4) from the mesh to the world."""
    reports = _reports()
    part, poly = outcome.partition, outcome.polygons
    table = reports.plane_table(mesh, part, poly, place=place)
    texts: dict[str, str] = reports.texts_of(
        name, mesh, part, poly, table, crs, place[:3, :3], outcome.numbers.get("size_step")
    )
    return texts


def _reports() -> Any:
    from importlib import import_module

    return import_module(f"{engine.__name__}.reports")


def write_report(folder: Path, texts: dict[str, str]) -> None:
    """Writes the files of a report; see `isimp_engine.reports`. Raises OSError."""
    _reports().write(folder, texts)
