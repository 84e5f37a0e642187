"""The examples of README.md work."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

import isimp_engine as engine
import shapes

ROOT = Path(__file__).resolve().parents[3]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```", README, re.MULTILINE | re.DOTALL)


def commands(program):
    lines = (line for block in blocks("sh") for line in block.splitlines())
    return [line for line in lines if line.split()[0] == program]


@pytest.fixture
def scan(tmp_path, monkeypatch):
    """A folder with a scan.ply in it, made the current one."""
    vertices, triangles = shapes.cube(12)
    lines = ["ply", "format ascii 1.0", f"element vertex {len(vertices)}"]
    lines += [f"property float {axis}" for axis in "xyz"]
    lines += [f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header"]
    lines += [" ".join(map(repr, vertex)) for vertex in vertices.tolist()]
    lines += [" ".join(map(str, [3, *triangle])) for triangle in triangles.tolist()]
    (tmp_path / "scan.ply").write_text("\n".join(lines) + "\n", encoding="ascii")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_python_example_runs(scan, capsys):
    (example,) = blocks("python")
    exec(compile(example, "README.md", "exec"), {})  # noqa: S102 (that is the point)
    said = capsys.readouterr().out
    assert said.startswith("6 regions, error ")  # the scan of these tests is a cube
    for name in ("simple.obj", "edited.obj"):
        corners = re.findall("^f", (scan / name).read_text(encoding="utf-8"), re.MULTILINE)
        assert f"\n{len(corners)} polygons, " in said


@pytest.mark.parametrize("command", commands("isimp"))
def test_the_commands_run(scan, command):
    program, *arguments = shlex.split(command)
    done = subprocess.run(
        [sys.executable, "-m", "isimp_engine", *arguments], capture_output=True, text=True, check=False
    )
    assert (program, done.returncode) == ("isimp", 0), done.stderr
    for name in arguments:
        assert name.startswith("-") or "." not in name or (scan / name).stat().st_size > 0


def test_every_file_it_names_is_there():
    links = re.findall(r"\]\(((?!http|#)[^)]+)\)", README)
    names = {
        *(link.partition("#")[0] for link in links),
        *(word for block in blocks("sh") for word in re.findall(r"(?:scripts|examples)/\w+\.\w+", block)),
    }
    assert len(names) > 5
    assert [name for name in sorted(names) if not (ROOT / name).is_file()] == []


def test_the_version_is_the_engines():
    assert f"isimp-{engine.__version__}" in README


def test_all_formats_that_are_written_are_listed():
    (row,) = re.findall(r"^\| read \| written \|\n\|.*\n\|.*\|(.*)\|$", README, re.MULTILINE)
    words = re.findall(r"\w+", row.lower())
    names = {suffix.replace(".", "") for suffix in engine.exporting.PLAIN} - {"stp"}  # STEP too
    assert names <= set(words)
