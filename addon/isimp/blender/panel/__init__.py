"""The panels of the sidebar, the most important first."""

from . import edit, main, more, planes, result, round_parts, sizes, steps

CLASSES = tuple(
    cls for module in (main, edit, planes, round_parts, sizes, result, more, steps) for cls in module.CLASSES
)
