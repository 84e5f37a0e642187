"""Renames layers that the add-on can't read before it writes its own, so that they stay in the file."""

from . import mesh_io, runtime

KEPT = ".kept"  # suffix of the names of renamed layers; Blender appends a number to one that exists


def foreign_layers(mesh) -> list:
    """Return the layers with a name of the add-on's but another kind, in either mode."""
    return [layer for layer in mesh.attributes if layer.name in mesh_io.KINDS and not mesh_io.is_own(layer)]


def rename(obj, regions_too: bool) -> None:
    """Renames foreign layers so that they stay in the file. regions_too: the regions and their state as well."""
    wanted = foreign_layers(obj.data)
    if regions_too:
        found = (mesh_io.own_layer(obj.data, name) for name in (mesh_io.REGION, mesh_io.STATE))
        wanted += [layer for layer in found if layer is not None]
    for layer in wanted:
        layer.name += KEPT
    if wanted:
        runtime.get().written.pop(obj.name, None)
        runtime.get().seen = {}
