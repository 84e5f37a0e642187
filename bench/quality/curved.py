"""Measures round parts (`PartitionOptions.curved`) on known shapes, compared with the partition without them.

    python -m bench.quality.curved [--only column,vase] [--noise 0,0.001,0.003] [--seeds 1,2,3] [--json OUT.json]
    python -m bench.quality.curved --scans FOLDER [--only scan/bunny_69k.ply]

`isimp_engine` must be importable. A row is the mean of the seeds. Both columns of a pair come from the same run.

  found right  share of the truly curved area that is in curved patches; share of their area that is truly curved
  axis radius  error of the best patch for each true part: degrees; %
  polygons     with round parts, and without: the quotient
  mean p99     distance of the scan's vertices from the polygons: the quotient
  quads        share of the cells with four corners, or three at a tip, where six cells of the part meet
  spread       standard deviation over mean of the areas of the cells, full cylinders and cones only
  whole        share of the cells' polygons that are whole under `planar`
  kept         share of the cells whose plane was kept
  defects      crossing, flipped, intersecting polygons and open or non-manifold edges more than without
  time         of the processor: partition and polygons with round parts over those without
"""

import argparse
import json
import time
from pathlib import Path

import numpy as np

import isimp_engine as engine
from bench.generators.round_shapes import extruded, made, part_of_faces, shapes, with_noise
from bench.quality.shape import newell
from isimp_engine.within import scan_distances

COLUMNS = (
    *("found", "right", "axis", "radius", "polygons", "more", "mean", "p99", "quads", "spread", "whole", "kept"),
    *("defects", "time"),
)
LEAST_AT_TIP = 6  # cells of a part at one corner


def defects(report):
    some = sum(report[k] for k in ("crossing", "flipped", "intersecting"))
    return some + (not report["manifold"])


def timed(vertices, faces, **options):
    """Partition and polygons of a fresh mesh, so that nothing is kept from before."""
    fresh = engine.clean(vertices, faces)
    begin = time.process_time()
    part = engine.partition(fresh, engine.PartitionOptions(threads=1, **options))
    poly = engine.polygonize(fresh, part)
    return fresh, part, poly, time.process_time() - begin


def axis_error(patch, truth):
    cosine = abs(np.dot(patch["axis"], truth) / np.linalg.norm(truth))
    return np.degrees(np.arccos(min(1.0, cosine)))


def against_truth(shape, part, truth, mesh_area):
    """Share found, share right, errors of axes and radii."""
    patch = np.full(part.region_count, -1)
    for k, p in enumerate(part.curved):
        patch[np.asarray(p["regions"])] = k
    of_face = np.where(part.face_region >= 0, patch[part.face_region], -1)
    is_round, is_found = truth >= 0, of_face >= 0
    row = {"found": mesh_area[is_round & is_found].sum() / max(mesh_area[is_round].sum(), 1e-300)}
    row["right"] = mesh_area[is_round & is_found].sum() / mesh_area[is_found].sum() if is_found.any() else 1.0
    axes, radii = [], []
    for k, round_part in enumerate(shape.parts):
        share = np.bincount(of_face[(truth == k) & is_found], mesh_area[(truth == k) & is_found], len(part.curved))
        if len(share) == 0 or share.max() <= 0:
            continue
        p = part.curved[int(share.argmax())]
        if round_part.radius and p["kind"] == round_part.kind and round_part.kind in ("cylinder", "sphere"):
            radii.append(abs(p["radius"] - round_part.radius) / round_part.radius * 100)
        if round_part.axis is not None and p["kind"] != "sphere":
            axes.append(axis_error(p, round_part.axis))
    row["axis"], row["radius"] = np.mean(axes or [np.nan]), np.mean(radii or [np.nan])
    return row


def of_cells(mesh, part, poly, plain_poly):
    """Measures of the polygons of the cells."""
    patch = np.full(part.region_count, -1)
    for k, p in enumerate(part.curved):
        patch[np.asarray(p["regions"])] = k
    is_cell = patch[poly.polygon_region] >= 0
    if not is_cell.any():
        return {"quads": np.nan, "spread": np.nan, "whole": np.nan, "kept": np.nan}
    corners = np.diff(np.append(np.asarray(poly.loop_start), len(poly.loops)))
    at_tip = np.zeros(len(corners), bool)
    owner, loops = np.repeat(np.arange(len(corners)), corners), np.asarray(poly.loops)
    for k in range(len(part.curved)):
        is_of = patch[poly.polygon_region][owner] == k
        meeting = np.bincount(loops[is_of], minlength=len(poly.vertices))
        at_tip[owner[is_of & (meeting[loops] >= LEAST_AT_TIP)]] = True
    start = np.append(np.asarray(poly.loop_start), len(poly.loops))
    area, spreads = np.linalg.norm(newell(np.asarray(poly.vertices)[loops], start), axis=1), []
    for k, p in enumerate(part.curved):
        mine = area[patch[poly.polygon_region] == k]
        if p["full"] and p["kind"] in ("cylinder", "cone") and len(mine):
            spreads.append(mine.std() / mine.mean())
    planar = engine.polygonize(mesh, part, engine.MeshingOptions(planar=True))
    pieces = np.bincount(planar.polygon_region, minlength=part.region_count)[patch >= 0]
    let_go = np.asarray(poly.planes_let_go, int)
    return {
        "quads": (corners[is_cell] == np.where(at_tip[is_cell], 3, 4)).mean(),
        "spread": np.mean(spreads or [np.nan]),
        "whole": (pieces == 1).mean(),
        "kept": 1 - (patch[let_go] >= 0).sum() / (patch >= 0).sum(),
    }


