"""The likeness of a textured result to its scan, and its price.

    python -m bench.quality.texture SCAN PROXIES [--size N] [--views 8] [--up z] [--pictures FOLDER]

Orthographic views of 512 x 512 pixels (2 x 2 samples), drawn here from the colours alone: PSNR where both are seen,
SSIM where either is. Seam: mean colour difference (0 to 255) of the two sides of edges, 8 points an edge, by
length. Tilt: mean angle between the normals of scan and result in these views, of flat polygons and with the normal
map. Seconds are processor time.
"""

import argparse
import json
import time
from pathlib import Path

import numpy as np
from PIL import Image

import isimp_engine as engine
from isimp_engine.texturing.baking import FINER

PIXELS, OVER = 512, 2


def look_up(image, uv):
    """Bilinear, without repetition; uv (n, 2), v upward."""
    height, width = image.shape[:2]
    x, y = uv[:, 0] * width - 0.5, (1 - uv[:, 1]) * height - 0.5
    x0, y0 = np.floor(x).astype(int), np.floor(y).astype(int)
    a, b = (x - x0)[:, None], (y - y0)[:, None]

    def at(i, j):
        return image[np.clip(j, 0, height - 1), np.clip(i, 0, width - 1), :3].astype(np.float64)

    top = at(x0, y0) * (1 - a) + at(x0 + 1, y0) * a
    return top * (1 - b) + (at(x0, y0 + 1) * (1 - a) + at(x0 + 1, y0 + 1) * a) * b


def cameras(count, up):
    """Right, above and toward the eye of each view: a ring of two heights."""
    up = np.eye(3)[up]
    side = np.roll(up, 1)
    other = np.cross(up, side)
    for k in range(count):
        tilt, turn = np.radians((15, 40)[k % 2]), 2 * np.pi * k / count
        eye = np.cos(tilt) * (np.cos(turn) * side + np.sin(turn) * other) + np.sin(tilt) * up
        right = np.cross(up, eye)
        right /= np.linalg.norm(right)
        yield right, np.cross(eye, right), eye


def seen(corners, camera, box):
    """For each pixel the triangle seen along a camera's axis, -1 for none, and the weights of its corners 1 and 2."""
    n = PIXELS * OVER
    size = np.linalg.norm(box[1] - box[0]) * 0.8
    p = (corners - (box[0] + box[1]) / 2) / size
    x, y, z = (p @ camera[0] + 0.5) * n, (0.5 - p @ camera[1]) * n, p @ camera[2]
    face, depth = np.full((n, n), -1), np.full((n, n), -np.inf)
    place = np.zeros((n, n, 2))
    e1x, e1y, e2x, e2y = x[:, 1] - x[:, 0], y[:, 1] - y[:, 0], x[:, 2] - x[:, 0], y[:, 2] - y[:, 0]
    area = e1x * e2y - e1y * e2x
    low = np.clip(np.floor([x.min(1), y.min(1)]), 0, n).astype(int)
    high = np.clip(np.ceil([x.max(1), y.max(1)]), 0, n).astype(int)
    for t in np.flatnonzero((area < -1e-12) & (high > low).all(0)):  # y points down, so front faces have it negative
        i, j = np.arange(low[0, t], high[0, t]), np.arange(low[1, t], high[1, t])
        dx, dy = i + 0.5 - x[t, 0], (j + 0.5 - y[t, 0])[:, None]
        b, c = (dx * e2y[t] - dy * e2x[t]) / area[t], (e1x[t] * dy - e1y[t] * dx) / area[t]
        d = z[t, 0] + b * (z[t, 1] - z[t, 0]) + c * (z[t, 2] - z[t, 0])
        part = np.s_[low[1, t] : high[1, t], low[0, t] : high[0, t]]
        inside = (b >= -1e-6) & (c >= -1e-6) & (b + c <= 1 + 1e-6) & (d > depth[part])
        depth[part][inside], face[part][inside] = d[inside], t
        place[part][inside] = np.stack([b[inside], c[inside]], axis=1)
    return face, place


