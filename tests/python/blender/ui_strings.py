"""Every fixed text of the add-on's panels, menus, operators, tools and preferences."""

import ast
from pathlib import Path

import bpy

from isimp import blender

_FOLDER = Path(blender.__file__).parent
_DRAWN = ("panel/*.py", "menus.py", "preferences.py", "presets.py", "tools/__init__.py", "start.py", "targets.py")
_BASES = (bpy.types.Operator, bpy.types.Panel, bpy.types.Menu, bpy.types.PropertyGroup, bpy.types.AddonPreferences)
_OWN = {"rna_type", "bl_idname", "filepath", "filter_glob", "remove_name", "remove_active"}


def all_strings() -> set:
    found = set()
    for cls in blender._CLASSES:
        found |= of_class(cls)
    for pattern in _DRAWN:
        for path in _FOLDER.glob(pattern):
            found |= drawn(path)
    for path in _FOLDER.rglob("*.py"):
        found |= said(path)
    theirs = {"iSimp", "Name"}  # the same in all languages, and Blender's own
    return {text for text in found if any(map(str.islower, text)) and text.strip() == text} - theirs


def of_class(cls) -> set:
    found, rnas = {getattr(cls, "bl_label", "")}, [cls.bl_rna]
    if issubclass(cls, bpy.types.Operator):
        rnas.append(getattr(bpy.ops.isimp, cls.bl_idname.split(".")[1]).get_rna_type())
        found.add((cls.__doc__ or "").strip())
    own = vars(cls).get("__annotations__", {})
    inherited = {p.identifier for base in _BASES if issubclass(cls, base) for p in base.bl_rna.properties}
    for rna in rnas:
        for prop in rna.properties:
            if prop.identifier in _OWN or (prop.identifier in inherited and prop.identifier not in own):
                continue
            if prop.name != prop.identifier:
                found |= {prop.name, prop.description}
            if prop.type == "ENUM":
                found |= {text for item in prop.enum_items_static for text in (item.name, item.description)}
    return found - {""}


def drawn(path) -> set:
    """Texts in the source of what is drawn: they begin with a capital letter, names of operators and icons do not."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    skipped = {id(part) for node in ast.walk(tree) if isinstance(node, ast.JoinedStr) for part in ast.walk(node)}
    for node in ast.walk(tree):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)) and ast.get_docstring(node) is not None:
            skipped.add(id(node.body[0].value))
    constants = (node for node in ast.walk(tree) if isinstance(node, ast.Constant) and id(node) not in skipped)
    texts = (node.value for node in constants if isinstance(node.value, str))
    return {text for text in texts if is_text(text)}


def said(path) -> set:
    """Texts that are translated by `text.said`."""
    calls = (node for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(node, ast.Call))
    calls = (call for call in calls if isinstance(call.func, ast.Attribute) and call.func.attr == "said")
    return {part.value for call in calls for part in call.args if isinstance(part, ast.Constant)}


def is_text(text: str) -> bool:
    """Whether it is for people: it begins as a sentence or a numbered line does, and is no name of Blender's."""
    begins = text[:1].isupper() or text[1:3] == ". "
    return begins and any(map(str.islower, text)) and not any(part in text for part in ("_MT_", "_PT_", "3D View"))
