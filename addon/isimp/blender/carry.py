"""What the vertices of a result keep of those of the scan that they stand for: vertex groups, and the armature."""

import numpy as np

from . import mesh_io, runtime


def bones(result, scan, arrays, outcome) -> None:
    """Gives the result the scan's vertex groups with their weights, and its armatures as long as they are at rest.

    arrays: those of the scan that the outcome was made from. Nothing is done where modifiers make other vertices than
    those of the scan's own mesh. A posed figure gets no armature, since that would bend it twice.
    """
    if not len(scan.vertex_groups) or len(arrays.vertices) != len(scan.data.vertices):
        return
    mesh = runtime.get().session.prepare(arrays, closing=outcome.closing).mesh
    source = np.asarray(mesh.source_vertex)[np.asarray(outcome.polygons.source_vertex)]
    groups = [
        result.vertex_groups.get(group.name) or result.vertex_groups.new(name=group.name)
        for group in scan.vertex_groups
    ]
    for own, of in enumerate(source.tolist()):
        for entry in scan.data.vertices[of].groups if of >= 0 else ():
            groups[entry.group].add([own], entry.weight, "REPLACE")
    if _is_at_rest(scan, arrays):
        _take_armatures(result, scan)


def _is_at_rest(scan, arrays) -> bool:
    """Whether modifiers leave the vertices where they are."""
    own = mesh_io.points(scan.data).reshape(-1, 3).astype(np.float64) @ mesh_io.shape_matrix(scan)
    return bool(np.abs(own - arrays.vertices).max() <= 1e-5 * np.ptp(own, axis=0).max())


def _take_armatures(result, scan) -> None:
    """Those that are switched on; none twice."""
    there = {modifier.object for modifier in result.modifiers if modifier.type == "ARMATURE"}
    for modifier in scan.modifiers:
        if modifier.type != "ARMATURE" or not modifier.show_viewport or modifier.object in {None, *there}:
            continue
        made = result.modifiers.new(modifier.name, "ARMATURE")
        for name in ("object", "use_deform_preserve_volume", "use_vertex_groups", "use_bone_envelopes"):
            setattr(made, name, getattr(modifier, name))
