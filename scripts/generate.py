"""Writes what is made from the engine's table of options, and the API page.

    PYTHONPATH=build-dev/python python scripts/generate.py

- python/isimp_engine/_core.pyi: its classes of options
- addon/isimp/engine_options.py: the table as plain data, so that recipes load without the engine
- docs/api.md, by scripts/api_docs.py

Tests say when one of them is out of date.
"""

import json
import re
import runpy
from pathlib import Path

import isimp_engine as engine

ROOT = Path(__file__).resolve().parents[1]
STUB = ROOT / "python" / "isimp_engine" / "_core.pyi"
DATA = ROOT / "addon" / "isimp" / "engine_options.py"
HEAD = '''"""The engine's options: name, type, default, range, meaning. Written by scripts/generate.py; do not edit."""
# ruff: noqa: E501

from typing import Any, NamedTuple


class Option(NamedTuple):
    kind: str  #: "int", "float", "bool" or "str"
    default: Any
    about: str  #: what it means
    words: str = ""  #: the range in words: "in [0, 1)"
    least: float | None = None
    above_least: bool = False  #: least itself is no value
    most: float | None = None
    below_most: bool = False  #: most itself is no value
    choices: tuple[str, ...] = ()

    def holds(self, value: float) -> bool:
        """Whether a number is in the range; infinity and NaN never are."""
        if not abs(value) < float("inf"):
            return False
        low = self.least is None or (value > self.least if self.above_least else value >= self.least)
        high = self.most is None or (value < self.most if self.below_most else value <= self.most)
        return low and high

'''
ENDS = ("least", "above_least", "most", "below_most")
CLASSES = (engine.CleanOptions, engine.MeshingOptions, engine.PartitionOptions)


def stub_of(kind: type) -> str:
    """The class as the stub has it."""
    fields = kind.fields()
    attributes = [f"    {field['name']}: {field['type']}" for field in fields]
    keywords = [f"        {field['name']}: {field['type']} = ...," for field in fields]
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
            "    def as_dict(self) -> dict[str, Any]: ...",
            "",
        ]
    )


def with_classes(text: str) -> str:
    """The stub with the classes of options as they are now."""
    for kind in CLASSES:
        pattern = rf"^class {kind.__name__}:\n(?:    .*\n)+"
        text, count = re.subn(pattern, lambda _, kind=kind: stub_of(kind), text, flags=re.MULTILINE)
        if count != 1:
            raise SystemExit(f"{STUB} has no class {kind.__name__}")
    return text


def data() -> str:
    """The table as the add-on has it."""
    text = HEAD
    for kind in CLASSES:
        text += f"\n{kind.__name__.removesuffix('Options').upper()}: dict[str, Option] = {{\n"
        for field in kind.fields():
            text += f'    "{field["name"]}": Option(\n'
            words = {
                "kind": field["type"].removesuffix(" | None"),
                "default": field["default"],
                "about": field["about"],
            }
            words |= {"words": field.get("range", "")} | {name: field[name] for name in ENDS if name in field}
            if "choices" in field:
                words["choices"] = tuple(field["choices"])
            usual = {"words": "", "above_least": False, "below_most": False}
            for name, value in words.items():
                if name in {"kind", "default", "about"} or value != usual.get(name):
                    text += f"        {name}={literal(value)},\n"
            text += "    ),\n"
        text += "}\n"
    return text


def literal(value: object) -> str:
    """A value as Python code, strings as the formatter has them."""
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, tuple):
        return "(" + ", ".join(map(literal, value)) + ")"
    return repr(value)


if __name__ == "__main__":
    DATA.write_text(data())
    STUB.write_text(with_classes(STUB.read_text()))
    runpy.run_path(str(ROOT / "scripts" / "api_docs.py"), run_name="__main__")
