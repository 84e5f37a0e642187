"""Small scans for the tests, and ways to check their results."""

import bpy
import numpy as np

from isimp.engine import engine


def cube(name="Scan", cells=6, quads=False):
    """A cube of side 2, each side cells x cells squares: quads, or two triangles each. Sides in order, all welded."""
    lines = np.linspace(-1, 1, cells + 1)
    vertices, faces, index = [], [], {}
    for axis in range(3):
        for side in (-1, 1):
            for i in range(cells):
                for j in range(cells):
                    corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
                    places = [np.roll((side, lines[a], lines[b]), axis) for a, b in corners[::side]]
                    quad = [index.setdefault(tuple(place.round(6)), len(index)) for place in places]
                    faces += [quad] if quads else [quad[:3], [quad[0], quad[2], quad[3]]]
    vertices = list(index)
    return add(name, vertices, faces)


def pierced(places=((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, 0, 1)), radius=2.0):
    """A rough sphere with small holes in these directions."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=5, radius=radius)
    scan = bpy.context.object
    scan.name = "Scan"
    points = coordinates(scan.data)
    points += np.random.default_rng(1).normal(0, 0.005 * radius, points.shape)
    scan.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    mode("EDIT")
    centers = np.array([polygon.center for polygon in scan.data.polygons])
    near = np.linalg.norm(centers[:, None] - radius * np.array(places), axis=2).min(axis=1) < 0.05 * radius
    select_faces(scan, *np.flatnonzero(near))
    bpy.ops.mesh.delete(type="FACE")
    mode("OBJECT")
    return scan


def tube():
    """A square plate with a square hole: a flat region that is no disc."""
    points = [(x, y, 0) for y in range(7) for x in range(7)]
    faces = []
    for y in range(6):
        for x in range(6):
            if not (2 <= x < 4 and 2 <= y < 4):
                a = 7 * y + x
                faces += [(a, a + 1, a + 8), (a, a + 8, a + 7)]
    return add("Scan", points, faces)


def column(around=48, along=24):
    """A standing cylinder of radius 1 and height 4: rows of quads, then the cap below and the one above."""
    angle, high = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.linspace(-2, 2, along + 1))
    side = np.stack([np.cos(angle), np.sin(angle), high], axis=2).reshape(-1, 3)
    k, m = (grid.ravel() for grid in np.meshgrid(np.arange(around), np.arange(along) * around))
    a, b = m + k, m + (k + 1) % around
    quads = np.stack([a, b, b + around, a + around], axis=1).tolist()
    caps = [range(around - 1, -1, -1), range(along * around, (along + 1) * around)]
    return add("Scan", side, [*quads, *caps])


def material_of(name, image):
    """A material whose colour is an image."""
    material = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    nodes = material.node_tree.nodes
    node = nodes.new("ShaderNodeTexImage")
    node.image = image
    shader = next(n for n in nodes if n.type == "BSDF_PRINCIPLED")
    material.node_tree.links.new(node.outputs["Color"], shader.inputs["Base Color"])
    return material


def add(name, vertices, faces):
    """An object with the given faces, linked, active and selected."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(map(float, v)) for v in vertices], [], [tuple(map(int, f)) for f in faces])
    assert not mesh.validate()
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    activate(obj)
    return obj


def hang(obj, **place):
    """Hangs an object on an empty one with these settings, and returns that."""
    obj.parent = bpy.data.objects.new("Parent", None)
    bpy.context.scene.collection.objects.link(obj.parent)
    for name, value in place.items():
        setattr(obj.parent, name, value)
    return obj.parent


def activate(obj):
    for other in bpy.context.selected_objects:
        other.select_set(False)
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj


def dimple(obj, depth=0.2):
    """Rounds a cube towards a sphere, so that its sides are no planes any more."""
    points = coordinates(obj.data)
    points += depth * (points / np.linalg.norm(points, axis=1, keepdims=True) * 1.2 - points)
    obj.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    obj.data.update()
    return obj


def push(message="step"):
    bpy.ops.ed.undo_push(message=message)


def coordinates(mesh):
    points = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", points)
    return points.reshape(-1, 3).astype(float)


def world(obj):
    matrix = np.array(obj.matrix_world, np.float64)
    return coordinates(obj.data) @ matrix[:3, :3].T + matrix[:3, 3]


def geometry(mesh):
    """All data of a scan that must never change."""
    loops = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", loops)
    starts = np.empty(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("loop_start", starts)
    return coordinates(mesh).tobytes(), loops.tobytes(), starts.tobytes(), len(mesh.edges)


def regions(obj):
    if obj.mode == "EDIT":
        obj.update_from_editmode()
        import bmesh

        edit = bmesh.from_edit_mesh(obj.data)
        layer = edit.faces.layers.int["isimp_region"]
        return np.array([face[layer] for face in edit.faces])
    label = np.empty(len(obj.data.polygons), np.int32)
    obj.data.attributes["isimp_region"].data.foreach_get("value", label)
    return label


def colors(obj):
    """(faces, 4) colour of each face's first corner, after checking that the others have the same."""
    layer = obj.data.attributes["isimp_color"]
    assert (layer.data_type, layer.domain) == ("FLOAT_COLOR", "CORNER")
    color = np.empty(4 * len(obj.data.loops), np.float32)
    layer.data.foreach_get("color", color)
    color = color.reshape(-1, 4)
    starts, totals = (np.empty(len(obj.data.polygons), np.int32) for _ in range(2))
    obj.data.polygons.foreach_get("loop_start", starts)
    obj.data.polygons.foreach_get("loop_total", totals)
    assert (color == np.repeat(color[starts], totals, axis=0)).all()
    return color[starts]


def face_pairs(mesh):
    """(E, 2) faces that share an edge."""
    mesh.calc_loop_triangles()
    triangles, faces = np.empty(3 * len(mesh.loop_triangles), np.int32), np.empty(len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles)
    mesh.loop_triangles.foreach_get("polygon_index", faces)
    return faces[engine.guides.shared_edges(triangles.reshape(-1, 3))[0]]


def select_faces(obj, *faces):
    """Selects these faces and no others, in either mode."""
    if obj.mode == "EDIT":
        import bmesh

        edit = bmesh.from_edit_mesh(obj.data)
        for part in (edit.verts, edit.edges, edit.faces):
            for item in part:
                item.select = False
        edit.faces.ensure_lookup_table()
        for face in faces:
            edit.faces[face].select_set(True)
        bmesh.update_edit_mesh(obj.data)
        return
    chosen = np.zeros(len(obj.data.polygons), bool)
    chosen[list(faces)] = True
    obj.data.polygons.foreach_set("select", chosen)


def mode(name):
    bpy.ops.object.mode_set(mode=name)
