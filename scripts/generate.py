"""Writes the files derived from the engine's table of options, and the API page.

    PYTHONPATH=build-dev/python python scripts/generate.py

- python/isimp_engine/_core.pyi: its classes of options
- python/isimp_engine/recipe/engine_fields.py: options as settings of steps
- python/isimp_engine/recipe/engine_options.py: the table as plain data, so that recipes load without the engine
- docs/api.md, by scripts/api_docs.py

Tests fail when one of them is out of date.
"""

import json
import re
import runpy
from pathlib import Path
from typing import Any

import isimp_engine as engine

ROOT = Path(__file__).resolve().parents[1]
STUB = ROOT / "python" / "isimp_engine" / "_core.pyi"
DATA = ROOT / "python" / "isimp_engine" / "recipe" / "engine_options.py"
HEAD = '''"""The engine's options of partition and meshing. Written by scripts/generate.py; do not edit."""
# fmt: off
# ruff: noqa: E501

from typing import Any

from .options import Option
'''
HEAD_OF_GONE = """
#: settings of earlier versions by step, which have no effect, and the value that means so
GONE: dict[str, dict[str, Any]] = {
"""
FIELDS = DATA.with_name("engine_fields.py")
PLAIN = runpy.run_path(str(DATA.with_name("options.py")))  # by its path: the package needs the files made here
Option, COUNTS = PLAIN["Option"], PLAIN["COUNTS"]
HEAD_OF_FIELDS = '''"""The engine's options as settings of steps. Written by scripts/generate.py; do not edit."""

from __future__ import annotations

from dataclasses import dataclass

from .step import Step
'''
FACTS = ("least", "above_least", "most", "below_most", "unit", "label", "tip", "low", "high", "digits")
MACHINE = ("threads", "backend")  #: options that change no result, so they are no settings of recipes
CLASSES = (
    engine.CleanOptions,
    engine.MeshingOptions,
    engine.PartitionOptions,
    engine.RegulariseOptions,
    engine.TextureOptions,
)


def type_of(field: dict[str, Any]) -> str:
    """The type of a field in the stub."""
    return f"Literal[{', '.join(map(literal, field['choices']))}]" if "choices" in field else field["type"]


def stub_of(kind: type) -> str:
    """Return the text of the class in the stub."""
    fields = kind.fields()
    attributes = [f"    {field['name']}: {type_of(field)}" for field in fields]
    keywords = [f"        {field['name']}: {type_of(field)} = ...," for field in fields]
    return "\n".join(
        [
            f"class {kind.__name__}:",
            *attributes,
            "    def __init__(",
            "        self,",
            "        *,",
            *keywords,
            "    ) -> None: ...",
            "    @staticmethod",
            "    def fields() -> list[dict[str, Any]]: ...",
            "    @staticmethod",
            "    def gone() -> dict[str, Any]: ...",
            "    def as_dict(self) -> dict[str, Any]: ...",
            "",
        ]
    )


def with_classes(text: str) -> str:
    """The stub with the present classes of options."""
    for kind in CLASSES:
        pattern = rf"^class {kind.__name__}:\n(?:    .*\n)+"
        text, count = re.subn(pattern, lambda _, kind=kind: stub_of(kind), text, flags=re.MULTILINE)
        if count != 1:
            raise SystemExit(f"{STUB} has no class {kind.__name__}")
    return text


def table_of(kind: type) -> str:
    """The name of the add-on's table of a class: MESHING."""
    return kind.__name__.removesuffix("Options").upper()


def settings_of(kind: type) -> list[dict[str, Any]]:
    """The options that are settings of recipes; options of repairs only if the panel shows them."""
    is_repair = kind is engine.CleanOptions
    return [field for field in kind.fields() if field["name"] not in MACHINE and (field["label"] or not is_repair)]


def option_of(field: dict[str, Any]) -> Option:
    """A row of the table as plain data."""
    facts = {name: tuple(field[name]) for name in ("choices", "items") if name in field}
    facts |= {name: field[name] for name in FACTS if name in field}
    return Option(field["type"].removesuffix(" | None"), field["default"], field.get("range", ""), **facts)


def fields() -> str:
    """The options as fields of classes that steps inherit."""
    text = HEAD_OF_FIELDS
    for kind in CLASSES:
        text += f"\n\n@dataclass(frozen=True)\nclass {kind.__name__.removesuffix('Options')}Fields(Step):\n"
        for field in settings_of(kind):
            name, type_name = field["name"], field["type"].removesuffix(" | None")
            if name in COUNTS:  # the step chooses one of them
                continue
            text += f"    {name}: {type_name} = {literal(option_of(field).unset)}\n"
    return text


def data() -> str:
    """The tables in the add-on's form."""
    gone = {kind.__name__.removesuffix("Options").lower(): kind.gone() for kind in CLASSES}
    rows = "".join(f"    {literal(step)}: {literal(names)},\n" for step, names in gone.items() if names)
    text = HEAD + f"{HEAD_OF_GONE}{rows}}}\n"
    for kind in CLASSES:
        text += f"\n{table_of(kind)}: dict[str, Option] = {{\n"
        for field in settings_of(kind):
            text += f'    "{field["name"]}": Option(\n'
            option = option_of(field)
            for key, value in option._asdict().items():
                if key in ("kind", "default") or value != Option._field_defaults[key]:
                    text += f"        {key}={literal(value)},\n"
            text += "    ),\n"
        text += "}\n"
    return text


def literal(value: object) -> str:
    """A value as Python code, strings as the formatter has them."""
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, dict):
        return "{" + ", ".join(f"{literal(key)}: {literal(each)}" for key, each in value.items()) + "}"
    if isinstance(value, tuple):
        return "(" + ", ".join(map(literal, value)) + ")"
    return repr(value)


if __name__ == "__main__":
    DATA.write_text(data())
    FIELDS.write_text(fields())
    STUB.write_text(with_classes(STUB.read_text()))
    runpy.run_path(str(ROOT / "scripts" / "api_docs.py"), run_name="__main__")
