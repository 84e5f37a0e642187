"""The user's mesh as arrays, with cached digests and edges."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from .engine import engine


@dataclass(frozen=True, eq=False)
class Scan:
    """The user's mesh as arrays: faces with any number of corners, cut into triangles.

    vertices (V, 3) float, scene units; triangles (T, 3) int32; triangle_face (T,) int32, the user's face of each.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    triangle_face: np.ndarray
    face_count: int
    #: {name: (face_count,) numbers} painted by the user. Layers of `recipe.MARKS` are Blender's own marks: edges as
    #: (K, 2) vertices, materials and face sets of each face. Layers that the mesh does not have are missing.
    layers: dict[str, np.ndarray] = field(default_factory=dict)

    #: results computed from the mesh, shared by scans that differ only in their layers
    _known: dict[str, Any] = field(default_factory=dict, repr=False)

    def with_layers(self, layers: dict[str, np.ndarray]) -> Scan:
        """Return the same mesh with other layers."""
        return replace(self, layers=layers)

    @cached_property
    def layers_digest(self) -> str:
        """Digest of the layers, equal for equal layers."""
        digest = hashlib.blake2b(digest_size=16)
        for name in sorted(self.layers):
            digest.update(f"{name}\0{self.layers[name].shape}".encode())
            digest.update(np.ascontiguousarray(self.layers[name]).tobytes())
        return digest.hexdigest()

    @property
    def digest(self) -> str:
        """Digest of the arrays without the layers, equal for equal arrays."""
        if "digest" not in self._known:
            digest = hashlib.blake2b(digest_size=16)
            for array in (self.vertices, self.triangles, self.triangle_face):
                digest.update(f"{array.dtype}{array.shape}".encode())
                digest.update(np.ascontiguousarray(array).view(np.uint8).data)
            digest.update(str(self.face_count).encode())
            self._known["digest"] = digest.hexdigest()
        found: str = self._known["digest"]
        return found

    @property
    def source(self) -> Any:
        """The triangles with their faces, as `engine.source.Source`."""
        if "source" not in self._known:
            arrays = (self.vertices, self.triangles, self.triangle_face, self.face_count)
            self._known["source"] = engine.source.Source(*arrays, digest=self.digest)
        return self._known["source"]

    @property
    def edges(self) -> tuple[np.ndarray, np.ndarray]:
        """(E, 2) triangles that share an edge, (E, 2) the vertices of that edge."""
        found: tuple[np.ndarray, np.ndarray] = self.source.triangle_edges
        return found

    @property
    def face_edges(self) -> tuple[np.ndarray, np.ndarray]:
        """(E, 2) user's faces that share an edge, (E, 2) the vertices of that edge."""
        found: tuple[np.ndarray, np.ndarray] = self.source.face_edges
        return found
