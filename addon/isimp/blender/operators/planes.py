"""Operators that align planes of regions: Regularise finds related planes, Align sets the selected ones."""

import dataclasses

import bpy
import numpy as np
from bpy.props import EnumProperty, FloatProperty

from ... import recipe as rcp
from ...language import own, said
from ..controls import settings, up_direction
from ..controls.properties import AlignSettings
from ..scene import mesh_io, targets
from ..texts import text
from .edits import _Edit

_TO = AlignSettings.__annotations__["to"].keywords
_WITH_LEAD = ("parallel", "perpendicular", "coplanar")


class _Planes(_Edit):
    """Mixin of the operators of this module."""

    @property
    def _unit(self):
        return bpy.context.scene.unit_settings

    def told(self, before, numbers):
        return text.planes_line(numbers, self._unit.system, self._unit.scale_length)


class ISIMP_OT_regularise(_Planes, settings.RegulariseSettings, bpy.types.Operator):
    """Snap nearly level, upright, perpendicular, parallel or coplanar planes, within the limit"""

    bl_idname = "isimp.regularise"
    bl_label = "Regularise"
    adjusted = ("angle", "length", "up")
    does_all = True

    @classmethod
    def problem(cls, context, scan):
        return targets.needs_regions(scan)

    def wanted(self, context, target):
        step = up_direction.of_scan(settings.to_step(rcp.Regularise, self), target.scan)
        if step.up == "region":
            step = dataclasses.replace(step, face=self.faces(target.scan)[0])
        return target.recipe.then(step)


class ISIMP_OT_align(_Planes, bpy.types.Operator):
    """Set the planes of the regions of the selected faces. Regularise, Mesh and edits elsewhere keep them"""

    bl_idname = "isimp.align"
    bl_label = "Align Planes"
    adjusted = ("to", "length")

    @property
    def may_be_all(self):
        return self.to == "free"

    to: EnumProperty(**_TO)
    length: FloatProperty(**AlignSettings.__annotations__["length"].keywords)

    @classmethod
    def description(cls, context, properties):
        return said(_DESCRIPTIONS[properties.to])

    def wanted(self, context, target):
        faces = self._led(target.scan, self.each(target.scan))
        if len(faces) < 2 and self.to in _WITH_LEAD:
            several = own(
                "Only one region is selected: select faces of two or more. The region of the active face leads."
            )
            raise mesh_io.Unusable(said(several))
        up = settings.to_step(rcp.Regularise, settings.group(context, rcp.Regularise))
        step = rcp.AlignPlanes(faces=tuple(faces), to=self.to, length=round(self.length, 6))
        step = up_direction.as_last(step, up, target.recipe)
        return target.recipe.then(up_direction.of_scan(step, target.scan))

    def _led(self, scan, faces: list) -> list:
        """Return the faces, the leading region's first. It is the last clicked, the active or the largest region."""
        regions = mesh_io.read_regions(scan)
        if len(faces) < 2 or max(faces) >= len(regions):
            return faces
        if self.chosen:  # the region clicked last leads
            return [faces[-1], *faces[:-1]]
        chosen, active = regions[faces], scan.data.polygons.active
        lead = regions[active] if 0 <= active < len(regions) and scan.data.polygons[active].select else -1
        if lead < 0 or lead not in chosen:
            area = np.empty(len(regions))
            scan.data.polygons.foreach_get("area", area)
            lead = chosen[np.argmax([area[regions == region].sum() for region in chosen])]
        first = chosen.tolist().index(lead)
        return [faces[first], *faces[:first], *faces[first + 1 :]]


_DESCRIPTIONS = {
    "level": own("Make the regions of the selected faces level, as floors and ceilings are"),
    "upright": own("Make the regions of the selected faces upright, as walls are"),
    "parallel": own("Make the regions of the selected faces parallel to the region of the active face"),
    "perpendicular": own("Turn the regions of the selected faces at right angles to the region of the active face"),
    "coplanar": own("Put the regions of the selected faces into one plane: the plane of the active face if it is held"),
    "free": own("Release the planes of the selected faces' regions: they follow the scan, also after Regularise"),
}
CLASSES = (ISIMP_OT_regularise, ISIMP_OT_align)
