"""Exports to other programs, in double precision: CityJSON, DXF and IFC for buildings, and STEP for CAD."""

from .formats import BUILDING_KINDS, KINDS, LODS, PLAIN, STEP_KINDS, TEXTURED, TILES, kind_of, missing, require
from .surfaces import PLANAR, Surfaces, surfaces_of, validity
from .writing import UNITS, write

__all__ = [
    "BUILDING_KINDS",
    "KINDS",
    "LODS",
    "PLAIN",
    "PLANAR",
    "STEP_KINDS",
    "TEXTURED",
    "TILES",
    "UNITS",
    "Surfaces",
    "kind_of",
    "missing",
    "require",
    "surfaces_of",
    "validity",
    "write",
]
