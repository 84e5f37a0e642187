"""The promise of CONTRIBUTING.md: two places of a header make an option. Its use and its row in the panel are left."""

import importlib.util
import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import isimp_engine as engine
from isimp_engine.cli.command import parser

ROOT = Path(__file__).resolve().parents[3]
HEADERS = ROOT / "native" / "include"
RECIPE = ROOT / "python" / "isimp_engine" / "recipe"
ABOUT = "How crisp it is."
#: by class of options: its header, and the member and the row before which the new ones are inserted
CASES = {
    engine.PartitionOptions: ("partition/options.h", "  double leave_out = ", '      field("leave_out"'),
    engine.RegulariseOptions: ("regular/regularise.h", "  Up up = ", '      choice("up"'),
}
MAIN = """
#include <iostream>
#include "isimp/partition/options.h"
#include "isimp/regular/regularise.h"

template <class Options>
void show() {
  Options options;
  std::cout << options.crispness << std::endl;
  options.crispness = 2;
  try {
    isimp::check_fields(options);
  } catch (const isimp::InvalidInput& error) {
    std::cout << error.what() << std::endl;
  }
}

int main() {
  show<isimp::PartitionOptions>();
  show<isimp::RegulariseOptions>();
}
"""


def insert(path, before, line):
    text = path.read_text()
    assert text.count(before) == 1
    path.write_text(text.replace(before, line + before))


def test_two_places_in_a_header_give_a_checked_option(tmp_path):
    compiler = shutil.which("c++")
    eigen = Path("/usr/include/eigen3")
    if compiler is None or not eigen.is_dir():
        pytest.skip("there is no compiler here, or no Eigen")
    shutil.copytree(HEADERS, tmp_path / "include")
    for name, member, row in CASES.values():
        header = tmp_path / "include" / "isimp" / name
        insert(header, member, "  double crispness = 0.5;\n")
        text = f'field("crispness", &O::crispness, between(0, 1), Unit::none, "{ABOUT}").shown("Crisp", "{ABOUT}")'
        insert(header, row, f"      {text},\n")
    (tmp_path / "main.cpp").write_text(MAIN)
    command = [compiler, "-std=c++20", f"-I{tmp_path / 'include'}", f"-I{eigen}"]
    command += [str(tmp_path / "main.cpp"), "-o", str(tmp_path / "main")]
    subprocess.run(command, check=True, timeout=120)
    said = subprocess.run([tmp_path / "main"], check=True, capture_output=True, text=True, timeout=10).stdout
    assert said == 2 * "0.5\ncrispness must be in [0, 1], got 2\n"


@pytest.fixture
def crisp(monkeypatch):
    """The engine's tables as the bindings make them once the headers have the number."""
    row = {"name": "crispness", "type": "float", "default": 0.5, "least": 0.0, "most": 1.0, "range": "in [0, 1]"}
    row |= {"label": "Crisp", "tip": "How crisp it is"}
    like = next(field for field in engine.PartitionOptions.fields() if field["name"] == "smooth")
    assert set(row) <= set(like)
    for kind in CASES:
        table = [*kind.fields(), like | row]
        monkeypatch.setattr(kind, "fields", staticmethod(lambda table=table: table))
        monkeypatch.setattr(kind, "crispness", property(doc=ABOUT), raising=False)


@pytest.fixture
def crisp_recipes(crisp, generate, monkeypatch, tmp_path):
    """The recipes with the files that are made of such tables, and no other change."""
    folder = tmp_path / "crisp_recipes"
    shutil.copytree(RECIPE, folder)
    (folder / generate.DATA.name).write_text(generate.data())
    (folder / generate.FIELDS.name).write_text(generate.fields())
    spec = importlib.util.spec_from_file_location("crisp_recipes", folder / "__init__.py")
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "crisp_recipes", module)
    spec.loader.exec_module(module)
    yield module
    for name in [name for name in sys.modules if name.startswith("crisp_recipes.")]:
        del sys.modules[name]


def test_the_table_makes_the_stub(crisp, generate):
    for kind in CASES:
        stub = generate.stub_of(kind)
        assert "    crispness: float\n" in stub
        assert "        crispness: float = ...,\n" in stub


@pytest.mark.parametrize("kind", CASES, ids=lambda kind: kind.__name__)
def test_the_table_makes_the_flag(crisp, kind, monkeypatch, capsys):
    other = next(each for each in CASES if each is not kind)
    fields = [field for field in other.fields() if field["name"] != "crispness"]
    monkeypatch.setattr(other, "fields", staticmethod(lambda: fields))
    assert parser().parse_args(["simplify", "a.ply", "b.ply", "--crispness", "0.25"]).crispness == 0.25
    with pytest.raises(SystemExit):
        parser().parse_args(["simplify", "--help"])
    assert ABOUT in capsys.readouterr().out


@pytest.mark.parametrize(("step", "table"), [("Partition", "PARTITION"), ("Regularise", "REGULARISE")])
def test_steps_have_the_setting_check_it_and_give_it_to_the_engine(crisp_recipes, step, table):
    cls, options = getattr(crisp_recipes, step), getattr(crisp_recipes, table)
    assert (options["crispness"].label, options["crispness"].tip) == ("Crisp", "How crisp it is")
    made = cls(crispness=0.75)
    assert crisp_recipes.engine_options(made, options)["crispness"] == 0.75
    text = crisp_recipes.Recipe((made,)).to_json()
    assert json.loads(text)["steps"][0]["crispness"] == 0.75
    assert crisp_recipes.Recipe.from_json(text).steps == (made,)
    with pytest.raises(crisp_recipes.RecipeError, match=r"crispness must be in \[0, 1\], got 2"):
        cls(crispness=2.0)
