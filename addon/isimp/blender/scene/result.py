"""Creates and fills the result object of Mesh, places it, and detects edits of it by the user."""

import hashlib
import json

import bpy
import numpy as np
from mathutils import Matrix

from ...language import own
from . import mesh_io, targets

_PLACE = ("location", "rotation_euler", "rotation_quaternion", "rotation_axis_angle", "scale")
_KINDS = {"FLOAT": np.float32, "INT": np.int32, "BOOLEAN": bool}
COPIED = own("copied")
MADE_OF = "isimp_of"  #: on a material of the add-on: the name of the scan's material that it replaces
_DELTA = ("delta_location", "delta_rotation_euler", "delta_rotation_quaternion", "delta_scale")


def digest(obj) -> str:
    """Return a hash of the data that a user can edit in a result's mesh, weights and materials.

    Cost: linear in its size, which is small.
    """
    with mesh_io.whole(obj) as mesh:
        return _digest(obj, mesh)


def _digest(obj, mesh) -> str:
    found = hashlib.blake2b(digest_size=16)
    keys = mesh.shape_keys.key_blocks if mesh.shape_keys is not None else ()
    for items, name in (
        (mesh.vertices, "co"),
        (mesh.edges, "vertices"),
        (mesh.edges, "use_seam"),
        (mesh.edges, "use_edge_sharp"),
        (mesh.loops, "vertex_index"),
        (mesh.polygons, "loop_total"),
        (mesh.polygons, "material_index"),
        (mesh.polygons, "use_smooth"),
        *((layer.data, "uv") for layer in mesh.uv_layers),
        *((key.data, "co") for key in keys),
    ):
        found.update(_values(items, name).tobytes() + b"|")
    known = {mesh_io.COLOR, "position", "sharp_face", *mesh.uv_layers.keys()}  # hashed above, or the add-on's
    layers = [layer for layer in mesh.attributes if layer.name[0] != "." and layer.name not in known]
    more = [(layer.name, _values(layer.data, "value", "vector", "color")) for layer in layers]
    more += [
        (name, _values(items, name)) for items in (mesh.vertices, mesh.edges) for name in ("crease", "bevel_weight")
    ]
    for name, values in more:
        if values.any():  # Blender adds and removes layers of zeros
            found.update(name.encode() + values.tobytes())
    if mesh.shape_keys is not None and mesh.shape_keys.animation_data is not None:
        found.update(b"animated")
    named = (obj.vertex_groups, mesh.uv_layers, mesh.color_attributes, keys)
    names = [[item.name for item in items if item.name != mesh_io.COLOR] for items in named]
    slotted = [slot.material for slot in obj.material_slots]
    materials = [None if material is None else material.get(MADE_OF, material.name) for material in slotted]
    every = mesh.vertices if len(obj.vertex_groups) else ()
    weights = [[(entry.group, entry.weight) for entry in vertex.groups] for vertex in every]
    state = names, materials, weights, mesh.shape_keys is not None, mesh.has_custom_normals
    found.update(repr(state).encode())
    return found.hexdigest()


def _values(items, *names) -> np.ndarray:
    """Return the first of these properties that the items have, as an array; empty if they have none."""
    properties = items[0].bl_rna.properties if len(items) else ()
    name = next((name for name in names if name in properties), None)
    if name is None:
        return np.empty(0)
    if properties[name].type == "STRING":
        return np.frombuffer(repr([getattr(item, name) for item in items]).encode(), np.uint8)
    values = np.empty(max(1, properties[name].array_length) * len(items), _KINDS[properties[name].type])
    items.foreach_get(name, values)
    return values


def is_edited(obj) -> bool:
    """Return whether a result differs from the output of Mesh, or its digest is unknown."""
    return obj.isimp.made != digest(obj)


def why_kept(obj) -> str:
    """Return why Mesh must not overwrite a result; empty if it may."""
    named = obj.isimp.named  # empty in files of earlier versions
    if is_edited(obj):
        return own("edited by hand")
    if obj.data.users - obj.data.use_fake_user > 1:
        return COPIED
    if obj.asset_data is not None or obj.data.asset_data is not None:
        return own("marked as an asset")
    if named in ("", obj.name):
        return ""
    return COPIED if targets.is_copy(obj) else own("renamed")


