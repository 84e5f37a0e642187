"""The sidebar, most important first."""

from . import edit, main, options, planes, result, steps

CLASSES = tuple(cls for module in (main, edit, planes, result, options, steps) for cls in module.CLASSES)
