"""The thesis's three experiments on this engine: speed by method, distortion by round, the hybrid by fraction.

    python -m bench.studies.thesis --data DIR --out FOLDER [--only NAME,...]

Needs the package as `pip install .` makes it, and matplotlib for the plots. Times are processor time on one thread, and
wall time where a device works; each is given as a ratio to `lloyd` in the same process. FOLDER gets a CSV file and a
plot for each experiment.
"""

from __future__ import annotations

import argparse
import csv
import sys
import time
from pathlib import Path

import isimp_engine as engine
from bench.studies.gpu import write_rows

SCANS = {  # by name, below --data; anything else is the name of a file there
    "bunny": "scan/bunny_69k.ply",
    "armadillo": "scan/armadillo_86k.ply",
    "armadillo x 4": "scan/armadillo_346k_loop.ply",
    "dragon": "scan/dragon_871k.ply",
}
FRACTIONS = tuple(1 / 2**k for k in range(1, 6))
ROUNDS = 20
WAYS = {  # options of partition(), and how many rounds are enough to know the time of one
    "lloyd": ({"method": "lloyd"}, ROUNDS),
    "queued": ({"method": "queued"}, ROUNDS),
    "naive": ({"method": "naive"}, ROUNDS),
    "naive, brute force": ({"method": "naive", "search": "brute"}, 2),
    "default": ({"method": "hierarchy"}, ROUNDS),
}
COLORS = {"lloyd": "black", "queued": "tab:blue", "naive": "tab:orange", "naive, brute force": "tab:red"}
COLORS |= {"default": "tab:green", "hybrid": "tab:purple", "hybrid, relaxed": "tab:pink"}


def load(path: Path) -> engine.Mesh:
    return engine.clean(*engine.read(path))


def timed(mesh: engine.Mesh, **options) -> tuple[float, engine.Partition]:
    """Seconds, and the result."""
    clock = time.perf_counter if options.get("backend", "cpu") != "cpu" else time.process_time
    start = clock()
    part = engine.partition(mesh, engine.PartitionOptions(threads=1, **options))
    return clock() - start, part


def speed(name: str, path: Path, counts: list[int]) -> list[dict]:
    """For every method on every back end the time of a round against lloyd's; for the default the time of all."""
    mesh, rows = load(path), []
    for proxies in counts:
        seconds = {}
        for backend in engine.backends():
            if backend != "cpu":  # the first call wakes the device
                timed(mesh, proxies=proxies, iterations=1, backend=backend, method="queued")
            for way, (options, enough) in WAYS.items():
                if backend != "cpu" and way in ("lloyd", "default"):
                    continue  # these work on the CPU only
                spent, part = timed(mesh, proxies=proxies, iterations=enough, backend=backend, **options)
                whole = way == "default"
                done = 1 if whole else max(1, len(part.history) - (options["method"] in ("naive", "queued")))
                seconds[way] = spent / done
                gain = seconds["lloyd"] * (ROUNDS if whole else 1) / seconds[way]
                row = {"scan": name, "faces": len(mesh.triangles), "proxies": proxies, "method": way}
                row |= {"backend": backend, "rounds": done, "seconds": spent, "speed_up": gain, "error": part.error}
                rows.append(row)
    return rows


def rounds(name: str, path: Path, counts: list[int]) -> list[dict]:
    """The distortion after each round, as a share of lloyd's after the last, and that of the connected result."""
    mesh, rows, last = load(path), [], None
    for way in ("lloyd", "queued", "naive", "default"):
        for connect in ("repair", "flood") if way in ("queued", "naive") else ("",):
            options = WAYS[way][0] | ({"connect": connect} if connect else {})
            part = timed(mesh, proxies=middle(counts), iterations=ROUNDS, **options)[1]
            last = last or part.error
            row = {"scan": name, "method": way}
            if connect != "flood":  # the rounds before are the same
                on_the_way = part.history[:-1] if connect else part.history
                rows += [row | {"round": k, "error": error / last} for k, error in enumerate(on_the_way, 1)]
            rows.append(row | {"round": f"end {connect}".strip(), "error": part.error / last})
    return rows


def fractions(name: str, path: Path, counts: list[int]) -> list[dict]:
    """Time and distortion of the hybrid by the fraction of faces kept, against lloyd on all of them."""
    mesh, proxies = load(path), middle(counts)
    base, lloyd = timed(mesh, proxies=proxies, iterations=ROUNDS, method="lloyd")

    def row(method, fraction, decimating, partitioning, part) -> dict:
        times = {"decimating": decimating / base, "partitioning": partitioning / base}
        return {"scan": name, "method": method, "fraction": fraction} | times | {"error": part.error / lloyd.error}

    rows = [row("lloyd", 1.0, 0.0, base, lloyd)]
    rows.append(row("default", 1.0, 0.0, *timed(mesh, proxies=proxies, method="hierarchy")))
    for fraction in FRACTIONS:
        options = {"proxies": proxies, "iterations": ROUNDS, "method": "hybrid", "fraction": fraction}
        first, part = timed(mesh, connect="flood", **options)
        again, _ = timed(mesh, connect="flood", **options)  # the decimated mesh is kept
        rows.append(row("hybrid", fraction, first - again, again, part))
        rows.append(row("hybrid, relaxed", fraction, first - again, *timed(mesh, connect="repair", **options)))
    return rows


