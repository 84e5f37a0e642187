"""Reads a scan's arrays and keeps them between clicks: reading a million faces takes Blender 3.4 a fifth of a second.

The arrays are kept until the mesh changes. Blender reports each change of geometry when it updates the scene, and the
vertices are compared each time. Scripts change meshes without a report, so the arrays are not kept in the background.
"""

import math
import time

import bpy
import numpy as np

from .drawing import late
from .scene import barriers, mesh_io, runtime, weights

SPAN = 0.04  #: seconds of one piece of reading or writing, during which the window does not respond


class Known:
    """The scan read last, with data to detect changes of its mesh."""

    def __init__(self, obj, scan):
        self.mesh, self.scan = obj.data.name, scan
        self.counts, self.points, self.shape = _counts(obj.data), mesh_io.points(obj.data), mesh_io.shape_matrix(obj)

    def take_over(self, former) -> None:
        """Replaces the arrays by the former ones if they are equal, so that cached results stay valid."""
        names = ("vertices", "triangles", "triangle_face")
        pairs = ((getattr(former, name), getattr(self.scan, name)) for name in names)
        if former.face_count == self.scan.face_count and all(_equal(*pair) for pair in pairs):
            self.scan = former

    def fits(self, obj) -> bool:
        return (
            self.mesh == obj.data.name
            and self.counts == _counts(obj.data)
            and np.array_equal(self.shape, mesh_io.shape_matrix(obj))
            and _equal(self.points, mesh_io.points(obj.data))
        )

    def stands(self, obj) -> bool:
        """Return whether name, counts and shape are unchanged in Edit Mode. Comparing vertices there is too slow."""
        edit = mesh_io.edit_mesh(obj.data)
        return (
            self.mesh == obj.data.name
            and (*self.counts[:2], self.counts[3]) == (len(edit.verts), len(edit.edges), len(edit.faces))
            and np.array_equal(self.shape, mesh_io.shape_matrix(obj))
        )


def _equal(a: np.ndarray, b: np.ndarray) -> bool:
    """Return whether arrays have the same bits, as NaN differs from itself."""
    return a.dtype == b.dtype and np.array_equal(a.view(np.int32), b.view(np.int32))


def _counts(mesh):
    return len(mesh.vertices), len(mesh.edges), len(mesh.loops), len(mesh.polygons)


def read(context, obj, layers=frozenset(), again=False):
    """Return the scan like `mesh_io.read`, with the named layers if the object has them. Raises Unusable.

    again: uses the kept arrays without a comparison, since Blender reports every possible change.
    """
    known = runtime.get().scans.get(obj.name)
    scan = known.scan if again and known is not None else _read(context, obj)
    if not layers:
        return scan
    ready(context, obj, layers)
    groups = {name: group for name in layers if (group := _group(obj, name)) is not None}
    found = weights.read(obj, layers, groups)
    return scan.with_layers(found | barriers.read(obj, layers, len(scan.vertices)))


def ready(context, obj, layers, seconds: float = math.inf) -> bool:
    """Reads data for `read` of these layers for at most `seconds`. Returns whether all of it is read."""
    end = time.monotonic() + seconds
    if not any(name in obj.vertex_groups for name in layers):
        return True
    if not bpy.app.background:
        _read(context, obj)  # updates the mesh from Edit Mode, and drops the data of another mesh
    corners = known_corners(obj)
    groups = (_group(obj, name) for name in sorted(layers))
    return all(group.go_on(obj, end - time.monotonic(), corners) for group in groups if group is not None)


def regions(obj, scan, recipe) -> np.ndarray:
    """Return (faces,) int32 the regions of an object, from a cached outcome if there is one.

    In Edit Mode, reading them face by face takes a second for a million faces.
    """
    outcome = runtime.get().session.known(scan, recipe.without_mesh())
    return mesh_io.read_regions(obj) if outcome is None else outcome.face_region


def known_corners(obj) -> np.ndarray | None:
    """Return the vertex of each corner of a mesh of triangles, if its arrays are kept; else None."""
    known = runtime.get().scans.get(obj.name)
    if known is None or len(known.scan.triangles) != len(obj.data.polygons) or mesh_io.has_modifiers(obj):
        return None
    return known.scan.triangles.ravel()


def _group(obj, name: str):
    """Return the new or kept reader of a vertex group; None if the object has no such group."""
    if name not in obj.vertex_groups:
        return None
    groups = runtime.get().groups
    if (obj.name, name) not in groups:
        groups[obj.name, name] = weights.Group(obj, name)
    return groups[obj.name, name]


def _read(context, obj):
    known = runtime.get().scans
    if bpy.app.background:
        forget()
    if bpy.app.background or mesh_io.has_modifiers(obj):
        return mesh_io.read(context, obj)
    if mesh_io.is_edited(obj):
        if obj.name in known and known[obj.name].stands(obj):
            return known[obj.name].scan
        obj.update_from_editmode()
    if obj.name not in known or not known[obj.name].fits(obj):
        former = next((before.scan for before in known.values()), runtime.get().former)
        known.clear()  # keeps one scan only, as arrays are large
        runtime.get().groups.clear()
        known[obj.name] = Known(obj, mesh_io.read(context, obj, is_updated=True))
        if former is not None:
            known[obj.name].take_over(former)
        runtime.get().former = None
    return known[obj.name].scan


def forget_changed(depsgraph) -> None:
    """Drops the arrays of changed meshes, unless only `mesh_io`'s own layers changed."""
    current = runtime.get()
    for update in depsgraph.updates:
        if update.is_updated_geometry and isinstance(update.id, bpy.types.Mesh):
            name = update.id.original.name
            if name in current.own_writes:
                current.own_writes.discard(name)
            else:
                forget(name)
                late.forget(name)


def forget(name=None) -> None:
    """Drops the arrays of a mesh, or of all meshes."""
    runtime.get().seen = {}
    for known in (runtime.get().scans, runtime.get().groups):
        for key in [key for key, value in known.items() if name in (None, value.mesh)]:
            gone = known.pop(key)
            if isinstance(gone, Known):
                runtime.get().former = gone.scan
