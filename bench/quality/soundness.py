"""Makes polygons of real meshes and judges each by the promises of docs/guarantee.md.

    python -m bench.quality.soundness [--data DIR] [--only bunny,castle] [--proxies 50,300,1000] [--json OUT.json]

`isimp_engine` must be importable. Without --only it takes all of scan, building and nasty, one mesh at a time. A line a
run, then the bars. Times are of the processor.
"""

import json
import sys
import time

import numpy as np

import isimp_engine as engine
from bench.files import scan_command, scans
from tests.shared.polygon_judge import distances, judge

COUNTS = (50, 300, 1000)
SAMPLES = 3000
CAD = ("fandisk",)  # with flat sides
# Mean distance from the scan at 300 regions, % of the diagonal, of the first prototype: to be no worse.
DISTANCE = {
    "bunny": 0.20, "armadillo_86k": 0.31, "rockerarm": 0.15, "fandisk": 0.02, "castle": 0.18, "mech_holes": 0.18,
    "thingi_58011": 0.05, "thingi_99865": 0.34, "ogre": 0.32, "bones": 0.25, "dragon": 0.32,
}  # fmt: skip
HEAD = "polygons   /P corners  planarity mean   max  distance  extra  cross empty flip bent  far  hits excused  seconds"


def named(table, mesh):
    return next((value for key, value in table.items() if key in mesh), None)


def run(name, mesh, proxies):
    """One mesh at one number of regions: figures, and defects."""
    options = engine.MeshingOptions()
    part = engine.partition(mesh, engine.PartitionOptions(proxies=min(proxies, len(mesh.triangles))))
    started = time.process_time()
    poly = engine.polygonize(mesh, part, options)
    seconds = time.process_time() - started
    bounded = part.region_count >= options.flatness_from
    v, scan = judge(poly, mesh, part, options.flatness if bounded else 0, options.reach, outlined=True)
    said = poly.report
    extra = sum(said[f"split_for_{why}"] for why in ("unconnected", "holes", "handles", "pinches", "closed"))
    q = len(poly.loop_start)
    far = distances(scan.samples(SAMPLES), np.asarray(poly.vertices), v.facets) if v.facets is not None else [0]
    share = 100 / scan.diagonal
    return {
        "mesh": name, "proxies": proxies, "regions": part.region_count, "needed": part.proxies_needed,
        "components": mesh.report["components"], "polygons": q, "extra": extra, "corners": len(poly.loops) / q,
        "planarity_mean": share * float((v.bend * v.area).sum() / v.area.sum()),
        "planarity_max": share * float(v.bend.max()), "distance": share * float(np.mean(far)), "seconds": seconds,
        "defects": v.defects, "sound": v.sound, "capped": said["repair_capped"],
        "counts": {key: len(getattr(v, key))
                   for key in ("crossing", "empty", "flipped", "bent", "far", "hits", "excused")},
        "said": {key: said[key] for key in ("crossing", "flipped", "bent", "intersecting", "excused")},
    }  # fmt: skip


def line(r):
    c = r["counts"]
    return (
        f"{r['mesh'][:24]:24} {r['proxies']:5} {r['polygons']:8} {r['polygons'] / r['regions']:5.2f}"
        f" {r['corners']:6.2f}"
        f" {r['planarity_mean']:14.3f} {r['planarity_max']:6.2f} {r['distance']:8.3f} {r['extra']:6}"
        f" {c['crossing']:6} {c['empty']:5} {c['flipped']:4} {c['bent']:4} {c['far']:4} {c['hits']:5} {c['excused']:7}"
        f" {r['seconds']:8.2f} {'sound' if r['sound'] else 'NOT SOUND'}{' capped' if r['capped'] else ''}"
        f" {'; '.join(r['defects'])}"
    )


def bars(results):
    """Lines of name, wanted and measured figure, and whether it is met."""
    single = [r for r in results if r["components"] == 1 and r["regions"] == r["proxies"]]
    clean = [r for r in results if not r["counts"]["excused"]]
    other = [r for r in results if r["counts"]["excused"]]
    at = {p: [r for r in single if r["proxies"] == p] for p in COUNTS}

    def worst(rows, value, most):
        bad = sorted((r for r in rows if value(r) > most(r)), key=value, reverse=True)
        return ", ".join(f"{r['mesh']} {r['proxies']}: {value(r):.3g}" for r in bad) or "none"

    def every(what, wanted, rows, value, most):
        met = sum(value(r) <= most(r) for r in rows)
        return what, wanted, f"{met} of {len(rows)}; over: {worst(rows, value, most)}", met == len(rows)

    lines = [
        every("sound, none of the scan's own pairs met", "all", clean, lambda r: not r["sound"], lambda _: 0),
        every("sound but for excused pairs", "all", other, lambda r: not r["sound"], lambda _: 0),
        every("polygons at most 2 P + need", "all", results, lambda r: r["polygons"],
              lambda r: 2 * max(r["proxies"], r["needed"]) + r["extra"]),
        every("corners a polygon, P 300", "<= 6.0", at[300], lambda r: r["corners"], lambda _: 6.0),
    ]  # fmt: skip
    for p, most in ((1000, 1.02), (300, 1.12), (50, 1.4)):
        lines.append(every(f"polygons / P at {p}, one component", f"<= {most}", at[p],
                           lambda r: r["polygons"] / r["regions"], lambda _, most=most: most))  # fmt: skip
    lines.append(every("planarity mean, P 300, % of the diagonal", "scans <= .12, CAD <= .01", at[300],
                       lambda r: r["planarity_mean"],
                       lambda r: 0.01 if any(c in r["mesh"] for c in CAD) else 0.12))  # fmt: skip
    known = [r for r in results if r["proxies"] == 300 and named(DISTANCE, r["mesh"])]
    lines.append(every("scan to result mean, P 300", "no worse", known, lambda r: r["distance"],
                       lambda r: named(DISTANCE, r["mesh"]) + 0.005))  # fmt: skip
    return lines


def main():
    options = scan_command(__doc__, COUNTS).parse_args()
    paths = scans(options)
    results = []
    print(f"{'mesh':24} {'P':>5} {HEAD}")
    for path in paths:
        mesh = engine.clean(*engine.read(path))
        for proxies in map(int, options.proxies.split(",")):
            results.append(run(path.stem, mesh, proxies))
            print(line(results[-1]), flush=True)
    table = bars(results)
    for what, bar, measured, met in table:
        print(f"{'yes' if met else 'NO':3} {what}: {bar}: {measured}")
    if options.json:
        options.json.write_text(json.dumps(results, indent=1))
    sys.exit(not all(r["sound"] for r in results))


if __name__ == "__main__":
    main()
