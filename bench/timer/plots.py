"""Draws time and error over the number of faces and of regions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from bench.timer.table import fact, per_round

STYLES = {"reference": ("REF, plain", "0.45"), "lloyd": ("lloyd", "#3b6fb6"), "default": ("default", "#c8553d")}


def draw(growth: dict[str, Any], folder: Path) -> None:
    """Two figures: growth_faces.svg and growth_regions.svg."""
    import matplotlib as mpl  # only plots need it

    mpl.use("svg")
    mpl.rcParams.update({"svg.hashsalt": "isimp", "font.size": 9, "axes.spines.top": False, "axes.spines.right": False})
    import matplotlib.pyplot as plt

    for kind, label in (("faces", "faces"), ("regions", "regions")):
        runs = [result for name, result in growth.items() if name.startswith(kind + "/")]
        figure, (times, errors) = plt.subplots(1, 2, figsize=(8, 3), layout="constrained")
        for case, (title, color) in STYLES.items():
            done = [run for run in runs if case in run["cases"]]
            x = [run["mesh"]["faces"] if kind == "faces" else run["proxies"] for run in done]
            least = [min(per_round(run, case)) for run in done]
            if kind == "faces":
                least = [1e3 * ms / n for ms, n in zip(least, x, strict=True)]
            times.loglog(x, least, "o-", color=color, label=title, markersize=3)
            errors.loglog(x, [fact(run, case, "error") for run in done], "o-", color=color, label=title, markersize=3)
        times.set(xlabel=label, ylabel="processor time, µs a face" if kind == "faces" else "processor time, ms")
        errors.set(xlabel=label, ylabel="D, share of the area")
        errors.legend(frameon=False, loc="lower left")  # the one corner without lines
        figure.savefig(folder / f"growth_{kind}.svg", metadata={"Date": None})
        plt.close(figure)
