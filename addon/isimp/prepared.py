"""The engine's repaired mesh of a scan, with the maps between its faces and the user's faces."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from . import view
from .engine import engine
from .scan import Scan


@dataclass(frozen=True)
class Closing:
    """Options of the repair before the partition: limits for the openings to close, and other lengths."""

    handles: float = 0.0  #: handles up to this length are cut, scene units
    holes: float = 0.0  #: holes up to this length are filled, scene units
    flat_holes: float = 0.0  #: holes in flat walls up to this length are filled, scene units
    kept: tuple = ()  #: places of openings that stay open
    left_out: int = 0  #: number of components that stay as they are, since the partition leaves them out
    stitch: float | None = None  #: largest distance of borders to stitch; None: the engine finds it
    grid: float | None = None  #: cell of the grid whose steps are smoothed; None: the engine finds it

    def up_to(self, lengths, kept: tuple) -> Closing:
        """Return the repair with openings closed up to these lengths, except openings at the kept places."""
        holes, flat, handles = lengths.holes, lengths.flat_holes, lengths.handles
        return replace(self, handles=handles, holes=holes, flat_holes=flat, kept=kept, left_out=lengths.left_out)

    @property
    def opened(self) -> Closing:
        """The same repair without closing openings."""
        return replace(self, handles=0.0, holes=0.0, flat_holes=0.0, kept=(), left_out=0)


NONE_CLOSED = Closing()


@dataclass(frozen=True, eq=False)
class Prepared:
    """A scan with the engine's mesh of it, and the maps to the user's faces."""

    scan: Scan
    faces: Any  #: `engine.replay.Faces`
    layers: dict = field(default_factory=dict)  #: present layers of the scan
    closing: Closing = NONE_CLOSED  #: the repair that made the mesh

    @property
    def mesh(self) -> Any:
        return self.faces.mesh

    @property
    def mesh_face(self) -> np.ndarray:
        """(F',) the user's face of each face of the mesh."""
        found: np.ndarray = self.faces.mesh_face
        return found

    @property
    def face_pairs(self) -> np.ndarray:
        """(E, 2) user's faces that share an edge."""
        return self.scan.face_edges[0]


def prepared_of(scan: Scan, mesh, closing: Closing = NONE_CLOSED) -> Prepared:
    """Return the scan with the engine's mesh of it."""
    args = (mesh, scan.triangle_face, scan.face_count, scan.vertices, lambda: scan.face_edges)
    faces = engine.replay.Faces(*args)
    scan.face_edges, faces.face_triangle  # noqa: B018  (computed here and cached)
    return Prepared(scan, faces, closing=closing)


def joined_faces(prepared: Prepared, faces: np.ndarray, start: int) -> np.ndarray:
    """Return the faces that are connected to `start` over shared edges of the engine's mesh.

    The repair may have changed edges of the user's mesh, for example flipped them. faces: in rising order.
    """
    inside = np.zeros(prepared.scan.face_count, bool)
    inside[faces] = True
    some = np.flatnonzero(inside[prepared.mesh_face])
    beside, _ = engine.guides.shared_edges(np.asarray(prepared.mesh.triangles)[some])
    return view.connected(faces, prepared.mesh_face[some[beside]], start)


def scan_numbers(prepared: Prepared) -> dict:
    report = prepared.mesh.report
    names = ("components", "border_loops", "closed", "diagonal", "repairs")
    return {"triangles": len(prepared.scan.triangles), "faces": prepared.scan.face_count} | {
        name: report[name] for name in names if name in report
    }
