"""What its user painted on a scan, one number a face: vertex groups, and attributes of faces or vertices."""

import numpy as np

from . import mesh_io

_OWN = frozenset({mesh_io.REGION, mesh_io.STATE, mesh_io.COLOR})
_KINDS = {"FLOAT", "INT", "BOOLEAN", "INT8"}


def names(obj) -> list:
    """The vertex groups and attributes that can weigh."""
    groups = [group.name for group in obj.vertex_groups]
    return groups + [layer.name for layer in obj.data.attributes if _fits(layer) and layer.name not in {*_OWN, *groups}]


def face_names(obj) -> list:
    """The attributes of faces that regions can keep to."""
    layers = obj.data.attributes
    return [layer.name for layer in layers if _fits(layer) and layer.domain == "FACE" and layer.name not in _OWN]


def _fits(layer) -> bool:
    return layer.data_type in _KINDS and layer.domain in {"FACE", "POINT"} and not layer.name.startswith(".")


def read(obj, wanted, groups: dict) -> dict:
    """{name: (faces,) float32} of those of the wanted names that the object has, as of the last update_from_editmode.

    groups: what is known of vertex groups, and kept of them, as they take long to read.
    """
    found = {}
    for name in sorted(wanted):
        if name in obj.vertex_groups:
            if name not in groups:
                groups[name] = _of_faces(obj.data, _group(obj, obj.vertex_groups[name].index))
            found[name] = groups[name]
        elif obj.mode == "EDIT":
            values = edit_layer(obj.data, name)
            if values is not None:
                found[name] = values
        elif name in obj.data.attributes and _fits(obj.data.attributes[name]):
            layer = obj.data.attributes[name]
            kind = {"BOOLEAN": bool, "FLOAT": np.float32}.get(layer.data_type, np.int32)
            values = np.zeros(len(layer.data), kind)
            layer.data.foreach_get("value", values)
            found[name] = _of_faces(obj.data, values) if layer.domain == "POINT" else values.astype(np.float32)
    return found


def _group(obj, index: int) -> np.ndarray:
    """(V,) float32 weight of each vertex in a group.

    Cost: a loop in Python, a fifth of a second for 400,000 vertices; geometry nodes that make an attribute of the group
    take as long, as Blender copies and evaluates the mesh for them.
    """
    values = np.zeros(len(obj.data.vertices), np.float32)
    for number, vertex in enumerate(obj.data.vertices):
        for entry in vertex.groups:
            if entry.group == index:
                values[number] = entry.weight
    return values


def _of_faces(mesh, values: np.ndarray) -> np.ndarray:
    """(faces,) float32 the mean of each face's corners."""
    corners = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    totals = np.broadcast_to(mesh_io.corner_totals(mesh), len(mesh.polygons))
    start = np.cumsum(totals) - totals
    return (np.add.reduceat(values[corners].astype(np.float64), start) / totals).astype(np.float32)


def edit_layer(mesh, name: str):
    """(faces,) float32 of a layer in edit mode, or None."""
    edit = mesh_io.edit_mesh(mesh)
    for kind in ("float", "int"):
        layer = getattr(edit.faces.layers, kind).get(name)
        if layer is not None:
            return np.array([face[layer] for face in edit.faces], np.float32)
        layer = getattr(edit.verts.layers, kind).get(name)
        if layer is not None:
            values = [sum(vertex[layer] for vertex in face.verts) / len(face.verts) for face in edit.faces]
            return np.array(values, np.float32)
    return None
