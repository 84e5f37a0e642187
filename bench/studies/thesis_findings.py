"""The findings of the thesis on its floodings and its hybrid, compared with the figures of thesis.py."""

from __future__ import annotations


def findings(speed: list[dict], rounds: list[dict], fractions: list[dict]) -> list[dict]:
    """One row for each finding: thesis, holds (True or False, on all scans), here (the figures that show it)."""
    return [*_of_speed(speed), *_of_rounds(rounds), *_of_fractions(fractions)]


def _row(thesis: str, holds: list[bool], here: str) -> dict:
    return {"thesis": thesis, "holds": all(holds), "here": here}


def _scans(rows: list[dict]) -> list[str]:
    return list(dict.fromkeys(row["scan"] for row in rows))


def _range(values: list[float]) -> str:
    """The least and the largest, to two digits."""
    low, high = (f"{value:.2g}" for value in (min(values), max(values)))
    return low if low == high else f"{low} to {high}"


def _of_speed(rows: list[dict]) -> list[dict]:
    result = []
    for backend in dict.fromkeys(row["backend"] for row in rows):
        gain = {(r["scan"], r["method"], r["proxies"]): r["speed_up"] for r in rows if r["backend"] == backend}
        counts = sorted({r["proxies"] for r in rows})
        scans = sorted(_scans(rows), key=lambda scan: next(r["faces"] for r in rows if r["scan"] == scan))
        on = "" if backend == "cpu" else f" ({backend})"
        for method in ("naive, brute force", "naive"):
            by = [gain[scan, method, counts[-1]] / gain[scan, method, counts[0]] for scan in scans]
            here = f"{method}: times {_range(by)} from {counts[0]} to {counts[-1]} regions"
            result.append(_row(f"the naive one gains less with more regions{on}", [b < 0.9 for b in by], here))
        growth = [gain[scans[-1], "queued", count] / gain[scans[0], "queued", count] for count in counts]
        here = f"times {_range(growth)} from the smallest to the largest scan"
        result.append(_row(f"the queued one gains more on larger meshes{on}", [g > 1.1 for g in growth], here))
        small = [gain[scans[0], "queued", count] for count in counts]
        here = f"speed-up over lloyd {_range(small)}"
        result.append(_row(f"the queued one is slower on small meshes{on}", [g < 1 for g in small], here))
    return result


def _of_rounds(rows: list[dict]) -> list[dict]:
    error = {(r["scan"], r["method"], r["round"]): r["error"] for r in rows}
    scans = _scans(rows)

    def last(scan: str, method: str) -> float:
        return [r["error"] for r in rows if (r["scan"], r["method"]) == (scan, method) and isinstance(r["round"], int)][
            -1
        ]

    def order(connect: str) -> dict:
        queued, naive = ([error[scan, way, f"end {connect}"] for scan in scans] for way in ("queued", "naive"))
        holds = [1 <= q <= n for q, n in zip(queued, naive, strict=True)]
        here = f"lloyd 1, queued {_range(queued)}, naive {_range(naive)}"
        return _row(f"sequential best, then queued, then naive (connected by {connect})", holds, here)

    def raised(connect: str) -> tuple[list[float], str]:
        by = {
            way: [error[scan, way, f"end {connect}"] / last(scan, way) - 1 for scan in scans]
            for way in ("queued", "naive")
        }
        return [x for way in by.values() for x in way], ", ".join(f"{way} by {_range(x)}" for way, x in by.items())

    (flood, by_flood), (repair, by_repair) = raised("flood"), raised("repair")
    late = [error[scan, "lloyd", min(10, _rounds(rows, scan))] / last(scan, "lloyd") - 1 for scan in scans]
    return [
        order("flood"),
        order("repair"),
        _row("the last sequential round raises the error again", [x > 0 for x in flood], by_flood),
        _row(
            "(not in the thesis) a parallel repair loses less",
            [b < a for a, b in zip(flood, repair, strict=True)],
            by_repair,
        ),
        _row(
            "fewer than 10 rounds are enough", [x < 0.05 for x in late], f"the rounds after bring lloyd {_range(late)}"
        ),
    ]


def _rounds(rows: list[dict], scan: str) -> int:
    return max(r["round"] for r in rows if (r["scan"], r["method"]) == (scan, "lloyd") and isinstance(r["round"], int))


def _of_fractions(rows: list[dict]) -> list[dict]:
    hybrid = [r for r in rows if r["method"] == "hybrid"]
    whole = [r["decimating"] + r["partitioning"] for r in hybrid]
    share = [r["decimating"] / w for r, w in zip(hybrid, whole, strict=True)]
    best, kept, suffers = [], [], []
    for scan in _scans(rows):
        mine = [r for r in hybrid if r["scan"] == scan]
        best.append(min(r["decimating"] + r["partitioning"] for r in mine))
        sixteenth = next(r for r in mine if abs(r["fraction"] - 1 / 16) < 1e-9)
        kept.append(sixteenth["partitioning"])
        suffers.append(sixteenth["error"] / mine[0]["error"])
    default = {r["scan"]: r["error"] for r in rows if r["method"] == "default"}
    over = [r["error"] / default[r["scan"]] for r in rows if r["method"] == "hybrid, relaxed"]
    faithful = [r["error"] / default[r["scan"]] for r in hybrid]
    return [
        _row("decimating first is twice as fast", [b < 0.5 for b in best], f"takes {_range(best)} of lloyd's time"),
        _row("the decimator dominates", [x > 0.5 for x in share], f"{_range(share)} of the time"),
        _row(
            "90-95 % of the faces can go",
            [x < 1.1 for x in suffers],
            f"1/16 against 1/2: error times {_range(suffers)}",
        ),
        _row(
            "further partitions pay for it once", [k < 1 for k in kept], f"1/16 again: {_range(kept)} of lloyd's time"
        ),
        _row(
            "(not in the thesis) with relaxed borders the hybrid comes near the default",
            [x < 1.1 for x in over],
            f"error times {_range(over)} of the default's, without {_range(faithful)}",
        ),
    ]
