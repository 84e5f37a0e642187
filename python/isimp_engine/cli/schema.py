"""Print the commands and their options as JSON, for programs that call isimp: a JSON Schema for each command.

A property has the name of its option without dashes in front; `flag` is the word for the command line. Properties
without `flag` are the arguments in order. Options of earlier versions, which no longer do anything, are left out.
"""

import argparse
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from .. import __version__
from .errors import BAD_INPUT, INTERRUPTED, OK, SOME_FAILED, TERMINATED, USAGE
from .files import show
from .options import LIMITS

_TYPES: Mapping[Any, str] = {int: "integer", float: "number", str: "string", Path: "string"}
STATUS = {
    OK: "done",
    USAGE: "wrong usage",
    BAD_INPUT: "an input that can't be used",
    SOME_FAILED: "some scans of a batch failed",
    INTERRUPTED: "interrupted, nothing was written",
    TERMINATED: "terminated, nothing was written",
}


def schema(commands: Mapping[str, argparse.ArgumentParser]) -> dict[str, Any]:
    """The schemas of commands by name."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": f"isimp {__version__}",
        "exit_status": {str(status): meaning for status, meaning in STATUS.items()},
        "commands": {name: _command(parser) for name, parser in commands.items()},
    }


def run(arguments: argparse.Namespace) -> None:
    show(json.dumps(schema(arguments.commands), indent=2))


def _command(parser: argparse.ArgumentParser) -> dict[str, Any]:
    properties, required = dict[str, Any](), list[str]()
    for action in parser._actions:
        if isinstance(action, argparse._HelpAction) or action.help is argparse.SUPPRESS:
            continue  # options of earlier versions have no help
        words = action.option_strings
        name = words[0].lstrip("-") if words else action.dest
        properties[name] = {**_value(action), "description": _help(action)} | ({"flag": words[0]} if words else {})
        if action.required:
            required.append(name)
    return {
        "type": "object",
        "description": " ".join((parser.description or "").split()),
        "properties": properties,
        "required": required,
        "additionalProperties": False,
    }


def _value(action: argparse.Action) -> dict[str, Any]:
    """The schema of an option's value. Options that may stand alone can be true."""
    if action.nargs == 0:
        return {"type": "boolean"}
    # A type of our own parses text, such as "1000,300" or "auto".
    value: dict[str, Any] = {"type": _TYPES.get(action.type, "string")}
    if action.type in _TYPES:
        value |= _limits(getattr(action, LIMITS, {}))
    if action.choices:
        value["enum"] = list(action.choices)
    if isinstance(action, argparse._AppendAction) or action.nargs in ("+", "*"):
        return {"type": "array", "items": value}
    return {"anyOf": [{"type": "boolean"}, value]} if action.nargs == "?" else value


def _limits(field: Mapping[str, Any]) -> dict[str, Any]:
    """The range or the words of an option. field: see `set_limits`."""
    found = {"enum": field["choices"]} if "choices" in field else {}
    for key, strict, words in (
        ("least", "above_least", ("minimum", "exclusiveMinimum")),
        ("most", "below_most", ("maximum", "exclusiveMaximum")),
    ):
        if field.get(key) is not None:
            found[words[bool(field.get(strict))]] = field[key]
    return found


def _help(action: argparse.Action) -> str:
    return " ".join((action.help or "").replace("%(default)s", str(action.default)).replace("%%", "%").split())
