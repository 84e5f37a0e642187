"""Finds a bound whose regions are nearer to a drawn model than the regions of a detail."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _core
from ._core import Job, Mesh, Partition
from .within import Made

LEAST_TIMES = 1.5  #: a bound is reported if its planes are at least this many times nearer
MOST_FACES = 50_000  #: larger meshes are not examined
_LEAST_NOISE = 0.005  # share of the mean edge: scans have .01 and more, drawn models .001 and less
_TRIES = 7
_FEWEST, _MOST = 0.95, 1.03  # ratios of two numbers of regions that count as equal


@dataclass(frozen=True)
class Nearer:
    """A bound that has as many regions as a partition, with planes nearer to the model."""

    bound: float  #: scene units
    regions: int
    times: float  #: mean distance of the model from the planes of the partition, over the one from planes of the bound

    def as_dict(self) -> dict[str, Any]:
        return {"bound": self.bound, "regions": self.regions, "times": self.times}


def is_drawn(mesh: Mesh, noise: float | None = None) -> bool:
    """Whether a mesh was drawn and not scanned. noise: its deviation, scene units; None: it is estimated, in O(F)."""
    if noise is None:
        noise = float(_core._tile_measure(mesh, None)[3])
    edge = np.sqrt(mesh.report["area"] / len(mesh.triangles) * 4 / np.sqrt(3))
    return bool(noise < _LEAST_NOISE * edge)


def nearer_by_bound(mesh: Mesh, part: Partition, made: Made, job: Job | None = None) -> Nearer | None:
    """A bound whose planes are at least LEAST_TIMES nearer than those of a partition of a drawn model.

    made: how the partition was made. The numbers of regions are about equal. Returns None without such a bound, for a
    scan with noise, for a partition that was not found by a detail, and above MOST_FACES faces.
    Cost: some partitions by a bound, about twice the time of the first partition.
    """
    told, options = part.report, made.options
    drawn = told["tolerance"] is not None and is_drawn(mesh, told["noise"])
    is_plain = options.method == "hierarchy" and options.symmetry == "none" and not options.curved
    if not (drawn and is_plain) or len(mesh.triangles) > MOST_FACES:
        return None
    now = _distance(mesh, part)
    if now <= 1e-6 * mesh.report["diagonal"]:
        return None
    found, bound, low, high = None, 3 * now, 0.0, np.inf
    for _ in range(_TRIES):
        other = made.within_bound(mesh, bound, job)
        if other.region_count <= _MOST * part.region_count:
            found, high = (other, bound), bound
            if other.region_count >= _FEWEST * part.region_count:
                break
        else:
            low = bound
        bound = np.sqrt(low * high) if 0 < low < high < np.inf else bound * other.region_count / part.region_count
    if found is None:
        return None
    other, bound = found
    times = now / max(_distance(mesh, other), 1e-300)
    return Nearer(float(bound), other.region_count, float(times)) if times >= LEAST_TIMES else None


def _distance(mesh: Mesh, part: Partition) -> float:
    """The mean distance of the surface from planes with the normals of its regions, each at its region's middle."""
    region = np.asarray(part.face_region)
    corners = np.asarray(mesh.vertices)[np.asarray(mesh.triangles)[region >= 0]]
    region = region[region >= 0]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    height = np.einsum("fkd,fd->fk", corners, np.asarray(part.region_normal)[region])
    middle = np.bincount(region, area * height.mean(1)) / np.maximum(np.bincount(region, area), 1e-300)
    return float((area * np.abs(height - middle[region][:, None]).mean(1)).sum() / area.sum())
