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
        about="Border vertices at most this far apart may become one; scene units; 0: bit-equal places only.",
        words="a finite length, at least 0",
        least=0.0,
    ),
    "fill_holes": Option(
        kind="float",
        default=0.0,
        about="Borders at most this long round are closed; scene units; 0: none.",
        words="a length, at least 0",
        least=0.0,
    ),
    "cut_handles": Option(
        kind="float",
        default=0.0,
        about="Handles and tunnels with a loop at most this long go; scene units; 0: none.",
        words="a length, at least 0",
        least=0.0,
    ),
    "threads": Option(
        kind="int",
        default=0,
        about="How many threads may work, at most 256 or as many as there are cores; 0: as many as there are cores. The result does not depend on it.",
        words="at least 0",
        least=0.0,
    ),
}

MESHING: dict[str, Option] = {
    "chord_tolerance": Option(
        kind="float",
        default=0.7,
        about="A boundary is subdivided where it leaves its chord by more than this times sqrt(area / regions). It counts the less, the flatter the two regions meet.",
        words="in [0, 100]",
        least=0.0,
        most=100.0,
    ),
    "chord_area": Option(
        kind="float",
        default=0.53,
        about="The chords of a region may leave out or add at most this share of its area, so that small regions keep their shape. It counts the less, the flatter the two regions meet.",
        words="in [0, 100]",
        least=0.0,
        most=100.0,
    ),
    "reach": Option(
        kind="float",
        default=0.01,
        about="No corner is moved further than this share of the diagonal from the scan's vertex it stands for.",
        words="in [0, 1]",
        least=0.0,
        most=1.0,
    ),
    "flatten": Option(
        kind="int",
        default=30,
        about="Rounds of planes and corners in turn; 0 leaves the first placement.",
        words="in [0, 10000]",
        least=0.0,
        most=10000.0,
    ),
    "flatness_from": Option(
        kind="int",
        default=100,
        about="With fewer regions than this there is no bound on flatness: they are bent themselves.",
    ),
    "flatness": Option(
        kind="float",
        default=0.005,
        about="Polygons bent by more than this share of the diagonal are split; no bound at 0.",
        words="in [0, 100]",
        least=0.0,
        most=100.0,
    ),
    "repair_budget": Option(
        kind="float",
        default=4.0,
        about="Splits and diagonals that the repair may make, as a share of the polygons before; those that turn out not to be needed are taken back.",
        words="in [0, 1000]",
        least=0.0,
        most=1000.0,
    ),
    "threads": Option(
        kind="int",
        default=0,
        about="How many threads may work, at most 256 or as many as there are cores; 0: as many as there are cores. The result does not depend on it.",
        words="at least 0",
        least=0.0,
    ),
}

PARTITION: dict[str, Option] = {
    "proxies": Option(
        kind="int",
        default=None,
        about="So many regions, from 1 to the number of faces; at most one of this, detail, tolerance and bound.",
        words="at least 1",
        least=1.0,
    ),
    "detail": Option(
        kind="float",
        default=None,
        about="As many regions as the surface shows at a tolerance of this share of its size; 0.02, 0.01, 0.005, 0.0025 and 0.00125 are from very coarse to very fine. 0.005 if nothing says how many.",
        words="in (0, 1]",
        least=0.0,
        above_least=True,
        most=1.0,
    ),
    "tolerance": Option(
        kind="float",
        default=None,
        about="The same with the tolerance in scene units: about the mean distance of the surface from the planes of its regions.",
        words="a finite length above 0",
        least=0.0,
        above_least=True,
    ),
    "bound": Option(
        kind="float",
        default=None,
        about="As few regions as there may be with each vertex this near to its region's plane, scene units; by method 'hierarchy'.",
        words="a finite length above 0",
        least=0.0,
        above_least=True,
    ),
    "noise": Option(
        kind="float",
        default=None,
        about="Standard deviation of the scan's noise, scene units, below 3.5 of which no tolerance counts; None: estimated. 0 for what was drawn and not scanned.",
        words="a finite length, at least 0",
        least=0.0,
    ),
    "snap": Option(
        kind="bool",
        default=True,
        about="Where the surface clearly is made of so many planes, take that number; with detail and tolerance.",
    ),
    "adaptivity": Option(
        kind="float",
        default=0.0,
        about="How much denser regions get where the surface is rough; 0.25 is good for figures, 0 for buildings and drawn models.",
        words="in [0, 1]",
        least=0.0,
        most=1.0,
    ),
    "leave_out": Option(
        kind="float",
        default=0.001,
        about="Components each below this share of the whole area are left out, smallest first, while all of them together stay below ten times it; 0 keeps everything.",
        words="in [0, 1)",
        least=0.0,
        most=1.0,
        below_most=True,
    ),
    "seed": Option(
        kind="int",
        default=1,
        about="The number that starts the random seeding.",
        words="at least 0",
        least=0.0,
    ),
    "iterations": Option(
        kind="int",
        default=20,
        about="Upper bound on flood-and-fit rounds.",
        words="at least 1",
        least=1.0,
    ),
    "seeding": Option(
        kind="str",
        default="random",
        about="Where 'lloyd' and 'teleport' put the first proxies: 'random', distinct faces drawn by `seed`; 'farthest', each the face whose normal and place are farthest from all before; 'hierarchical', the faces nearest to the regions that 'hierarchy' gives.",
        choices=("random", "farthest", "hierarchical"),
    ),
    "method": Option(
        kind="str",
        default="hierarchy",
        about="How the regions are found: 'hierarchy', merging of a hierarchy of patches, then relaxation of the borders, the best and the fastest; 'lloyd', flooding and fitting in turn, the 2004 paper's and the thesis's own; 'teleport', that, then merging the cheapest pair and splitting the worst region until it no longer helps; 'naive' and 'queued', as 'lloyd' but all faces, or all of a queue, flooded at once, for many processors: the thesis's data-parallel floodings; 'hybrid', 'lloyd' on a decimated mesh, carried back.",
        choices=("lloyd", "hierarchy", "teleport", "naive", "queued", "hybrid"),
    ),
    "threads": Option(
        kind="int",
        default=0,
        about="How many threads may work, at most 256 or as many as there are cores; 0: as many as there are cores. The result does not depend on it.",
        words="at least 0",
        least=0.0,
    ),
    "backend": Option(
        kind="str",
        default="cpu",
        about="Where 'naive' and 'queued' run: one of backends(), 'cpu' among them. Same labels on all.",
    ),
    "nearest": Option(
        kind="int",
        default=8,
        about="How many of the nearest regions a face looks at in 'naive'.",
        words="in [1, 32]",
        least=1.0,
        most=32.0,
    ),
    "search": Option(
        kind="str",
        default="grid",
        about="How 'naive' finds them: by a 'grid', or by looking at all regions, 'brute', as the thesis has it.",
        choices=("grid", "brute"),
    ),
    "connect": Option(
        kind="str",
        default="repair",
        about="How the regions of 'naive' and 'queued' become connected at the end: 'repair', the largest piece of each grows over the others; 'flood', one sequential round, as the thesis has it, which loses more. Of 'hybrid' 'flood' is the thesis's, and 'repair' takes the default method and relaxed borders.",
        choices=("repair", "flood"),
    ),
    "fraction": Option(
        kind="float",
        default=0.125,
        about="Of the faces what 'hybrid' keeps when it decimates.",
        words="in (0, 1]",
        least=0.0,
        above_least=True,
        most=1.0,
    ),
}
