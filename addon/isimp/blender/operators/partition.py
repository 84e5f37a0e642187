import dataclasses

import bpy
import numpy as np
from bpy.props import BoolProperty

from ... import messages
from ... import recipe as rcp
from ...language import said
from ..controls import settings, units
from ..scene import mesh_io, pointed, selection, store, targets
from ..texts import text
from ..work.modal import RecipeOperator

_DETAIL = units.SHOWN[rcp.Partition]["detail_percent"]


class ISIMP_OT_partition(RecipeOperator, settings.PartitionSettings, bpy.types.Operator):
    """Split the scan into near-planar regions, shown in colours. The scan itself stays unchanged"""

    bl_idname = "isimp.partition"
    bl_label = "Partition"

    part: BoolProperty(
        name="Only Selected Faces",
        description="Split the selected faces only; all others stay in their regions",
        options={"SKIP_SAVE"},
    )

    detail_percent: _DETAIL

    @property
    def adjusted(self):
        way = {"detail": "detail_percent"}.get(self.count_by, self.count_by)
        return way, "adaptivity", "smooth"

    _is_pressed = False  # whether a button in Object Mode started the operator

    @property
    def does_all(self):
        return not self.part

    @classmethod
    def description(cls, context, properties):
        if properties.part:
            return said("Partition the selected faces only, with the settings above; all others stay in their regions")
        scan, problem = targets.find(context)
        edits = 0 if problem else messages.hand_edits(store.load(scan), context.window_manager.isimp.regularise_first)
        usual = said(cls.__doc__)
        return f"{usual}. {messages.will_drop(edits)}" if edits else usual

    @classmethod
    def problem(cls, context, scan):
        return ""

    def wanted(self, context, target):
        step = settings.to_step(rcp.Partition, self)
        if self.part:
            faces = self._faces(target.scan)
            if not len(faces):
                raise mesh_io.Unusable(
                    said("No face is selected: select the faces to partition in Edit Mode (Tab, then 3).")
                )
            step = dataclasses.replace(step, faces=tuple(faces.tolist()))
        given = [name for name in rcp.COUNTS if self.properties.is_property_set(name)]
        if len(given) == 1 and not self.properties.is_property_set("count_by"):
            step = dataclasses.replace(step, count_by=given[0])
        before = rcp.Recipe() if targets.needs_regions(target.scan) else store.load(target.scan)
        regularises = context.window_manager.isimp.regularise_first
        self._dropped = 0 if self.part else messages.hand_edits(before, regularises)
        if (last := before.whole()[1]) is not None and not self.part:  # choices for the scan are kept
            step = dataclasses.replace(step, keep_openings=last.keep_openings, more=last.more)
        return before.then(step)  # keeps the steps that locked regions depend on

    def invoke(self, context, event):
        self._is_pressed = context.mode == "OBJECT" and not bpy.app.background
        return super().invoke(context, event)

    def _faces(self, scan) -> np.ndarray:
        """Return the selected faces; for a button in Object Mode the faces of the regions clicked last."""
        if not self._is_pressed:
            return selection.selected_faces(scan)
        regions, faces = mesh_io.read_regions(scan), list(pointed.faces(scan))
        if not faces:
            raise mesh_io.Unusable(f"{said(pointed.NONE)}.")
        return np.flatnonzero(np.isin(regions, regions[faces]))

    def warnings(self, context, scan, before):
        lines = [] if before else text.lost_detail(scan, context.scene.unit_settings)  # on the first Partition only
        return [*lines, messages.dropped(self._dropped)] if self._dropped else lines

    def told(self, before, numbers):
        return messages.partitioned(numbers)


CLASSES = (ISIMP_OT_partition,)
