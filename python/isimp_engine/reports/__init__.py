"""Reports about a model: tables of its planes and round parts, and a page with pictures."""

from ..sizes import size_rows
from .files import ANGLES, NAMES, texts_of, write
from .page import numbers_of, write_page
from .planes import PlaneTable, angle_rows, plane_table, write_csv, write_geojson

__all__ = [
    "ANGLES",
    "NAMES",
    "PlaneTable",
    "angle_rows",
    "numbers_of",
    "plane_table",
    "size_rows",
    "texts_of",
    "write",
    "write_csv",
    "write_geojson",
    "write_page",
]
