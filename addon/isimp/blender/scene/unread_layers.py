"""Renames layers that the add-on can't read before it writes its own, so that they stay in the file."""

import numpy as np

from . import mesh_io, runtime

KEPT = ".kept"  # suffix of the names of renamed layers


def foreign_layers(mesh) -> list:
    """Return names and kinds of layers with a name of the add-on's but another kind, in either mode."""
    found = (layer for layer in mesh.attributes if layer.name in mesh_io.KINDS and not mesh_io.is_own(layer))
    return [(layer.name, f"{layer.data_type} of {layer.domain}") for layer in found]


def layers(mesh) -> list:
    """Return the names of the layers that `rename` renamed, in either mode."""
    begin = tuple(f"{name}{KEPT}" for name in mesh_io.KINDS)
    return [layer.name for layer in mesh.attributes if layer.name.startswith(begin)]


def has_regions(mesh) -> bool:
    """Return whether there is a layer of regions, of any state, in either mode."""
    return mesh_io.own_layer(mesh, mesh_io.REGION) is not None


def suffix(mesh) -> str:
    """Return the unused suffix for the next renamed layers."""
    end, number = KEPT, 1
    while any(f"{name}{end}" in mesh.attributes for name in mesh_io.KINDS):
        number += 1
        end = f"{KEPT}.{number}"
    return end


def rename(obj, regions_too: bool) -> None:
    """Renames layers with a name of the add-on's but another kind, so that they stay in the file.

    regions_too: whether to rename the regions and their state as well.
    """
    mesh, ours = obj.data, {mesh_io.REGION, mesh_io.STATE} if regions_too else set()
    named = [layer for layer in mesh.attributes if layer.name in mesh_io.KINDS]
    wanted = [layer for layer in named if layer.name in ours or not mesh_io.is_own(layer)]
    if not wanted:
        return
    end = suffix(mesh)
    for layer in wanted:
        layer.name += end
    runtime.get().written.pop(obj.name, None)
    runtime.get().seen = {}


def _state_layers(mesh) -> list:
    """Return the names of the renamed layers of states, the oldest first."""
    names = [name for name in layers(mesh) if name.startswith(f"{mesh_io.STATE}{KEPT}")]
    return sorted(names, key=lambda name: (len(name), name))


def last_state(obj) -> int:
    """Return the state in the layer that was renamed last; 0 if there is none. Like `mesh_io.state_of`."""
    names = _state_layers(obj.data)
    if not names:
        return 0
    if mesh_io.is_edited(obj):
        faces = mesh_io.edit_mesh(obj.data).faces
        layer = faces.layers.int.get(names[-1])
        return next(iter(faces))[layer] if layer is not None and len(faces) else 0
    layer = obj.data.attributes[names[-1]]
    ours = (layer.data_type, layer.domain) == mesh_io.KINDS[mesh_io.STATE]
    return layer.data[0].value if ours and len(layer.data) else 0


def states(obj) -> set:
    """Return all states in renamed layers."""
    found = set()
    for name in _state_layers(obj.data):
        if mesh_io.is_edited(obj):
            faces = mesh_io.edit_mesh(obj.data).faces
            layer = faces.layers.int.get(name)
            found |= {face[layer] for face in faces} if layer is not None else set()
        else:
            found |= set(np.unique(mesh_io.read_layer(obj.data, name)).tolist())
    return found - {0}
