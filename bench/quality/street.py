"""Measures the shape of the windows and walls of a generated street.

    python -m bench.quality.street [--counts 1,3,10] [--noises 0.0005,0.001,0.002] [--json OUT.json]

The houses come from houses.py, so their planes are known; detail and reach are the same lengths for any number of
houses. A row each without and with `regularise` and exactly planar polygons.

Columns:
  windows   true rectangles of .5 to 6 square metres, and of them the ones that are one quad with all angles within 12
            degrees of 90
  reveals   the same of .1 to .5 square metres
  triangles windows and reveals that are one triangle
  regions, polygons
  mean, p99 distance of the scan's vertices from the polygons, % of the diagonal
  whole     share of the polygons that stayed one, with planar
  freed     snapped planes that polygons do not keep to
  dirs      directions of planes
  slanted   share of the length of edges inside upright walls of more than 20 square metres that is neither level nor
            upright within 4 degrees
  time      of the processor, relative to the plain polygons
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any

import numpy as np

import isimp_engine as engine
from bench.generators import houses
from bench.quality import shape
from isimp_engine.guides import shared_edges
from isimp_engine.within import scan_distances
from tests.shared.polygon_judge import groups

DETAIL, REACH = 0.049, 0.098  # metres
WINDOW, REVEAL, WALL = (0.5, 6.0), (0.1, 0.5), 20.0  # square metres
SQUARE, SLANT = 12.0, 4.0  # degrees
HEAD = "houses noise           windows  of  reveals  of  tri regions polygons   mean    p99  whole   freed dirs"


def face_areas(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


def true_faces(street: houses.House) -> np.ndarray:
    """By triangle: the number of the connected part of its true plane."""
    pairs, _ = shared_edges(street.triangles)
    same = street.label[pairs[:, 0]] == street.label[pairs[:, 1]]
    return np.unique(groups(len(street.triangles), pairs[same])[1], return_inverse=True)[1]


class Judge:
    """The known figures of a street, to judge results with."""

    def __init__(self, street: houses.House) -> None:
        self.street = street
        self.mesh = engine.Mesh(street.vertices, street.triangles)
        self.area = face_areas(street.clean, street.triangles)
        self.part = true_faces(street)
        self.size = np.bincount(self.part, self.area)

    def rectangles(self, label: np.ndarray, poly: engine.PolygonMesh) -> dict[str, tuple[int, int, int]]:
        """Windows and reveals: how many there are, how many came out as one quad, and as one triangle."""
        start = np.append(poly.loop_start, len(poly.loops)).astype(np.int64)
        points = np.asarray(poly.vertices)[poly.loops]
        angle = shape.in_plane(points, start, shape.newell(points, start))[1]
        square = np.logical_and.reduceat(np.abs(angle - 90) < SQUARE, start[:-1])
        corners = np.diff(start)
        polygons = np.bincount(poly.polygon_region, minlength=label.max() + 1)
        first = np.zeros(label.max() + 1, np.int64)
        first[poly.polygon_region] = np.arange(len(corners))
        size = np.bincount(label[label >= 0], self.area[label >= 0], label.max() + 1)
        order = np.argsort(self.part, kind="stable")
        faces = np.split(order, np.cumsum(np.bincount(self.part))[:-1])
        found = {}
        for kind, (least, most) in {"windows": WINDOW, "reveals": REVEAL}.items():
            wanted = np.flatnonzero((self.size > least) & (self.size <= most))
            quads = triangles = 0
            for part in wanted:
                shares = np.bincount(label[faces[part]] + 1, self.area[faces[part]])
                region = int(shares.argmax()) - 1
                if region < 0 or shares.max() < 0.6 * self.size[part] or size[region] > 1.7 * self.size[part]:
                    continue
                if polygons[region] != 1:
                    continue
                quads += bool(corners[first[region]] == 4 and square[first[region]])
                triangles += bool(corners[first[region]] == 3)
            found[kind] = (len(wanted), quads, triangles)
        return found

    def slanted(self, label: np.ndarray, normal: np.ndarray, poly: engine.PolygonMesh) -> tuple[float, float]:
        """Length of the edges inside large upright walls: slanted ones, and all."""
        size = np.bincount(label[label >= 0], self.area[label >= 0], len(normal))
        wall = (size > WALL) & (np.abs(normal[:, 2]) < 0.1)
        start = np.append(poly.loop_start, len(poly.loops)).astype(np.int64)
        loops = np.asarray(poly.loops)
        ends = np.stack([loops, loops[shape.following(start)]], axis=1)
        polygon = np.repeat(np.arange(len(start) - 1), np.diff(start))
        key = np.sort(ends, axis=1)
        order = np.lexsort((key[:, 1], key[:, 0]))
        twin = np.flatnonzero((key[order][1:] == key[order][:-1]).all(axis=1))
        a, b = (np.asarray(poly.polygon_region)[polygon[order[twin + k]]] for k in (0, 1))
        inside = (a == b) & wall[a]
        line = np.diff(np.asarray(poly.vertices)[key[order[twin[inside]]]], axis=1)[:, 0]
        length = np.linalg.norm(line, axis=1)
        rise = np.degrees(np.arcsin(np.clip(np.abs(line[:, 2]) / np.maximum(length, 1e-300), 0, 1)))
        return float(length[(rise > SLANT) & (rise < 90 - SLANT)].sum()), float(length.sum())

    def row(self, part: engine.Partition, snapped: engine.Partition, options: engine.MeshingOptions) -> dict[str, Any]:
        started = time.process_time()
        poly = engine.polygonize(self.mesh, snapped, options)
        seconds = time.process_time() - started
        label = np.asarray(part.face_region)
        found = self.rectangles(label, poly)
        slanted, inside = self.slanted(label, np.asarray(part.region_normal), poly)
        far = scan_distances(self.mesh, part, poly)
        far = 100 / self.mesh.report["diagonal"] * far[np.isfinite(far)]
        report = poly.report
        return {
            "windows": found["windows"][0], "window_quads": found["windows"][1],
            "reveals": found["reveals"][0], "reveal_quads": found["reveals"][1],
            "triangles": found["windows"][2] + found["reveals"][2],
            "regions": part.region_count, "polygons": len(poly.loop_start),
            "mean": float(far.mean()), "p99": float(np.quantile(far, 0.99)),
            "whole": report.get("whole", 1.0), "let_go": report["planes_let_go"],
            "directions": (snapped.report or {}).get("directions", 0),
            "slanted": slanted / max(inside, 1e-300), "inside": inside, "seconds": seconds,
            "defects": report["crossing"] + report["flipped"] + report["bent"] + report["intersecting"],
        }  # fmt: skip

    def rows(self) -> list[dict[str, Any]]:
        """Plain, and regularised and planar."""
        share = 1 / self.mesh.report["diagonal"]
        part = engine.partition(self.mesh, engine.PartitionOptions(detail=DETAIL * share))
        plain = self.row(part, part, engine.MeshingOptions())
        snapped = engine.regularise(self.mesh, part)
        planar = self.row(part, snapped, engine.MeshingOptions(planar=True, planar_reach=REACH * share))
        return [plain, planar]


def line(count: int, noise: float, kind: str, row: dict[str, Any], of: float) -> str:
    return (
        f"{count:6} {noise:6.2%} {kind:8} {row['window_quads']:7} {row['windows']:4} {row['reveal_quads']:7} "
        f"{row['reveals']:4} {row['triangles']:4} {row['regions']:7} {row['polygons']:8} {row['mean']:6.4f} "
        f"{row['p99']:6.3f} {row['whole']:6.3f} {row['let_go']:7} {row['directions']:4} {row['slanted']:7.2f} "
        f"{row['seconds'] / of:4.1f}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--counts", default="1,3,10")
    parser.add_argument("--noises", default="0.0005,0.001,0.002")
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    print(HEAD, "slanted time")
    results = []
    for count in map(int, arguments.counts.split(",")):
        for noise in map(float, arguments.noises.split(",")):
            rows = Judge(houses.street(count, noise)).rows()
            for kind, row in zip(("plain", "planar"), rows, strict=True):
                print(line(count, noise, kind, row, rows[0]["seconds"]), flush=True)
                results.append({"houses": count, "noise": noise, "kind": kind} | row)
    if arguments.json:
        arguments.json.write_text(json.dumps(results, indent=1))


if __name__ == "__main__":
    main()
