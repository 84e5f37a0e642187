"""Imports the engine, installed or in the add-on's own folder. No other module imports it."""

from pathlib import Path

from .language import own

_FILE = Path(__file__)
_INSTALLED = _FILE.stat().st_mtime_ns
ENGINE_PROBLEM = ""  #: why the engine can't be used; empty if it can
try:
    import isimp_engine as engine
except ImportError as outer:
    try:
        from . import isimp_engine as engine
    except ImportError as inner:
        engine = None
        # The error of an engine that exists but does not load is more useful than "not found".
        ENGINE_PROBLEM = str(inner if isinstance(outer, ModuleNotFoundError) else outer)
        if Path(__file__).with_name("wheels").is_dir() and not __name__.startswith("bl_ext."):
            ENGINE_PROBLEM = own("this zip is for Blender 4.2 and later, the zip for earlier versions is called legacy")


def is_replaced() -> bool:
    """Return whether another version was installed over the running one, which Python can't load in its place."""
    return not _FILE.exists() or _FILE.stat().st_mtime_ns != _INSTALLED
