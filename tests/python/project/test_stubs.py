"""The typed stub has the compiled module's names, members and parameters, and all of these are documented."""

import ast
import re
from pathlib import Path

import pytest

import isimp_engine as engine
from isimp_engine import _core, regions, texturing

ROOT = Path(__file__).resolve().parents[3]
STUB = ast.parse((ROOT / "python/isimp_engine/_core.pyi").read_text())
CLASSES = [node for node in STUB.body if isinstance(node, ast.ClassDef) and not node.name.startswith("_")]
FUNCTIONS = [node for node in STUB.body if isinstance(node, ast.FunctionDef) and not node.name.startswith("_")]


def public(names):
    return {name for name in names if not name.startswith("_")}


def test_the_stub_and_the_package_have_the_modules_names():
    named = {node.name for node in CLASSES + FUNCTIONS}
    assert named == public(vars(_core))
    private = set(regions.__all__) | {"corner_sources", "read_polygons", "uv_islands"}
    of_python = set(texturing.__all__) | {"RecipeError", "Result", "__version__", "convex_parts", "simplify"}
    assert (named | of_python) - private == set(engine.__all__)
    for name in named - private - {"read", "write"}:  # the package's take more kinds of files
        assert getattr(engine, name) is getattr(_core, name)


@pytest.mark.parametrize("node", CLASSES, ids=lambda node: node.name)
def test_a_class_of_the_stub_has_the_members_of_the_real_one(node):
    members = {item.name for item in node.body if isinstance(item, ast.FunctionDef)}
    members |= {item.target.id for item in node.body if isinstance(item, ast.AnnAssign)}
    real = getattr(_core, node.name)
    earlier = set(real.gone()) if hasattr(real, "gone") else set()
    assert public(members) == public(vars(real)) - earlier
    assert real.__doc__
    for name in public(members):
        assert getattr(real, name).__doc__, f"{node.name}.{name} says nothing of itself"


@pytest.mark.parametrize("node", FUNCTIONS, ids=lambda node: node.name)
def test_a_function_of_the_stub_has_the_parameters_of_the_real_one(node):
    """pybind11 writes the signature into the first line: `name(first: type, second: type = default) -> type`."""
    signature, *text = getattr(_core, node.name).__doc__.splitlines()
    names = re.findall(r"(\w+): ", re.sub(r"= \w+\([^()]*\)", "= ...", signature))
    assert names == [argument.arg for argument in node.args.args + node.args.kwonlyargs]
    assert signature.count(" = ") >= len(node.args.defaults)
    assert any(text)


def test_files_made_from_the_table_of_options_are_up_to_date(generate):
    assert generate.with_classes(generate.STUB.read_text()) == generate.STUB.read_text(), "run scripts/generate.py"
    assert generate.data() == generate.DATA.read_text(), "run scripts/generate.py"
