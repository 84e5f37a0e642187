"""Raises a clear error if the engine is installed for other versions of Python than the running one."""

import re
import sys
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path


def pythons(names: list[str]) -> list[str]:
    """The Pythons that files like _core.cpython-311-x86_64-linux-gnu.so are for: 3.11."""
    found = {match.groups() for name in names if (match := re.match(r"_core\.(?:cpython-|cp)(\d)(\d+)\D", name))}
    return [f"{major}.{minor}" for major, minor in sorted(found, key=lambda pair: (int(pair[0]), int(pair[1])))]


def problem(names: list[str], suffixes: list[str]) -> str:
    """The reason why none of these modules loads; empty if one may, or if there is none at all."""
    carried = pythons(names)
    if not carried or {f"_core{suffix}" for suffix in suffixes} & set(names):
        return ""
    running = "{}.{}".format(*sys.version_info)
    return (
        f"this iSimp has its engine for Python {', '.join(carried)} on {systems(names)}; this is Python {running} on "
        f"{sys.platform}: install the iSimp for it"
    )


def systems(names: list[str]) -> str:
    """The systems of the modules, as their suffixes name them: x86_64-linux-gnu."""
    found = {match[1] for name in names if (match := re.match(r"_core\.(?:cpython-|cp)\d+-(.+)\.(?:so|pyd)$", name))}
    return ", ".join(sorted(found)) or "this system"


def check() -> None:
    names = sorted(path.name for path in Path(__file__).parent.glob("_core.*"))
    if why := problem(names, EXTENSION_SUFFIXES):
        raise ImportError(why)


check()
