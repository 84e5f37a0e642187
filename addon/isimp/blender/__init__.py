"""Everything that touches Blender. Without numpy this is a panel that names the remedy."""

from . import without_numpy

if without_numpy.is_missing():
    from .without_numpy import register, unregister
else:
    from .everything import _CLASSES, register, unregister

    __all__ = ["_CLASSES", "register", "unregister"]
