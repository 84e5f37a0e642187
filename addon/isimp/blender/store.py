"""Recipe <-> mesh, so that undo, save, load, duplicate and append can't part them.

Every step is a node: its parent, its settings, its numbers. A node's id is a hash of its parent and its settings, so
the id of the last step stands for the whole recipe: the *state*. The state is kept in a face layer of the mesh, beside
the regions it led to; nodes are kept in a property of the mesh and never changed, only added.

Undo in edit mode restores the layers but no properties. As the state is in a layer, it is always that of the regions
seen; as nodes are only added, the property still knows it. Undo past the start of edit mode and redo can leave the
property behind; the copy in memory bridges that.
"""

import json
import zlib

import bpy
from bpy.props import CollectionProperty, IntProperty, StringProperty

from .. import recipe as rcp
from . import mesh_io, runtime

MOST_NODES = 4000


class IsimpNode(bpy.types.PropertyGroup):
    """A step of a recipe; `name` is its id"""

    parent: IntProperty()
    step: StringProperty()
    numbers: StringProperty()


class IsimpMesh(bpy.types.PropertyGroup):
    """What iSimp keeps on a mesh"""

    nodes: CollectionProperty(type=IsimpNode)
    user_color: StringProperty()


class IsimpObject(bpy.types.PropertyGroup):
    """Which scan a result is of"""

    # By name and key, as a pointer would keep a deleted scan in the file.

    key: StringProperty()
    scan_key: StringProperty()
    scan_name: StringProperty()


def load(obj):
    """The recipe that led to the regions on the object: empty if it has none, None if it is not known."""
    return recipe_of(obj.data, mesh_io.state_of(obj))


def numbers(obj) -> dict:
    """What the last step did."""
    node = _node(obj.data, mesh_io.state_of(obj))
    return json.loads(node[2]) if node and node[2] else {}


def recipe_of(mesh, state: int):
    known = runtime.get().recipes
    if state not in known:
        steps = []
        at = state
        while at:
            node = _node(mesh, at)
            if node is None:
                return None
            steps.append(rcp.step_from_dict(json.loads(node[1])))
            at = node[0]
        known[state] = rcp.Recipe(tuple(reversed(steps)))
    return known[state]


def save(obj, recipe, step_numbers: dict) -> int:
    """Keeps the recipe on the object's mesh. Returns its state, for the layer beside the regions."""
    mesh = obj.data
    parent = 0
    for step in recipe.steps:
        parent = _add_node(mesh, parent, json.dumps(step.to_dict(), sort_keys=True))
    text = json.dumps(step_numbers)
    _set_numbers(mesh, parent, text)
    runtime.get().recipes[parent] = recipe
    if len(mesh.isimp.nodes) > MOST_NODES:
        _forget_others(mesh, parent)
    return parent


def _node(mesh, state: int):
    """(parent, step, numbers) or None."""
    item = mesh.isimp.nodes.get(str(state))
    if item is not None:
        return item.parent, item.step, item.numbers
    return runtime.get().nodes.get(state)


def _add_node(mesh, parent: int, step: str) -> int:
    state = zlib.crc32(f"{parent} {step}".encode()) & 0x7FFFFFFF
    while True:
        node = _node(mesh, state)
        if state and (node is None or node[:2] == (parent, step)):
            break
        state = (state + 1) & 0x7FFFFFFF  # taken by another step
    if mesh.isimp.nodes.get(str(state)) is None:
        item = mesh.isimp.nodes.add()
        item.name, item.parent, item.step = str(state), parent, step
        if node is not None:
            item.numbers = node[2]
    runtime.get().nodes.setdefault(state, (parent, step, ""))
    return state


def _set_numbers(mesh, state: int, text: str) -> None:
    item = mesh.isimp.nodes[str(state)]
    item.numbers = text
    runtime.get().nodes[state] = (item.parent, item.step, text)


def _forget_others(mesh, state: int) -> None:
    """Drops the nodes that do not lead to the state."""
    needed = set()
    while state:
        needed.add(str(state))
        state = mesh.isimp.nodes[str(state)].parent
    for index in range(len(mesh.isimp.nodes) - 1, -1, -1):
        if mesh.isimp.nodes[index].name not in needed:
            mesh.isimp.nodes.remove(index)


CLASSES = (IsimpNode, IsimpMesh, IsimpObject)


def register() -> None:
    bpy.types.Mesh.isimp = bpy.props.PointerProperty(type=IsimpMesh)
    bpy.types.Object.isimp = bpy.props.PointerProperty(type=IsimpObject)


def unregister() -> None:
    del bpy.types.Mesh.isimp
    del bpy.types.Object.isimp
