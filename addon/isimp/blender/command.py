"""Adds the command of the package to Blender 4.2 and later: `blender --command isimp simplify scan.ply simple.obj`."""

import bpy

from ..engine import engine
from ..language import said

_handle = None


def run(words) -> int:
    """Runs the command with its arguments. Returns the exit status."""
    if engine is None:
        print(said("The iSimp engine does not load: install the zip for this system"))
        return 1
    from importlib import import_module

    try:
        return int(import_module(f"{engine.__name__}.cli").main(words) or 0)
    except SystemExit as end:  # by --help and wrong usage
        return end.code if isinstance(end.code, int) else 1


def register() -> None:
    global _handle  # noqa: PLW0603  (Blender needs it to unregister the command)
    if hasattr(bpy.utils, "register_cli_command"):
        _handle = bpy.utils.register_cli_command("isimp", run)


def unregister() -> None:
    global _handle  # noqa: PLW0603
    if _handle is not None:
        bpy.utils.unregister_cli_command(_handle)
        _handle = None