def why_kept_here(context, scan) -> str:
    """Return `why_kept` of the active object if it is a result. A result in Edit Mode counts as edited."""
    active = context.view_layer.objects.active
    if active is None or active == scan:
        return ""
    return own("edited by hand") if active.mode == "EDIT" else why_kept(active)


def sign(obj) -> None:
    """Stores digest and name of a result that Mesh has just made."""
    obj.isimp.made, obj.isimp.named = digest(obj), obj.name


def to_fill(context, scan) -> tuple:
    """Return (the object to fill with polygons, [(result to keep, reason)]). Kept results are marked."""
    result, kept = None, []
    for made in targets.results_of(context.scene, scan):
        why = why_kept(made) if result is None else COPIED
        if why:
            kept.append((made, why))
            made.isimp.made = targets.KEPT
        else:
            result = made
    return result or _new(scan, context), kept


def _new(scan, context):
    name = targets.named(scan.name, ".simplified")
    result = bpy.data.objects.new(name, bpy.data.meshes.new(name))
    for collection in scan.users_collection or (context.scene.collection,):
        collection.objects.link(result)
    return result


def fill(result, scan, outcome) -> np.ndarray:
    """Replaces the result's polygons and places it at the scan, with the scan's parent and transform if possible.

    Vertices of a scan far from its own origin are relative to the outcome's origin, and the result's location has the
    offset. Blender rounds a location to float32; the rounding error is added to the vertices.
    Returns the (3, 3) matrix that maps directions (n, 3) in the scan's mesh to the result's mesh.
    """
    polygons = outcome.polygons
    loops, start = np.array(polygons.loops), np.array(polygons.loop_start)
    unshaped = np.linalg.inv(mesh_io.shape_matrix(scan))
    vertices, shift = (np.asarray(polygons.vertices) - outcome.origin) @ unshaped, outcome.origin @ unshaped
    moved, own_parent = _moved(result), _parent_of_user(result)
    vertices, loops, turn = place_at(result, scan, vertices, shift, loops, start)
    result.isimp.parent = _parent_name(result)
    result.isimp.placed = json.dumps([list(row) for row in result.matrix_basis])
    if moved is not None:
        result.matrix_basis = moved @ result.matrix_basis
    for name, value in own_parent.items():
        setattr(result, name, value)
    defective = np.zeros(len(start), np.int32)
    for found in outcome.numbers["flaws"].values():
        defective[found] = 1
    layers = {mesh_io.REGION: np.asarray(polygons.polygon_region), mesh_io.DEFECT: defective}
    if result.data.shape_keys is not None:  # Blender would keep the keys of the removed vertices
        result.shape_key_clear()
    mesh_io.fill_polygons(result.data, vertices, loops, start, layers)
    return turn


def corner_order(result, outcome):
    """Return the corner of the outcome's polygons for each corner of the result; None if the polygons differ."""
    wanted, start = np.array(outcome.polygons.loops), np.array(outcome.polygons.loop_start)
    loops = np.empty(len(result.data.loops), np.int32)
    result.data.loops.foreach_get("vertex_index", loops)
    each = np.arange(len(wanted))
    for order in (each, turned(each, start)):
        if np.array_equal(wanted[order], loops):
            return order
    return None


def take_materials(result, scan, outcome) -> None:
    """Sets the material of each polygon to the most frequent one of its region's faces."""
    materials = [slot.material for slot in scan.material_slots]
    if not any(materials):
        return
    of_face = np.empty(len(scan.data.polygons), np.int32)
    scan.data.polygons.foreach_get("material_index", of_face)
    inside, count = outcome.face_region >= 0, len(materials)
    keys = outcome.face_region[inside].astype(np.int64) * count + np.clip(of_face[inside], 0, count - 1)
    votes = np.bincount(keys, minlength=count * len(outcome.region_color)).reshape(-1, count)
    result.data.materials.clear()
    for material in materials:
        result.data.materials.append(material)
    chosen = votes.argmax(axis=1).astype(np.int32)[np.asarray(outcome.polygons.polygon_region)]
    result.data.polygons.foreach_set("material_index", chosen)
    result.data.update()


