"""The promise of CONTRIBUTING.md for a tool of the add-on: one module, and its rows in tools/__init__.py."""

import ast
import re
from pathlib import Path

import pytest

BLENDER = Path(__file__).resolve().parents[3] / "addon" / "isimp" / "blender"
TOOLBAR = BLENDER / "tools" / "__init__.py"
TEXTS = {path: path.read_text() for path in BLENDER.rglob("*.py")}
TREE = ast.parse(TEXTS[TOOLBAR])
TOOLS = {
    node.name: node
    for node in TREE.body
    if isinstance(node, ast.ClassDef) and [ast.unparse(base) for base in node.bases] == ["_Tool"]
}


def row(name):
    """The value that tools/__init__.py assigns to a name."""
    found = [node for node in TREE.body if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == name]
    return ast.unparse(found[0].value)


def test_each_class_of_a_tool_is_in_the_toolbars():
    assert len(TOOLS) >= 5
    assert re.findall(r"\b_[A-Z]\w+", row("_TOOLS")) == list(TOOLS)
    modules = {path.stem for path in TOOLBAR.parent.glob("*.py") if "\nCLASSES = " in TEXTS[path]} - {"__init__"}
    assert set(re.findall(r"(\w+)\.CLASSES", row("CLASSES"))) == modules


@pytest.mark.parametrize("name", TOOLS)
def test_only_the_toolbar_and_buttons_name_a_tool(name):
    values = {ast.unparse(node.targets[0]): node.value for node in TOOLS[name].body if isinstance(node, ast.Assign)}
    assert {"bl_idname", "bl_label", "bl_description", "bl_icon", "bl_keymap"} <= set(values)
    assert ast.unparse(values["bl_keymap"]).startswith("_with_rest("), "presses that it lacks would select objects"
    tool = ast.literal_eval(values["bl_idname"])
    named = [path for path, text in TEXTS.items() if tool in text]
    assert [path for path in named if path.parent.name != "panel"] == [TOOLBAR], "buttons alone may choose a tool"


def registered(operator):
    """The modules whose CLASSES have the operator."""
    for path, text in TEXTS.items():
        for cls in ast.parse(text).body if f'"{operator}"' in text else ():
            is_made = isinstance(cls, ast.ClassDef) and f"bl_idname = '{operator}'" in ast.unparse(cls)
            if is_made and re.search(rf"\b{cls.name}\b", text.split("\nCLASSES")[1]):
                yield path


@pytest.mark.parametrize("name", TOOLS)
def test_one_module_has_each_operator_of_a_tool(name):
    source = ast.get_source_segment(TEXTS[TOOLBAR], TOOLS[name])
    operators = set(re.findall(r'"(isimp\.(?!\w+_tool")\w+)"', source)) | {
        "isimp.hover",
        "isimp.size_here",
        "isimp.turn",
    }
    assert len(operators) > 3
    for operator in operators:
        assert len(list(registered(operator))) == 1, operator
