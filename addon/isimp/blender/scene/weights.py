"""Reads weights painted on a scan, one number for each face: vertex groups, attributes of faces or vertices."""

import math
import time

import numpy as np

from . import mesh_io, unread_layers

_OWN = (mesh_io.REGION, mesh_io.STATE, mesh_io.COLOR)
_KINDS = {"FLOAT", "INT", "BOOLEAN", "INT8"}
_PIECE = 5000  # vertices: a few thousandths of a second


def names(obj) -> list:
    """Return the names of the vertex groups and attributes that can be weights."""
    groups = [group.name for group in obj.vertex_groups]
    layers = (layer.name for layer in obj.data.attributes if _fits(layer))
    return groups + [name for name in layers if not _is_own(name) and name not in groups]


def face_names(obj) -> list:
    """Return the names of the face attributes that can be barriers."""
    layers = obj.data.attributes
    return [layer.name for layer in layers if _fits(layer) and layer.domain == "FACE" and not _is_own(layer.name)]


def _is_own(name: str) -> bool:
    return name in _OWN or name.startswith(tuple(f"{own}{unread_layers.KEPT}" for own in _OWN))


def _fits(layer) -> bool:
    return layer.data_type in _KINDS and layer.domain in {"FACE", "POINT"} and not layer.name.startswith(".")


def read(obj, wanted, groups: dict) -> dict:
    """Return {name: (faces,) float32} of the wanted layers that the object has, as of the last update_from_editmode.

    groups: {name: Group} of the wanted vertex groups.
    """
    found = {}
    for name in sorted(wanted):
        if name in groups:
            found[name] = groups[name].values
        elif mesh_io.is_edited(obj):
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


class Group:
    """The weights of a vertex group, read in pieces, since Blender has no bulk access to them.

    Reading takes a fifth of a second for 400,000 vertices. Geometry nodes that convert the group to an attribute take
    as long, since Blender copies and evaluates the mesh, and can't be split into pieces.
    """

    def __init__(self, obj, name: str):
        self.mesh, self.name = obj.data.name, name
        self.values = None  #: (faces,) float32 after all pieces are read
        self._weight, self._done = np.zeros(len(obj.data.vertices), np.float32), 0

    def go_on(self, obj, seconds: float = math.inf, corners=None) -> bool:
        """Reads for `seconds`, at least one piece. Returns whether all is read. No reference to Blender data is kept.

        corners: (L,) the vertices of all faces' corners, read if None.
        """
        end = time.monotonic() + seconds
        if len(self._weight) != len(obj.data.vertices):
            self.__init__(obj, self.name)
        index = obj.vertex_groups[self.name].index
        while self._done < len(self._weight):
            for number, vertex in enumerate(obj.data.vertices[self._done : self._done + _PIECE], self._done):
                for entry in vertex.groups:
                    if entry.group == index:
                        self._weight[number] = entry.weight
            self._done += _PIECE
            if time.monotonic() > end:
                return False
        if self.values is None:
            self.values = _of_faces(obj.data, self._weight, corners)
        return True


def _of_faces(mesh, values: np.ndarray, corners=None) -> np.ndarray:
    """Return (faces,) float32 the mean of each face's corners."""
    if corners is None:
        corners = np.empty(len(mesh.loops), np.int32)
        mesh.loops.foreach_get("vertex_index", corners)
    totals = np.broadcast_to(mesh_io.corner_totals(mesh), len(mesh.polygons))
    start = np.cumsum(totals) - totals
    return (np.add.reduceat(values[corners].astype(np.float64), start) / totals).astype(np.float32)


def edit_layer(mesh, name: str):
    """Return (faces,) float32 values of a layer in Edit Mode; None if there is none."""
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
