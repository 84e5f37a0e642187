"""The sidebar, most important first."""

from . import edit, main, result, steps

CLASSES = tuple(cls for module in (main, edit, result, steps) for cls in module.CLASSES)
