"""The steps of a recipe, done on a repaired scan."""

from .edits import EDITS, edited
from .faces import Faces, face_edges
from .places import Surface, placed, places_of

__all__ = ["EDITS", "Faces", "Surface", "edited", "face_edges", "placed", "places_of"]