def row_of(vertices, faces, shape=None, clean_vertices=None, **options):
    plain_mesh, plain, plain_poly, plain_time = timed(vertices, faces, **options)
    mesh, part, poly, seconds = timed(vertices, faces, curved=True, **options)
    corners = np.asarray(mesh.vertices)[np.asarray(mesh.triangles)]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    row = {"patches": [p["kind"] for p in part.curved], "time": seconds / plain_time}
    row["polygons"] = len(poly.loop_start)
    row["more"] = len(poly.loop_start) / len(plain_poly.loop_start)
    far, plain_far = scan_distances(mesh, part, poly), scan_distances(plain_mesh, plain, plain_poly)
    far, plain_far = far[np.isfinite(far)], plain_far[np.isfinite(plain_far)]
    row["mean"], row["p99"] = far.mean() / plain_far.mean(), np.quantile(far, 0.99) / np.quantile(plain_far, 0.99)
    row["max"] = far.max() / plain_far.max()
    row["defects"] = defects(poly.report) - defects(plain_poly.report)
    row["same"] = np.array_equal(part.face_region, plain.face_region)
    row.update(of_cells(mesh, part, poly, plain_poly))
    if shape is not None:
        truth = part_of_faces(shape, clean_vertices, faces)[np.asarray(mesh.source_face)]
        row.update(against_truth(shape, part, truth, area))
    return row, (mesh, part, poly, plain, plain_poly)


def line(name, row):
    def text(column):
        value = row.get(column, np.nan)
        return f"{value:8.3f}" if isinstance(value, float) else f"{value:8d}"

    return f"{name:22s}" + "".join(text(c) for c in COLUMNS)


def mean_of(rows):
    out = {}
    for column in COLUMNS:
        values = np.array([r.get(column, np.nan) for r in rows], float)
        values = values[np.isfinite(values)]
        ratio = column in ("more", "mean", "p99", "time")
        out[column] = float(
            np.exp(np.log(values).mean()) if ratio and len(values) else np.mean(values) if len(values) else np.nan
        )
    return out


def run_shapes(names, noises, seeds):
    all_rows = {}
    known = shapes() | extruded()
    for noise in noises:
        print(f"{'noise ' + format(noise * 100, '.2g') + ' %':22s}" + "".join(f"{c:>8s}" for c in COLUMNS), flush=True)
        means = []
        for name in names or known:
            clean_vertices, faces = made(known[name])
            rows = []
            for seed in seeds if noise else seeds[:1]:
                vertices = with_noise(clean_vertices, noise, seed)
                rows.append(row_of(vertices, faces, known[name], clean_vertices)[0])
            all_rows[f"{name} {noise}"] = rows
            means.append(mean_of(rows))
            print(line(name, means[-1]), " ".join(sorted(rows[0]["patches"])), flush=True)
        print(line("all", mean_of(means)), flush=True)
    return all_rows


def run_scans(folder, names):
    all_rows = {}
    print(f"{'scan':22s}" + "".join(f"{c:>8s}" for c in COLUMNS), flush=True)
    for path in sorted(folder.glob("*/*.ply")):
        name = f"{path.parent.name}/{path.name}"
        if names and name not in names:
            continue
        row, _ = row_of(*engine.read(str(path)))
        all_rows[name] = row
        print(line(path.stem[:22], row), "same" if row["same"] else " ".join(row["patches"]), flush=True)
    return all_rows


def shape_arguments(description, noise):
    """A parser with the arguments of a run over generated shapes; noise: the default."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="names with commas between")
    parser.add_argument("--noise", default=noise)
    parser.add_argument("--seeds", default="1,2,3")
    parser.add_argument("--json", type=Path)
    return parser


def main():
    parser = shape_arguments(__doc__, "0,0.001,0.003")
    parser.add_argument("--scans", type=Path)
    given = parser.parse_args()
    names = [n for n in given.only.split(",") if n]
    if given.scans:
        rows = run_scans(given.scans, names)
    else:
        rows = run_shapes(names, [float(n) for n in given.noise.split(",")], [int(s) for s in given.seeds.split(",")])
    if given.json:
        given.json.write_text(json.dumps(rows, indent=1, default=str))


if __name__ == "__main__":
    main()
