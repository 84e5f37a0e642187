"""Operator that scales a scan by a known length."""

import bpy

from ...language import own, said
from .. import reading
from ..controls import settings
from ..scene import mesh_io, store
from .edits import _Edit


class ISIMP_OT_set_length(_Edit, bpy.types.Operator):
    """Scale the scan so that the distance of two chosen planes, or a chosen diameter, has this length"""

    bl_idname = "isimp.set_length"
    bl_label = "Set Length"
    adjusted = ("length",)

    length: settings.KNOWN_LENGTH

    _scale = ()  #: of the scan once the work has ended well
    _factor = 1.0

    @classmethod
    def problem(cls, context, scan):
        missing = super().problem(context, scan)
        return missing or ("" if store.numbers(scan).get("sizes") else own("There are no sizes: press Mesh first"))

    def wanted(self, context, target):
        scan, regions = target.scan, mesh_io.read_regions(target.scan)
        chosen = {int(regions[face]) for face in self.each(scan)}
        for _, kind, value, _, measured, _, of in store.numbers(scan).get("sizes", []):
            if kind != "angle" and chosen == set(of):
                self._factor = self.length / (measured or value)
                self._scale = tuple(part * self._factor for part in scan.scale)
                return target.recipe.scaled(self._factor)
        raise mesh_io.Unusable(said("Choose two parallel planes, or one round part: click a line of Sizes."))

    def _read(self, context, scan, recipe):
        """Reads the scan with its new scale. The scan itself gets it in `show`, as the work may be stopped or fail."""
        before = tuple(scan.scale)
        _scale(context, scan, self._scale)
        try:
            reading.ready(context, scan, recipe.layers())
            return super()._read(context, scan, recipe)
        finally:
            _scale(context, scan, before)

    def show(self, context, scan, work, outcome):
        _scale(context, scan, self._scale)
        return super().show(context, scan, work, outcome)

    def told(self, before, numbers):
        return said("Scaled by {factor}", factor=f"{self._factor:.5g}")


def _scale(context, scan, scale: tuple) -> None:
    scan.scale = scale
    context.view_layer.update()


CLASSES = (ISIMP_OT_set_length,)
