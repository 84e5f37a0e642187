"""Makes the table of wanted and measured figures from results. Nothing is measured here."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from statistics import mean, median, quantiles
from typing import Any

from bench.timer.jobs import COUNTS, SCANS

Result = dict[str, Any]  # output of a program
LARGE = 500_000  # faces from which the bars for a million hold
JUDGED = [f"{mesh}/{count}" for mesh in SCANS for count in COUNTS]  # the jobs that bars of speed and error are for
CGAL_PEAK_MB = 895  # on the dragon, 500 proxies, as measured once on its own


@dataclass(frozen=True)
class Row:
    """One line; `met` is None where there is no bar, or no figure to compare with it."""

    what: str
    where: str
    wanted: str
    measured: str
    met: bool | None


def per_round(result: Result, case: str, clock: str = "cpu_ms") -> list[float]:
    """The median time of a run, by round."""
    return [median(run[clock][0] for run in runs) for runs in result["cases"][case]]


def speed_up(result: Result, case: str, over: str, clock: str = "cpu_ms") -> float:
    """The speed of a case relative to another: the median over rounds, each round by itself."""
    pairs = zip(per_round(result, case, clock), per_round(result, over, clock), strict=True)
    return median(slow / fast for fast, slow in pairs)


def least(result: Result, case: str, clock: str) -> float:
    return min(run[clock][0] for runs in result["cases"][case] for run in runs)


def fact(result: Result, case: str, key: str) -> float:
    """The mean over rounds, that is over seeds."""
    return mean(runs[0][key] for runs in result["cases"][case])


def reference_round(result: Result) -> float:
    """Milliseconds of one round of the plain reference on this mesh, in this process."""
    return median(ms for runs in result["cases"]["reference"] for ms in runs[0]["round_ms"])


def percent(ratio: float) -> str:
    return f"{100 * (ratio - 1):+.1f} %"


def relative(value: float, base: float) -> float:
    """value / base, where both may be nothing but rounding."""
    tiny = 1e-9
    return (value + tiny) / (base + tiny)


def partition_rows(where: str, result: Result, *, bars: bool) -> Iterator[Row]:
    large = result["mesh"]["faces"] >= LARGE
    for case, speed, error, border in (
        ("lloyd", 6.0 if large else 0, 1.01, 0),
        ("default", 80.0 if large else 40, 0.8 if large else 0.9, 1.06 if large else 0),
    ):
        ratio = speed_up(result, case, "reference")
        more_error = relative(fact(result, case, "error"), fact(result, "reference", "error"))
        more_border = relative(fact(result, case, "border_length"), fact(result, "reference", "border_length"))
        wanted = (
            [f">= {speed:.0f} x"] * bool(speed) + [f"D {percent(error)}"] + [f"border {percent(border)}"] * bool(border)
        )
        yield Row(
            f"{case}, one thread, against REF",
            where,
            ", ".join(wanted) if bars else "",
            f"{ratio:.1f} x, D {percent(more_error)}, border {percent(more_border)}",
            ratio >= speed and more_error <= error and (not border or more_border <= border) if bars else None,
        )
    yield threads_row("default", "labels", where, result, same=same_labels(result), bar=1.5 if bars else None)
    if "teleport" in result["cases"]:
        yield teleport_row(where, result)
    if "new_count" in result["cases"]:
        yield new_count_row(where, result)
    if "new_detail" in result["cases"]:
        yield new_detail_row(where, result)


def same_labels(result: Result) -> bool:
    """Whether every run of a round gave the same labels on one thread and on two."""
    rounds = zip(result["cases"]["default"], result["cases"]["default_two_threads"], strict=True)
    return all(len({run["fingerprint"] for run in one + two}) == 1 for one, two in rounds)


def threads_row(case: str, of: str, where: str, result: Result, *, same: bool, bar: float | None) -> Row:
    """A case on two threads against one; `same`: whether it gave the same `of` both times."""
    # By the processor time of the calling thread, which has a share in every loop and does the rest alone: wall time
    # means little where other programs keep the cores from working in parallel.
    both = (case, f"{case}_two_threads")
    one, two = (least(result, name, "own_ms") for name in both)
    wall_one, wall_two = (least(result, name, "wall_ms") for name in both)
    return Row(
        f"{case}, two threads against one, by the calling thread's time",
        where,
        f">= {bar} x, same {of}" if bar else f"same {of}",
        f"{one / two:.2f} x (wall: {wall_one / wall_two:.2f} x), {'same' if same else 'OTHER'} {of}",
        same and (bar is None or one >= bar * two),
    )


def teleport_row(where: str, result: Result) -> Row:
    more_error = relative(fact(result, "teleport", "error"), fact(result, "reference", "error"))
    measured = f"{speed_up(result, 'teleport', 'reference'):.1f} x, D {percent(more_error)}"
    return Row("teleport, one thread, against REF", where, "", measured, None)


def new_count_row(where: str, result: Result) -> Row:
    took = median(per_round(result, "new_count"))
    two = median(per_round(result, "new_count_two_threads", "own_ms"))
    rounds = took / reference_round(result)
    measured = f"{took:.0f} ms, {rounds:.2f} REF rounds; two threads {two:.0f} ms"
    large = result["mesh"]["faces"] >= LARGE
    return Row(
        "a new number of regions from a kept Partitioner",
        where,
        "<= 40 ms" if large else "",
        measured,
        took <= 40 if large else None,
    )


def new_detail_row(where: str, result: Result) -> Row:
    took = {case: median(per_round(result, f"new_detail{case}")) for case in ("", "_adapted", "_finest")}
    two = median(per_round(result, "new_detail_two_threads", "own_ms"))
    measured = ", ".join(f"{case[1:]} {ms:.0f}" if case else f"{ms:.0f}" for case, ms in took.items())
    large = result["mesh"]["faces"] >= LARGE
    return Row(
        "another detail from the kept tree",
        where,
        "<= 60 ms" if large else "",
        f"{measured} ms, {took[''] / reference_round(result):.2f} REF rounds; two threads {two:.0f} ms",
        max(took.values()) <= 60 if large else None,
    )


def edit_rows(where: str, result: Result, *, bars: bool) -> Iterator[Row]:
    for case, most in (("add", (2.0, 6.0)), ("delete", (1.5, 5.0))):
        runs = [runs[0] for runs in result["cases"].get(case, []) if len(runs[0]["cpu_ms"]) > 1]
        if not runs:
            continue
        laps = [ms for run in runs for ms in run["cpu_ms"]]
        middle, high = median(laps), quantiles(laps, n=20)[-1]
        worse = mean(relative(mean(run["errors"]), run["error_of_full_run"]) for run in runs)
        yield Row(
            f"{case} at a face, median / p95",
            where,
            f"<= {most[0]} / {most[1]} ms, D +0.5 % of a full run" if bars else "",
            f"{middle:.2f} / {high:.2f} ms, D {percent(worse)}",
            middle <= most[0] and high <= most[1] and worse <= 1.005 if bars else None,
        )


def set_up_rows(where: str, result: Result) -> Iterator[Row]:
    unit = reference_round(result)
    mesh = median(per_round(result, "mesh"))
    large = result["mesh"]["faces"] >= LARGE
    wanted, met = ("<= .3 REF rounds", mesh <= 0.3 * unit) if large else ("", None)
    yield Row("arrays to Mesh", where, wanted, f"{mesh / unit:.2f} REF rounds", met)
    if "clean" in result["cases"]:
        clean = median(per_round(result, "clean"))
        wanted, measured = "<= 1.5 x Mesh + 100 ms", f"{clean / mesh:.2f} x Mesh, {clean - mesh:+.0f} ms"
        yield Row("clean on a sound mesh", where, wanted, measured, clean <= 1.5 * mesh + 100)
        if "close" in result["cases"]:
            close = median(per_round(result, "close"))
            yield Row("the same with small openings closed", where, "", f"{close / unit:.2f} REF rounds", None)


def same_polygons(result: Result) -> bool:
    """Whether every run gave the same polygons, on one thread and on two."""
    cases = (result["cases"][name] for name in ("polygonize", "polygonize_two_threads"))
    return len({run["fingerprint"] for case in cases for runs in case for run in runs}) == 1


def meshing_row(where: str, name: str, result: Result) -> Row:
    ratio = median(per_round(result, "polygonize")) / reference_round(result)
    most = {"armadillo": 1.0, "dragon": 1.5}.get(name)
    good = result["cases"]["polygonize"][0][0]
    polygons = f"{good['polygons']:.0f} polygons, {'manifold' if good['manifold'] else 'NOT MANIFOLD'}"
    return Row(
        "polygonize",
        where,
        f"<= {most} REF rounds" if most else "",
        f"{ratio:.2f} REF rounds, {polygons}",
        ratio <= most if most else None,
    )


def whole_way_rows(name: str, result: Result) -> Iterator[Row]:
    way, megabyte = result["whole_way"], 1e6
    own = (way["peak_bytes"] - way["array_bytes"]) / megabyte
    dragon, fine = name == "dragon", name == "dragon-loop"
    yield Row(
        "peak memory beyond the arrays, file to file",
        name,
        f"<= {CGAL_PEAK_MB / 4:.0f} MB" if dragon else "",
        f"{own:.0f} MB",
        own <= CGAL_PEAK_MB / 4 if dragon else None,
    )
    rest = [took for phase, took in way["phases"].items() if phase != "read"]
    cpu, wall = (sum(took[clock] for took in rest) / 1e3 for clock in ("cpu_ms", "wall_ms"))
    phases = ", ".join(f"{phase} {took['cpu_ms']:.0f}" for phase, took in way["phases"].items())
    measured = f"{cpu:.2f} s of processor ({phases} ms), {wall:.2f} s wall"
    yield Row("mesh to written, one thread", name, "< 1.5 s" if fine else "", measured, cpu < 1.5 if fine else None)
    one, two = way["read_on_threads"]["one"], way["read_on_threads"]["two"]
    yield Row(
        "binary PLY read, two threads over one",
        name,
        "",
        f"{two['wall_ms'] / one['wall_ms']:.2f} of the wall time ({two['wall_ms']:.0f} ms), "
        f"{two['cpu_ms'] / one['cpu_ms']:.2f} of the processor time",
        None,
    )


def cgal_row(name: str, results: Result) -> Row:
    _, mesh, count, seeding = name.split("/")
    peer = results[name]
    rounds = peer["rounds"]["cpu_ms"] / 20 / median(peer["reference_round_ms"])
    more = [
        f"a round takes {rounds:.2f} REF rounds",
        f"peak {peer['peak_bytes'] / 1e6:.0f} MB",
        f"meshing {peer['meshing']['cpu_ms'] / median(peer['reference_round_ms']):.1f} REF rounds, "
        + ("manifold" if peer["manifold"] else "not manifold"),
    ]
    own = results.get(f"{mesh}/{count}")
    if own:
        more.append(f"D {percent(relative(peer['result']['error'], fact(own, 'reference', 'error')))} of REF")
    return Row(f"CGAL, {seeding} seeds, 20 rounds", f"{mesh}, P {count}", "", ", ".join(more), None)


def python_rows(where: str, result: Result) -> Iterator[Row]:
    for case, most in (("add", (2.0, 6.0)), ("delete", (1.5, 5.0))):
        laps = result[case]
        middle, high = median(laps), quantiles(laps, n=20)[-1]
        yield Row(
            f"{case} through Python, median / p95",
            where,
            f"<= {most[0]} / {most[1]} ms",
            f"{middle:.2f} / {high:.2f} ms",
            middle <= most[0] and high <= most[1],
        )


def growth_rows(growth: Result) -> Iterator[Row]:
    for kind, per_face in (("faces", True), ("regions", False)):
        runs = [result for name, result in growth.items() if name.startswith(kind)]
        if len(runs) < 2:
            continue
        sizes = [run["mesh"]["faces"] for run in runs]
        costs = [median(per_round(run, "default")) / (n if per_face else 1) for run, n in zip(runs, sizes, strict=True)]
        spread = max(costs) / min(costs)
        span = f"F {min(sizes)} to {max(sizes)}" if per_face else f"P {runs[0]['proxies']} to {runs[-1]['proxies']}"
        yield Row(
            f"default, time {'a face' if per_face else 'over P'}: largest to least",
            span,
            "<= 1.3" if per_face else "nearly flat",
            f"{spread:.2f}",
            spread <= 1.3 if per_face else None,
        )


def rows(results: dict[str, Result], growth: dict[str, Result]) -> list[Row]:
    table: list[Row] = []
    for name, result in results.items():
        kind, *rest = name.split("/")
        if kind == "whole-way":
            table += whole_way_rows(rest[0], result)
        elif kind == "cgal":
            table.append(cgal_row(name, results))
        elif kind == "python":
            table += python_rows(f"{rest[0]}, P {rest[1]}", result)
        else:
            where = f"{kind}, P {rest[0]}"
            table += partition_rows(where, result, bars=name in JUDGED)
            table += edit_rows(where, result, bars=result["mesh"]["faces"] >= LARGE and rest[0] == "500")
            if rest[0] == "500":
                table += set_up_rows(where, result)
            if "polygonize" in result["cases"]:
                table.append(meshing_row(where, kind, result))
            if "polygonize_two_threads" in result["cases"]:
                same = same_polygons(result)
                table.append(threads_row("polygonize", "polygons", where, result, same=same, bar=None))
            if "polygonize_planar" in result["cases"]:
                ratio = median(per_round(result, "polygonize_planar")) / reference_round(result)
                table.append(Row("polygonize to planar polygons", where, "", f"{ratio:.2f} REF rounds", None))
    table += growth_rows(growth)
    return sorted(table, key=lambda row: row.what)


def sound(table: list[Row], results: dict[str, Result]) -> bool:
    """Conditions that do not depend on times: there are rows, and repeated runs gave the same."""
    judged = [result for result in results.values() if "default" in result.get("cases", {})]
    return (
        bool(table)
        and bool(judged)
        and all(same_labels(result) for result in judged)
        and all(same_polygons(result) for result in judged if "polygonize_two_threads" in result["cases"])
    )


def text(table: list[Row], *, judge: bool) -> str:
    """The table in Markdown."""
    met = {True: "yes", False: "no", None: ""}
    lines = [("what", "mesh", "wanted", "measured", "met")]
    lines += [(row.what, row.where, row.wanted, row.measured, met[row.met if judge else None]) for row in table]
    widths = [max(len(line[i]) for line in lines) for i in range(5)]
    lines.insert(1, tuple("-" * width for width in widths))
    padded = ([cell.ljust(width) for cell, width in zip(line, widths, strict=True)] for line in lines)
    return "\n".join(f"| {' | '.join(cells)} |" for cells in padded)
