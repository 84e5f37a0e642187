"""The add-on's operators."""

from . import (
    clean_up,
    compare,
    edits,
    files,
    finish,
    mesh,
    openings,
    partition,
    planes,
    problems,
    proxies,
    recipes,
    regions,
    round_parts,
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
    clean_up,
    round_parts,
    planes,
    mesh,
    finish,
    files,
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
