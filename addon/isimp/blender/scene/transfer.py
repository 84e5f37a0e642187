"""Transfers data from a scan to its result: vertex groups, armatures, colour attributes, UV maps, shape keys."""

import numpy as np

from . import mesh_io, runtime
from .result import corner_order


def bones(result, scan, arrays, outcome) -> None:
    """Copies the scan's vertex groups with their weights to the result, and its armatures if they are at rest.

    arrays: the scan that the outcome was made from. Returns without a copy if modifiers change the number of vertices.
    A posed figure gets no armature, since the armature would bend it twice.
    """
    if not len(scan.vertex_groups) or len(arrays.vertices) != len(scan.data.vertices):
        return
    mesh = runtime.get().session.prepare(arrays, repair=outcome.repair).mesh
    source = np.asarray(mesh.source_vertex)[np.asarray(outcome.polygons.source_vertex)]
    groups = [
        result.vertex_groups.get(group.name) or result.vertex_groups.new(name=group.name)
        for group in scan.vertex_groups
    ]
    for own, of in enumerate(source.tolist()):
        for entry in scan.data.vertices[of].groups if of >= 0 else ():
            groups[entry.group].add([own], entry.weight, "REPLACE")
    if _is_at_rest(scan, arrays, _keys(scan)):
        _take_armatures(result, scan)


def _is_at_rest(scan, arrays, keys: list) -> bool:
    """Return whether modifiers do not move vertices away from the mesh with its shape keys. keys: from `_keys`."""
    own = mesh_io.points(scan.data).reshape(-1, 3).astype(np.float64)
    own = (own + sum(value * offsets for _, value, offsets in keys)) @ mesh_io.shape_matrix(scan)
    own, seen = (points[np.isfinite(own).all(axis=1)] for points in (own, arrays.vertices))
    return bool(np.abs(own - seen).max(initial=0) <= 1e-5 * np.ptp(own, axis=0).max())


def _take_armatures(result, scan) -> None:
    """Copies the armature modifiers that are switched on, except armatures that the result has already."""
    there = {modifier.object for modifier in result.modifiers if modifier.type == "ARMATURE"}
    for modifier in scan.modifiers:
        if modifier.type != "ARMATURE" or not modifier.show_viewport or modifier.object in {None, *there}:
            continue
        made = result.modifiers.new(modifier.name, "ARMATURE")
        for name in ("object", "use_deform_preserve_volume", "use_vertex_groups", "use_bone_envelopes"):
            setattr(made, name, getattr(modifier, name))


def values_of_keys(result) -> dict:
    """Return {name: value} of the shape keys of a result that were moved since Mesh."""
    keys = result.data.shape_keys
    return {} if keys is None else {key.name: key.value for key in keys.key_blocks if key.value != keys.get(key.name)}


def layers(result, scan, arrays, outcome, turn, slid: dict) -> None:
    """Copies colour attributes, UV maps except the texture's, and shape keys from the scan to the result.

    Each corner has the value of the closest point of its own region, in UV maps within one island. Each vertex has the
    mean of its corners. Returns without a copy if modifiers change the topology of the scan. A posed figure gets no
    shape keys.

    arrays: the scan that the outcome was made from. turn: returned by `result.fill`. slid: values of the shape keys
    that the result had before.
    """
    mesh = scan.data
    if (len(arrays.vertices), arrays.face_count) != (len(mesh.vertices), len(mesh.polygons)):
        return
    colors = [layer for layer in mesh.color_attributes if layer.name != mesh_io.COLOR]
    maps = [layer for layer in mesh.uv_layers if not layer.active_render]
    keys = _keys(scan)
    if keys and not _is_at_rest(scan, arrays, keys):
        keys = []
    order = corner_order(result, outcome)
    if not (colors or maps or keys) or order is None:
        return
    carrier = _Carrier(arrays, outcome)
    loops = _loops(mesh, arrays) if maps or any(layer.domain == "CORNER" for layer in colors) else None
    for layer in colors:
        values = _read(layer.data, "color", 4)
        of_corner = carrier(values[arrays.triangles if layer.domain == "POINT" else loops])
        made = _color_layer(result.data, layer)
        made.data.foreach_set(
            "color", (carrier.mean(of_corner) if layer.domain == "POINT" else of_corner[order]).ravel()
        )
    for layer in maps:
        uv = _read(layer.data, "uv", 2)[loops]
        made = result.data.uv_layers.get(layer.name) or result.data.uv_layers.new(name=layer.name, do_init=False)
        made.data.foreach_set("uv", _Carrier(arrays, outcome, uv)(uv)[order].ravel())
    if keys:
        _put_keys(result, scan, keys, carrier, arrays, turn, slid)


