"""Layouts compared with xatlas: how much of the image polygons fill, and the time.

    PYTHONPATH=build-dev/python python -m bench.peers.atlas_peer MESH PROXIES [--size 2048] [--gutter 4]

Python has xatlas (PyPI). Both pack the same charts, first one for each polygon, then the unfolded ones. xatlas chooses
width and height itself, at our scale; its fill is that of this image. Seconds are processor time; ours are for
flattening, unfolding and packing, xatlas's for packing alone.
"""

import argparse
import itertools
import json
import time
from pathlib import Path

import numpy as np
import xatlas

import isimp_engine as engine


def polygon_areas(uv, starts):
    ends = np.append(starts, len(uv))
    areas = []
    for a, b in itertools.pairwise(ends):
        x, y = uv[a:b].T
        areas.append(abs((np.roll(x, 1) * y - x * np.roll(y, 1)).sum()) / 2)
    return np.array(areas)


def packed(uv, triangles, area, gutter):
    """Width, height and fill of xatlas's layout of charts in texels."""
    atlas = xatlas.Atlas()
    atlas.add_uv_mesh(uv.astype(np.float32), triangles.astype(np.uint32))
    options = xatlas.PackOptions()
    options.padding, options.resolution, options.texels_per_unit = gutter, 0, 1.0
    options.rotate_charts_to_axis = False
    atlas.generate(pack_options=options)
    return atlas.width, atlas.height, area / (atlas.width * atlas.height)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh", type=Path)
    parser.add_argument("proxies", type=int)
    parser.add_argument("--size", type=int, default=2048)
    parser.add_argument("--gutter", type=int, default=4)
    asked = parser.parse_args()
    mesh = engine.clean(*engine.read(asked.mesh))
    part = engine.partition(mesh, engine.PartitionOptions(proxies=asked.proxies))
    poly = engine.polygonize(mesh, part)
    for unfold in (0.0, engine.TextureOptions().unfold):
        options = engine.TextureOptions(size=asked.size, gutter=asked.gutter, unfold=unfold)
        start = time.process_time()
        atlas = engine._core._unwrap(poly, options, 1.0)
        own = time.process_time() - start
        uv = engine._core._uv(poly, atlas) * asked.size
        triangles, _ = engine.regions.triangulate(
            np.column_stack([uv, np.zeros(len(uv))]), np.arange(len(uv), dtype=np.int32), poly.loop_start
        )
        if unfold:  # corners of one chart that coincide are one vertex, so that xatlas keeps it whole
            chart = np.repeat(atlas.chart, np.diff(np.append(poly.loop_start, len(uv))))
            keys = np.column_stack([np.round(uv, 3), chart])
            _, first, same = np.unique(keys, axis=0, return_index=True, return_inverse=True)
            triangles, shown = same.ravel()[triangles], uv[first]
        else:
            shown = uv
        start = time.process_time()
        width, height, fill = packed(shown, triangles, polygon_areas(uv, poly.loop_start).sum(), asked.gutter)
        peer = time.process_time() - start
        row = {"mesh": asked.mesh.name, "polygons": len(poly.loop_start), "charts": atlas.chart_count}
        row |= {"fill": round(atlas.fill, 3), "seconds": round(own, 3)}
        row |= {"xatlas": f"{width}x{height}", "xatlas_fill": round(fill, 3), "xatlas_seconds": round(peer, 3)}
        print(json.dumps(row), flush=True)


if __name__ == "__main__":
    main()
