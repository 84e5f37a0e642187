"""Stores recipes on meshes, so that undo, save, load, duplicate and append can't separate them.

Every step is a node: its parent, its settings, its numbers. A node's id is a hash of its parent and its settings, so
the id of the last step identifies the whole recipe: the *state*. A face layer of the mesh stores the state next to the
regions. A property of the mesh stores the nodes. Nodes are added and never changed, except for their numbers.

Undo in Edit Mode restores layers but not properties. As the state is in a layer, it always belongs to the visible
regions. As nodes are only added, the property has their steps too. Undo past the start of Edit Mode and redo can leave
an older property; a copy in memory has the missing nodes.

Nodes that this version can't read are never changed or dropped, since a later version may read them. Layers with such
a state are renamed before others are written (see unread_layers.rename).
"""

import json
import zlib

import bpy
from bpy.props import CollectionProperty, IntProperty, StringProperty

from ... import stored
from ...language import own, said
from . import mesh_io, raw_properties, runtime, unread_layers

MOST_NODES = 4000
_NO_LIST = own("The steps can't be read: another value is in the place of their list")


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
    """Which scan a result is of"""

    # The scan is stored by name and key, since a pointer would keep a deleted scan in the file.

    key: StringProperty()
    scan_key: StringProperty()
    scan_name: StringProperty()
    made: StringProperty()  # digest of a result after Mesh; see result.py
    named: StringProperty()  # name of a result after Mesh
    placed: StringProperty()  # transform of a result after Mesh, as JSON
    unrendered: StringProperty()  # not empty: hidden in renders by the add-on, not by the user


def load(obj):
    """Return the recipe of the regions on the object: empty if it has none, None if it can't be read."""
    return read(obj).recipe


def numbers(obj) -> dict:
    """Return the readable numbers of the last step."""
    return read(obj).numbers


def read(obj) -> stored.Stored:
    """Return the stored data of the regions on the object. It never raises, also for a damaged file."""
    return _read(obj.data, mesh_io.state_of(obj))


def kept(obj):
    """Return the recipe of the layers that were renamed last, if it is readable and differs from the present one."""
    state = unread_layers.last_state(obj)
    recipe = _read(obj.data, state).recipe if state else None
    return recipe if recipe is not None and recipe != load(obj) else None


def _read(mesh, state: int) -> stored.Stored:
    current, key = runtime.get(), (mesh.name_full, state)
    if key not in current.stored:
        found = _Nodes(mesh)
        known = stored.Stored(None, problem=said(_NO_LIST)) if found.are_lost and key[1] else None
        known = known or stored.read(key[1], found.node, current.recipes.get(key))
        current.stored[key], current.recipes[key] = known, known.recipe
    return current.stored[key]


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
        found = raw_properties.nodes(mesh)
        self.are_lost = found is None
        self._found = found or []
        self.ids = [_id(node.get("name")) for node in self._found]
        self.places = {at: place for place, at in reversed(list(enumerate(self.ids)))}  # first place of each id

    def node(self, state: int):
        """Return (parent, step, numbers); None if there is no such node, or it is malformed."""
        place = self.places.get(state)
        return runtime.get().nodes.get(state) if place is None else stored.node_from(self._found[place])

    def suits(self, state: int, parent: int, step: str) -> bool:
        """Return whether an id belongs to this step, or is free for it."""
        node = self.node(state)
        return node[:2] == (parent, step) if node is not None else state not in self.places


def _id(name) -> int:
    """Return the id in the name of a node; 0, which no node has, if the name has none."""
    is_id = isinstance(name, str) and name.isascii() and name.isdecimal() and len(name) < 12
    return int(name) if is_id and str(int(name)) == name else 0


def save(obj, recipe, step_numbers: dict) -> int:
    """Stores the recipe on the object's mesh. Returns its state, for the layer next to the regions."""
    mesh, memory, text = obj.data, runtime.get().nodes, json.dumps(step_numbers)
    raw_properties.move_foreign(mesh)
    state, fresh = 0, []
    found = _Nodes(mesh)
    for step in (json.dumps(step.to_dict(), sort_keys=True) for step in recipe.steps):
        parent, state = state, _state(found, state, step)
        known = found.node(state) or (parent, step, "")
        if state not in found.places:
            fresh.append((state, known))
        memory[state] = known
    for at, node in fresh:
        item = mesh.isimp.nodes.add()
        item.name, item.parent, item.step, item.numbers = str(at), *node
    mesh.isimp.nodes[_Nodes(mesh).places[state]].numbers = text
    memory[state] = (*memory[state][:2], text)
    forget()
    runtime.get().recipes[mesh.name_full, state] = recipe
    if len(mesh.isimp.nodes) > runtime.get().most_nodes.get(mesh.name_full, MOST_NODES):
        _forget_others(obj, state)
        # Many nodes may have to stay, so the next search waits until their number has doubled.
        runtime.get().most_nodes[mesh.name_full] = max(MOST_NODES, 2 * len(mesh.isimp.nodes))
    return state


def _state(found: _Nodes, parent: int, step: str) -> int:
    """Return the id of a step that follows another."""
    state = zlib.crc32(f"{parent} {step}".encode()) & 0x7FFFFFFF
    while not state or not found.suits(state, parent, step):
        state = (state + 1) & 0x7FFFFFFF  # another step has this id
    return state


def _forget_others(obj, state: int) -> None:
    """Drops nodes that are not ancestors of the state, of a renamed layer's state or of an unreadable node."""
    mesh, found = obj.data, _Nodes(obj.data)
    good = stored.readable(found.ids, found.node)
    heads = {state, *unread_layers.states(obj), *(at for at in found.ids if at not in good)}
    needed = set()
    while heads:
        at = heads.pop()
        if at and at not in needed:
            needed.add(at)
            heads.add((found.node(at) or (0,))[0])
    for place, at in reversed(list(enumerate(found.ids))):
        if at and at not in needed and place == found.places[at]:
            mesh.isimp.nodes.remove(place)


CLASSES = (IsimpNode, IsimpMesh, IsimpObject)


def register() -> None:
    bpy.types.Mesh.isimp = bpy.props.PointerProperty(type=IsimpMesh)
    bpy.types.Object.isimp = bpy.props.PointerProperty(type=IsimpObject)


def unregister() -> None:
    del bpy.types.Mesh.isimp
    del bpy.types.Object.isimp
