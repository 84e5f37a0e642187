"""Stores recipes on meshes, so that undo, save, load, duplicate and append can't separate them.

Every step is a node: its parent, its settings, its numbers. A node's id is a hash of its parent and its settings, so
the id of the last step identifies the whole recipe: the *state*. A face layer of the mesh stores the state next to the
regions. A property of the mesh stores the nodes. Nodes are added and never changed, except for their numbers.

Undo in Edit Mode restores layers but not properties. As the state is in a layer, it always belongs to the visible
regions. As nodes are only added, the property has their steps too. Undo past the start of Edit Mode and redo can leave
an older property; a copy in memory has the missing nodes.

Steps that this version can't read are kept as a text of the file before others replace them (see `keep`), since a
later version may read them.
"""

import json
import zlib

import bpy
from bpy.props import CollectionProperty, IntProperty, StringProperty

from ... import stored
from . import mesh_io, runtime

MOST_NODES = 4000


class IsimpNode(bpy.types.PropertyGroup):
    """A step of a recipe; `name` is its id"""

    parent: IntProperty()
    step: StringProperty()
    numbers: StringProperty()


class IsimpMesh(bpy.types.PropertyGroup):
    """The data of iSimp on a mesh"""

    nodes: CollectionProperty(type=IsimpNode)
    user_color: StringProperty()


class IsimpObject(bpy.types.PropertyGroup):
    """Which scan a result is of, and which kind a scan"""

    # The scan is stored by names and key, since a pointer would keep a deleted scan in the file.

    key: StringProperty()
    scan_key: StringProperty()
    scan_name: StringProperty()
    scan_mesh: StringProperty()  # empty in files of earlier versions
    made: StringProperty()  # digest of a result after Mesh; see result.py
    named: StringProperty()  # name of a result after Mesh
    placed: StringProperty()  # transform of a result after Mesh, as JSON
    parent: StringProperty()  # name of a result's parent after Mesh
    kind: StringProperty()  # name of the preset chosen for a scan
    unrendered: StringProperty()  # not empty: hidden in renders by the add-on, not by the user


def load(obj):
    """Return the recipe of the regions on the object: empty if it has none, None if it can't be read."""
    return read(obj).recipe


def numbers(obj) -> dict:
    """Return the readable numbers of the last step."""
    return read(obj).numbers


def read(obj) -> stored.Stored:
    """Return the stored data of the regions on the object."""
    current, state = runtime.get(), mesh_io.state_of(obj)
    key = obj.data.name_full, state
    if key not in current.stored:
        found = stored.read(state, _Nodes(obj.data).node, current.recipes.get(key))
        current.stored[key], current.recipes[key] = found, found.recipe
    return current.stored[key]


def keep(obj) -> None:
    """Keeps steps that can't be read as a text of the file, before others replace them."""
    steps = read(obj).text
    if steps:
        bpy.data.texts.new(text_name(obj)).write(steps)


def text_name(obj) -> str:
    """Return the name of the text that `keep` makes; Blender appends a number to one that exists."""
    return f"{obj.name}.steps"


def forget() -> None:
    """Drops the cache of stored data. Undo can restore other numbers of the same state."""
    runtime.get().stored.clear()


def forget_file() -> None:
    """Drops all data of a file before another one is opened."""
    forget()
    runtime.get().recipes.clear()
    runtime.get().nodes.clear()
    runtime.get().most_nodes.clear()
    runtime.get().live.settings.clear()


class _Nodes:
    """The nodes of a mesh by their ids. Invalid after a node is added or removed."""

    def __init__(self, mesh):
        self._found = mesh.isimp.nodes
        self.places = {node.name: place for place, node in enumerate(self._found)}

    def node(self, state: int):
        """Return (parent, step, numbers); None if there is no such node."""
        place = self.places.get(str(state))
        if place is None:
            return runtime.get().nodes.get(state)
        found = self._found[place]
        return found.parent, found.step, found.numbers


def save(obj, recipe, step_numbers: dict) -> int:
    """Stores the recipe on the object's mesh. Returns its state, for the layer next to the regions."""
    mesh, memory, text = obj.data, runtime.get().nodes, json.dumps(step_numbers)
    state, fresh = 0, []
    found = _Nodes(mesh)
    for step in (json.dumps(step.to_dict(), sort_keys=True) for step in recipe.steps):
        parent, state = state, _state(found, state, step)
        memory[state] = found.node(state) or (parent, step, "")
        if str(state) not in found.places:
            fresh.append(state)
    for at in fresh:
        item = mesh.isimp.nodes.add()
        item.name, item.parent, item.step, item.numbers = str(at), *memory[at]
    mesh.isimp.nodes[str(state)].numbers = text
    memory[state] = (*memory[state][:2], text)
    forget()
    runtime.get().recipes[mesh.name_full, state] = recipe
    if len(mesh.isimp.nodes) > runtime.get().most_nodes.get(mesh.name_full, MOST_NODES):
        _forget_others(mesh, state)
        # Many nodes may have to stay, so the next search waits until their number has doubled.
        runtime.get().most_nodes[mesh.name_full] = max(MOST_NODES, 2 * len(mesh.isimp.nodes))
    return state


def _state(found: _Nodes, parent: int, step: str) -> int:
    """Return the id of a step that follows another."""
    state = zlib.crc32(f"{parent} {step}".encode()) & 0x7FFFFFFF
    while not state or (found.node(state) or (parent, step))[:2] != (parent, step):
        state = (state + 1) & 0x7FFFFFFF  # another step has this id
    return state


def _forget_others(mesh, state: int) -> None:
    """Drops nodes that are not ancestors of the state."""
    found, needed = _Nodes(mesh), set()
    while state and str(state) not in needed:
        needed.add(str(state))
        state = (found.node(state) or (0,))[0]
    for name, place in reversed(found.places.items()):
        if name not in needed:
            mesh.isimp.nodes.remove(place)


CLASSES = (IsimpNode, IsimpMesh, IsimpObject)


def register() -> None:
    bpy.types.Mesh.isimp = bpy.props.PointerProperty(type=IsimpMesh)
    bpy.types.Object.isimp = bpy.props.PointerProperty(type=IsimpObject)


def unregister() -> None:
    del bpy.types.Mesh.isimp
    del bpy.types.Object.isimp
