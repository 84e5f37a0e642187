"""Operator that scales a scan by a known length."""

import bpy

from ...language import own, said
from ..controls import settings
from ..scene import mesh_io, store
from .edits import _Edit


class ISIMP_OT_set_length(_Edit, bpy.types.Operator):
    """Scale the scan so that the distance of two chosen planes, or a chosen diameter, has this length"""

    bl_idname = "isimp.set_length"
    bl_label = "Set Length"
    adjusted = ("length",)

    length: settings.KNOWN_LENGTH

    _scaled = ("", ())  #: the scan and its former scale
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
                self._scaled = scan.name, tuple(scan.scale)
                self._factor = self.length / (measured or value)
                scan.scale = [part * self._factor for part in scan.scale]
                context.view_layer.update()
                return target.recipe
        raise mesh_io.Unusable(said("Choose two parallel planes, or one round part: click a line of Sizes."))

    def _refuse(self, context, work, error):
        name, scale = self._scaled
        if name in bpy.data.objects:
            bpy.data.objects[name].scale = scale
        return super()._refuse(context, work, error)

    def told(self, before, numbers):
        return said("Scaled by {factor}", factor=f"{self._factor:.5g}")


CLASSES = (ISIMP_OT_set_length,)
