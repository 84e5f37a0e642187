"""The typed stub has the compiled module's names, members and parameters, and all of these are documented."""

import ast
import re
from pathlib import Path

import pytest

import isimp_engine as engine
from isimp_engine import _core, texturing

ROOT = Path(__file__).resolve().parents[3]
STUB = ast.parse((ROOT / "python/isimp_engine/_core.pyi").read_text())
CLASSES = [node for node in STUB.body if isinstance(node, ast.ClassDef) and not node.name.startswith("_")]
FUNCTIONS = [node for node in STUB.body if isinstance(node, ast.FunctionDef)]


def public(names):
    return {name for name in names if not name.startswith("_")}


def test_the_stub_and_the_package_have_the_modules_names():
    named = {node.name for node in CLASSES + FUNCTIONS}
    assert named == public(vars(_core))
    assert named | {"__version__"} | set(texturing.__all__) | {"Result", "simplify"} == set(engine.__all__)
    for name in named - {"read", "read_polygons", "write"}:  # the package's take more kinds of files
        assert getattr(engine, name) is getattr(_core, name)


@pytest.mark.parametrize("node", CLASSES, ids=lambda node: node.name)
def test_a_class_of_the_stub_has_the_members_of_the_real_one(node):
    members = {item.name for item in node.body if isinstance(item, ast.FunctionDef)}
    members |= {item.target.id for item in node.body if isinstance(item, ast.AnnAssign)}
    real = getattr(_core, node.name)
    assert public(members) == public(vars(real))
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


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("explode_round", "release_round"),
        ("with_segments", "set_segments"),
        ("patch_of", "round_part_at"),
        ("separated_faces", "barrier_faces"),
    ],
)
def test_earlier_names_work_and_name_the_new_ones(old, new):
    with pytest.warns(DeprecationWarning, match=f"{old} is now {new}"):
        assert getattr(engine, old) is getattr(engine, new)
    assert old not in engine.__all__
    with pytest.raises(AttributeError, match="no attribute 'no_such_name'"):
        engine.no_such_name  # noqa: B018
