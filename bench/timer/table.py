"""Makes the table of wanted and measured figures from results. Nothing is measured here."""

from __future__ import annotations

from collections.abc import Iterator
from statistics import mean, median, quantiles
from typing import Any, NamedTuple

from bench.timer.jobs import COUNTS, SCANS

Result = dict[str, Any]  # output of a job
LARGE = 500_000  # faces from which the bars for a million hold
JUDGED = [f"{mesh}/{count}" for mesh in SCANS for count in COUNTS]  # the jobs that bars of speed and error are for
CGAL_PEAK_MB = 895  # on the dragon, 500 proxies, as measured once on its own
EDITS = {"add": (2.0, 6.0), "delete": (1.5, 5.0)}  # milliseconds: the median and the 95th of a hundred
MESHING = {"armadillo": 1.0, "dragon": 1.5}  # REF rounds


class Row(NamedTuple):
    """One line; `met` is None where there is no bar, or no figure to compare with it."""

    what: str
    where: str
    wanted: str
    measured: str
    met: bool | None


def row(what: str, where: str, measured: str, has_bar: bool = False, wanted: str = "", met: bool = False) -> Row:
    return Row(what, where, wanted if has_bar else "", measured, bool(met) if has_bar else None)


def per_round(result: Result, case: str, clock: str = "cpu_ms") -> list[float]:
    """The median time of a run, by round."""
    return [median(run[clock][0] for run in runs) for runs in result["cases"][case]]


def speed_up(result: Result, case: str, over: str = "reference") -> float:
    """The speed of a case relative to another: the median over rounds, each round by itself."""
    pairs = zip(per_round(result, case), per_round(result, over), strict=True)
    return median(slow / fast for fast, slow in pairs)


def fact(result: Result, case: str, key: str) -> float:
    """The mean over rounds, that is over seeds."""
    return mean(runs[0][key] for runs in result["cases"][case])


def reference_round(result: Result) -> float:
    """Milliseconds of one round of the plain reference on this mesh, in this process."""
    return median(ms for runs in result["cases"]["reference"] for ms in runs[0]["round_ms"])


def in_rounds(result: Result, case: str) -> float:
    return median(per_round(result, case)) / reference_round(result)


def percent(ratio: float) -> str:
    return f"{100 * (ratio - 1):+.1f} %"


def relative(value: float, base: float) -> float:
    """value / base, where both may be nothing but rounding."""
    tiny = 1e-9
    return (value + tiny) / (base + tiny)


def against_reference(result: Result, case: str, key: str) -> float:
    return relative(fact(result, case, key), fact(result, "reference", key))


def partition_rows(where: str, result: Result, *, bars: bool) -> Iterator[Row]:
    large = result["mesh"]["faces"] >= LARGE
    for case, speed, error, border in (
        ("lloyd", 6.0 if large else 0, 1.01, 0),
        ("default", 80.0 if large else 40, 0.8 if large else 0.9, 1.06 if large else 0),
    ):
        ratio = speed_up(result, case)
        worse, longer = (against_reference(result, case, key) for key in ("error", "border_length"))
        wanted = (
            [f">= {speed:.0f} x"] * bool(speed) + [f"D {percent(error)}"] + [f"border {percent(border)}"] * bool(border)
        )
        met = ratio >= speed and worse <= error and (not border or longer <= border)
        measured = f"{ratio:.1f} x, D {percent(worse)}, border {percent(longer)}"
        yield row(f"{case}, one thread, against REF", where, measured, bars, ", ".join(wanted), met)
    yield threads_row("default", "labels", where, result, bar=1.5 if bars else None)
    if "teleport" in result["cases"]:
        measured = f"{speed_up(result, 'teleport'):.1f} x, D {percent(against_reference(result, 'teleport', 'error'))}"
        yield row("teleport, one thread, against REF", where, measured)
    if "new_count" in result["cases"]:
        took, two = median(per_round(result, "new_count")), median(per_round(result, "new_count_two_threads", "own_ms"))
        measured = f"{took:.0f} ms, {in_rounds(result, 'new_count'):.2f} REF rounds; two threads {two:.0f} ms"
        yield row("a new number of regions from a kept mesh", where, measured, large, "<= 40 ms", took <= 40)
    if "new_detail" in result["cases"]:
        times = {case: median(per_round(result, f"new_detail{case}")) for case in ("", "_adapted", "_finest")}
        two = median(per_round(result, "new_detail_two_threads", "own_ms"))
        measured = ", ".join(f"{case[1:]} {ms:.0f}" if case else f"{ms:.0f}" for case, ms in times.items())
        measured += f" ms, {in_rounds(result, 'new_detail'):.2f} REF rounds; two threads {two:.0f} ms"
        met = max(times.values()) <= 60
        yield row("another detail from the kept tree", where, measured, large, "<= 60 ms", met)


