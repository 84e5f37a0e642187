"""A scan's arrays, not read anew for every click: a million faces take Blender 3.4 a fifth of a second.

What was read is kept while nothing says that the mesh has changed: Blender tells of every change of geometry once the
scene is brought up to date, and the vertices are compared each time. Scripts change meshes without such news, so in the
background everything is read.
"""

import dataclasses

import bpy
import numpy as np

from . import marks, mesh_io, runtime, weights


class Known:
    """A scan as it was read, and of what."""

    def __init__(self, obj, scan):
        self.mesh, self.scan, self.groups = obj.data.name, scan, {}
        self.counts, self.points, self.shape = _counts(obj.data), mesh_io.points(obj.data), mesh_io.shape_matrix(obj)

    def fits(self, obj) -> bool:
        return (
            self.mesh == obj.data.name
            and self.counts == _counts(obj.data)
            and np.array_equal(self.shape, mesh_io.shape_matrix(obj))
            and np.array_equal(self.points, mesh_io.points(obj.data))
        )

    def stands(self, obj) -> bool:
        """Whether nothing tells of a change in Edit Mode. Comparing vertices there takes Blender most of a second."""
        edit = mesh_io.edit_mesh(obj.data)
        return (
            self.mesh == obj.data.name
            and (*self.counts[:2], self.counts[3]) == (len(edit.verts), len(edit.edges), len(edit.faces))
            and np.array_equal(self.shape, mesh_io.shape_matrix(obj))
        )


def _counts(mesh):
    return len(mesh.vertices), len(mesh.edges), len(mesh.loops), len(mesh.polygons)


def read(context, obj, layers=frozenset(), again=False):
    """As `mesh_io.read`, with the layers of the given names that the object has. Raises Unusable.

    again: nothing but news from Blender can have changed the mesh since it was read last.
    """
    known = runtime.get().scans.get(obj.name)
    scan = known.scan if again and known is not None else _read(context, obj)
    if not layers:
        return scan
    known = runtime.get().scans.get(obj.name)
    found = weights.read(obj, layers, {} if known is None else known.groups)
    return dataclasses.replace(scan, layers=found | marks.read(obj, layers, len(scan.vertices)))


def _read(context, obj):
    known = runtime.get().scans
    if bpy.app.background or mesh_io.has_modifiers(obj):
        return mesh_io.read(context, obj)
    if obj.mode == "EDIT":
        if obj.name in known and known[obj.name].stands(obj):
            return known[obj.name].scan
        obj.update_from_editmode()
    if obj.name not in known or not known[obj.name].fits(obj):
        known.clear()  # one is enough, and large
        known[obj.name] = Known(obj, mesh_io.read(context, obj))
    return known[obj.name].scan


def forget_changed(depsgraph) -> None:
    """Drops what was read of meshes that have changed, other than by `mesh_io`'s own layers."""
    current = runtime.get()
    for update in depsgraph.updates:
        if update.is_updated_geometry and isinstance(update.id, bpy.types.Mesh):
            name = update.id.original.name
            if name in current.own_writes:
                current.own_writes.discard(name)
            else:
                forget(name)


def forget(name=None) -> None:
    """Drops what was read of a mesh, or of all."""
    runtime.get().seen = {}
    known = runtime.get().scans
    for key in [key for key, value in known.items() if name in (None, value.mesh)]:
        del known[key]