def middle(counts: list[int]) -> int:
    """The number of regions where only one is tried."""
    return sorted(counts)[len(counts) // 2]


def legend_below(figure) -> None:
    """One legend for all parts of a figure."""
    found = {}
    for axes in figure.axes:
        found |= {label: line for line, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    figure.legend(found.values(), found.keys(), loc="outside lower center", ncols=4, fontsize=8, frameon=False)


def plot_speed(figure, rows: list[dict]) -> None:
    scans = list(dict.fromkeys(row["scan"] for row in rows))
    for place, scan in enumerate(scans, 1):
        axes = figure.add_subplot(1, len(scans), place, title=scan, xlabel="regions", xscale="log", yscale="log")
        axes.axhline(1, color="black", linewidth=0.8)
        for way, backend in dict.fromkeys((r["method"], r["backend"]) for r in rows):
            line = [r for r in rows if (r["scan"], r["method"], r["backend"]) == (scan, way, backend)]
            style = {"color": COLORS[way], "linestyle": "-" if backend == "cpu" else "--", "marker": "o"}
            label = way if backend == "cpu" else f"{way}, {backend}"
            axes.plot([r["proxies"] for r in line], [r["speed_up"] for r in line], label=label, **style)
        axes.set_ylabel("speed-up over lloyd" if place == 1 else "")
        axes.set_ylim(0.005, 200)
    legend_below(figure)


def plot_rounds(figure, rows: list[dict]) -> None:
    scans = list(dict.fromkeys(row["scan"] for row in rows))
    for place, scan in enumerate(scans, 1):
        axes = figure.add_subplot(1, len(scans), place, title=scan, xlabel="round")
        for way in ("lloyd", "queued", "naive"):
            line = [r for r in rows if r["scan"] == scan and r["method"] == way]
            on_the_way = [r for r in line if isinstance(r["round"], int)]
            axes.plot([r["round"] for r in on_the_way], [r["error"] for r in on_the_way], color=COLORS[way], label=way)
            for end, marker in (("end repair", "o"), ("end flood", "x")):
                at = [r["error"] for r in line if r["round"] == end]
                label = f"{way}, connected by {end[4:]}"
                axes.plot([ROUNDS + 1] * len(at), at, marker, color=COLORS[way], label=label if at else None)
        default = next(r["error"] for r in rows if r["scan"] == scan and r["method"] == "default")
        axes.axhline(default, color=COLORS["default"], linestyle=":", label="default")
        axes.set_ylim(0.5, 1.5)
        axes.set_ylabel("distortion, lloyd's last = 1" if place == 1 else "")
    legend_below(figure)


def plot_fractions(figure, rows: list[dict]) -> None:
    scans = list(dict.fromkeys(row["scan"] for row in rows))
    for place, scan in enumerate(scans, 1):
        axes = figure.add_subplot(2, len(scans), place, title=scan, yscale="log")
        below = figure.add_subplot(2, len(scans), place + len(scans), xlabel="faces kept", ylim=(0.5, 1.5))
        for method in ("hybrid", "hybrid, relaxed"):
            line = [r for r in rows if r["scan"] == scan and r["method"] == method]
            at = range(len(line))
            color = {"color": COLORS[method]}
            if method == "hybrid":
                first = [r["decimating"] + r["partitioning"] for r in line]
                axes.plot(at, first, "o-", color="tab:red", label="decimating and hybrid")
            axes.plot(at, [r["partitioning"] for r in line], "o-", label=f"{method}, decimated before", **color)
            below.plot(at, [r["error"] for r in line], "o-", **color)
        default = next(r for r in rows if r["scan"] == scan and r["method"] == "default")
        for each, value in ((axes, default["partitioning"]), (below, default["error"])):
            each.axhline(1, color="black", linewidth=0.8, label="lloyd")
            each.axhline(value, color=COLORS["default"], linestyle=":", label="default")
            each.set_xticks(at, [f"1/{round(1 / r['fraction'])}" for r in line])
        axes.set_ylabel("time, lloyd = 1" if place == 1 else "")
        below.set_ylabel("distortion, lloyd = 1" if place == 1 else "")
    legend_below(figure)


EXPERIMENTS = {
    "speed": (speed, plot_speed, (10, 3.7)),
    "rounds": (rounds, plot_rounds, (10, 3.8)),
    "fractions": (fractions, plot_fractions, (10, 5.6)),
}


def read_rows(path: Path) -> list[dict]:
    def value(text: str):
        for kind in (int, float):
            try:
                return kind(text)
            except ValueError:
                pass
        return text

    with path.open(newline="") as file:
        return [{key: value(text) for key, text in row.items()} for row in csv.DictReader(file)]


def draw(path: Path, plot, size: tuple[float, float], rows: list[dict]) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    plot(figure, rows)
    figure.savefig(path, dpi=100)


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, help="the folder with the scans")
    parser.add_argument("--out", type=Path, default=Path("out/thesis"), help="where CSV files and plots go")
    parser.add_argument("--scans", default="bunny,armadillo x 4,dragon", help=", ".join(SCANS) + ", or files in --data")
    parser.add_argument("--counts", default="100,500,2000", help="of regions; where one is enough, the middle one")
    parser.add_argument("--only", default=",".join(EXPERIMENTS), help="which experiments")
    parser.add_argument("--csv-only", action="store_true", help="draw nothing: no matplotlib needed")
    parser.add_argument("--plots-only", action="store_true", help="draw the CSV files that are there")
    given = parser.parse_args(arguments)
    counts = [int(count) for count in given.counts.split(",")]
    given.out.mkdir(parents=True, exist_ok=True)
    for name in given.only.split(","):
        run, plot, size = EXPERIMENTS[name]
        file = given.out / f"{name}.csv"
        if not given.plots_only:
            rows = []
            for scan in given.scans.split(","):
                print(f"{name}: {scan}", file=sys.stderr)
                rows += run(scan, given.data / SCANS.get(scan, scan), counts)
                write_rows(file, rows)
        if not given.csv_only:
            draw(given.out / f"thesis_{name}.jpg", plot, size, read_rows(file))


if __name__ == "__main__":
    main()
