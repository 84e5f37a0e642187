"""The panels of the sidebar, the most important first."""

from . import edit, main, options, planes, result, round_parts, steps

CLASSES = tuple(cls for module in (main, edit, round_parts, planes, result, options, steps) for cls in module.CLASSES)
