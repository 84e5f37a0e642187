"""The engine, in the add-on's own folder or installed beside it. The only importer of it."""

ENGINE_PROBLEM = ""  #: why the engine can't be used; empty when it can
try:
    import isimp_engine as engine
except ImportError:
    try:
        from . import isimp_engine as engine
    except ImportError as error:
        engine = None
        ENGINE_PROBLEM = str(error)
