"""The tables of files equal the output of scripts/file_table.py."""

import subprocess
from pathlib import Path

import pytest

from conftest import script

ROOT = Path(__file__).parents[3]
file_table = script("file_table")


@pytest.fixture
def tree(tmp_path, monkeypatch):
    """A repository of its own for the script."""
    monkeypatch.setattr(file_table, "ROOT", tmp_path)
    subprocess.run(["git", "init", "-q", tmp_path], check=True)

    def write(name, text):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    return write


def rows(page):
    return [line for line in page.splitlines() if line.startswith(("| `", "| **"))]


@pytest.mark.skipif(not (ROOT / ".git").exists(), reason="needs a checkout")
@pytest.mark.parametrize("name", ["page", "bench_page"])
def test_the_page_is_up_to_date(name):
    path = {"page": file_table.PAGE, "bench_page": file_table.BENCH}[name]
    written = path.read_text(encoding="utf-8")
    assert written == getattr(file_table, name)(), "files or first sentences have changed: run scripts/file_table.py"


def test_a_header_and_its_source_share_a_row_and_a_public_header_is_bold(tree):
    tree("native/include/isimp/core/job.h", "#pragma once\n/// Progress. More.\nclass Job;\n")
    tree("native/src/core/job.cpp", '#include "isimp/core/job.h"\n/// Other.\nvoid f();\n')
    tree("native/src/core/inner.h", "#pragma once\n\n/// Inner: a part.\nint inner();\n")
    assert rows(file_table.page()) == ["| `inner.h` | Inner: a part |", "| **`job.h`** | Progress |"]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("// Of the file.\n#include <a>\n/// Of f.\nint f();\n", "Of the file"),
        (
            "#include <a>\n/// Of g.\nint g();\n/// Of the class\n/// in two lines. More.\nclass CutWall {};\n",
            "Of the class in two lines",
        ),
        ("#include <a>\n/// Of g (e.g. this).\nint g();\n", "Of g (e.g. this)"),
    ],
)
def test_the_sentence_of_a_source_is_of_the_file_then_of_its_name_then_the_first(tree, text, sentence):
    tree("native/src/meshing/cut_wall.cpp", text)
    assert rows(file_table.page()) == [f"| `cut_wall.cpp` | {sentence} |"]


def test_a_python_file_gives_its_docstring_or_that_of_its_class_and_a_script_its_comment(tree):
    tree("python/a.py", '"""Adds: numbers.\n\nMore.\n"""\n')
    tree("python/b.py", 'class B:\n    """Button. It is red."""\n')
    tree("python/c/__init__.py", "")
    tree("scripts/run.sh", "#!/usr/bin/env bash\n# Runs all:\n#   scripts/run.sh\nset -e\n")
    assert rows(file_table.page()) == ["| `a.py` | Adds: numbers |", "| `b.py` | Button |", "| `run.sh` | Runs all |"]


def test_a_file_without_a_sentence_is_named(tree):
    tree("cuda/a.h", "#pragma once\nint f();\n")
    with pytest.raises(SystemExit, match=r"no first sentence in: cuda/a\.h"):
        file_table.page()


def test_a_long_sentence_ends_at_its_colon():
    assert file_table.first_sentence("Repairs polygons: " + "word " * 40) == "Repairs polygons"
