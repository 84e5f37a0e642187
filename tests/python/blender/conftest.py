"""Tests that need Blender: run by `blender -b` (see inside.py), or by plain pytest where bpy is installed from PyPI."""

import os
import sys
from pathlib import Path

import pytest

try:
    import bpy
except ModuleNotFoundError as error:
    if error.name != "bpy":
        raise
    bpy = None
    collect_ignore_glob = ["test_*.py"]  # the tests in window/ start a Blender of their own
else:
    collect_ignore = ["window"]

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture(scope="session")
def addon():
    """The add-on, switched on once for all tests."""
    import isimp

    isimp.register()
    yield isimp
    isimp.unregister()


@pytest.fixture(autouse=bpy is not None)
def scene(addon):
    """An empty scene with undo switched on, for each test."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.context.preferences.edit.use_global_undo = True
    bpy.ops.ed.undo_push(message="start")
    yield bpy.context.scene
    # In Blender 3.4 `bpy.context.tool_settings` makes this scene the owner of `bpy.context.window` for the rest of the
    # session. When another file is open, the export of a GLB file then writes into the freed scene.
    assert bpy.context.id_data is None, "use bpy.context.scene.tool_settings"


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config):
    # bpy 4.5 from PyPI never returns from a destructor when Python ends.
    if bpy is not None and not bpy.app.binary_path:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(int(getattr(config, "exit_status", 1)))


def pytest_sessionfinish(session, exitstatus):
    session.config.exit_status = exitstatus
