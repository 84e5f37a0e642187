"""Writes the classes of options in python/isimp_engine/_core.pyi from the engine's own table of fields.

    PYTHONPATH=build-dev/python python scripts/generate_stubs.py

A test says when they are out of date.
"""

import re
from pathlib import Path

import isimp_engine as engine

STUB = Path(__file__).resolve().parents[1] / "python" / "isimp_engine" / "_core.pyi"
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


if __name__ == "__main__":
    STUB.write_text(with_classes(STUB.read_text()))
