"""The promise of CONTRIBUTING.md: a number added in two places of C++ and two of the add-on is an option everywhere."""

import dataclasses
import runpy
import shutil
import subprocess
from pathlib import Path

import pytest

import isimp_engine as engine
from isimp.recipe import steps
from isimp_engine.cli.command import parser

ROOT = Path(__file__).resolve().parents[3]
HEADERS = ROOT / "native" / "include"
ABOUT = "How crisp it is."
MAIN = """
#include <iostream>
#include "isimp/partition/options.h"

int main() {
  isimp::PartitionOptions options;
  std::cout << options.crispness << std::endl;
  options.crispness = 2;
  try {
    isimp::check_fields(options);
  } catch (const isimp::InvalidInput& error) {
    std::cout << error.what() << std::endl;
  }
}
"""


def insert(text, before, line):
    assert text.count(before) == 1
    return text.replace(before, line + before)


def test_two_places_in_a_header_give_a_checked_option(tmp_path):
    compiler = shutil.which("c++")
    eigen = Path("/usr/include/eigen3")
    if compiler is None or not eigen.is_dir():
        pytest.skip("there is no compiler here, or no Eigen")
    shutil.copytree(HEADERS, tmp_path / "include")
    header = tmp_path / "include" / "isimp" / "partition" / "options.h"
    text = insert(header.read_text(), "  double leave_out = ", "  double crispness = 0.5;\n")
    field = f'      field("crispness", &O::crispness, between(0, 1), Unit::none, "{ABOUT}"),\n'
    header.write_text(insert(text, '      field("leave_out"', field))
    (tmp_path / "main.cpp").write_text(MAIN)
    command = [compiler, "-std=c++20", f"-I{tmp_path / 'include'}", f"-I{eigen}"]
    command += [str(tmp_path / "main.cpp"), "-o", str(tmp_path / "main")]
    subprocess.run(command, check=True, timeout=120)
    said = subprocess.run([tmp_path / "main"], check=True, capture_output=True, text=True, timeout=10).stdout
    assert said == "0.5\ncrispness must be in [0, 1], got 2\n"


@pytest.fixture
def crisp(monkeypatch):
    """The engine's table as the bindings make it once the header has the number."""
    row = {"name": "crispness", "type": "float", "default": 0.5, "least": 0.0, "most": 1.0, "range": "in [0, 1]"}
    like = next(field for field in engine.PartitionOptions.fields() if field["name"] == "smooth")
    assert set(row) <= set(like)
    table = [*engine.PartitionOptions.fields(), like | row]
    monkeypatch.setattr(engine.PartitionOptions, "fields", staticmethod(lambda: table))
    monkeypatch.setattr(engine.PartitionOptions, "crispness", property(doc=ABOUT), raising=False)


def test_the_table_makes_stub_flag_and_the_add_ons_copy(crisp, generate, capsys):
    stub = generate.stub_of(engine.PartitionOptions)
    assert "    crispness: float\n" in stub
    assert "        crispness: float = ...,\n" in stub
    assert '    "crispness": Option(\n        kind="float",\n        default=0.5,\n' in generate.data()
    parsed = parser().parse_args(["simplify", "a.ply", "b.ply", "--crispness", "0.25"])
    assert parsed.crispness == 0.25
    with pytest.raises(SystemExit):
        parser().parse_args(["simplify", "--help"])
    assert ABOUT in capsys.readouterr().out


def test_a_field_of_the_step_is_checked_and_reaches_the_engine(crisp, generate, monkeypatch, tmp_path):
    copy = tmp_path / "engine_options.py"
    copy.write_text(generate.data().replace("from .options import Option", "from isimp.recipe.options import Option"))
    made = runpy.run_path(str(copy))
    monkeypatch.setattr(steps, "PARTITION", made["PARTITION"])

    @dataclasses.dataclass(frozen=True)
    class Partition(steps.Partition):
        crispness: float = 0.5

    assert steps.engine_options(Partition(crispness=0.75), made["PARTITION"])["crispness"] == 0.75
    with pytest.raises(steps.RecipeError, match=r"crispness must be in \[0, 1\], got 2"):
        Partition(crispness=2)
