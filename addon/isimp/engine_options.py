"""The engine's options: name, type, default, range, meaning. Written by scripts/generate.py; do not edit."""
# ruff: noqa: E501

from typing import Any, NamedTuple


class Option(NamedTuple):
    kind: str  #: "int", "float", "bool" or "str"
    default: Any
    about: str  #: what it means
    words: str = ""  #: the range in words: "in [0, 1)"
    least: float | None = None
    above_least: bool = False  #: least itself is no value
    most: float | None = None
    below_most: bool = False  #: most itself is no value
    choices: tuple[str, ...] = ()

    def holds(self, value: float) -> bool:
        """Whether a number is in the range; infinity and NaN never are."""
        if not abs(value) < float("inf"):
            return False
        low = self.least is None or (value > self.least if self.above_least else value >= self.least)
        high = self.most is None or (value < self.most if self.below_most else value <= self.most)
        return low and high


CLEAN: dict[str, Option] = {
    "weld": Option(
        kind="float",
        default=0.0,
        about="Largest distance at which two border vertices may become one, in scene units. 0: only equal positions.",
        words="a finite length, at least 0",
        least=0.0,
    ),
    "fill_holes": Option(
        kind="float",
        default=0.0,
        about="Largest length of a border that is closed, in scene units. 0: none.",
        words="a length, at least 0",
        least=0.0,
    ),
    "cut_handles": Option(
        kind="float",
        default=0.0,
        about="Largest length of a loop round a handle or tunnel that is removed, in scene units. 0: none.",
        words="a length, at least 0",
        least=0.0,
    ),
    "threads": Option(
        kind="int",
        default=0,
        about="Number of threads, at most 256. 0: one for each core. The result does not depend on it.",
        words="at least 0",
        least=0.0,
    ),
}

MESHING: dict[str, Option] = {
    "chord_tolerance": Option(
        kind="float",
        default=0.7,
        about="Distance between a boundary and its chord at which the boundary gets another corner, as a share of sqrt(area / regions). Larger where the two regions are nearly coplanar.",
        words="in [0, 100]",
        least=0.0,
        most=100.0,
    ),
    "chord_area": Option(
        kind="float",
        default=0.53,
        about="Largest share of a region's area that its chords may add or leave out, so that small regions keep their shape. Larger where the two regions are nearly coplanar.",
        words="in [0, 100]",
        least=0.0,
        most=100.0,
    ),
    "reach": Option(
        kind="float",
        default=0.01,
        about="Largest distance of a corner from its vertex of the scan, as a share of the diagonal.",
        words="in [0, 1]",
        least=0.0,
        most=1.0,
    ),
    "flatten": Option(
        kind="int",
        default=30,
        about="Rounds of fitting planes and moving corners. 0 keeps the first positions.",
        words="in [0, 10000]",
        least=0.0,
        most=10000.0,
    ),
    "flatness_from": Option(
        kind="int",
        default=100,
        about="Number of regions from which flatness applies; larger regions are not planar themselves.",
    ),
    "flatness": Option(
        kind="float",
        default=0.005,
        about="Largest distance of a corner from its polygon's plane, as a share of the diagonal; polygons beyond it are split. 0: no limit.",
        words="in [0, 100]",
        least=0.0,
        most=100.0,
    ),
    "repair_budget": Option(
        kind="float",
        default=4.0,
        about="Largest number of splits and diagonals of the repair, as a multiple of the number of polygons. Those that prove unnecessary are undone.",
        words="in [0, 1000]",
        least=0.0,
        most=1000.0,
    ),
    "threads": Option(
        kind="int",
        default=0,
        about="Number of threads, at most 256. 0: one for each core. The result does not depend on it.",
        words="at least 0",
        least=0.0,
    ),
}

