"""Makes the page docs/gallery.md with its pictures, and pictures of the stories, performance.md and buildings.md.

    blender -b --python-use-system-env --python-exit-code 1 --python scripts/gallery.py -- FOLDER [NAME...]

`isimp_engine` must be on PYTHONPATH, the scans in $ISIMP_DATA or ../shared/data; FOLDER has the files of
examples/scans.py. NAME: parts of the names of pictures; without one, all are made and the page is written.
"""

import os
import sys
import time
from pathlib import Path

import bpy
import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "examples"), str(ROOT)]

import picture  # noqa: E402

import isimp_engine as engine  # noqa: E402
from bench.generators import houses, painted_scans, round_shapes, scanned  # noqa: E402

DATA = Path(os.environ.get("ISIMP_DATA", ROOT.parent / "shared" / "data"))
IMAGES = ROOT / "docs" / "images"
PAGE = ROOT / "docs" / "gallery.md"
PAPER, EDGE = np.array([0.86, 0.86, 0.84]), 0.0013  # radius of the lines, as a share of the diagonal
WIDE, HIGH, QUALITY = 620, 300, 82  # pixels and JPEG quality of a picture
COLORS = np.array([[0.55, 0.69, 0.86], [0.93, 0.71, 0.49], [0.62, 0.80, 0.58], [0.85, 0.62, 0.66], [0.73, 0.66, 0.84],
                   [0.90, 0.83, 0.56], [0.56, 0.79, 0.78], [0.78, 0.75, 0.72]])  # fmt: skip

STANFORD, YCB = "Stanford 3D Scanning Repository", "YCB objects, CC BY 4.0"
OURS = "made by `bench/generators`"


def file_of(name):
    return lambda: engine.read(DATA / name)


def made_house():
    made = houses.make(noise=0.0005)
    return made.vertices, made.triangles


def made_owl():
    made = painted_scans.star(painted_scans.owl_surface, painted_scans.owl_colour, 60_000, 16, 0.0015)
    return made.vertices, made.triangles


def made_column():
    vertices, triangles = round_shapes.made(round_shapes.shapes()["column"])
    return round_shapes.with_noise(vertices, 0.001, 3), triangles


# Name, the scan, upward axis, degrees around it, options of the command, the origin of the scan.
ROWS = (
    ("bunny", file_of("scan/bunny_69k.ply"), "Y", 0, {"proxies": 200}, STANFORD),
    ("armadillo", file_of("scan/armadillo_86k.ply"), "Y", 15, {"proxies": 400}, STANFORD),
    ("dragon", file_of("scan/dragon_871k.ply"), "Y", 0, {"proxies": 600}, STANFORD),
    ("brick", file_of("real/brick_16k.ply"), "Z", 30, {"planar": True}, YCB),
    ("can", file_of("real/meat_can_16k.ply"), "Z", 30, {"curved": True, "detail": 0.01}, YCB),
    ("tin", file_of("real/tin_16k.ply"), "Z", 30, {"curved": True, "detail": 0.01}, YCB),
    ("bottle", file_of("real/bottle_16k.ply"), "Z", 30, {"detail": 0.01}, YCB),
    ("office", file_of("real/office_27k.ply"), "Y", 180, {"proxies": 400}, "plane-opt-rgbd, MIT"),
    ("house", made_house, "Z", 30, {"planar": True, "regularise": True}, OURS),
    ("site", lambda: scanned.make(2), "Z", 60, {"proxies": 120, "planar": True}, OURS),
    ("owl", made_owl, "Z", 110, {"triangles": 1500}, OURS),
    ("column", made_column, "Z", 30, {"curved": True}, OURS),
)

HEAD = """# Gallery

Twelve scans, each at the left, and its polygons at the right. `scripts/gallery.py` makes the pictures and this page
from the scans, with the shown options of `isimp simplify scan.ply model.obj`. Seconds are of the processor, for all
threads together, from the arrays of the scan to the polygons. Distances are of the scan's vertices from the polygons,
on average, in % of the diagonal.

"""
FOOT = """
The scans themselves are not part of iSimp. The three of the Stanford 3D Scanning Repository are courtesy of the
Stanford Computer Graphics Laboratory. The YCB objects (Calli and others 2015) and the office are meshes of their data
sets with fewer triangles.
"""


def view_of(points, up, turn):
    """The points around their middle, and the axes of the picture."""
    return np.asarray(points, float) - np.mean(points, axis=0), picture.look_from(up, turn)


def panel(name, points, loops, start, color, view, shift, edge):
    """A surface with a colour for each face, and its edges, as objects. edge: the radius of the lines; 0: none."""
    arrays = picture.arrays_of(points, loops, start)
    normal = np.repeat(picture.area_vectors(arrays), arrays["total"], axis=0)
    if not edge:
        normal = picture._vertex_normals(arrays)[arrays["corners"]]
    color = np.concatenate([np.broadcast_to(color, (len(start), 3)), np.ones((len(start), 1))], axis=1)
    parts = [picture.surface(name, arrays, color, normal, view, shift)]
    if edge:
        radius = edge * np.linalg.norm(np.ptp(points, axis=0))
        parts.append(picture.tubes(f"{name} edges", points, picture.edges_of(arrays), radius, shift))
    return parts


