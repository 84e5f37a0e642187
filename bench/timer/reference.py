"""REF, the plain method of reference.cpp, and the measures of a partition from any program."""

from __future__ import annotations

import ctypes
from functools import cache

import numpy as np

from bench.files import ROOT, compiled
from bench.quality.fingerprints import fingerprint
from isimp_engine.guides import shared_edges
from tests.shared.polygon_judge import groups

ROUNDS = 20


@cache
def _library() -> ctypes.CDLL:
    return ctypes.CDLL(str(compiled(ROOT / "bench" / "timer" / "reference.cpp", "-shared", "-fPIC")))


class Surface:
    """A mesh for the plain method, in the caller's order of faces."""

    def __init__(self, vertices, triangles):
        corners = np.asarray(vertices, float)[triangles]
        vector = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
        length = np.linalg.norm(vector, axis=1)
        self.normal = np.ascontiguousarray(vector / np.where(length > 0, length, 1)[:, None])
        self.area = length / length.sum()
        self.pairs, ends = shared_edges(np.asarray(triangles))
        self.length = np.linalg.norm(vertices[ends[:, 0]] - vertices[ends[:, 1]], axis=1)
        self.neighbours = np.full((len(triangles), 3), -1, np.int32)
        both = np.concatenate([self.pairs, self.pairs[:, ::-1]])
        both = both[np.argsort(both[:, 0], kind="stable")]
        rank = np.arange(len(both)) - np.searchsorted(both[:, 0], both[:, 0])
        self.neighbours[both[rank < 3, 0], rank[rank < 3]] = both[rank < 3, 1]

    def reference(self, proxies, seed=1, rounds=ROUNDS):
        """Labels, and the error and the milliseconds of each round."""
        count = len(self.area)
        seeds = np.random.default_rng(seed).choice(count, proxies, replace=False).astype(np.int32)
        label, errors, spent = np.empty(count, np.int32), np.empty(rounds), np.empty(rounds)
        at = (array.ctypes.data_as(ctypes.c_void_p) for array in (self.normal, self.area, self.neighbours))
        out = (array.ctypes.data_as(ctypes.c_void_p) for array in (label, errors, spent))
        _library().reference(count, *at, proxies, seeds.ctypes.data_as(ctypes.c_void_p), rounds, *out)
        return label, errors, spent

    def score(self, label):
        """D, the sum of area * |n_face - n_region|^2; borders; regions, and connected pieces beyond one a region."""
        kept, count = label >= 0, int(label.max()) + 1
        sums = np.stack([np.bincount(label[kept], (self.area * self.normal[:, k])[kept], count) for k in range(3)], 1)
        mean = sums / np.maximum(np.linalg.norm(sums, axis=1), 1e-300)[:, None]
        off = ((self.normal - mean[label]) ** 2).sum(axis=1)
        a, b = label[self.pairs].T
        border = (a != b) & (a >= 0) & (b >= 0)
        pieces = np.unique(groups(len(label), self.pairs[a == b])[1][kept])
        regions = len(np.unique(label[kept]))
        return {
            "error": float((self.area * off)[kept].sum()),
            "border_edges": int(border.sum()),
            "border_length": float(self.length[border].sum()),
            "regions": regions,
            "fragments": len(pieces) - regions,
            "unlabelled_area": float(self.area[~kept].sum()),
            "fingerprint": fingerprint(label),
        }
