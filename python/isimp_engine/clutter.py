"""Finds regions with many polygons, such as foliage, a sieve of holes or a heap of things on a desk."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ._core import InvalidInput, Mesh, Partition, PolygonMesh, leave_out_regions

MOST = 8  #: largest number of polygons of a region that is not clutter


@dataclass(frozen=True)
class Clutter:
    """A region with more than MOST polygons."""

    region: int
    polygons: int
    center: tuple[float, float, float]  #: mean of its corners

    def as_dict(self) -> dict[str, Any]:
        return {"region": self.region, "polygons": self.polygons, "center": list(self.center)}


def clutter(polygons: PolygonMesh) -> list[Clutter]:
    """The regions of a PolygonMesh with more than MOST polygons, the worst first.

    Cost: O(corners) for each region found.
    """
    of = np.asarray(polygons.polygon_region)
    counts = np.bincount(of) if len(of) else of
    ends = np.append(polygons.loop_start, len(polygons.loops))
    region = np.repeat(of, np.diff(ends))  # the region of each corner
    found = []
    for r in np.flatnonzero(counts > MOST):
        x, y, z = np.asarray(polygons.vertices)[np.asarray(polygons.loops)[region == r]].mean(0).tolist()
        found.append(Clutter(int(r), int(counts[r]), (x, y, z)))
    return sorted(found, key=lambda each: -each.polygons)


def without_clutter(mesh: Mesh, part: Partition, found: list[Clutter], box: bool = False) -> Partition:
    """The partition with the regions of `clutter` left out, or with boxes in their place; see leave_out_regions.

    Raises InvalidInput if one is of another partition.
    """
    if not found:
        return part
    for each in found:
        if not 0 <= each.region < part.region_count:
            there = f"the partition has {part.region_count} regions: it was found in another one"
            raise InvalidInput(f"clutter names region {each.region}, but {there}")
    return leave_out_regions(mesh, part, part.region_seed[[each.region for each in found]].astype(np.int64), box)
