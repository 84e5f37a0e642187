"""Reads Blender's own marks on a mesh as barriers: seams, sharp edges, materials, face sets."""

import numpy as np

from ... import recipe as rcp
from ...language import said
from . import mesh_io, weights

_FACE_SET = ".sculpt_face_set"  # exists since Blender 3.6


def read(obj, wanted, vertex_count: int) -> dict:
    """Return {layer: values} of the wanted layers of `recipe.MARKS`, as of the last update_from_editmode.

    vertex_count: number of vertices of the scan. Raises Unusable if it differs from the mesh's, due to modifiers.
    """
    mesh, found = obj.data, {}
    for name, flag in (("seams", "use_seam"), ("sharp", "use_edge_sharp")):
        if rcp.MARKS[name] not in wanted:
            continue
        if len(mesh.vertices) != vertex_count:
            raise mesh_io.Unusable(
                said(
                    "The marked edges of '{name}' can't be traced through its modifiers: apply them first "
                    "(Object > Apply > Visual Geometry to Mesh).",
                    name=obj.name,
                )
            )
        marked, ends = np.empty(len(mesh.edges), bool), np.empty(2 * len(mesh.edges), np.int32)
        mesh.edges.foreach_get(flag, marked)
        mesh.edges.foreach_get("vertices", ends)
        found[rcp.MARKS[name]] = ends.reshape(-1, 2)[marked]
    if rcp.MARKS["materials"] in wanted:
        values = np.empty(len(mesh.polygons), np.int32)
        mesh.polygons.foreach_get("material_index", values)
        found[rcp.MARKS["materials"]] = values
    if rcp.MARKS["face_sets"] in wanted:
        values = _face_sets(obj)
        if values is not None:
            found[rcp.MARKS["face_sets"]] = values
    return found


def _face_sets(obj):
    if mesh_io.is_edited(obj):
        return weights.edit_layer(obj.data, _FACE_SET)
    layer = obj.data.attributes.get(_FACE_SET)
    if layer is None or (layer.data_type, layer.domain) != ("INT", "FACE"):
        return None
    values = np.empty(len(layer.data), np.int32)
    layer.data.foreach_get("value", values)
    return values
