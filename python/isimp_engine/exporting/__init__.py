"""Ways out to other programs, in double precision: CityJSON, DXF and IFC for buildings, and STEP for CAD."""

from .surfaces import PLANAR, Surfaces, surfaces_of, validity
from .writing import KINDS, STEP_KINDS, UNITS, kind_of, missing, require, write

__all__ = [
    "KINDS",
    "PLANAR",
    "STEP_KINDS",
    "UNITS",
    "Surfaces",
    "kind_of",
    "missing",
    "require",
    "surfaces_of",
    "validity",
    "write",
]