def _moved(result):
    """Return the matrix by which the user has moved a result; None if it was not moved."""
    try:
        placed = Matrix(json.loads(result.isimp.placed))
    except (ValueError, TypeError):  # not stored, or written by another version
        return None
    if placed == result.matrix_basis or abs(placed.determinant()) < 1e-30:
        return None
    return result.matrix_basis @ placed.inverted()


def _parent_of_user(result) -> dict:
    """Return the properties of a parent that a result has got, or lost, since Mesh; empty if it has the same one."""
    if _parent_name(result) == result.isimp.parent:
        return {}
    kept = {name: getattr(result, name) for name in ("parent", "parent_type", "parent_bone")}
    return kept | {"matrix_parent_inverse": result.matrix_parent_inverse.copy()}


def _parent_name(obj) -> str:
    return "" if obj.parent is None else obj.parent.name


def place_at(result, scan, vertices, shift, loops, start) -> tuple:
    """Places an object at another one, with its parent and transform if these determine the place.

    vertices, shift: in the space of the scan's mesh; the vertices are relative to the shift. Returns (vertices, loops,
    turn): the vertices to use with that place, the loops, turned where it mirrors, and `turn` as `fill` returns it.
    """
    # Blender multiplies a parent's transform in float32: far from zero, only a result without one is exact.
    if _is_told_by_transform(scan) and not (scan.parent is not None and shift.any()):
        return vertices + _place_alike(result, scan, shift), loops, np.eye(3)
    return _place_in_world(result, scan, vertices, shift, loops, start)


def _is_told_by_transform(scan) -> bool:
    """Return whether parent and transform alone determine the scan's place: no constraint, no bone as parent."""
    matrix = scan.matrix_basis
    if scan.parent is not None:
        if scan.parent_type != "OBJECT":
            return False
        matrix = scan.parent.matrix_world @ scan.matrix_parent_inverse @ matrix
    place = np.array(scan.matrix_world)
    return np.allclose(np.array(matrix), place, rtol=1e-6, atol=1e-6 * np.abs(place[:3, :3]).max())


def _place_alike(result, scan, shift) -> np.ndarray:
    """Copies the scan's parent and transform to the result, moved by `shift`. Returns the location's rounding error.

    Shift and error are in the space of the scan's mesh.
    """
    result.parent, result.matrix_parent_inverse = scan.parent, scan.matrix_parent_inverse
    result.rotation_mode = scan.rotation_mode
    for name in (*_PLACE, *_DELTA):
        setattr(result, name, getattr(scan, name))
    if not shift.any():
        return np.zeros(3)
    matrix = np.array(scan.matrix_basis, np.float64)[:3, :3]
    wanted = np.array(scan.location, np.float64) + matrix @ shift
    result.location = wanted
    return np.linalg.solve(matrix, wanted - np.array(result.location, np.float64))


def _place_in_world(result, scan, vertices, shift, loops, start):
    """Places the result at the scan in the world. Returns (vertices, loops, turn), in world axes for a sheared scan."""
    place = np.array(scan.matrix_world, np.float64)
    matrix = place[:3, :3].copy()
    place[:3, 3] += matrix @ shift
    turn = np.eye(3)
    unsheared = np.array(Matrix.LocRotScale(*scan.matrix_world.decompose()), np.float64)[:3, :3]
    if not np.allclose(unsheared, matrix, rtol=0, atol=1e-5 * np.abs(matrix).max()):
        place[:3, :3] = np.eye(3)
        vertices, turn = vertices @ matrix.T, matrix.T
        if np.linalg.det(matrix) < 0:
            loops = turned(loops, start)
    result.parent = None
    result.matrix_world = Matrix(place.tolist())
    rounded = place[:3, 3] - place[:3, 3].astype(np.float32)
    return vertices + np.linalg.solve(place[:3, :3], rounded), loops, turn


def turned(loops: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Return the loops with the direction of each polygon reversed."""
    totals = np.diff(start, append=len(loops))
    within = np.arange(len(loops)) - np.repeat(start, totals)
    return loops[np.repeat(start + totals - 1, totals) - within]
