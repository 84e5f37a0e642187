"""The add-on's operators."""

from . import (
    compare,
    edits,
    mesh,
    openings,
    partition,
    planes,
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
    planes,
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
