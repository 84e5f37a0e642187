"""Options of features that only earlier versions have: they are accepted with a warning, and have no effect."""

import json
import warnings

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
from isimp_engine import recipe as rcp
from isimp_engine.cli import main

NOTE = "has no effect: this version of iSimp does not have it"
OLD = {
    "isimp_recipe": 1,
    "steps": [
        {"step": "partition", "proxies": 6, "symmetry": "found"},
        {"step": "regularise", "even_spacing": True, "merge_islands": 0.1},
        {"step": "mesh"},
    ],
}


@pytest.fixture(scope="module")
def cube():
    return shapes.cube(4)


@pytest.fixture
def scan(tmp_path, cube):
    path = tmp_path / "scan.obj"
    meshfiles.obj(path, *cube)
    return path


@pytest.mark.parametrize(
    ("kind", "name", "value"),
    [
        (engine.PartitionOptions, "symmetry", "x"),
        (engine.RegulariseOptions, "even_spacing", True),
        (engine.RegulariseOptions, "merge_islands", 0.5),
        (engine.TextureOptions, "height", True),
    ],
)
def test_fields_are_accepted_with_a_warning(kind, name, value):
    without = kind.gone()[name]
    with pytest.warns(UserWarning, match=f"{kind.__name__}.{name} {NOTE}"):
        made = kind(**{name: value})
    assert made == kind()
    with pytest.warns(UserWarning, match=NOTE):
        setattr(made, name, value)
    assert getattr(made, name) == without
    assert name not in made.as_dict()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        kind(**{name: without})


def test_simplify_gives_the_result_without_it(cube):
    plain = engine.simplify(cube, proxies=6)
    with pytest.warns(UserWarning, match=f"symmetry {NOTE}"):
        made = engine.simplify(cube, proxies=6, symmetry="x")
    np.testing.assert_array_equal(made.polygons.loops, plain.polygons.loops)


def test_a_recipe_is_done_without_it_and_names_each():
    recipe = rcp.Recipe.from_values(OLD)
    assert [text.partition(" has ")[0] for text in recipe.gone] == [
        "step 1: symmetry",
        "step 2: even_spacing",
        "step 2: merge_islands",
    ]
    assert "symmetry" not in recipe.to_json()
    assert rcp.Recipe.from_json(recipe.to_json()).gone == ()
    off = {"isimp_recipe": 1, "steps": [{"step": "partition", "symmetry": "none"}]}
    assert rcp.Recipe.from_values(off).gone == ()


def test_the_report_has_the_notes_of_the_recipe(cube):
    found = engine.simplify(cube, recipe=OLD).report["partition"]["warnings"]
    assert sum(NOTE in text for text in found) == 3


def test_the_command_takes_old_flags_and_recipes(scan, tmp_path, capsys):
    out, recipe = tmp_path / "out.obj", tmp_path / "recipe.json"
    recipe.write_text(json.dumps(OLD))
    flags = ["--regularise", "--even-spacing", "--merge-islands", "0.1", "--symmetry", "x"]
    assert main(["simplify", str(scan), str(out), "--proxies", "6", "--quiet", *flags]) == 0
    said = capsys.readouterr().err.splitlines()
    assert [line.split()[1] for line in said] == ["--even-spacing", "--merge-islands", "--symmetry"]
    assert main(["simplify", str(scan), str(out), "--recipe", str(recipe)]) == 0
    assert capsys.readouterr().out.count(NOTE) == 3
    with pytest.raises(SystemExit):
        main(["simplify", "--help"])
    assert "--symmetry" not in capsys.readouterr().out
