"""Reads and writes Blender meshes: bulk arrays in Object Mode, BMesh layers in Edit Mode."""

from contextlib import contextmanager
from itertools import islice

import bmesh
import bpy
import numpy as np

from ... import float_loss, view
from ...language import own, said
from ...session import Scan
from . import runtime

REGION, COLOR = "isimp_region", "isimp_color"
DEFECT = "isimp_flaw"  # on the result's polygons: 1 for defective ones
STATE = ".isimp_state"  # id of the recipe that made the regions; see store.py
KINDS = {REGION: ("INT", "FACE"), STATE: ("INT", "FACE"), COLOR: ("FLOAT_COLOR", "CORNER")}
_ORIGIN = ".isimp_origin"
_PIECE = 5000  # faces: writing all of them takes about a hundredth of a second
_UNKNOWN = -2  # no region has this number


class Unusable(Exception):
    """The object can't be used. The message has the reason and a remedy."""


def shape_matrix(obj) -> np.ndarray:
    """Return (3, 3) the scale and shear of the object's transform, without rotation, mirroring and location.

    Regions, lengths and areas belong to the visible shape, and do not depend on its place. The result has the scan's
    transform, and so is mirrored with it.
    """
    matrix = np.array(obj.matrix_world, np.float64)[:3, :3]
    values, axes = np.linalg.eigh(matrix.T @ matrix)
    scale = np.sqrt(np.maximum(values, 0.0))
    if not np.isfinite(matrix).all() or scale.min() <= 1e-9 * scale.max():
        raise Unusable(
            said("'{name}' is scaled to nothing along an axis: give it a scale other than 0.", name=obj.name)
        )
    shape = axes @ np.diag(scale) @ axes.T
    digits = 10.0 ** (np.floor(np.log10(scale.max())) - 5)  # rounding error of the transform must not change the result
    return np.round(shape / digits) * digits


def has_shape(obj) -> bool:
    """Return whether `shape_matrix` of the object exists."""
    try:
        shape_matrix(obj)
    except Unusable:
        return False
    return True


def lost_detail(obj) -> float_loss.Loss | None:
    """Return the float32 loss of an object far from its own origin, lengths with its scale; None if negligible."""
    box = np.array(obj.bound_box, np.float64)
    scale = np.linalg.norm(np.array(obj.matrix_world, np.float64)[:3, :3], axis=0)
    return float_loss.loss(box.min(axis=0), box.max(axis=0), scale)


def place_matrix(obj) -> np.ndarray:
    """Return (4, 4) from the space of a `Scan` of the object to the world."""
    place = np.array(obj.matrix_world, np.float64)
    place[:3, :3] = place[:3, :3] @ np.linalg.inv(shape_matrix(obj))
    return place


def read(context, obj, is_updated: bool = False) -> Scan:
    """Return the visible object: evaluated, scaled, triangulated. Faces are of its own mesh. Raises Unusable.

    is_updated: whether the mesh has the changes of Edit Mode. The update takes half a second for a million faces.
    """
    shape = shape_matrix(obj)
    if is_edited(obj) and not is_updated:
        obj.update_from_editmode()
    face_count = len(obj.data.polygons)
    if not has_modifiers(obj):
        vertices, triangles, faces = _arrays(obj.data)
    else:
        vertices, triangles, faces = _evaluated_arrays(context, obj)
    if not np.array_equal(shape, np.eye(3)):
        vertices = vertices.astype(np.float64) @ shape
    return Scan(vertices, triangles, faces, face_count)


def has_modifiers(obj) -> bool:
    """Return whether modifiers or shape keys change the mesh of an object."""
    return obj.data.shape_keys is not None or any(modifier.show_viewport for modifier in obj.modifiers)


def points(mesh) -> np.ndarray:
    """Return (3 V,) float32 coordinates."""
    vertices = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", vertices)
    return vertices


def edge_lines(mesh) -> np.ndarray:
    """Return (2 E, 3) float32 the ends of all edges."""
    ends = np.empty(2 * len(mesh.edges), np.int32)
    mesh.edges.foreach_get("vertices", ends)
    return points(mesh).reshape(-1, 3)[ends]


