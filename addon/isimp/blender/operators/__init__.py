"""The add-on's operators."""

from . import edits, mesh, partition, problems, proxies, recipes, regions, steps

_MODULES = (partition, proxies, edits, mesh, problems, steps, recipes, regions)
CLASSES = tuple(cls for module in _MODULES for cls in module.CLASSES)
