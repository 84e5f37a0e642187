"""CityJSON 1.1 and 2.0: one building with semantic surfaces."""

import json
import math
from typing import Any

import numpy as np

from .._core import PolygonMesh
from .surfaces import CLASSES, Surfaces, rings

VERSIONS = ("2.0", "1.1")
_TRANSFORM = "transform"  # written separately: after an import of cjio, json writes only six digits of a number
_STEPS = 1e-9  # share of the diagonal: coordinates are rounded to whole powers of ten of about this


def cityjson(poly: PolygonMesh, surfaces: Surfaces, name: str, crs: int | None = None, version: str = "2.0") -> str:
    """The file's text. A closed model is a Solid, any other a MultiSurface; holes between its surfaces stay open."""
    if version not in VERSIONS:
        raise ValueError(f"version must be one of {', '.join(VERSIONS)}, got {version!r}")
    at = np.asarray(poly.vertices, dtype=np.float64)
    low = np.floor(at.min(0)) if len(at) else np.zeros(3)
    diagonal = float(np.linalg.norm(np.ptp(at, axis=0))) if len(at) else 1.0
    digits = max(0, -math.floor(math.log10(_STEPS * diagonal))) if diagonal > 0 else 9
    step = float(f"1e-{digits}")
    points = np.rint((at - low) / step).astype(np.int64).tolist()
    used = [kind for kind in CLASSES if kind in surfaces.kind]
    values: list[Any] = [used.index(kind) for kind in surfaces.kind]
    faces: list[Any] = [[loop.tolist()] for loop in rings(poly)]
    geometry = {
        "type": "Solid" if surfaces.solid else "MultiSurface",
        "lod": "2",
        "boundaries": [faces] if surfaces.solid else faces,
        "semantics": {
            "surfaces": [{"type": kind} for kind in used],
            "values": [values] if surfaces.solid else values,
        },
    }
    metadata: dict[str, Any] = {}
    if len(at):
        metadata["geographicalExtent"] = [*at.min(0).tolist(), *at.max(0).tolist()]
    if crs is not None:
        metadata["referenceSystem"] = f"https://www.opengis.net/def/crs/EPSG/0/{crs}"
    content = {
        "type": "CityJSON",
        "version": version,
        "transform": _TRANSFORM + ":",
        "metadata": metadata,
        "CityObjects": {name: {"type": "Building", "geometry": [geometry]}},
        "vertices": points,
    }
    text = json.dumps(content, separators=(",", ":"), allow_nan=False)
    scale, shift = ",".join([repr(step)] * 3), ",".join(repr(x) for x in low.tolist())
    return text.replace(f'"{_TRANSFORM}:"', f'{{"scale":[{scale}],"translate":[{shift}]}}', 1) + "\n"
