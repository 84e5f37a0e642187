"""The add-on's operators."""

from . import (
    clean_up,
    compare,
    edits,
    files,
    finish,
    imports,
    lods,
    mesh,
    more,
    openings,
    partition,
    planes,
    problems,
    proxies,
    recipes,
    regions,
    round_parts,
    select_by,
    sizes,
    steps,
    texture,
    workspace,
)

try:
    from . import install
except ImportError:  # in an extension, which may not start programs
    install = None

_MODULES = (
    partition,
    openings,
    more,
    proxies,
    edits,
    clean_up,
    round_parts,
    planes,
    sizes,
    mesh,
    finish,
    lods,
    imports,
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
CLASSES = tuple(cls for module in (*_MODULES, install) if module for cls in module.CLASSES)
