"""Recipes: the steps from a scan to its result, as plain values with checks. Standard library only.

The command and batches read recipes with these modules, and the add-on has a copy of the folder.
"""

from .checks import RecipeError
from .engine_options import CLEAN, MESHING, PARTITION, REGULARISE, TEXTURE
from .language import count, noun, own, plural, said, speak
from .options import COUNTS, Option
from .places import Places, faces_of, moved
from .plane_steps import ALIGNMENTS, AlignPlanes, Regularise
from .recipe import Recipe, parsed
from .round_steps import ExplodeRound, RoundRegions, RoundSegments
from .step import KINDS, Step, engine_options
from .steps import (
    MARKS,
    METHODS,
    MOST_ROUNDS,
    AddProxy,
    AddWorst,
    CutRegion,
    DeleteLeast,
    DeleteProxy,
    EraseFaces,
    EvenBorders,
    GrowRegion,
    Improve,
    LeaveOutRegions,
    LockRegions,
    MergeCheapest,
    MergeRegions,
    Mesh,
    PaintFaces,
    Partition,
    ShrinkRegion,
    SmoothFaces,
    SplitRegion,
    Texture,
    UnlockRegions,
    step_from_dict,
)

__all__ = [
    "ALIGNMENTS",
    "CLEAN",
    "COUNTS",
    "KINDS",
    "MARKS",
    "MESHING",
    "METHODS",
    "MOST_ROUNDS",
    "PARTITION",
    "REGULARISE",
    "TEXTURE",
    "AddProxy",
    "AddWorst",
    "AlignPlanes",
    "CutRegion",
    "DeleteLeast",
    "DeleteProxy",
    "EraseFaces",
    "EvenBorders",
    "ExplodeRound",
    "GrowRegion",
    "Improve",
    "LeaveOutRegions",
    "LockRegions",
    "MergeCheapest",
    "MergeRegions",
    "Mesh",
    "Option",
    "PaintFaces",
    "Partition",
    "Places",
    "Recipe",
    "RecipeError",
    "Regularise",
    "RoundRegions",
    "RoundSegments",
    "ShrinkRegion",
    "SmoothFaces",
    "SplitRegion",
    "Step",
    "Texture",
    "UnlockRegions",
    "count",
    "engine_options",
    "faces_of",
    "moved",
    "noun",
    "own",
    "parsed",
    "plural",
    "said",
    "speak",
    "step_from_dict",
]