def render(name, panels, view, size=(WIDE, HIGH)):
    """Panels side by side. panels: (points, loops, start, color, edge)."""
    scene = bpy.data.scenes.new("Picture")
    shift, everything = np.zeros(3), []
    for number, (points, loops, start, color, edge) in enumerate(panels):
        if number:
            wide = max(np.ptp(before @ view[0]) for before in (panels[number - 1][0], points))
            shift = shift + 1.06 * wide * view[0]
        for part in panel(f"Panel {number}", points, loops, start, color, view, shift, edge):
            scene.collection.objects.link(part)
        everything.append(points[np.unique(loops)] + shift)
    picture.frame(scene, np.vstack(everything), view, *size)
    picture.set_up(scene, IMAGES / f"{name}.jpg", "JPEG")
    scene.render.image_settings.quality = QUALITY
    bpy.ops.render.render(write_still=True, scene=scene.name)
    bpy.data.scenes.remove(scene)


def triangles_of(points, triangles, color):
    return points, np.ravel(triangles), np.arange(0, np.size(triangles), 3), color, 0.0


def polygons_of(points, poly, color=None, edge=EDGE):
    """Polygons as a panel. color: of each, by default that of its region."""
    if color is None:
        color = 0.5 * COLORS[(np.asarray(poly.polygon_region) * 5) % len(COLORS)] + 0.5 * PAPER
    return points, poly.loops, poly.loop_start, color, edge


def render_pair(name, vertices, triangles, poly, up, turn, size=(WIDE, HIGH)):
    """A scan at the left, its polygons at the right."""
    points, view = view_of(vertices, up, turn)
    made = np.asarray(poly.vertices) - np.mean(vertices, axis=0)
    render(name, [triangles_of(points, triangles, PAPER), polygons_of(made, poly)], view, size)


def flags(options):
    return " ".join(f"--{name}" if value is True else f"--{name} {value}" for name, value in options.items())


def distance(result):
    """The mean distance of the scan's vertices from the polygons, in % of the diagonal."""
    from isimp_engine.within import scan_distances

    far = scan_distances(result.mesh, result.partition, result.polygons)
    return 100 * float(np.nanmean(far)) / result.mesh.report["diagonal"]


def gallery_row(name, read, up, turn, options, origin):
    vertices, triangles = read()
    started = time.process_time()
    result = engine.simplify((vertices, triangles), **options)
    seconds = time.process_time() - started
    poly = result.polygons
    render_pair(f"gallery-{name}", vertices, triangles, poly, up, turn)
    cells = (
        f"![The {name}: scan and polygons](images/gallery-{name}.jpg)",
        f"**{name}**, {origin}. {len(triangles):,} triangles",
        f"{len(poly.loop_start):,} polygons of {result.partition.region_count:,} regions",
        f"{distance(result):.2f}",
        f"{seconds:.1f}",
        f"`{flags(options) or 'none'}`",
    )
    return f"| {' | '.join(cells)} |"


def gallery(asked):
    heads = ("scan and polygons", "theirs", "ours", "distance", "seconds", "options")
    lines = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    for row in ROWS:
        if any(part in f"gallery-{row[0]}" for part in asked):
            lines.append(gallery_row(*row))
            print(lines[-1], flush=True)
    if asked == [""]:
        PAGE.write_text(HEAD + "\n".join(lines) + "\n" + FOOT, encoding="utf-8")


def mean_colors(soup):
    """The colour of the image in the middle of each triangle, (F, 3) from 0 to 1."""
    image = soup.images[0]
    u, v = soup.uv.mean(axis=1).T
    row = ((1 - v) * (image.shape[0] - 1)).round().astype(int).clip(0, image.shape[0] - 1)
    column = (u * (image.shape[1] - 1)).round().astype(int).clip(0, image.shape[1] - 1)
    return (image[row, column, :3] / 255.0) ** 1.1


def of_regions(color, result):
    """The mean colour of the faces of each polygon's region."""
    region = np.asarray(result.partition.face_region)
    there = region >= 0
    count = result.partition.region_count
    of_face = color[np.asarray(result.mesh.source_face)[there]]
    sums = [np.bincount(region[there], of_face[:, k], count) for k in range(3)]
    mean = np.stack(sums, axis=1) / np.bincount(region[there], minlength=count)[:, None]
    return mean[np.asarray(result.polygons.polygon_region)]


def story_games(folder):
    soup = engine.read_textured(folder / "statue.glb")
    color = mean_colors(soup)
    points, view = view_of(soup.vertices, "Y", 20)
    panels = [triangles_of(points, soup.triangles, color)]
    for proxies in (430, 150, 50):
        result = engine.simplify((soup.vertices, soup.triangles), proxies=proxies)
        made = np.asarray(result.polygons.vertices) - soup.vertices.mean(axis=0)
        panels.append(polygons_of(made, result.polygons, of_regions(color, result)))
    render("games", panels, view, (1000, 380))


