"""Damaged and future forms of the data that the add-on stores with a scan; and panels to read."""

import random
from types import SimpleNamespace

import bpy
import numpy as np

from isimp.blender import panel

LATER = '{"step": "future_step", "strength": 2}'


def home(block):
    """The place of properties that add-ons register: since Blender 5.0 not among the custom properties."""
    return block.bl_system_properties_get(do_create=True) if hasattr(block, "bl_system_properties_get") else block


def put(group, name, value):
    """Sets a property to a value of any type: Blender 5.0 changes the type of none that is there."""
    if group.get(name) is not None:
        del group[name]
    group[name] = value


def nodes(mesh):
    """The nodes as they lie in the file, of any kind."""
    return home(mesh)["isimp"]["nodes"]


def plain(value):
    """A custom property's value in Python."""
    if hasattr(value, "to_dict"):
        return {name: plain(inner) for name, inner in value.items()}
    if hasattr(value, "to_list") or isinstance(value, list):
        return [plain(inner) for inner in value]
    return value


def dump(block):
    """All data in the place of the add-on's properties."""
    return plain(home(block).get("isimp"))


def kept(block) -> list:
    """Return all data that the add-on has moved to another name."""
    return [plain(block[name]) for name in block.keys() if name.startswith("isimp.kept")]  # noqa: SIM118


def last(mesh):
    state = str(mesh.attributes[".isimp_state"].data[0].value)
    return next(node for node in nodes(mesh) if node["name"] == state)


def set_last(**values):
    """Sets other values of any type in the last step's node."""

    def damage(scan):
        for name, value in values.items():
            put(last(scan.data), name, value)

    return damage


def self_parent(scan):
    node = last(scan.data)
    node["parent"] = int(node["name"])


def circle(scan):
    node = last(scan.data)
    before = next(other for other in nodes(scan.data) if other["name"] == str(node["parent"]))
    before["parent"] = int(node["name"])


def long_chain(scan):
    chain = [{"name": str(at), "parent": at + 1, "step": '{"step": "add_proxy", "face": 1}'} for at in range(1, 30_000)]
    put(home(scan.data)["isimp"], "nodes", chain)
    write(scan.data.attributes[".isimp_state"], 1)


def write(layer, value):
    layer.data.foreach_set("value", np.full(len(layer.data), value))


def of_kind(name, kind, domain):
    """Puts a layer of another kind in the place of one of the add-on's."""

    def damage(scan):
        scan.data.attributes.remove(scan.data.attributes[name])
        layer = scan.data.attributes.new(name, kind, domain)
        if kind in {"FLOAT", "INT"}:
            write(layer, 7)

    return damage


def with_value(name, value):
    return lambda scan: write(scan.data.attributes[name], value)


def in_place(value):
    """Puts something else in the place of all that is kept on the mesh."""

    def damage(scan):
        put(home(scan.data), "isimp", value)

    return damage


def no_nodes(scan):
    del home(scan.data)["isimp"]["nodes"]


def nodes_are(value):
    def damage(scan):
        put(home(scan.data)["isimp"], "nodes", value)

    return damage


