"""`isimp schema`: its JSON describes the commands and their options."""

import argparse
import json
import re
from pathlib import Path
from typing import Any

import pytest

import isimp_engine as engine
from isimp_engine.cli import main
from isimp_engine.cli.schema import schema


@pytest.fixture
def commands(capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    assert main(["schema"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["title"] == f"isimp {engine.__version__}"
    assert found["exit_status"]["3"] == "an input that can't be used"
    return dict(found["commands"])


def test_every_command_and_option_is_there(commands: dict[str, Any]) -> None:
    assert commands.keys() == {"simplify", "batch", "tiles", "report", "colliders", "info", "schema"}
    simplify = commands["simplify"]
    assert simplify["required"] == ["input", "output"]
    assert {"proxies", "metric", "planar", "lods", "report", "keep-opening"} < simplify["properties"].keys()
    for name, command in commands.items():
        for key, value in command["properties"].items():
            assert value["description"], (name, key)
            assert value.get("flag", f"--{key}") == f"--{key}", (name, key)


def test_options_of_earlier_versions_are_left_out(commands: dict[str, Any]) -> None:
    for name, command in commands.items():
        assert not {"symmetry", "even-spacing", "merge-islands", "height"} & command["properties"].keys(), name
        descriptions = [value["description"] for value in command["properties"].values()]
        assert "==SUPPRESS==" not in descriptions, name


def test_ranges_and_words_are_those_of_the_engine(commands: dict[str, Any]) -> None:
    options = commands["simplify"]["properties"]
    assert options["metric"]["enum"] == ["mixed", "normals", "distance"]
    assert (options["proxies"]["type"], options["proxies"]["minimum"]) == ("integer", 1)
    assert (options["detail"]["exclusiveMinimum"], options["detail"]["maximum"]) == (0, 1)
    assert options["clutter"]["enum"] == ["keep", "leave-out", "box"]
    assert options["keep-opening"] == {"type": "array", "items": {"type": "string"}} | {
        key: options["keep-opening"][key] for key in ("description", "flag")
    }
    assert options["texture"]["anyOf"][0] == {"type": "boolean"}


def test_a_range_is_that_of_the_option_and_not_of_one_with_its_name(commands: dict[str, Any]) -> None:
    def limits(command: str, name: str) -> dict[str, Any]:
        return {key: value for key, value in commands[command]["properties"][name].items() if "imum" in key}

    assert limits("tiles", "detail") == {"exclusiveMinimum": 0, "maximum": 1}
    assert limits("colliders", "parts") == {"minimum": 1}
    assert limits("colliders", "max-vertices") == {"minimum": 8}
    assert limits("colliders", "tolerance") == {"exclusiveMinimum": 0}
    assert commands["colliders"]["properties"]["thickness"]["anyOf"][1] == {"type": "number", "exclusiveMinimum": 0}
    parser = argparse.ArgumentParser()
    parser.add_argument("--tolerance", type=int)
    (given,) = (each for name, each in schema({"own": parser})["commands"]["own"]["properties"].items() if name != "h")
    assert given == {"type": "integer", "description": "", "flag": "--tolerance"}


def test_they_are_valid_schemas(commands: dict[str, Any]) -> None:
    jsonschema = pytest.importorskip("jsonschema")
    for command in commands.values():
        jsonschema.Draft202012Validator.check_schema(command)
    check = jsonschema.Draft202012Validator(commands["simplify"])
    check.validate({"input": "a.ply", "output": "b.obj", "proxies": 300, "planar": True, "regularise": 5.0})
    for wrong in ({"proxies": 0}, {"metric": "cubes"}, {"unknown": 1}, {"detail": 2.0}):
        assert not check.is_valid({"input": "a.ply", "output": "b.obj"} | wrong), wrong


def test_the_page_for_programs_names_options_and_statuses_that_exist(
    commands: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    page = (Path(__file__).resolve().parents[3] / "AGENTS.md").read_text(encoding="utf-8")
    flags = {f"--{name}" for command in commands.values() for name in command["properties"]}
    assert set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", page)) - {"--python"} <= flags
    assert set(re.findall(r"`isimp (\w+)", page)) == commands.keys()
    assert main(["schema"]) == 0
    statuses = json.loads(capsys.readouterr().out)["exit_status"]
    stated = {status for row in re.findall(r"^\| ([\d, ]+) \|", page, re.MULTILINE) for status in row.split(", ")}
    assert stated == statuses.keys()
