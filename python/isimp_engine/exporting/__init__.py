"""Exports to other programs, in double precision except binary STL, GLB and glTF.

CityJSON, DXF, IFC and energy models of buildings, STEP for CAD, STL and 3MF for printers, colliders for games.
"""

from .formats import BUILDING_KINDS, KINDS, LODS, PLAIN, STEP_KINDS, TEXTURED, TILES, kind_of, missing, require
from .surfaces import PLANAR, Surfaces, surfaces_of, validity
from .writing import write

__all__ = [
    "BUILDING_KINDS",
    "KINDS",
    "LODS",
    "PLAIN",
    "PLANAR",
    "STEP_KINDS",
    "TEXTURED",
    "TILES",
    "Surfaces",
    "kind_of",
    "missing",
    "require",
    "surfaces_of",
    "validity",
    "write",
]