class _Carrier:
    """Transfers values at the corners of the scan's triangles to the corners of polygons."""

    def __init__(self, arrays, outcome, uv=None):
        """uv: (T, 3, 2) a UV map to transfer: each region then uses only the island with most of its area."""
        self._triangle, self._weights = runtime.get().session.corner_sources(arrays, outcome, uv)
        self._loops = np.asarray(outcome.polygons.loops)
        self._count = np.maximum(np.bincount(self._loops, minlength=len(outcome.polygons.vertices)), 1)

    def __call__(self, values) -> np.ndarray:
        """Return (L, n) float32 the values of the polygons' corners from values (T, 3, n)."""
        taken = np.einsum("lc,lcn->ln", self._weights, values[np.maximum(self._triangle, 0)])
        return np.where(self._triangle[:, None] >= 0, taken, 0).astype(np.float32)

    def mean(self, of_corner) -> np.ndarray:
        """Return (W, n) float32 the mean of each vertex's corners from values (L, n)."""
        sums = [np.bincount(self._loops, column, len(self._count)) for column in of_corner.T]
        return (np.stack(sums, axis=1) / self._count[:, None]).astype(np.float32)


def _read(data, name: str, width: int) -> np.ndarray:
    values = np.empty(width * len(data), np.float32)
    data.foreach_get(name, values)
    return values.reshape(-1, width)


def _loops(mesh, arrays) -> np.ndarray:
    """Return (T, 3) the mesh's corner at each corner of a triangle."""
    of_loop, count = np.empty(len(mesh.loops), np.int32), len(mesh.vertices)
    mesh.loops.foreach_get("vertex_index", of_loop)
    faces = np.repeat(np.arange(len(mesh.polygons), dtype=np.int64), mesh_io.corner_totals(mesh))
    keys = faces * count + of_loop
    order = np.argsort(keys, kind="stable")
    wanted = arrays.triangle_face.astype(np.int64)[:, None] * count + arrays.triangles
    return order[np.searchsorted(keys[order], wanted)]


def _color_layer(mesh, like):
    """Return the colour attribute of the same name and kind. An older one of another kind is removed."""
    there = mesh.color_attributes.get(like.name)
    if there is not None and (there.data_type, there.domain) != (like.data_type, like.domain):
        mesh.color_attributes.remove(there)
        there = None
    return there or mesh.color_attributes.new(name=like.name, type=like.data_type, domain=like.domain)


def _keys(scan) -> list:
    """Return (shape key, value, offsets (V, 3)) of each shape key of the scan except the reference key."""
    keys = scan.data.shape_keys
    if keys is None or not keys.use_relative:
        return []
    found = []
    for key in keys.key_blocks:
        if key == keys.reference_key:
            continue
        offsets = (_read(key.data, "co", 3) - _read(key.relative_key.data, "co", 3)).astype(np.float64)
        group = scan.vertex_groups.get(key.vertex_group) if key.vertex_group else None
        if group is not None:
            offsets *= _weights(scan, group)[:, None]
        found.append((key, 0.0 if key.mute else key.value, offsets))
    return found


def _weights(scan, group) -> np.ndarray:
    weights = np.zeros(len(scan.data.vertices))
    for i, vertex in enumerate(scan.data.vertices):
        weights[i] = sum(entry.weight for entry in vertex.groups if entry.group == group.index)
    return weights


def _put_keys(result, scan, keys: list, carrier, arrays, turn, slid: dict) -> None:
    """Adds the shape keys. Their offsets are subtracted from the polygons to get the reference key."""
    moves = [carrier.mean(carrier(offsets[arrays.triangles])) @ turn for _, _, offsets in keys]
    now = mesh_io.points(result.data).reshape(-1, 3).astype(np.float64)
    first = now - sum(value * move for (_, value, _), move in zip(keys, moves, strict=True))
    result.data.vertices.foreach_set("co", first.astype(np.float32).ravel())
    result.shape_key_add(name=scan.data.shape_keys.reference_key.name, from_mix=False)
    for (key, _, _), move in zip(keys, moves, strict=True):
        made = result.shape_key_add(name=key.name, from_mix=False)
        made.data.foreach_set("co", (first + move).astype(np.float32).ravel())
        made.slider_min, made.slider_max = key.slider_min, key.slider_max
        made.value, made.mute = slid.get(key.name, key.value), key.mute
        result.data.shape_keys[key.name] = key.value
    result.data.update()
