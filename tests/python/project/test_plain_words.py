"""scripts/plain_words.py counts mannered words in comments and docstrings, and in nothing else."""

import sys

import pytest

from conftest import script

plain_words = script("plain_words")
DOCSTRINGS = '"""Reads a file.\n\nWhat is missing is skipped."""\n\n\ndef f():\n    """Of x."""\n    return 1  # gone\n'


@pytest.mark.parametrize(
    ("path", "text", "expected"),
    [
        ("a.cpp", "// Returns the faces of a region.\n", []),
        ("a.cpp", "// Returns what is left, and those of the border.\n", [(1, ["what", "those of"])]),
        ("a.cpp", "int x;  // of all corners\n", [(1, ["of"])]),
        ("a.cpp", "// Removes the edge. Tells whether it did.\n", [(1, ["Tells"])]),
        ("a.cpp", "// Splits the ring round the vertex beside it, anew.\n", [(1, ["round the", "beside", "anew"])]),
        ("a.cpp", "/// \\return  of all corners\n", [(1, ["of"])]),
        ("a.cpp", "/// \\param a  the faces\n/// \\throws Cancelled  nothing was changed\n", []),
        ("a.cpp", "// A round of trials. Rounds of the sum.\n", []),
        ("a.h", "/// Removes the corners. The\n/// others are what\n/// is left.\nint f();\n", [(2, ["what"])]),
        ("a.h", "}  // namespace isimp\nint f();  // NOLINT(what-is)\n", []),
        ("a.cpp", 'auto a = "// what is"; auto b = R"(what is // that)"; int c = 1\'000;\n', []),
        ("a.py", 'a = "what is"\nb = "# what is"\n', []),
        ("a.py", DOCSTRINGS, [(3, ["What"]), (7, ["Of"]), (8, ["gone"])]),
        ("a.sh", 'echo "${#what} #what is"\n', []),
        ("a.sh", "#!/bin/sh\n# What is made\nmake # for those that build\n", [(2, ["What"]), (3, ["those that"])]),
    ],
)
def test_words_of_comments_count_and_others_do_not(path, text, expected):
    assert [(each.line, each.words) for each in plain_words.findings(path, text)[1]] == expected


def test_the_check_fails_above_a_limit_and_names_lines(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["plain_words.py"])
    monkeypatch.setattr(plain_words, "listed", lambda folders: ["scripts/plain_words.py"])
    monkeypatch.setattr(plain_words, "READERS", {".py": lambda text: [(1, True, "What is gone goes anew.")]})
    with pytest.raises(SystemExit, match="too many mannered words"):
        plain_words.main()
    assert "scripts/plain_words.py:1: What, gone, goes, anew" in capsys.readouterr().out
    assert plain_words.folder("native/src/partition/borders/a.cpp") == "native/src/partition"
    assert plain_words.folder("tests/python/blender/a.py") == "tests/python"
