"""docs/api.md is the output of scripts/api_docs.py for the module's docstrings."""

import re
from pathlib import Path

import pytest

import isimp_engine as engine
from conftest import script

ROOT = Path(__file__).parents[3]
api_docs = script("api_docs")


@pytest.fixture(scope="module")
def page():
    return api_docs.page()


def test_the_page_is_up_to_date(page):
    written = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    assert written == page, "the docstrings have changed: run scripts/api_docs.py"


def test_the_page_has_a_section_for_every_public_name(page):
    titles = re.findall(r"^### (\w+)$", page, re.MULTILINE)
    assert set(engine.__all__) - {"__version__"} <= set(titles)
    assert re.search(r"### PartitionOptions\n(?s:.*?)\| `leave_out` \| `0.001` \| ", page)
    assert "`partition(mesh, options=..., *, job=None, weights=None, barriers=None)`" in page


@pytest.mark.parametrize(
    ("signature", "names"),
    [
        ("f(a: m.Mesh, b: SupportsInt | SupportsIndex = 3) -> int", "(a, b=3)"),
        ("f(self: m.Job, *, a: m.Options = Options(x=1, y='z'), b: str = 'cpu') -> None", "(*, a=..., b='cpu')"),
        ("f() -> list[str]", "()"),
    ],
)
def test_signatures_of_compiled_functions_are_shortened(signature, names):
    assert api_docs.compiled_parameters(f"{signature}\n\nText.") == names
