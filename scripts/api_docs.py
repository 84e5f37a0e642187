"""Writes docs/api.md, the reference of the Python module, from the docstrings of the installed package.

    scripts/api_docs.py [--out docs/api.md]

Run it with a Python that has isimp_engine: installed, or by PYTHONPATH=build-dev/python.
"""

import argparse
import dataclasses
import importlib
import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
HEAD = """# API of the Python module

`scripts/api_docs.py` makes this page from the docstrings of `isimp_engine`: change the docstrings, not the page.
`help(isimp_engine)` shows the same texts. The package is typed, so editors and mypy know the types.

The names on this page are all public names, at most 60, and stable from version 1.0 on. Other names are private.
A name that was public works until the next version, with a DeprecationWarning that
has its new name or place. [From Python](python.md) has a use of each.

Letters of shapes: V vertices, F faces and R regions of a mesh; W vertices, Q polygons and L corners of polygons.
"""
MODULES = ("batch", "tiles")
_SIGNATURE = re.compile(r"\w+\(.*\)( -> .+)?$")  # the first line of a docstring of pybind11


def documentation(thing: Any) -> str:
    """The docstring, without the signature that pybind11 puts in front."""
    text = inspect.getdoc(thing) or ""
    first, _, rest = text.partition("\n")
    return rest.strip() if _SIGNATURE.match(first) else text.strip()


def parameters(thing: Any) -> str:
    """`(mesh, options=..., job=None)`: names, and defaults where they are short."""
    try:
        signature = inspect.signature(thing)
    except (TypeError, ValueError):
        return compiled_parameters(thing.__doc__ or "")
    plain = [each.replace(annotation=each.empty) for each in signature.parameters.values() if each.name != "self"]
    return str(inspect.Signature(plain))


def compiled_parameters(text: str) -> str:
    """As `parameters`, from the signature in a docstring of pybind11."""
    line = text.partition("\n")[0].partition(" -> ")[0]
    inside = re.sub(
        r"\w+\([^()]*\)", "...", line[line.index("(") + 1 : line.rindex(")")]
    )  # a default that is an object
    names = []
    for part in re.split(r", (?=\w+:|\*)", inside):
        name, _, value = part.partition(" = ")
        name = name.partition(":")[0]
        if name and name != "self":
            names.append(f"{name}={value}" if value else name)
    return f"({', '.join(names)})"


def is_compiled_class(cls: type) -> bool:
    return type(cls).__name__ == "pybind11_type"


def members(cls: type) -> Iterator[tuple[str, str, str]]:
    """(name with parameters, default, text) of the public members of a class."""
    if dataclasses.is_dataclass(cls):
        about = field_comments(cls)
        for field in dataclasses.fields(cls):
            default = "" if field.default is dataclasses.MISSING else repr(field.default)
            yield field.name, default, about.get(field.name, "")
    defaults = cls() if is_compiled_class(cls) and hasattr(cls, "as_dict") else None
    for name, attribute in vars(cls).items():
        # The docstring of a static method's wrapper is Python's own, of static methods as such.
        member = attribute.__func__ if isinstance(attribute, staticmethod) else attribute
        fields = getattr(cls, "__dataclass_fields__", {})
        if name.startswith("_") or name in fields:
            continue
        is_value = isinstance(member, property) or not callable(member)
        default = repr(getattr(defaults, name)) if defaults is not None and is_value else ""
        yield name if is_value else f"{name}{parameters(member)}", default, documentation(member)


def field_comments(cls: type) -> dict[str, str]:
    """The comments `#: ...` behind the fields of a dataclass."""
    found = re.findall(r"^    (\w+): .*?#: (.+)$", inspect.getsource(cls), re.MULTILINE)
    return dict(found)


def cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|").replace("<", "&lt;")


def table(cls: type) -> list[str]:
    rows = list(members(cls))
    if not rows:
        return []
    if any(default for _, default, _ in rows):
        lines = ["| member | default | meaning |", "|---|---|---|"]
        return [
            *lines,
            *(f"| `{name}` | {f'`{value}`' if value else ''} | {cell(text)} |" for name, value, text in rows),
            "",
        ]
    return ["| member | meaning |", "|---|---|", *(f"| `{name}` | {cell(text)} |" for name, _, text in rows), ""]


def block(text: str) -> list[str]:
    """A docstring with its own lines kept."""
    return ["```text", text, "```", ""] if text else []


def entry(name: str, thing: Any) -> list[str]:
    """The section of a class or a function."""
    if not isinstance(thing, type):
        return [f"### {name}", "", f"`{name}{parameters(thing)}`", "", *block(documentation(thing))]
    if issubclass(thing, BaseException):
        return [
            f"### {name}",
            "",
            f"An exception, a kind of `{thing.__bases__[0].__name__}`.",
            "",
            *block(documentation(thing)),
        ]
    text = documentation(thing)
    if "__init__" not in vars(thing) or hasattr(thing, "as_dict"):  # not made by callers, or all fields are keywords
        return [f"### {name}", "", *block(text), *table(thing)]
    if dataclasses.is_dataclass(thing):
        return [f"### {name}", "", f"`{name}{parameters(thing)}`", "", *block(text), *table(thing)]
    call = f"`{name}{parameters(thing.__init__)}`"
    more = documentation(thing.__init__)
    return [f"### {name}", "", call, "", *block(f"{text}\n\n{more}".strip()), *table(thing)]


def own(module: ModuleType) -> Iterator[tuple[str, Any]]:
    """The public classes and functions of a module of the package: its __all__, else the ones that it defines."""
    if hasattr(module, "__all__"):
        yield from ((name, getattr(module, name)) for name in module.__all__)
        return
    for name, thing in vars(module).items():
        if not name.startswith("_") and getattr(thing, "__module__", None) == module.__name__ and callable(thing):
            yield name, thing


def page() -> str:
    """The whole of docs/api.md."""
    engine = importlib.import_module("isimp_engine")
    lines = [HEAD]
    named = [(name, getattr(engine, name)) for name in engine.__all__ if not name.startswith("_")]
    for title, wanted in (("Classes", True), ("Functions", False)):
        lines += [f"## {title}", ""]
        for name, thing in named:
            if isinstance(thing, type) is wanted:
                lines += entry(name, thing)
    for name in MODULES:
        module = importlib.import_module(f"isimp_engine.{name}")
        lines += [f"## isimp_engine.{name}", "", *block(documentation(module))]
        for own_name, thing in own(module):
            lines += entry(own_name, thing)
    return "\n".join(lines).rstrip() + "\n"


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "api.md", help="default docs/api.md")
    parser.parse_args(argv).out.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