def story_colliders(folder):
    vertices, triangles = engine.read(folder / "crate.glb")
    result = engine.simplify((vertices, triangles), planar=True, keep_openings=True)
    points, view = view_of(vertices, "Y", 30)
    made = np.asarray(result.polygons.vertices) - vertices.mean(axis=0)
    loops, corners, color = [], [], []
    for number, part in enumerate(engine.convex_parts(result)):
        away = part.vertices.mean(axis=0) - vertices.mean(axis=0)
        loops.append(part.triangles + sum(map(len, corners)))
        corners.append(part.vertices - vertices.mean(axis=0) + 0.35 * away)
        color.append(np.tile(COLORS[number], (len(part.triangles), 1)))
    parts = np.concatenate(corners), np.concatenate(loops).ravel()
    apart = (*parts, np.arange(0, len(parts[1]), 3), np.concatenate(color), EDGE)
    render("games-colliders", [triangles_of(points, triangles, PAPER), polygons_of(made, result.polygons), apart], view)


def story_surveys(folder):
    vertices, triangles = engine.read(folder / "house.ply")
    result = engine.simplify((vertices, triangles), planar=True, regularise=True)
    render_pair("surveys", vertices, triangles, result.polygons, "Z", 30, (900, 380))


def story_parts(folder):
    vertices, triangles = engine.read(folder / "plate.stl")
    result = engine.simplify((vertices, triangles), curved=True)
    render_pair("parts", vertices, triangles, result.polygons, "Z", 30, (900, 300))


# Pictures of docs/performance.md: polygons without and with the remedies for their shape. Scan, upward axis, degrees.
SHAPES = {
    "shape-bunny": ("scan/bunny_69k.ply", "Y", 0),
    "shape-armadillo": ("scan/armadillo_86k.ply", "Y", 15),
    "shape-lion": ("nasty/lionstatue_63k_misoriented.ply", "Y", -60),
    "shape-castle": ("building/openmvs_castle_175k.ply", "Z", 45),
    "shape-dragon": ("scan/dragon_871k.ply", "Y", 0),
}


def shape(name, file, up, turn):
    mesh = engine.openings.closed_for(engine.clean(*engine.read(DATA / file)), 300)
    middle, panels = np.mean(mesh.vertices, axis=0), []
    for partition, meshing in (({"smooth": 0.0}, {"join_junctions": 0.0}), ({}, {})):
        part = engine.partition(mesh, engine.PartitionOptions(proxies=300, **partition))
        poly = engine.polygonize(mesh, part, engine.MeshingOptions(**meshing))
        panels.append(polygons_of(np.asarray(poly.vertices) - middle, poly, PAPER, 0.0011))
    render(name, panels, picture.look_from(up, turn), (1400, 760))


def direction_colors(regular):
    """A colour for each region by the direction of its plane, opposite ones alike; grey where that is level."""
    normal = np.asarray(regular.region_normal)
    hue = np.arctan2(normal[:, 1], normal[:, 0]) % np.pi / np.pi
    wheel = 0.5 + 0.5 * np.cos(2 * np.pi * (hue[:, None] - np.array([0.0, 1 / 3, 2 / 3])))
    share = np.linalg.norm(normal[:, :2], axis=1)[:, None]
    return share * (0.35 + 0.55 * wheel) + (1 - share) * 0.8


def street(name):
    """The picture of docs/buildings.md: a scanned street of ten houses and its exactly planar polygons, from above."""
    made = houses.street()
    mesh = engine.Mesh(made.vertices, made.triangles)
    regular = engine.regularise(mesh, engine.partition(mesh, engine.PartitionOptions(detail=0.0005)))
    poly = engine.polygonize(mesh, regular, engine.MeshingOptions(planar=True, planar_reach=0.001))
    right, _, toward = picture.look_from("Z", 24)
    level = np.cross(right, [0.0, 0.0, 1.0])
    level *= np.sign(level @ toward) / np.linalg.norm(level)
    toward = np.cos(np.radians(34)) * level + np.sin(np.radians(34)) * np.array([0.0, 0.0, 1.0])
    middle = np.mean(mesh.vertices, axis=0)
    points, corners = np.asarray(mesh.vertices) - middle, np.ravel(mesh.triangles)
    color = direction_colors(regular)[np.asarray(poly.polygon_region)]
    panels = [(points, corners, np.arange(0, len(corners), 3), PAPER, 0.0),
              polygons_of(np.asarray(poly.vertices) - middle, poly, color, 0.00025)]  # fmt: skip
    render(name, panels, np.array([right, np.cross(toward, right), toward]), (1500, 800))


def main():
    folder, *asked = sys.argv[sys.argv.index("--") + 1 :]
    asked = asked or [""]
    stories = {"games": story_games, "games-colliders": story_colliders, "surveys": story_surveys, "parts": story_parts}
    for name, draw in stories.items():
        if any(part in name for part in asked):
            draw(Path(folder))
    for name, row in SHAPES.items():
        if any(part in name for part in asked):
            shape(name, *row)
    if any(part in "buildings-street" for part in asked):
        street("buildings-street")
    gallery(asked)


main()