def is_same(result: Result, case: str) -> bool:
    """Whether every run of a round gave the same on one thread and on two."""
    rounds = zip(result["cases"][case], result["cases"][f"{case}_two_threads"], strict=True)
    return all(len({run["fingerprint"] for run in one + two}) == 1 for one, two in rounds)


def threads_row(case: str, of: str, where: str, result: Result, *, bar: float | None) -> Row:
    """A case on two threads against one."""
    # By the processor time of the calling thread, which has a share in every loop and does the rest alone: wall time
    # means little where other programs keep the cores from working in parallel.
    one, two, wall_one, wall_two = (
        min(run[clock][0] for runs in result["cases"][name] for run in runs)
        for clock in ("own_ms", "wall_ms")
        for name in (case, f"{case}_two_threads")
    )
    same = is_same(result, case)
    measured = f"{one / two:.2f} x (wall: {wall_one / wall_two:.2f} x), {'same' if same else 'OTHER'} {of}"
    wanted = f">= {bar} x, same {of}" if bar else f"same {of}"
    what = f"{case}, two threads against one, by the calling thread's time"
    return row(what, where, measured, True, wanted, same and (bar is None or one >= bar * two))


def edit_rows(where: str, result: Result, *, bars: bool) -> Iterator[Row]:
    for case, most in EDITS.items():
        runs = [runs[0] for runs in result["cases"].get(case, []) if len(runs[0].get("cpu_ms", ())) > 1]
        if not runs:
            continue
        laps = [ms for run in runs for ms in run["cpu_ms"]]
        middle, high = median(laps), quantiles(laps, n=20)[-1]
        worse = mean(relative(mean(run["errors"]), run["error_of_full_run"]) for run in runs)
        measured, wanted = f"{middle:.2f} / {high:.2f} ms, D {percent(worse)}", f"<= {most[0]} / {most[1]} ms"
        met = middle <= most[0] and high <= most[1] and worse <= 1.005
        yield row(f"{case} at a face, median / p95", where, measured, bars, f"{wanted}, D +0.5 % of a full run", met)


def set_up_rows(where: str, result: Result) -> Iterator[Row]:
    large, mesh = result["mesh"]["faces"] >= LARGE, median(per_round(result, "mesh"))
    rounds = in_rounds(result, "mesh")
    yield row("arrays to Mesh", where, f"{rounds:.2f} REF rounds", large, "<= .3 REF rounds", rounds <= 0.3)
    if "clean" in result["cases"]:
        clean = median(per_round(result, "clean"))
        measured = f"{clean / mesh:.2f} x Mesh, {clean - mesh:+.0f} ms"
        yield row("clean on a sound mesh", where, measured, True, "<= 1.5 x Mesh + 100 ms", clean <= 1.5 * mesh + 100)
    if "close" in result["cases"]:
        yield row("the same with small openings closed", where, f"{in_rounds(result, 'close'):.2f} REF rounds")


def meshing_rows(where: str, name: str, result: Result) -> Iterator[Row]:
    if "polygonize" in result["cases"]:
        ratio, most, good = in_rounds(result, "polygonize"), MESHING.get(name), result["cases"]["polygonize"][0][0]
        polygons = f"{good['polygons']:.0f} polygons, {'manifold' if good['manifold'] else 'NOT MANIFOLD'}"
        measured = f"{ratio:.2f} REF rounds, {polygons}"
        yield row("polygonize", where, measured, most is not None, f"<= {most} REF rounds", ratio <= (most or 0))
    if "polygonize_two_threads" in result["cases"]:
        yield threads_row("polygonize", "polygons", where, result, bar=None)
    if "polygonize_planar" in result["cases"]:
        yield row("polygonize to planar polygons", where, f"{in_rounds(result, 'polygonize_planar'):.2f} REF rounds")


