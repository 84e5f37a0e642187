"""A picture of a scan's regions in colours next to the polygons made of them, by Workbench."""

import bpy
import numpy as np
from mathutils import Matrix

WIDTH, HEIGHT = 1800, 960
LINE = (0.012, 0.014, 0.018, 1.0)
PAPER = (1.0, 1.0, 1.0)
GAP = 0.10  # between the two, and around them, as a share of the height
SIDES = 6  # sides of the thin tubes that stand for lines
BORDER, EDGE = 0.0009, 0.0016  # radii of lines between regions and of polygons' edges, as a share of the diagonal


def render(scan, result, path, up="Z", turn=30.0):
    """Writes the picture. up: the axis of Blender's space that points upwards; turn: degrees around it."""
    view = look_from(up, turn)
    left, right = _arrays(scan), _arrays(result)
    middle = left["points"].mean(axis=0)  # far from zero float32 is too coarse for a picture
    for arrays in (left, right):
        arrays["points"] -= middle
    size = np.linalg.norm(np.ptp(left["points"], axis=0))
    scene = bpy.data.scenes.new("Picture")
    across = left["points"] @ view[0]
    shift = (np.ptp(across) + GAP * np.ptp(left["points"] @ view[1])) * view[0]
    thin = np.clip((200 / len(right["start"])) ** 0.25, 0.4, 1.0)  # many polygons want thinner lines
    region_color = _region_colors(scan, left)
    normals = _vertex_normals(left)[left["corners"]], np.repeat(area_vectors(right), right["total"], axis=0)
    parts = [
        surface("Regions", left, region_color[left["region"]], normals[0], view, 0 * shift),
        tubes("Borders", left["points"], _borders(left), thin * BORDER * size, 0 * shift),
        surface("Polygons", right, _pale(region_color[right["region"]]), normals[1], view, shift),
        tubes("Edges", right["points"], right["edges"], thin * EDGE * size, shift),
    ]
    for part in parts:
        scene.collection.objects.link(part)
    frame(scene, np.vstack([left["points"], left["points"] + shift, right["points"] + shift]), view)
    set_up(scene, path)
    bpy.ops.render.render(write_still=True, scene=scene.name)
    for part in parts:
        bpy.data.meshes.remove(part.data)
    bpy.data.scenes.remove(scene)


def look_from(up, turn):
    """(3, 3) rows: to the right, upwards, towards the camera; seen from a little above. up: X, Y or Z."""
    upward = np.eye(3)["XYZ".index(up)]
    front = np.roll(upward, -2) if up != "Y" else np.array([0.0, 0.0, 1.0])
    front = -front if up == "Z" else front
    side = np.cross(upward, front)
    angle, height = np.radians(turn), np.radians(14.0)
    level = np.cos(angle) * front + np.sin(angle) * side
    toward = np.cos(height) * level + np.sin(height) * upward
    right = np.cross(upward, toward)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(toward, right), toward])


def _arrays(obj):
    """Points in the world, corners, faces and edges of an object's own mesh, and its regions."""
    mesh, matrix = obj.data, np.array(obj.matrix_world, np.float64)  # Blender 5 gives float32 otherwise
    points = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", points)
    arrays = {"points": points.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]}
    for name, source, key, width in (
        ("corners", mesh.loops, "vertex_index", 1),
        ("corner_edge", mesh.loops, "edge_index", 1),
        ("start", mesh.polygons, "loop_start", 1),
        ("total", mesh.polygons, "loop_total", 1),
        ("edges", mesh.edges, "vertices", 2),
        ("region", mesh.attributes["isimp_region"].data, "value", 1),
    ):
        values = np.empty(width * len(source), np.int32)
        source.foreach_get(key, values)
        arrays[name] = values.reshape(-1, width) if width > 1 else values
    return arrays


def _region_colors(scan, arrays):
    """(R + 1, 4) the colour of each region, as the scan shows it; the last is that of faces without region."""
    color = np.empty(4 * len(arrays["corners"]), np.float32)
    scan.data.attributes["isimp_color"].data.foreach_get("color", color)
    table = np.full((arrays["region"].max() + 2, 4), 0.5, np.float32)
    table[arrays["region"]] = color.reshape(-1, 4)[arrays["start"]]
    return table


def _pale(color):
    return np.concatenate([0.35 * color[:, :3] + 0.65 * np.array([0.80, 0.80, 0.78]), color[:, 3:]], axis=1)


def _borders(arrays):
    """(E, 2) vertices of the edges between regions, and of the scan's own border."""
    face_region = np.repeat(arrays["region"], arrays["total"])
    low = np.full(len(arrays["edges"]), np.iinfo(np.int32).max, np.int32)
    high = np.full(len(arrays["edges"]), -2, np.int32)
    np.minimum.at(low, arrays["corner_edge"], face_region)
    np.maximum.at(high, arrays["corner_edge"], face_region)
    uses = np.bincount(arrays["corner_edge"], minlength=len(low))
    return arrays["edges"][(low != high) | (uses == 1)]


def arrays_of(points, corners, start):
    """Polygons as the functions here take them: polygon q has the corners from start[q] on."""
    corners, start = np.asarray(corners), np.asarray(start)
    total = np.diff(np.append(start, len(corners)))
    return {"points": np.asarray(points, np.float64), "corners": corners, "start": start, "total": total}