def at_corners(values, face, place):
    """(n, k): values (F, 3, k) of corners at the places of faces."""
    b, c = place.T[:, :, None]
    return values[face, 0] * (1 - b - c) + values[face, 1] * b + values[face, 2] * c


def view(corners, uv, image_of, images, camera, box):
    """(n, n, 3) colours and (n, n) mask of triangles (F, 3, 3), seen along a camera's axis."""
    face, place = seen(corners, camera, box)
    mask = face >= 0
    f, at = face[mask], at_corners(uv, face[mask], place[mask])
    colours = np.zeros((len(f), 3))
    for m, image in enumerate(images):
        colours[image_of[f] == m] = look_up(image, at[image_of[f] == m])
    full = np.zeros((*mask.shape, 3))
    full[mask] = colours
    return reduced(full), reduced(mask[:, :, None].astype(float))[:, :, 0]


def unit(vectors):
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12)


def vertex_normals(soup):
    """(F, 3, 3): of each corner the mean normal of the faces at its place, by area."""
    corners = soup.vertices[soup.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sums = np.zeros_like(soup.vertices)
    for k in range(3):
        np.add.at(sums, soup.triangles[:, k], normal)
    return unit(sums)[soup.triangles]


def texel_polygons(mesh, part, poly, made, options):
    """The polygon of each texel, -1 in gutters. The layout is made again: with the same density it is the same."""
    density = FINER * made.report["source_texels_per_unit"]
    atlas = engine._core._unwrap(poly, options, density)
    assert (atlas.side, atlas.chart_count) == (made.report["size"], made.report["charts"])
    return engine._core._bake_map(mesh, part, poly, atlas, options)[0]


def tilts(soup, mesh, part, poly, made, options, triangles, cameras, box):
    """Mean angle between the scan's normals and the result's, of flat polygons and with the map. Degrees."""
    polygon = texel_polygons(mesh, part, poly, made, options)
    frame = np.stack(
        [made.polygon_tangent, np.cross(made.polygon_normal, made.polygon_tangent), made.polygon_normal], axis=1
    )
    inside = polygon >= 0
    bent = np.zeros((*polygon.shape, 3))  # in space; nothing in gutters, which then do not count
    local = made.normal[inside] / 127.5 - 1
    bent[inside] = np.einsum("nk,nkd->nd", local, frame[polygon[inside]])
    corners, of_scan = poly.vertices[poly.loops], vertex_normals(soup)
    of_corner = np.repeat(np.arange(len(poly.loop_start)), np.diff(np.append(poly.loop_start, len(poly.loops))))
    found = []
    for camera in cameras:
        face, place = seen(soup.vertices[soup.triangles], camera, box)
        other, at = seen(corners[triangles], camera, box)
        both = (face >= 0) & (other >= 0)
        wanted = unit(at_corners(of_scan, face[both], place[both]))
        flat = made.polygon_normal[of_corner[triangles[other[both], 0]]]
        mapped = unit(look_up(bent, at_corners(made.uv[triangles], other[both], at[both])))
        found.append([np.degrees(np.arccos(np.clip((wanted * n).sum(1), -1, 1))).mean() for n in (flat, mapped)])
    return np.mean(found, axis=0)


def reduced(image):
    return image.reshape(PIXELS, OVER, PIXELS, OVER, -1).mean((1, 3))


def blurred(image, width=7):
    """The mean of width x width pixels."""
    padded = np.pad(image, width // 2, mode="reflect")
    sums = np.pad(padded.cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    return (sums[width:, width:] - sums[:-width, width:] - sums[width:, :-width] + sums[:-width, :-width]) / width**2


def likeness(one, other):
    """PSNR and SSIM of two views with their masks."""
    (a, in_a), (b, in_b) = one, other
    both, either = (in_a > 0.99) & (in_b > 0.99), (in_a > 0.5) | (in_b > 0.5)
    psnr = 10 * np.log10(255**2 / max(((a - b)[both] ** 2).mean(), 1e-9))
    x, y = a.mean(2) + (1 - in_a) * 128, b.mean(2) + (1 - in_b) * 128
    mx, my = blurred(x), blurred(y)
    vx, vy, cov = blurred(x * x) - mx * mx, blurred(y * y) - my * my, blurred(x * y) - mx * my
    c1, c2 = (0.01 * 255) ** 2, (0.03 * 255) ** 2
    ssim = (2 * mx * my + c1) * (2 * cov + c2) / ((mx * mx + my * my + c1) * (vx + vy + c2))
    return psnr, ssim[either].mean()


def seam(poly, made):
    """Mean colour difference of the two sides of the edges of two polygons."""
    ends = np.append(poly.loop_start, len(poly.loops))
    after = np.arange(1, len(poly.loops) + 1)
    after[ends[1:] - 1] = poly.loop_start
    edges = {}
    total = length = 0.0
    for i, j in enumerate(after):
        a, b = int(poly.loops[i]), int(poly.loops[j])
        if (b, a) not in edges:
            edges[a, b] = (i, j)
            continue
        k, m = edges.pop((b, a))
        t = ((np.arange(8) + 0.5) / 8)[:, None]
        here = look_up(made.image, made.uv[i] * (1 - t) + made.uv[j] * t)
        there = look_up(made.image, made.uv[m] * (1 - t) + made.uv[k] * t)
        size = np.linalg.norm(poly.vertices[a] - poly.vertices[b])
        total += size * np.abs(here - there).mean()
        length += size
    return total / max(length, 1e-300)


def views_of_scan(soup, cameras, boxes):
    seen = soup.vertices[soup.triangles], soup.uv % (1 + 1e-9), soup.material, soup.images
    return [view(*seen, *each) for each in zip(cameras, boxes, strict=True)]


def views_of_result(poly, made, cameras, boxes):
    corners, each = poly.vertices[poly.loops], np.arange(len(poly.loops), dtype=np.int32)
    triangles, _ = engine.regions.triangulate(corners, each, poly.loop_start)
    seen = corners[triangles], made.uv[triangles], np.zeros(len(triangles), dtype=int), [made.image]
    return [view(*seen, *each) for each in zip(cameras, boxes, strict=True)], triangles


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scan", type=Path)
    parser.add_argument("proxies", type=int)
    parser.add_argument("--size", type=int)
    parser.add_argument("--views", type=int, default=8)
    parser.add_argument("--up", choices="xyz", default="z")
    parser.add_argument("--band", type=int, default=engine.TextureOptions().band)
    parser.add_argument("--pictures", type=Path, help="a folder for scan and result side by side")
    asked = parser.parse_args()
    soup = engine.read_textured(asked.scan)
    mesh = engine.clean(soup.vertices, soup.triangles)
    part = engine.partition(mesh, engine.PartitionOptions(proxies=asked.proxies))
    poly = engine.polygonize(mesh, part)
    start = time.process_time()
    options = engine.TextureOptions(size=asked.size, band=asked.band, threads=1)
    made = engine.texture(mesh, part, poly, soup, options)
    figures = {"scan": asked.scan.name, "polygons": len(poly.loop_start), "seconds": time.process_time() - start}
    box = np.stack([soup.vertices[np.unique(soup.triangles)].min(0), soup.vertices[np.unique(soup.triangles)].max(0)])
    views, found = list(cameras(asked.views, "xyz".index(asked.up))), []
    results, triangles = views_of_result(poly, made, views, [box] * len(views))
    for k, (before, after) in enumerate(zip(views_of_scan(soup, views, [box] * len(views)), results, strict=True)):
        found.append(likeness(before, after))
        if asked.pictures:
            pair = np.hstack([c + (1 - m[:, :, None]) * 255 for c, m in (before, after)])
            Image.fromarray(np.clip(pair, 0, 255).astype(np.uint8)).save(asked.pictures / f"{asked.scan.stem}_{k}.png")
    psnr, ssim = np.mean(found, axis=0)
    figures |= {"psnr": psnr, "ssim": ssim, "seam": seam(poly, made)}
    figures["tilt_flat"], figures["tilt_map"] = tilts(soup, mesh, part, poly, made, options, triangles, views, box)
    figures |= made.report
    print(json.dumps({key: round(v, 4) if isinstance(v, float) else v for key, v in figures.items()}))


if __name__ == "__main__":
    main()
