"""The sidebar, most important first."""

from . import edit, main, regularity, result, steps

CLASSES = tuple(cls for module in (main, edit, regularity, result, steps) for cls in module.CLASSES)
