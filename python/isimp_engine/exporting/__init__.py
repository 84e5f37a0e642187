"""Ways out to programs for buildings: CityJSON, DXF and IFC, with surfaces by class, in double precision."""

from .surfaces import PLANAR, Surfaces, surfaces_of, validity
from .writing import KINDS, kind_of, require, write

__all__ = ["KINDS", "PLANAR", "Surfaces", "kind_of", "require", "surfaces_of", "validity", "write"]
