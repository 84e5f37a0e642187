"""scripts/tidy_sources.py names the sources whose code has changed."""

from pathlib import Path

import pytest

from conftest import script

ROOT = Path(__file__).parents[3]


@pytest.fixture
def tidy(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "scripts")
    return script("tidy_sources")


@pytest.mark.parametrize(
    ("text", "same"),
    [
        ('#include "b.h"\n\n/// Another comment.\nint a = 1;  // one\nchar b[] = "// no comment";\n', True),
        ('#include "a.h"\nint a = 1; /* two\nlines */\nchar b[] = "// no comment";\n', True),
        ('#include "a.h"\nint a = 2;\nchar b[] = "// no comment";\n', False),
        ('#include "a.h"\nint a = 1;\nchar b[] = "// another text";\n', False),
        ('#include "a.h"\n// int a = 1;\nchar b[] = "// no comment";\n', False),
    ],
)
def test_comments_and_includes_are_no_code(tidy, text, same):
    code = tidy.code_of('#include "a.h"\nint a = 1;\nchar b[] = "// no comment";\n')
    assert (tidy.code_of(text) == code) == same


@pytest.mark.parametrize(
    ("text", "same"),
    [
        ("std::list<Chart> charts_;\nint f(Chart c) { return charts_; }", True),
        ("std::list<Chart> pieces_;\nint f(Chart c)\n{ return pieces_; }", True),
        ("std::list<Chart> charts_;\nint f(Piece c) { return charts_; }", False),
        ("std::list<Chart> charts;\nint f(Chart c) { return charts; }", False),
        ("std::list<chart> pieces_;\nint f(chart c) { return pieces_; }", False),
        ("std::vector<Piece> pieces_;\nint f(Piece c) { return pieces_; }", False),
        ("std::list<Piece> pieces_;\nlong f(Piece c) { return pieces_; }", False),
    ],
)
def test_names_of_the_same_style_are_no_change(tidy, text, same):
    tokens = tidy.without_own_names(["std::list<Piece> pieces_;", "int f(Piece c) { return pieces_; }"])
    assert (tidy.without_own_names(text.splitlines()) == tokens) == same


def test_each_changed_header_is_read_once(tidy):
    a, b, c, h, i, k = (Path(name) for name in ("a.cpp", "b.cpp", "c.cpp", "h.h", "i.h", "k.h"))
    read = {a: {a, h}, b: {b, h, i}, c: {c, k}}
    assert tidy.chosen(read, {h, i}) == [b]
    assert tidy.chosen(read, {a, h}) == [a]
    assert tidy.chosen(read, {a, h, i}) == [a, b]
    assert tidy.chosen(read, {k, Path("unread.h")}) == [c]
    assert tidy.chosen(read, set()) == []


def test_a_source_reads_the_headers_that_its_headers_include(tidy, monkeypatch, tmp_path):
    inside = tmp_path / "native" / "src"
    monkeypatch.setattr(tidy, "ROOT", tmp_path)
    monkeypatch.setattr(tidy, "INSIDE", inside)
    files = {
        "native/src/mesh/files/read.cpp": '#include <vector>\n#include "files/read.h"\n',
        "native/src/mesh/files/read.h": '#include "isimp/core/job.h"\n#include "read.h"\n',
        "native/src/other/files/read.h": "",
        "native/include/isimp/core/job.h": "",
        "native/include/isimp/core/array.h": "",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    read = tidy.read_by(inside / "mesh" / "files" / "read.cpp")
    assert {str(path.relative_to(tmp_path)) for path in read} == set(list(files)[:2]) | {list(files)[3]}


def test_a_moved_file_is_compared_with_its_old_text(tidy, monkeypatch):
    monkeypatch.setattr(tidy, "output", lambda *command: "M\tnative/src/core/job.cpp\nR090\told.h\tnative/src/new.h\n")
    monkeypatch.setattr(tidy, "at", lambda commit, name: "int moved;" if name == "old.h" else "")
    monkeypatch.setattr(Path, "read_text", lambda self: "int moved;  // here" if self.name == "new.h" else "int job;")
    assert tidy.with_changed_code("HEAD") == {ROOT / "native" / "src" / "core" / "job.cpp"}