def polygons(mesh) -> tuple[np.ndarray, np.ndarray]:
    """Return (L,) int32 the vertex of each corner, and (Q,) int32 the first corner of each polygon."""
    loops, start = np.empty(len(mesh.loops), np.int32), np.empty(len(mesh.polygons), np.int32)
    mesh.loops.foreach_get("vertex_index", loops)
    mesh.polygons.foreach_get("loop_start", start)
    return loops, start


def loop_triangles(mesh, what):
    """Return (3 T,) int32 "vertices" or "loops" of Blender's triangles, and (T,) the polygon of each triangle."""
    mesh.calc_loop_triangles()
    corners = np.empty(3 * len(mesh.loop_triangles), np.int32)
    faces = np.empty(len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get(what, corners)
    mesh.loop_triangles.foreach_get("polygon_index", faces)
    return corners, faces


def _arrays(mesh):
    vertices = points(mesh)
    if len(mesh.loops) == 3 * len(mesh.polygons):
        triangles = np.empty(len(mesh.loops), np.int32)
        corners = mesh.attributes.get(".corner_vert")  # 20 times as fast as loops; not in all versions
        if corners is not None:
            corners.data.foreach_get("value", triangles)
        else:
            mesh.loops.foreach_get("vertex_index", triangles)
        faces = np.arange(len(mesh.polygons), dtype=np.int32)
    else:
        triangles, faces = loop_triangles(mesh, "vertices")
    return vertices.reshape(-1, 3), triangles.reshape(-1, 3), faces


def _evaluated_arrays(context, obj):
    """Return `_arrays` of the mesh with its modifiers and shape keys, with faces of the mesh itself.

    An attribute on a copy traces the faces, so the scan does not change, and the mode does not matter.
    """
    copy = obj.copy()
    copy.data = obj.data.copy()
    try:
        copy.hide_viewport = False
        context.scene.collection.objects.link(copy)
        origin = copy.data.attributes.new(_ORIGIN, "INT", "FACE")
        origin.data.foreach_set("value", np.arange(len(copy.data.polygons), dtype=np.int32))
        depsgraph = context.evaluated_depsgraph_get()
        depsgraph.update()
        evaluated = copy.evaluated_get(depsgraph)
        mesh = evaluated.to_mesh()
        try:
            vertices, triangles, faces = _arrays(mesh)
            origin = mesh.attributes.get(_ORIGIN)
            if len(mesh.polygons) == 0:
                raise Unusable(said("The modifiers of '{name}' leave no faces.", name=obj.name))
            if origin is None or origin.domain != "FACE":
                names = ", ".join(modifier.name for modifier in obj.modifiers if modifier.show_viewport)
                text = own(
                    "The modifiers of '{name}' ({modifiers}) make faces that can't be traced back to its own: "
                    "apply them first (Object > Apply > Visual Geometry to Mesh)."
                )
                raise Unusable(said(text, name=obj.name, modifiers=names))
            traced = np.empty(len(mesh.polygons), np.int32)
            origin.data.foreach_get("value", traced)
        finally:
            evaluated.to_mesh_clear()
    finally:
        data = copy.data
        bpy.data.objects.remove(copy)
        bpy.data.meshes.remove(data)
    return vertices, triangles, traced[faces]


def edit_mesh(mesh):
    """Return the BMesh of a mesh in Edit Mode.

    A reference is kept, since Blender changes every element when Python frees a BMesh: 60 ms for a million faces.
    """
    edit = bmesh.from_edit_mesh(mesh)
    runtime.get().edit = edit
    return edit


def is_edited(obj) -> bool:
    """Return whether an object's mesh is in Edit Mode. While a file is opened, `mode` may be EDIT without a BMesh."""
    return obj.mode == "EDIT" and obj.data.is_editmode


@contextmanager
def whole(obj):
    """Yields the mesh of an object with all layers. In Edit Mode it is a copy, as the mesh itself has empty layers."""
    if not is_edited(obj):
        yield obj.data
        return
    obj.update_from_editmode()
    copy = obj.data.copy()
    try:
        yield copy
    finally:
        bpy.data.meshes.remove(copy)


def counts(obj) -> tuple[int, int]:
    """Return the numbers of vertices and faces of an object's mesh, in either mode."""
    if is_edited(obj):
        edit = edit_mesh(obj.data)
        return len(edit.verts), len(edit.faces)
    return len(obj.data.vertices), len(obj.data.polygons)


def is_own(layer) -> bool:
    """Return whether a layer has the name and the kind of a layer of the add-on."""
    return (layer.data_type, layer.domain) == KINDS.get(layer.name)


def own_layer(mesh, name: str):
    """Return a layer of the add-on; None if there is none of its name and kind."""
    layer = mesh.attributes.get(name)
    if layer is None or is_own(layer):
        return layer
    return next((other for other in mesh.attributes if other.name == name and is_own(other)), None)


def state_of(obj) -> int:
    """Return the state stored with the regions; 0 if there is none. Cost: O(1)."""
    if is_edited(obj):
        faces = edit_mesh(obj.data).faces
        layer = faces.layers.int.get(STATE)
        return next(iter(faces))[layer] if layer is not None and len(faces) else 0
    layer = own_layer(obj.data, STATE)
    return layer.data[0].value if layer is not None and len(layer.data) else 0


def read_regions(obj) -> np.ndarray:
    """Return (faces,) int32 regions as last written; all -1 without a layer of regions."""
    if is_edited(obj):
        return _read_edit_regions(obj)
    regions = np.full(len(obj.data.polygons), -1, np.int32)
    layer = own_layer(obj.data, REGION)
    if layer is not None:
        layer.data.foreach_get("value", regions)
    return _possible(regions)


def region_of(obj, face: int) -> int:
    """Return the region of one face in Object Mode, as last written; -1 if it has none."""
    layer = own_layer(obj.data, REGION)
    region = layer.data[face].value if layer is not None and face < len(layer.data) else -1
    return region if region < len(obj.data.polygons) else -1


def _possible(regions: np.ndarray) -> np.ndarray:
    """Return regions with impossible numbers replaced by -1. Large numbers would need huge arrays of counts."""
    regions[(regions < 0) | (regions >= len(regions))] = -1
    return regions


def _read_edit_regions(obj) -> np.ndarray:
    """Return `read_regions` of a mesh in Edit Mode. The result is cached until state or number of faces change."""
    seen, faces = runtime.get().seen, edit_mesh(obj.data).faces
    state, regions = seen.get(obj.name, (0, None))
    if state and state == state_of(obj) and len(regions) == len(faces):
        return regions.copy()
    layer = faces.layers.int.get(REGION)
    if layer is None:
        return np.full(len(faces), -1, np.int32)
    regions = _possible(np.fromiter((face[layer] for face in faces), np.int32, len(faces)))
    if not bpy.app.background:  # Blender reports no changes in the background
        runtime.get().seen = {obj.name: (state_of(obj), regions)}
    return regions.copy()


def corner_totals(mesh) -> np.ndarray | int:
    """Return the number of corners of each polygon; a single number if all are triangles."""
    if len(mesh.loops) == 3 * len(mesh.polygons):
        return 3
    totals = np.empty(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("loop_total", totals)
    return totals


def write_regions(
    obj, face_region: np.ndarray, face_color: np.ndarray, state: int, corner_color=None, tells: bool = True
) -> None:
    """Writes regions, their colours and their state on the mesh, and changes nothing else of it.

    face_color: (faces,) rows of view.COLORS. corner_color: colours of the corners, computed if None; the array is
    reused afterwards. `tells`: whether to report the change to Blender in Object Mode; see late.py.
    """
    if is_edited(obj):
        if not _is_written(obj, face_region, state):
            for _ in writing(obj, face_region, face_color, state):
                pass
    else:
        if corner_color is None:
            corner_color = view.corner_colors(view.COLORS, face_color, corner_totals(obj.data), runtime.get().pool)
        _write_layers(obj.data, face_region, corner_color, state)
        if tells:
            tell(obj.data)
    show_color(obj.data)


def write_state(obj, state: int) -> None:
    """Writes another state; the regions do not change."""
    if is_edited(obj):
        edit = edit_mesh(obj.data)
        stamp = edit.faces.layers.int.get(STATE) or edit.faces.layers.int.new(STATE)
        for face in edit.faces:
            face[stamp] = state
        bmesh.update_edit_mesh(obj.data, loop_triangles=False, destructive=False)
    else:
        count = len(obj.data.polygons)
        _layer(obj.data, STATE, "INT", "FACE").data.foreach_set("value", np.full(count, state, np.int32))
        tell(obj.data)


def clear_regions(obj) -> None:
    """Removes regions, their colours and their state from the mesh, and restores the active colour attribute."""
    if is_edited(obj):
        edit = edit_mesh(obj.data)
        for layers, name in (
            (edit.faces.layers.int, REGION),
            (edit.faces.layers.int, STATE),
            (edit.loops.layers.float_color, COLOR),
        ):
            if layers.get(name) is not None:
                layers.remove(layers[name])
        bmesh.update_edit_mesh(obj.data, loop_triangles=False, destructive=False)
    else:
        for name in (REGION, STATE, COLOR):
            layer = own_layer(obj.data, name)
            if layer is not None:
                obj.data.attributes.remove(layer)
        tell(obj.data)
    give_color_back(obj.data)


def _write_layers(mesh, face_region, corner_color, state) -> None:
    _write_ints(mesh, face_region, state)
    _layer(mesh, COLOR, "FLOAT_COLOR", "CORNER").data.foreach_set("color", corner_color.ravel())
    runtime.get().pool.give(corner_color)


def tell(mesh) -> None:
    """Reports to Blender that layers of a mesh have changed. The change is recorded as the add-on's own."""
    runtime.get().own_writes.add(mesh.name)
    mesh.update()


def _write_ints(mesh, face_region, state) -> None:
    _layer(mesh, REGION, "INT", "FACE").data.foreach_set("value", face_region.astype(np.int32, copy=False))
    _layer(mesh, STATE, "INT", "FACE").data.foreach_set("value", np.full(len(face_region), state, np.int32))


def _layer(mesh, name, kind, domain):
    layer = mesh.attributes.get(name)
    if layer is not None and (layer.data_type, layer.domain) != (kind, domain):
        mesh.attributes.remove(layer)
        layer = None
    return layer or mesh.attributes.new(name, kind, domain)


def _is_written(obj, face_region, state) -> bool:
    """Return whether these regions were the last ones written in Edit Mode and the state is unchanged since."""
    known, region, _ = runtime.get().written.get(obj.name, (0, None, None))
    return known == state == state_of(obj) and region is face_region


def writing(obj, face_region, face_color, state):
    """Does `write_regions` in Edit Mode face by face, since there is no bulk access. Yields the completed share.

    Only faces with another region or colour are written. Nothing else may change the mesh between two pieces.
    """
    edit = edit_mesh(obj.data)
    before, was, old_color = runtime.get().written.pop(obj.name, (0, None, None))
    fresh = 0
    for fresh in _make_edit_layers(edit):
        yield 0.01 * fresh
    if fresh or not before or before != state_of(obj) or len(was) != len(face_region):
        was, differs = np.full(len(face_region), _UNKNOWN), np.ones(len(face_region), bool)
    else:
        differs = (was != face_region) | (old_color != face_color)
    region, stamp = (edit.faces.layers.int[name] for name in (REGION, STATE))
    color, faces = edit.loops.layers.float_color[COLOR], iter(edit.faces)
    for begin in range(0, len(face_region), _PIECE):
        piece = slice(begin, begin + _PIECE)
        values = (each[piece].tolist() for each in (was, differs, face_region))
        values = (*values, view.COLORS[face_color[piece]].tolist())
        for face, seen, another, label, value in zip(islice(faces, _PIECE), *values, strict=True):
            face[stamp] = state
            if another or face[region] != seen:  # differs if faces were added or reordered
                _paint(face, region, label, color, value)
        yield min(1.0, piece.stop / len(face_region))
    runtime.get().written = {obj.name: (state, face_region, face_color)}
    runtime.get().seen = {}
    runtime.get().own_writes.add(obj.data.name)
    bmesh.update_edit_mesh(obj.data, loop_triangles=False, destructive=False)


def _paint(face, region, label, color, value) -> None:
    face[region] = label
    for corner in face.loops:
        corner[color] = value


def _make_edit_layers(edit):
    """Adds missing layers; yields their number after each. A new layer invalidates references to others."""
    made = 0
    for layers, names in ((edit.faces.layers.int, (REGION, STATE)), (edit.loops.layers.float_color, (COLOR,))):
        for name in names:
            if layers.get(name) is None:
                layers.new(name)
                made += 1
                yield made


def show_color(mesh) -> None:
    """Makes the regions' colours the active ones, and stores the former ones. Renders keep the user's colours."""
    colors = mesh.color_attributes
    active, ours, rendered = colors.active_color, colors.get(COLOR), _rendered(mesh)
    if ours is None:
        return
    if active is not None and active.name != COLOR:
        mesh.isimp.user_color = active.name
    if active != ours:  # each assignment makes Blender upload the mesh again
        colors.active_color = ours
    _render(mesh, rendered if rendered != COLOR else mesh.isimp.user_color)


def give_color_back(mesh) -> None:
    """Restores the colours that were active before the regions' colours."""
    name, rendered = mesh.isimp.user_color, _rendered(mesh)
    layer = mesh.color_attributes.get(name) if name else None
    if layer is not None:
        mesh.color_attributes.active_color = layer
        _render(mesh, rendered if rendered != COLOR else name)


def _rendered(mesh) -> str:
    """Return the name of the colours for renders and exporters; empty if there are none."""
    colors = mesh.color_attributes
    return colors[colors.render_color_index].name if 0 <= colors.render_color_index < len(colors) else ""


def _render(mesh, name: str) -> None:
    """Makes colours the ones for renders, if there are any of that name."""
    place = mesh.color_attributes.find(name) if name else -1
    if place >= 0 and _rendered(mesh) != name:
        mesh.color_attributes.render_color_index = place


def read_layer(mesh, name: str) -> np.ndarray:
    """Return (polygons,) int32 values of a face layer in Object Mode; zeros if there is none."""
    values, layer = np.zeros(len(mesh.polygons), np.int32), mesh.attributes.get(name)
    if layer is not None and (layer.data_type, layer.domain) == ("INT", "FACE"):
        layer.data.foreach_get("value", values)
    return values


def fill_polygons(
    mesh, vertices: np.ndarray, loops: np.ndarray, loop_start: np.ndarray, layers: dict, more=None
) -> None:
    """Replaces all geometry of a mesh by polygons. vertices (W, 3), loops (L,), loop_start (Q,).

    layers: {name: (Q,) int} face layers to write. more: writes further layers, before Blender removes invalid faces.
    """
    mesh.clear_geometry()
    mesh.vertices.add(len(vertices))
    mesh.loops.add(len(loops))
    mesh.polygons.add(len(loop_start))
    mesh.vertices.foreach_set("co", vertices.astype(np.float32).ravel())
    mesh.loops.foreach_set("vertex_index", loops.astype(np.int32))
    mesh.polygons.foreach_set("loop_start", loop_start.astype(np.int32))
    totals = np.diff(loop_start, append=len(loops)).astype(np.int32)
    mesh.polygons.foreach_set("loop_total", totals)
    mesh.polygons.foreach_set("use_smooth", np.zeros(len(loop_start), bool))
    mesh.update(calc_edges=True)
    for name, values in layers.items():
        _layer(mesh, name, "INT", "FACE").data.foreach_set("value", values.astype(np.int32))
    if more is not None:
        more()
    mesh.validate()
    mesh.update()
