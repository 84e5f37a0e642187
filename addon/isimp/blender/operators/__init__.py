"""The add-on's operators."""

from . import mesh, partition, proxies, regions

CLASSES = (*partition.CLASSES, *proxies.CLASSES, *mesh.CLASSES, *regions.CLASSES)
