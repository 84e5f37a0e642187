"""The part of the add-on that imports bpy. Without numpy, only a panel with the remedy is registered."""

from . import without_numpy

if without_numpy.is_missing():
    from .without_numpy import register, unregister
else:
    from .everything import _CLASSES, register, unregister

    __all__ = ["_CLASSES", "register", "unregister"]
