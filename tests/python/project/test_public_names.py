"""The public names are few, on the page of the API and in an example. Names of before work, with a warning."""

import inspect
import re
import sys
from pathlib import Path

import pytest

import isimp_engine as engine
from isimp_engine import batch, reading, regions, texturing, tiles

ROOT = Path(__file__).resolve().parents[3]
MOST = 60
NAMES = [(module, name) for module in (engine, batch, tiles) for name in module.__all__]


def test_there_are_few():
    on_the_page = [name for _, name in NAMES if name != "__version__"]
    assert len(on_the_page) <= MOST, "make another name private first, or say in docs/api.md why there are more"


def test_the_page_of_the_api_has_exactly_these():
    page = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    assert re.findall(r"^## (isimp_engine.*)$", page, re.MULTILINE) == [batch.__name__, tiles.__name__]
    titles = re.findall(r"^### (\w+)$", page, re.MULTILINE)
    assert sorted(titles) == sorted(name for _, name in NAMES if name != "__version__")


def test_each_is_used_in_an_example():
    pages = [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]
    blocks = [re.findall(r"^```python\n(.*?)^```", page.read_text("utf-8"), re.MULTILINE | re.DOTALL) for page in pages]
    code = "\n".join(text for found in blocks for text in found)
    for module, name in NAMES:
        of = "engine" if module is engine else module.__name__.rpartition(".")[2]
        assert re.search(rf"\b{of}\.{name}\b", code), f"docs/python.md has no use of {of}.{name}"


def test_a_job_is_a_keyword():
    for module, name in NAMES:
        function = getattr(module, name)
        if inspect.isfunction(function) and (job := inspect.signature(function).parameters.get("job")):
            assert job.kind is inspect.Parameter.KEYWORD_ONLY, name


@pytest.mark.parametrize(
    ("package", "old", "thing", "said"),
    [
        (engine, "explode_round", engine.release_round, "is now isimp_engine.release_round"),
        (engine, "with_segments", engine.set_segments, "is now isimp_engine.set_segments"),
        (engine, "patch_of", regions.round_part_at, "isimp_engine.regions.round_part_at"),
        (engine, "separated_faces", regions.barrier_faces, "isimp_engine.regions.barrier_faces"),
        (engine, "region_fits", regions.region_fits, "private from the next version on"),
        (engine, "uv_islands", texturing.uv_islands, "private from the next version on"),
        (engine, "read_polygons", reading.read_polygons, "private from the next version on"),
        (batch, "read_rows", batch.table.read_rows, "isimp_engine.batch.table.read_rows"),
        (batch, "Ending", engine.children.process.Ending, "isimp_engine.children.process.Ending"),
        (tiles, "Outcome", sys.modules["isimp_engine.tiles.run"].Outcome, "isimp_engine.tiles.run.Outcome"),
    ],
)
def test_names_of_before_work(package, old, thing, said):
    with pytest.warns(DeprecationWarning, match=said):
        assert getattr(package, old) is thing
    assert old not in package.__all__


@pytest.mark.parametrize("package", [engine, batch, tiles])
def test_a_name_that_was_never_there_is_missing(package):
    with pytest.raises(AttributeError, match="no attribute 'no_such_name'"):
        package.no_such_name  # noqa: B018
