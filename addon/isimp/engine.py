"""The engine, in the add-on's own folder or installed beside it. The only importer of it."""

from pathlib import Path

from .language import own

ENGINE_PROBLEM = ""  #: why the engine can't be used; empty when it can
try:
    import isimp_engine as engine
except ImportError as outer:
    try:
        from . import isimp_engine as engine
    except ImportError as inner:
        engine = None
        # What is there and does not load says more than what is not there.
        ENGINE_PROBLEM = str(inner if isinstance(outer, ModuleNotFoundError) else outer)
        if Path(__file__).with_name("wheels").is_dir() and not __name__.startswith("bl_ext."):
            ENGINE_PROBLEM = own("this one is for Blender 4.2 and later, the one for earlier ones is called legacy")
