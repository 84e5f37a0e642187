"""The commands of the stories in docs run in a fresh folder, and the stories stay short."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

import meshfiles
import shapes
from isimp_engine.cli import main

ROOT = Path(__file__).resolve().parents[3]
STORIES = ("games", "surveys", "parts")
MOST_WORDS = 700


def text_of(page):
    return (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8")


def commands(page):
    blocks = re.findall(r"^```sh\n(.*?)^```", text_of(page), re.MULTILINE | re.DOTALL)
    return [line for block in blocks for line in block.splitlines()]


@pytest.fixture(scope="module")
def scans(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scans")
    subprocess.run([sys.executable, ROOT / "examples" / "scans.py", folder], check=True)
    return folder


@pytest.mark.parametrize("page", STORIES)
def test_the_commands_of_a_story_run_in_a_fresh_folder(page, scans, tmp_path, monkeypatch, capsys):
    for scan in scans.iterdir():
        (tmp_path / scan.name).write_bytes(scan.read_bytes())
    monkeypatch.chdir(tmp_path)
    assert len(commands(page)) >= 5
    for command in commands(page):
        program, *arguments = shlex.split(command)
        if arguments[-1].endswith(".step"):
            pytest.importorskip("OCP")
        assert (program, main(arguments)) == ("isimp", 0), f"{command}: {capsys.readouterr().err}"
        if arguments[0] == "simplify" and "--lods" not in arguments:
            assert Path(arguments[2]).stat().st_size > 0, command


@pytest.mark.parametrize("page", STORIES)
def test_a_story_is_short_and_names_its_limits(page):
    text = text_of(page)
    assert len(text.split()) <= MOST_WORDS
    assert "\n## Not for\n" in text
    assert "](images/" in text


def summary(capsys, *arguments):
    assert main(["simplify", *map(str, arguments)]) == 0
    return capsys.readouterr().out


def test_the_figures_of_the_stories_are_those_of_the_results(scans, tmp_path, capsys):
    games, surveys, parts = (" ".join(text_of(page).split()) for page in STORIES)
    statue = summary(capsys, scans / "statue.glb", tmp_path / "a.glb", "--triangles", 1500)
    faces, polygons = re.search(r"([\d,]+) faces.*?(\d+) polygons", statue, re.DOTALL).groups()
    assert f"Here {faces} triangles become {polygons} polygons" in games
    house = summary(capsys, scans / "house.ply", tmp_path / "a.ifc", "--planar", "--regularise")
    assert f"makes {re.search(r'[0-9]+ polygons of [0-9]+ regions', house)[0]}" in surveys
    plate = summary(capsys, scans / "plate.stl", tmp_path / "a.obj", "--curved")
    assert "3 cylinders" in plate
    assert f"Here {re.search(r'([0-9,]+) faces', plate)[1]} triangles become a solid" in parts


def test_points_become_a_mesh(scans, tmp_path, capsys):
    pytest.importorskip("pymeshlab")
    program, mesh = ROOT / "examples" / "points_to_mesh.py", tmp_path / "mesh.ply"
    subprocess.run([sys.executable, program, scans / "points.ply", mesh, "--depth", "7"], check=True)
    assert "1 part, closed" in summary(capsys, mesh, tmp_path / "house.obj", "--planar")


def test_a_scanned_room_has_a_reverberation_time(tmp_path):
    pytest.importorskip("pyroomacoustics")
    vertices, faces = shapes.cube(12)
    meshfiles.obj(tmp_path / "room.obj", vertices * [6, 4, 2.6], faces[:, ::-1])
    command = [sys.executable, ROOT / "examples" / "acoustics.py", tmp_path / "room.obj"]
    told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    assert told.startswith("6 walls, ")
    assert float(told.split()[-2]) == pytest.approx(0.87, rel=0.05)