#: {name: (damage, the line of text)}; with any of these the steps can't be read
UNREADABLE = {
    "its own parent": (self_parent, "form a circle"),
    "a circle of two": (circle, "form a circle"),
    "a chain of 30,000": (long_chain, "more than 20,000"),
    "a parent that is missing": (set_last(parent=77), "a step before the last 1 is missing"),
    "a parent below 0": (set_last(parent=-77), "a step before the last 1 is missing"),
    "a parent that is text": (set_last(parent="1"), "The steps of these regions are unknown"),
    "a parent that is a fraction": (set_last(parent=1.5), "The steps of these regions are unknown"),
    "a step of a later version": (set_last(step=LATER), "step 2: 'future_step' is not a step of this version"),
    "a setting of a later version": (
        set_last(step='{"step": "add_proxy", "how": 2}'),
        "add_proxy has no setting 'how'",
    ),
    "broken JSON": (set_last(step='{"step": "add_pro'), "step 2 is not a step: it is not JSON"),
    "deep JSON": (set_last(step="[" * 200_000), "step 2 is not a step: its brackets are nested too deeply"),
    "a huge number": (
        set_last(step='{"step": "add_proxy", "face": 1e999}'),
        "face of add_proxy must be a whole number, got inf",
    ),
    "a number beyond 32 bits": (
        set_last(step='{"step": "add_proxy", "face": 4294967296}'),
        "must be at most 2147483647",
    ),
    "NaN": (set_last(step='{"step": "partition", "detail": NaN}'), "detail must be in (0, 1], got nan"),
    "half a letter": (
        set_last(step='{"step": "partition", "weights": "\\ud800"}'),
        "contains characters that are not valid in a name",
    ),
    "a step that is a number": (set_last(step=7), "The steps of these regions are unknown"),
    "a step that is bytes": (set_last(step=b"\xff\xfe"), "The steps of these regions are unknown"),
    "a name that is a number": (set_last(name=3), "The steps of these regions are unknown"),
    "no nodes": (no_nodes, "The steps of these regions are unknown"),
    "nodes that are a number": (nodes_are(5), "another value is in the place of their list"),
    "nodes that are numbers": (nodes_are([1, 2, 3]), "another value is in the place of their list"),
    "nodes that are one": (nodes_are({"name": "1"}), "another value is in the place of their list"),
    "a number in place of all": (in_place(5), "another value is in the place of their list"),
    "text in place of all": (in_place("later"), "another value is in the place of their list"),
    "a state below 0": (with_value(".isimp_state", -5), "The steps of these regions are unknown"),
    "the largest state": (with_value(".isimp_state", 2**31 - 1), "The steps of these regions are unknown"),
    "a state of fractions": (of_kind(".isimp_state", "FLOAT", "FACE"), "'.isimp_state' is no layer of iSimp's"),
    "a state of points": (of_kind(".isimp_state", "INT", "POINT"), "'.isimp_state' is no layer of iSimp's"),
    "a state of colours": (of_kind(".isimp_state", "FLOAT_COLOR", "CORNER"), "'.isimp_state' is no layer of iSimp's"),
}
#: with these the steps are read; the other fault does no harm
READABLE = {
    "numbers that are none": set_last(numbers="[" * 100_000),
    "numbers of other types": set_last(
        numbers='{"regions": "x", "failed": 1, "polygons": [], "error": NaN, "seconds": 1e999}'
    ),
    "a reason of many lines": set_last(numbers='{"failed": 1, "reason": "a\\nb' + "c" * 10**5 + '\\ud800"}'),
    "regions of fractions": of_kind("isimp_region", "FLOAT", "FACE"),
    "regions of points": of_kind("isimp_region", "INT", "POINT"),
    "regions that are huge": with_value("isimp_region", 2**31 - 1),
    "regions below none": with_value("isimp_region", -(2**31)),
    "colours of points": of_kind("isimp_color", "BYTE_COLOR", "POINT"),
    "no colours": lambda scan: scan.data.attributes.remove(scan.data.attributes["isimp_color"]),
    "a shown colour that is a number": lambda scan: put(home(scan.data)["isimp"], "user_color", 7),
}


def at_random(draw: random.Random, mesh) -> None:
    """Damages the nodes of a mesh somehow."""
    values = [
        0,
        1,
        -1,
        2**31 - 1,
        1.5,
        float("nan"),
        "",
        "1",
        LATER,
        "{",
        "[" * 2000,
        b"\xff",
        [1, 2],
        [1.5],
        {"a": 1},
        [],
    ]
    found = nodes(mesh)
    ids = [int(node["name"]) for node in found]
    for _ in range(draw.randrange(1, 4)):
        node = draw.choice(found)
        kind = draw.randrange(6)
        if kind == 0:
            put(node, "parent", draw.choice(ids))
        elif kind == 1:
            text = str(node.get("step"))
            at = draw.randrange(len(text) + 1)
            put(node, "step", text[:at] + draw.choice(["", "x", "}", "9" * 30]) + text[at + draw.randrange(4) :])
        elif kind == 2:
            put(node, "name", draw.choice(["0", "-1", "x", "", str(draw.choice(ids)), "00" + str(ids[0])]))
        else:
            put(node, draw.choice(["parent", "step", "numbers", "name", "more"]), draw.choice(values))
    if draw.random() < 0.05:
        put(home(mesh), "isimp", draw.choice(values))


class Layout:
    """A replacement for a panel's layout that stores its texts."""

    operator_context = "INVOKE_DEFAULT"  #: Blender reads it where something was appended to a panel

    def __init__(self, said):
        self.said = said

    def label(self, text="", icon="NONE"):
        text.encode()  # else Blender can't show it
        self.said.append(text)

    def prop(self, data, name, **_):
        getattr(data, name)

    def prop_enum(self, data, name, value, text, text_ctxt):
        getattr(data, name)
        self.said.append(text)

    def menu(self, name, text="", **_):
        self.said.append(text)

    popover = menu

    def separator(self):
        pass

    def operator(self, name, text="", **_):
        self.said.append(text)
        return SimpleNamespace(bl_rna=getattr(bpy.ops.isimp, name.removeprefix("isimp.")).get_rna_type())

    def row(self, **_):
        return Layout(self.said)

    column = box = split = grid_flow = row


def panels() -> str:
    """The texts of all panels that are shown now, in a line."""
    said = []
    for cls in panel.CLASSES:
        layout = Layout(said)
        if not hasattr(cls, "poll") or cls.poll(bpy.context):
            cls.draw(SimpleNamespace(layout=layout, prepare=lambda context, layout=layout: layout), bpy.context)
    return " ".join(said).replace("\N{NO-BREAK SPACE}", " ")


def operators() -> dict:
    """The operators of the add-on that can be called now."""
    return {name: getattr(bpy.ops.isimp, name).poll() for name in dir(bpy.ops.isimp)}
