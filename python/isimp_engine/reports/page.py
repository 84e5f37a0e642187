"""The page of a report: pictures, a histogram of the deviation, planes and round parts. It needs no other file."""

import base64
import html
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import Mesh, Partition, __version__
from .planes import PlaneTable

_BINS = 40
_WIDE, _HIGH = 640, 220  # size of the histogram, in pixels
_ROWS = 500  # planes on the page at most, the largest first
_STYLE = """
body { font: 15px/1.4 system-ui, sans-serif; margin: 2em; color: #222; background: #fff }
table { border-collapse: collapse } td, th { padding: .2em .7em; border-bottom: 1px solid #ddd }
th { text-align: left; position: sticky; top: 0; background: #fff } td.n { text-align: right }
img { display: block; max-width: 100% }
"""
_SHOWN = ("region", "class", "area", "tilt", "azimuth", "distance_mean", "distance_rms", "distance_max")

_ROUND_SHOWN = (
    *("number", "kind", "radius", "axis_x", "axis_y", "axis_z", "segments", "rings", "area"),
    *("distance_mean", "distance_rms", "distance_max"),
)


def numbers_of(mesh: Mesh, part: Partition, report: dict[str, Any], table: PlaneTable) -> dict[str, Any]:
    """The numbers of the whole model on the page, in scene units. report: the report of the polygons."""
    away = table.away[np.isfinite(table.away)]
    return {
        "isimp": __version__,
        "scan: faces": len(mesh.triangles),
        "scan: area": float(mesh.report["area"]),
        "regions": int(part.region_count),
        "polygons": int(report["polygons"]),
        "closed": bool(report["closed"]),
        "planarity, largest": float(report["planarity_max"]),
        "deviation, mean": float(away.mean()) if len(away) else None,
        "deviation, root mean square": float(np.sqrt((away**2).mean())) if len(away) else None,
        "deviation, 95 % are below": float(np.quantile(away, 0.95)) if len(away) else None,
        "deviation, largest": float(away.max()) if len(away) else None,
    }


def histogram(away: NDArray[np.float64], bins: int = _BINS) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """(counts, ends) of the distances that are known; the last bin has all above the 99th percentile."""
    known = away[np.isfinite(away)]
    most = float(np.quantile(known, 0.99)) if len(known) else 0.0
    ends = np.linspace(0.0, most if most > 0 else 1.0, bins + 1)
    counts, _ = np.histogram(np.minimum(known, ends[-1]), ends)
    return counts, ends


def write_page(title: str, report: dict[str, Any], table: PlaneTable, picture: bytes) -> str:
    """HTML. report: numbers by their names. picture: a PNG."""
    return "\n".join(_lines(title, report, table, picture)) + "\n"


def _lines(title: str, report: dict[str, Any], table: PlaneTable, picture: bytes) -> Iterator[str]:
    yield "<!DOCTYPE html>"
    yield f'<html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title>'
    yield f"<style>{_STYLE}</style></head><body><h1>{html.escape(title)}</h1>"
    image = base64.b64encode(picture).decode()
    yield f'<img alt="The scan at the left, the model at the right" src="data:image/png;base64,{image}">'
    yield "<table>"
    for name, value in report.items():
        yield f'<tr><td>{html.escape(name)}</td><td class="n">{html.escape(_told(value))}</td></tr>'
    yield "</table><h2>Deviation of the scan from the model</h2>"
    yield "<p>How well the model describes this scan; the accuracy of the scan itself is not part of it.</p>"
    yield from _bars(*histogram(table.away))
    rows = sorted(table.rows, key=lambda row: (-row["area"], row["region"]))
    yield "<h2>Planes</h2>"
    if len(rows) > _ROWS:
        yield f"<p>The largest {_ROWS:,} of {len(rows):,}; planes.csv has all.</p>"
    yield f"<table><tr>{''.join(f'<th>{name}</th>' for name in _SHOWN)}</tr>"
    for row in rows[:_ROWS]:
        yield f"<tr>{''.join(_cell(row[name]) for name in _SHOWN)}</tr>"
    yield "</table>"
    if table.round_parts:
        yield f"<h2>Round parts</h2><table><tr>{''.join(f'<th>{name}</th>' for name in _ROUND_SHOWN)}</tr>"
        for row in table.round_parts:
            yield f"<tr>{''.join(_cell(row[name]) for name in _ROUND_SHOWN)}</tr>"
        yield "</table>"
    yield "</body></html>"


def _cell(value: Any) -> str:
    return f"<td>{html.escape(value)}</td>" if isinstance(value, str) else f'<td class="n">{_told(value)}</td>'


def _told(value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.4g}" if isinstance(value, float) else f"{value:,}" if isinstance(value, int) else str(value)


def _bars(counts: NDArray[np.int64], ends: NDArray[np.float64]) -> Iterator[str]:
    wide, most = _WIDE / len(counts), max(1, int(counts.max()))
    yield f'<svg width="{_WIDE}" height="{_HIGH + 24}" role="img" aria-label="Histogram">'
    for number, count in enumerate(counts.tolist()):
        high = _HIGH * count / most
        yield (
            f'<rect x="{number * wide:.1f}" y="{_HIGH - high:.1f}" width="{wide - 1:.1f}" height="{high:.1f}" '
            f'fill="#4a7ebb"><title>{ends[number]:.3g} to {ends[number + 1]:.3g}: {count:,}</title></rect>'
        )
    yield f'<text x="0" y="{_HIGH + 18}" font-size="13">0</text>'
    yield f'<text x="{_WIDE}" y="{_HIGH + 18}" font-size="13" text-anchor="end">{ends[-1]:.3g} and above</text></svg>'
