"""The declarations of the engine's public headers, so that tests find the ones that Python lacks."""

import re
from pathlib import Path

INCLUDE = Path(__file__).resolve().parents[2] / "native" / "include" / "isimp"


def struct_fields(header, struct):
    """The names of a struct's data members, in order."""
    text = (INCLUDE / header).read_text()
    body = re.search(rf"^struct {struct} {{\n(.*?)^}};", text, re.MULTILINE | re.DOTALL).group(1)
    body = re.sub(r"//[^\n]*", "", body)
    body = re.sub(r"\{[^{}]*\}", "", body)  # bodies of member functions, initialisers
    fields = []
    for statement in body.split(";"):
        if "(" in statement or not statement.strip():
            continue
        names = re.sub(r"<[^<>]*>", "", re.sub(r"<[^<>]*>", "", statement)).split(",")
        fields += [re.sub(r"=.*", "", name, flags=re.DOTALL).split()[-1] for name in names]
    return fields


def enumerators(header, enum):
    """The names of an enumeration's values, in order."""
    text = (INCLUDE / header).read_text()
    body = re.search(rf"^enum class {enum} {{\n(.*?)^}};", text, re.MULTILINE | re.DOTALL).group(1)
    return re.findall(r"^\s*(\w+)", re.sub(r"//[^\n]*", "", body), re.MULTILINE)
