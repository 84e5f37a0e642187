"""Every fixed text of the add-on's panels, menus, operators, tools and preferences."""

import ast
import re
from functools import cache
from pathlib import Path

import bpy

from isimp import blender, language, recipe
from isimp.recipe import MESHING, PARTITION, TEXTURE

_FOLDER = Path(blender.__file__).parent
_DRAWN = ("panel/*.py", "menus.py", "preferences.py", "tools/__init__.py")
_DRAWN += ("controls/presets.py", "view/quick_start.py", "scene/targets.py")
_BASES = (bpy.types.Operator, bpy.types.Panel, bpy.types.Menu, bpy.types.PropertyGroup, bpy.types.AddonPreferences)
if hasattr(bpy.types, "FileHandler"):  # Blender 4.1 and later
    _BASES += (bpy.types.FileHandler,)
_SENTENCE = re.compile(r"[a-z]{2,} \W*[a-z{]|[}a-z]\S* [a-z]{2,}")
_OWN = {"rna_type", "bl_idname", "filepath", "filter_glob", "remove_name", "remove_active"}


def sources() -> list:
    """All of the add-on and its recipes, without generated files and, in the packed one, the engine."""
    own = {path for path in _FOLDER.parent.rglob("*.py") if "isimp_engine" not in path.parts}
    own |= set(Path(recipe.__file__).parent.glob("*.py"))
    return sorted(path for path in own if path.name != "engine_options.py")


@cache
def all_strings() -> set:
    found = set()
    for cls in blender._CLASSES:
        found |= of_class(cls)
    for pattern in _DRAWN:
        for path in _FOLDER.glob(pattern):
            found |= drawn(path)
    for path in sources():
        found |= said(path)
    found |= settings()
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
    """Texts in the source of panels: they begin with a capital letter, names of operators and icons do not."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    skipped = {id(part) for node in ast.walk(tree) if isinstance(node, ast.JoinedStr) for part in ast.walk(node)}
    for node in ast.walk(tree):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)) and ast.get_docstring(node) is not None:
            skipped.add(id(node.body[0].value))
    constants = (node for node in ast.walk(tree) if isinstance(node, ast.Constant) and id(node) not in skipped)
    texts = (node.value for node in constants if isinstance(node.value, str))
    return {text for text in texts if is_text(text)}


def said(path) -> set:
    """Texts of messages: arguments of `own` and `said`, and the nouns in `count` and `noun`, singular and plural."""
    found = set()
    for call in _calls(ast.parse(path.read_text(encoding="utf-8"))):
        texts = [part.value for part in call.args if isinstance(part, ast.Constant) and isinstance(part.value, str)]
        found |= set(texts) if _name(call) in {"said", "own"} else {form for one in texts for form in _forms(one)}
    return found


def _calls(tree):
    calls = (node for node in ast.walk(tree) if isinstance(node, ast.Call))
    return [call for call in calls if _name(call) in {"said", "own", "count", "_count", "noun"}]


def _name(call) -> str:
    return call.func.id if isinstance(call.func, ast.Name) else getattr(call.func, "attr", "")


def _forms(one: str) -> set:
    return {f"{{number}} {one}", f"{{number}} {language.plural(one)}"}


def settings() -> set:
    """The rules for the engine's options, as words."""
    words = (option.words for table in (PARTITION, MESHING, TEXTURE) for option in table.values())
    return {text for text in words if re.search("[a-z]{3}", text)}


def unsaid(path) -> list:
    """Sentences in a source that nothing translates: neither a message, nor a fixed text, nor the name of a stage.

    Sentences are strings with two words or more. Texts of `describe` and `described` are for logs and scripts.
    """
    tree, known = ast.parse(path.read_text(encoding="utf-8")), all_strings()
    skipped = {id(part) for call in _calls(tree) for part in ast.walk(call)}
    for node in ast.walk(tree):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)) and ast.get_docstring(node) is not None:
            skipped.add(id(node.body[0].value))
        if isinstance(node, ast.FunctionDef) and node.name == "describe":
            skipped |= {id(part) for part in ast.walk(node)}
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "described":
            skipped.add(id(node.value))
        if isinstance(node, ast.JoinedStr):
            skipped |= {id(part) for part in ast.walk(node) if part is not node}
    found = []
    for node in ast.walk(tree):
        if id(node) in skipped:
            continue
        if isinstance(node, ast.JoinedStr):
            text = "".join(part.value if isinstance(part, ast.Constant) else "{}" for part in node.values)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            text = node.value
        else:
            continue
        is_known = isinstance(node, ast.Constant) and not known.isdisjoint({text, text.capitalize()})
        if _SENTENCE.search(text) and not is_known:
            found.append(text)
    return found


def is_text(text: str) -> bool:
    """Whether it is for people: it begins as a sentence or a numbered line does, and is no name of Blender's."""
    begins = text[:1].isupper() or text[1:3] == ". "
    return begins and any(map(str.islower, text)) and not any(part in text for part in ("_MT_", "_PT_", "3D View"))
