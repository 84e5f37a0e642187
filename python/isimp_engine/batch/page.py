"""results.html: one page with the results of a batch, problems first. It needs no other file."""

import base64
import html
import os
from collections.abc import Iterable
from pathlib import Path
from urllib.parse import quote

from ..folders import WORK
from .table import Row

NAME = "results.html"
_PICTURES = 1000  # most pictures on the page; about 10 KB each
_DEFECTS = ("crossing", "flipped", "bent", "intersecting")

_STYLE = """
body { font: 15px/1.4 system-ui, sans-serif; margin: 2em; color: #222; background: #fff }
table { border-collapse: collapse } td, th { padding: .3em .8em; border-bottom: 1px solid #ddd; vertical-align: middle }
th { text-align: left; position: sticky; top: 0; background: #fff } td.n { text-align: right }
tr.failed { background: #fdeaea } tr.defective { background: #fff7e0 } img { display: block }
"""


def defects(row: Row) -> list[str]:
    """Return the defects of a result, such as `3 bent` or `not manifold`, and the warnings of its partition."""
    found = [f"{row[kind]} {kind}" for kind in _DEFECTS if row.get(kind)]
    if row.get("manifold") is False:
        found.append("not manifold")
    distance, allowed = row.get("scan_distance"), row.get("scan_distance_allowed")
    if distance is not None and allowed is not None and distance > allowed:
        found.append(f"{distance:.3g} off the scan, {allowed:.3g} allowed")
    return found + list(row.get("warnings") or ())


def in_order(rows: Iterable[Row]) -> list[Row]:
    """Sort rows: failed scans first, then results with defects, then the others."""
    return sorted(rows, key=lambda row: (row["status"] == "ok", not defects(row), row["name"]))


def totals(rows: list[Row]) -> str:
    """Return a summary: `996 of 1,000 scans ok, 4 failed; 12,345,678 faces became 45,210 polygons`."""
    good = [row for row in rows if row["status"] == "ok"]
    text = f"{len(good):,} of {len(rows):,} {'scan' if len(rows) == 1 else 'scans'} ok"
    if len(good) < len(rows):
        text += f", {len(rows) - len(good):,} failed"
    if faces := sum(row.get("faces", 0) for row in good):
        text += f"; {faces:,} faces became {sum(row.get('polygons', 0) for row in good):,} polygons"
    return text


def write(folder: Path, rows: list[Row], pictures: Path) -> None:
    """Write the page of these rows into the output folder."""
    lines = [
        "<!DOCTYPE html>",
        '<html lang="en"><head><meta charset="utf-8"><title>isimp batch</title>',
        f"<style>{_STYLE}</style></head><body>",
        f"<h1>{html.escape(folder.name)}</h1><p>{totals(rows)}.</p>",
    ]
    if len(rows) > _PICTURES:
        lines.append(f"<p>The first {_PICTURES:,} rows have pictures.</p>")
    heads = ("scan and result", "name", "", "faces", "regions", "polygons", "flat to", "seconds", "peak MB")
    lines.append(f"<table><thead><tr>{''.join(f'<th>{head}</th>' for head in heads)}</tr></thead><tbody>")
    lines += [_line(row, folder, pictures if k < _PICTURES else None) for k, row in enumerate(in_order(rows))]
    lines.append("</tbody></table></body></html>")
    part = folder / WORK / NAME
    part.write_text("\n".join(lines) + "\n", encoding="utf-8", errors="backslashreplace")
    part.replace(folder / NAME)


def _line(row: Row, folder: Path, pictures: Path | None) -> str:
    failed, problems = row["status"] != "ok", defects(row)
    kind = "failed" if failed else "defective" if problems else "ok"
    said = str(row["why"]) if failed else ", ".join(problems)
    flat = ""
    if row.get("planarity_mean") is not None and row.get("diagonal"):
        flat = f"{row['planarity_mean'] / row['diagonal']:.3%}"
    numbers = [
        *(f"{row[name]:,}" if row.get(name) is not None else "" for name in ("faces", "regions", "polygons")),
        flat,
        f"{row['seconds']:.1f}",
        "" if row["peak_mb"] is None else f"{row['peak_mb']:,.0f}",
    ]
    cells = [f"<td>{_picture(row, pictures)}</td><td>{_name(row, folder)}</td><td>{html.escape(said)}</td>"]
    cells += [f'<td class="n">{number}</td>' for number in numbers]
    return f'<tr class="{kind}">{"".join(cells)}</tr>'


def _name(row: Row, folder: Path) -> str:
    """Return the name as a link to the result."""
    if not row.get("output"):
        return html.escape(row["name"])
    place = os.path.relpath(row["output"], folder)
    return f'<a href="{html.escape(quote(os.fsencode(place)))}">{html.escape(row["name"])}</a>'


def _picture(row: Row, pictures: Path | None) -> str:
    if pictures is None or row["status"] != "ok":
        return ""
    try:
        data = (pictures / f"{row['key']}.png").read_bytes()
    except OSError:
        return ""
    source = base64.b64encode(data).decode()
    return f'<img src="data:image/png;base64,{source}" alt="scan and result" loading="lazy">'