def whole_way_rows(name: str, result: Result) -> Iterator[Row]:
    way, most = result["whole_way"], CGAL_PEAK_MB / 4
    own, is_dragon = (way["peak_bytes"] - way["array_bytes"]) / 1e6, name == "dragon"
    what = "peak memory beyond the arrays, file to file"
    yield row(what, name, f"{own:.0f} MB", is_dragon, f"<= {most:.0f} MB", own <= most)
    rest = [took for phase, took in way["phases"].items() if phase != "read"]
    cpu, wall = (sum(took[clock] for took in rest) / 1e3 for clock in ("cpu_ms", "wall_ms"))
    phases = ", ".join(f"{phase} {took['cpu_ms']:.0f}" for phase, took in way["phases"].items())
    measured = f"{cpu:.2f} s of processor ({phases} ms), {wall:.2f} s wall"
    yield row("mesh to written, one thread", name, measured, name == "dragon-loop", "< 1.5 s", cpu < 1.5)
    one, two = way["read_on_threads"]["one"], way["read_on_threads"]["two"]
    measured = f"{two['wall_ms'] / one['wall_ms']:.2f} of the wall time ({two['wall_ms']:.0f} ms), "
    measured += f"{two['cpu_ms'] / one['cpu_ms']:.2f} of the processor time"
    yield row("binary PLY read, two threads over one", name, measured)


def cgal_row(name: str, results: Result) -> Row:
    _, mesh, count, seeding = name.split("/")
    peer = results[name]
    unit = median(peer["reference_round_ms"])
    more = [
        f"a round takes {peer['rounds_ms'] / 20 / unit:.2f} REF rounds",
        f"peak {peer['peak_bytes'] / 1e6:.0f} MB",
        f"meshing {peer['meshing_ms'] / unit:.1f} REF rounds, " + ("manifold" if peer["manifold"] else "not manifold"),
    ]
    own = results.get(f"{mesh}/{count}")
    if own:
        more.append(f"D {percent(relative(peer['result']['error'], fact(own, 'reference', 'error')))} of REF")
    return row(f"CGAL, {seeding} seeds, 20 rounds", f"{mesh}, P {count}", ", ".join(more))


def growth_rows(growth: Result) -> Iterator[Row]:
    for kind, per_face in (("faces", True), ("regions", False)):
        runs = [result for name, result in growth.items() if name.startswith(kind)]
        if len(runs) < 2:
            continue
        sizes = [run["mesh"]["faces"] for run in runs]
        costs = [median(per_round(run, "default")) / (n if per_face else 1) for run, n in zip(runs, sizes, strict=True)]
        spread = max(costs) / min(costs)
        span = f"F {min(sizes)} to {max(sizes)}" if per_face else f"P {runs[0]['proxies']} to {runs[-1]['proxies']}"
        what = f"default, time {'a face' if per_face else 'over P'}: largest to least"
        yield Row(
            what, span, "<= 1.3" if per_face else "nearly flat", f"{spread:.2f}", spread <= 1.3 if per_face else None
        )


def rows(results: dict[str, Result], growth: dict[str, Result]) -> list[Row]:
    table: list[Row] = []
    for name, result in results.items():
        kind, *rest = name.split("/")
        if kind == "whole-way":
            table += whole_way_rows(rest[0], result)
        elif kind == "cgal":
            table.append(cgal_row(name, results))
        else:
            where = f"{kind}, P {rest[0]}"
            table += partition_rows(where, result, bars=name in JUDGED)
            table += edit_rows(where, result, bars=result["mesh"]["faces"] >= LARGE and rest[0] == "500")
            table += set_up_rows(where, result) if rest[0] == "500" else []
            table += meshing_rows(where, kind, result)
    return sorted([*table, *growth_rows(growth)], key=lambda row: row.what)


def sound(table: list[Row], results: dict[str, Result]) -> bool:
    """Conditions that do not depend on times: there are rows, and repeated runs gave the same."""
    judged = [result for result in results.values() if "default" in result.get("cases", {})]
    return bool(table and judged) and all(
        is_same(result, case)
        for result in judged
        for case in ("default", "polygonize")
        if f"{case}_two_threads" in result["cases"]
    )


def text(table: list[Row], *, judge: bool) -> str:
    """The table in Markdown."""
    met = {True: "yes", False: "no", None: ""}
    lines = [("what", "mesh", "wanted", "measured", "met")]
    lines += [(*row[:4], met[row.met if judge else None]) for row in table]
    widths = [max(len(line[i]) for line in lines) for i in range(5)]
    lines.insert(1, tuple("-" * width for width in widths))
    padded = ([cell.ljust(width) for cell, width in zip(line, widths, strict=True)] for line in lines)
    return "\n".join(f"| {' | '.join(cells)} |" for cells in padded)