PARTITION: dict[str, Option] = {
    "proxies": Option(
        kind="int",
        default=None,
        about="Number of regions, at most the number of faces. Give at most one of proxies, detail, tolerance and bound.",
        words="at least 1",
        least=1.0,
    ),
    "detail": Option(
        kind="float",
        default=None,
        about="Chooses the number of regions: smallest visible detail, as a share of the surface's size. 0.02, 0.01, 0.005, 0.0025 and 0.00125 go from very coarse to very fine. 0.005 if none of the four is given.",
        words="in (0, 1]",
        least=0.0,
        above_least=True,
        most=1.0,
    ),
    "tolerance": Option(
        kind="float",
        default=None,
        about="As detail, but in scene units: about the mean distance of the surface from the planes of its regions.",
        words="a finite length above 0",
        least=0.0,
        above_least=True,
    ),
    "bound": Option(
        kind="float",
        default=None,
        about="As few regions as possible with every vertex within this distance of its region's plane, in scene units. Method 'hierarchy' only.",
        words="a finite length above 0",
        least=0.0,
        above_least=True,
    ),
    "noise": Option(
        kind="float",
        default=None,
        about="Standard deviation of the scan's noise, in scene units. Detail below 3.5 times it is ignored. None: estimated. 0: a drawn model, not a scan.",
        words="a finite length, at least 0",
        least=0.0,
    ),
    "snap": Option(
        kind="bool",
        default=True,
        about="If the surface clearly consists of a certain number of planes, use that number. For detail and tolerance.",
    ),
    "adaptivity": Option(
        kind="float",
        default=0.0,
        about="Smaller regions where the surface is rough. 0.25 suits figures, 0 suits buildings and drawn models.",
        words="in [0, 1]",
        least=0.0,
        most=1.0,
    ),
    "leave_out": Option(
        kind="float",
        default=0.001,
        about="Components below this share of the total area get no region, smallest first, as long as all of them together stay below ten times it. 0 keeps every component.",
        words="in [0, 1)",
        least=0.0,
        most=1.0,
        below_most=True,
    ),
    "seed": Option(
        kind="int",
        default=1,
        about="Seed of the random numbers.",
        words="at least 0",
        least=0.0,
    ),
    "iterations": Option(
        kind="int",
        default=20,
        about="Maximum number of rounds of flooding and fitting.",
        words="at least 1",
        least=1.0,
    ),
    "seeding": Option(
        kind="str",
        default="random",
        about="First seeds of 'lloyd' and 'teleport'. 'random': distinct random faces. 'farthest': each the face that differs most from all seeds before. 'hierarchical': one face in each region of 'hierarchy'.",
        choices=("random", "farthest", "hierarchical"),
    ),
    "method": Option(
        kind="str",
        default="hierarchy",
        about="How the regions are found. 'hierarchy': merge small patches, then relax the borders; the best and the fastest. 'lloyd': flood and fit in turn, the method of the 2004 paper. 'teleport': as 'lloyd', then merge the cheapest pair and split the worst region while the error falls. 'naive' and 'queued': as 'lloyd', with all faces, or all of a queue, flooded at once; for GPUs. 'hybrid': partition a decimated mesh, and carry the regions back.",
        choices=("lloyd", "hierarchy", "teleport", "naive", "queued", "hybrid"),
    ),
    "threads": Option(
        kind="int",
        default=0,
        about="Number of threads, at most 256. 0: one for each core. The result does not depend on it.",
        words="at least 0",
        least=0.0,
    ),
    "backend": Option(
        kind="str",
        default="cpu",
        about="Where 'naive' and 'queued' run: one of backends(). The labels are the same on all.",
    ),
    "nearest": Option(
        kind="int",
        default=8,
        about="Number of nearest regions that a face compares in 'naive'.",
        words="in [1, 32]",
        least=1.0,
        most=32.0,
    ),
    "search": Option(
        kind="str",
        default="grid",
        about="How 'naive' finds them: 'grid', or 'brute', which compares all regions, as in the thesis.",
        choices=("grid", "brute"),
    ),
    "connect": Option(
        kind="str",
        default="repair",
        about="How 'naive' and 'queued' make regions connected at the end. 'repair': the largest piece of each region grows over the others. 'flood': one sequential round, as in the thesis, with a larger error. In 'hybrid', 'flood' follows the thesis, and 'repair' uses method 'hierarchy' and relaxes the borders.",
        choices=("repair", "flood"),
    ),
    "fraction": Option(
        kind="float",
        default=0.125,
        about="Share of the faces that 'hybrid' keeps when it decimates.",
        words="in (0, 1]",
        least=0.0,
        above_least=True,
        most=1.0,
    ),
}
