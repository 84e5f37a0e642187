"""Reads and sets the selection of polygons in Object and Edit Mode, at once or in pieces."""

import bmesh
import bpy
import numpy as np

from . import mesh_io

_PIECE = 5000  # faces: selecting all of them takes about a hundredth of a second


def leave_modes(context, *objects) -> None:
    """Brings the active object and these to Object Mode. An object keeps its mode while another one is active."""
    shown, active = context.view_layer.objects, context.view_layer.objects.active
    for obj in (active, *objects):
        if obj is not None and obj.mode != "OBJECT" and obj.name in shown:
            shown.active = obj
            bpy.ops.object.mode_set(mode="OBJECT")
    shown.active = active


def selected_faces(obj) -> np.ndarray:
    """Return the indices of the selected faces, in either mode."""
    if mesh_io.is_edited(obj):
        obj.update_from_editmode()
    selected = np.empty(len(obj.data.polygons), bool)
    obj.data.polygons.foreach_get("select", selected)
    return np.flatnonzero(selected)


def select_polygons(obj, chosen: np.ndarray, corners: np.ndarray | None = None) -> None:
    """Selects polygons and their corners, and deselects all others, in either mode.

    chosen: (polygons,) bool. corners: the vertex of each corner, read if None.
    """
    for _ in selecting(obj, chosen, corners):
        pass


def selecting(obj, chosen: np.ndarray, corners: np.ndarray | None = None):
    """Does `select_polygons` in pieces in Edit Mode; yields before each. Nothing else may change the mesh between."""
    mesh = obj.data
    if mesh_io.is_edited(obj):
        edit = mesh_io.edit_mesh(mesh)
        if bpy.ops.mesh.select_all.poll():  # seconds faster than one by one
            bpy.ops.mesh.select_all(action="DESELECT")
        else:
            for part in (edit.verts, edit.edges, edit.faces):
                for item in part:
                    item.select = False
        faces = np.flatnonzero(chosen)
        for begin in range(0, len(faces), _PIECE):
            yield
            edit.faces.ensure_lookup_table()
            for face in faces[begin : begin + _PIECE].tolist():
                edit.faces[face].select_set(True)
        bmesh.update_edit_mesh(mesh, loop_triangles=False, destructive=False)
        return
    edges = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("edge_index", edges)
    if corners is None:
        corners = np.empty(len(mesh.loops), np.int32)
        mesh.loops.foreach_get("vertex_index", corners)
    inside = np.repeat(chosen, mesh_io.corner_totals(mesh))  # polygons lie in the order of their corners
    for name, domain, items, which in (
        (".select_vert", "POINT", mesh.vertices, corners[inside]),
        (".select_edge", "EDGE", mesh.edges, edges[inside]),
        (".select_poly", "FACE", mesh.polygons, chosen),
    ):
        flags = np.zeros(len(items), bool)
        flags[which] = True
        # The attribute is replaced: 5.0 may store a single value, and crashes if an array is written over it.
        if (old := mesh.attributes.get(name)) is not None:
            mesh.attributes.remove(old)
        mesh.attributes.new(name, "BOOLEAN", domain).data.foreach_set("value", flags)
    mesh_io.tell(mesh)
