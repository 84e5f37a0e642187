"""Writes the files derived from the engine's table of options, and the API page.

    PYTHONPATH=build-dev/python python scripts/generate.py

- python/isimp_engine/_core.pyi: its classes of options
- python/isimp_engine/recipe/engine_options.py: the table as plain data, so that recipes load without the engine
- docs/api.md, by scripts/api_docs.py
- docs/files.md, by scripts/file_table.py

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

from .options import Option
'''
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
    """The class in the stub."""
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


def data() -> str:
    """The table in the add-on's form."""
    text = HEAD
    tables = {"MESHING": engine.MeshingOptions, "PARTITION": engine.PartitionOptions}
    tables |= {"REGULARISE": engine.RegulariseOptions, "TEXTURE": engine.TextureOptions}
    for name, kind in tables.items():
        text += f"\n{name}: dict[str, Option] = {{\n"
        for field in kind.fields():
            facts = {"kind": field["type"].removesuffix(" | None"), "default": field["default"]}
            facts |= {"words": field.get("range", "")}
            facts |= {end: field[end] for end in ("least", "above_least", "most", "below_most") if end in field}
            facts |= {"choices": tuple(field.get("choices", ()))}
            text += f'    "{field["name"]}": Option(\n'
            for key, value in facts.items():
                if key in ("kind", "default") or not (value is False or value in ("", ())):  # the others are defaults
                    text += f"        {key}={literal(value)},\n"
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
    for script in ("api_docs.py", "file_table.py"):
        runpy.run_path(str(ROOT / "scripts" / script), run_name="__main__")
