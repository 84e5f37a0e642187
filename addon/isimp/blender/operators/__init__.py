"""The add-on's operators."""

from . import mesh, partition, proxies, recipes, regions, steps

_MODULES = (partition, proxies, mesh, steps, recipes, regions)
CLASSES = tuple(cls for module in _MODULES for cls in module.CLASSES)
