"""scripts/plain_words.py counts mannered words in comments and docstrings, and in nothing else."""

import subprocess
import sys
from pathlib import Path

import pytest

from conftest import script

ROOT = Path(__file__).parents[3]
plain_words = script("plain_words")


def found(path, text):
    words, findings = plain_words.findings(path, text)
    return words, [(each.line, each.words) for each in findings]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("// Returns the faces of a region.\n", []),
        ("// What is left.\n", ["What"]),
        ("// Returns what is left, and those of the border.\n", ["what", "those of"]),
        ("int x;  // of all corners\n", ["of"]),
        ("int x = f(a);  ///< And so on\n", ["And"]),
        ("// Removes the edge. Tells whether it did.\n", ["Tells"]),
        ("// Splits the ring round the vertex beside it, anew.\n", ["round the", "beside", "anew"]),
        ("/// \\return  of all corners\n", ["of"]),
        ("/// \\param a  the faces\n/// \\throws Cancelled  nothing was changed\n", []),
        ("// A round of trials. Rounds of the sum.\n", []),
    ],
)
def test_phrases_and_first_words_of_cpp(text, expected):
    assert [word for _, words in found("a.cpp", text)[1] for word in words] == expected


def test_a_sentence_over_two_lines_counts_once_and_at_its_line():
    words, findings = found("a.h", "/// Removes the corners. The\n/// others are what\n/// is left.\nint f();\n")
    assert words == 9
    assert findings == [(2, ["what"])]


def test_code_and_strings_do_not_count():
    assert found("a.cpp", 'auto a = "// what is"; auto b = R"(what is // that)"; int c = 1\'000;\n') == (0, [])
    assert found("a.py", 'a = "what is"\nb = "# what is"\n') == (0, [])
    assert found("a.sh", 'echo "${#what} #what is"\n') == (0, [])


def test_marks_for_tools_do_not_count():
    assert found("a.h", "}  // namespace isimp\nint f();  // NOLINT(what-is)\n") == (0, [])


def test_docstrings_and_comments_of_python_count():
    text = '"""Reads a file.\n\nWhat is missing is skipped."""\n\n\ndef f():\n    """Of x."""\n    return 1  # gone\n'
    assert found("a.py", text) == (11, [(3, ["What"]), (7, ["Of"]), (8, ["gone"])])


def test_comments_of_shell_count():
    assert found("a.sh", "#!/bin/sh\n# What is made\nmake # for those that build\n")[1] == [
        (2, ["What"]),
        (3, ["those that"]),
    ]


@pytest.mark.parametrize(
    ("path", "expected"),
    [
        ("native/src/mesh/a.cpp", "native/src/mesh"),
        ("native/src/partition/borders/a.cpp", "native/src/partition"),
        ("native/include/isimp/core/a.h", "native/include/isimp/core"),
        ("addon/isimp/blender/a.py", "addon"),
        ("tests/python/blender/a.py", "tests/python"),
        ("setup.py", "."),
    ],
)
def test_files_count_for_their_folder(path, expected):
    assert plain_words.folder(path) == expected


def test_the_check_fails_above_a_limit_and_names_lines(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["plain_words.py"])
    monkeypatch.setattr(plain_words, "listed", lambda folders: ["scripts/plain_words.py"])
    monkeypatch.setattr(plain_words, "READERS", {".py": lambda text: [(1, True, "What is gone goes anew.")]})
    with pytest.raises(SystemExit, match="too many mannered words"):
        plain_words.main()
    assert "scripts/plain_words.py:1: What, gone, goes, anew" in capsys.readouterr().out


def test_the_repository_keeps_its_limits():
    if not (ROOT / ".git").exists():
        pytest.skip("no git repository: the files are not listed")
    run = subprocess.run([sys.executable, "scripts/plain_words.py"], cwd=ROOT, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr
