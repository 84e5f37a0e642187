"""The add-on's operators."""

from . import (
    compare,
    edits,
    mesh,
    openings,
    partition,
    problems,
    proxies,
    recipes,
    regions,
    select_by,
    steps,
    texture,
    workspace,
)

_MODULES = (
    partition,
    openings,
    proxies,
    edits,
    mesh,
    texture,
    problems,
    steps,
    recipes,
    regions,
    select_by,
    compare,
    workspace,
)
CLASSES = tuple(cls for module in _MODULES for cls in module.CLASSES)
