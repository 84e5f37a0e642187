"""Panels and menus drawn without a window."""

import bpy


class Recorder:
    """A layout that records everything drawn on it: texts, and controls by kind and name.

    made: the buttons, and whether each is lit; buttons: the last ones of each operator and of each text.
    """

    def __init__(self, drawn):
        for name, value in {"drawn": drawn, "made": [], "buttons": {}}.items():
            object.__setattr__(self, name, value)

    def __setattr__(self, name, value):
        pass

    def __getattr__(self, name):
        if name in {"row", "column", "split", "box", "grid_flow", "column_flow", "menu_pie"}:
            return lambda *_, **__: self
        if name in {"separator", "template_icon"}:
            return lambda *_, **__: None
        raise AttributeError(name)

    def label(self, text="", **_):
        assert isinstance(text, str), f"no text: {text!r}"
        self.drawn.append(("label", text))

    def operator(self, name, text="", depress=False, **_):
        assert isinstance(text, str), f"no text: {text!r}"
        self.drawn.append(("operator", text or name))
        group, operator = name.split(".")
        made = Settable(getattr(getattr(bpy.ops, group), operator).get_rna_type())
        self.made.append((made, depress))
        self.buttons.update({name: made, text: made})
        return made

    def prop(self, data, name, text="", **_):
        assert name in data.bl_rna.properties, name
        assert isinstance(text, str), f"no text: {text!r}"
        self.drawn.append(("prop", name))

    def prop_enum(self, data, name, value, **_):
        self.drawn.append(("prop", f"{name} {value}"))

    def menu(self, name, **_):
        assert hasattr(bpy.types, name), name
        self.drawn.append(("menu", name))

    def popover(self, name, **_):
        assert hasattr(bpy.types, name), name
        self.drawn.append(("popover", name))


class Settable:
    """A button whose operator has all properties that are set."""

    def __init__(self, rna):
        object.__setattr__(self, "bl_rna", rna)
        object.__setattr__(self, "values", {})

    def __setattr__(self, name, value):
        assert self.bl_rna.properties.find(name) >= 0, f"no property {name}"
        self.values[name] = value


def controls(*classes):
    """The controls that panels and menus draw, as (kind, name); none where they are not to be seen."""
    drawn = []
    for cls in classes:
        if not hasattr(cls, "poll") or cls.poll(bpy.context):
            layout = Recorder(drawn)
            cls.draw(type("Drawn", (), {"layout": layout, "prepare": lambda self, context: self.layout})(), bpy.context)
    return [each for each in drawn if each[0] != "label"]
