"""The steps of a recipe, done on a repaired scan."""

from .edits import EDITS, edited, upward
from .faces import Faces, face_edges

__all__ = ["EDITS", "Faces", "edited", "face_edges", "upward"]