def _next_corners(arrays):
    """(L,) for each corner the vertex of the next one of its polygon."""
    following = np.arange(1, len(arrays["corners"]) + 1)
    following[arrays["start"] + arrays["total"] - 1] = arrays["start"]
    return arrays["corners"][following]


def edges_of(arrays):
    """(E, 2) vertices of the polygons' edges, each once."""
    ends = np.stack([arrays["corners"], _next_corners(arrays)], axis=1)
    return np.unique(np.sort(ends, axis=1), axis=0)


def area_vectors(arrays):
    """(F, 3) area vectors."""
    place, following = arrays["points"][arrays["corners"]], arrays["points"][_next_corners(arrays)]
    return np.add.reduceat(np.cross(place, following), arrays["start"], axis=0)


def _vertex_normals(arrays):
    normals = np.zeros_like(arrays["points"])
    np.add.at(normals, arrays["corners"], np.repeat(area_vectors(arrays), arrays["total"], axis=0))
    return normals


def surface(name, arrays, face_color, corner_normal, view, shift):
    """A surface with its light painted on, soft from the upper left: colours stay bright, no side is black."""
    normal = corner_normal / np.maximum(np.linalg.norm(corner_normal, axis=1, keepdims=True), 1e-30)
    color = np.repeat(face_color, arrays["total"], axis=0)
    normal *= np.where(normal @ view[2] < 0, -1, 1)[:, None]  # the back of an open scan may be seen too
    light = np.array([-0.45, 0.65, 0.6]) @ view
    shade = 0.5 + 0.5 * normal @ (light / np.linalg.norm(light))
    color[:, :3] *= (0.22 + 0.98 * shade**1.3)[:, None]
    return _object(name, arrays["points"] + shift, arrays["corners"], arrays["start"], arrays["total"], color)


def tubes(name, points, edges, radius, shift):
    """Thin closed prisms along the edges."""
    a, b = points[edges[:, 0]] + shift, points[edges[:, 1]] + shift
    length = np.linalg.norm(b - a, axis=1)
    a, b, length = a[length > 0], b[length > 0], length[length > 0, None]  # the others have no direction
    along = (b - a) / length
    across = np.cross(along, np.where(np.abs(along[:, :1]) < 0.7, [[1.0, 0, 0]], [[0, 1.0, 0]]))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    other = np.cross(along, across)
    angle = 2 * np.pi * np.arange(SIDES) / SIDES
    ring = radius * (np.cos(angle)[:, None, None] * across + np.sin(angle)[:, None, None] * other)  # (SIDES, E, 3)
    over = 0.5 * radius * along  # lines meet without a notch
    vertices = np.concatenate([ring + a - over, ring + b + over]).transpose(1, 0, 2).reshape(-1, 3)
    k = np.arange(SIDES)
    sides = np.stack([k, (k + 1) % SIDES, (k + 1) % SIDES + SIDES, k + SIDES], axis=1)
    corners = (sides[None] + 2 * SIDES * np.arange(len(a))[:, None, None]).ravel()
    count = SIDES * len(a)
    color = np.tile(np.array(LINE, np.float32), (4 * count, 1))
    return _object(name, vertices, corners, 4 * np.arange(count), np.full(count, 4), color)


def _object(name, points, corners, start, total, corner_color):
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(points))
    mesh.loops.add(len(corners))
    mesh.polygons.add(len(start))
    mesh.vertices.foreach_set("co", points.astype(np.float32).ravel())
    mesh.loops.foreach_set("vertex_index", corners.astype(np.int32))
    mesh.polygons.foreach_set("loop_start", start.astype(np.int32))
    mesh.polygons.foreach_set("loop_total", total.astype(np.int32))
    mesh.polygons.foreach_set("use_smooth", np.zeros(len(start), bool))
    mesh.update(calc_edges=True)
    layer = mesh.attributes.new("color", "FLOAT_COLOR", "CORNER")
    layer.data.foreach_set("color", corner_color.astype(np.float32).ravel())
    mesh.color_attributes.active_color = mesh.color_attributes["color"]
    return bpy.data.objects.new(name, mesh)


def frame(scene, points, view, most_wide=WIDTH, most_high=HEIGHT):
    """An orthographic camera that just holds all points, and a picture of the shape they need."""
    flat = points @ view.T
    low, high = flat.min(axis=0), flat.max(axis=0)
    margin = GAP * (high[1] - low[1])
    width, height = (high - low)[:2] + 2 * margin
    place = view.T @ np.array([*(low + high)[:2] / 2, high[2] + (high - low).max()])
    camera = bpy.data.cameras.new("Picture")
    camera.type = "ORTHO"
    camera.ortho_scale = max(width, height)
    camera.clip_end = 10 * float((high - low).max())
    camera.clip_start = camera.clip_end * 1e-4
    holder = bpy.data.objects.new("Picture", camera)
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = view.T, place
    holder.matrix_world = Matrix(matrix.tolist())
    scene.collection.objects.link(holder)
    scene.camera = holder
    scale = min(most_wide / width, most_high / height)
    scene.render.resolution_x, scene.render.resolution_y = round(scale * width), round(scale * height)


def set_up(scene, path, file_format="PNG"):
    scene.render.engine = "BLENDER_WORKBENCH"
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = file_format
    scene.render.filepath = str(path)
    scene.view_settings.view_transform = "Standard"
    scene.display.render_aa = "16"
    scene.world = bpy.data.worlds.new("Picture")
    scene.world.color = PAPER
    shading = scene.display.shading
    shading.light, shading.color_type = "FLAT", "VERTEX"
