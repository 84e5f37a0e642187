"""The add-on's operators."""

from . import edits, mesh, partition, problems, proxies, recipes, regions, steps, texture

_MODULES = (partition, proxies, edits, mesh, texture, problems, steps, recipes, regions)
CLASSES = tuple(cls for module in _MODULES for cls in module.CLASSES)
