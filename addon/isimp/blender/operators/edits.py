"""Edits of regions at faces, and edits whose place is chosen by the error."""

import bpy
import numpy as np
from bpy.props import BoolProperty, FloatProperty, FloatVectorProperty, IntProperty, StringProperty

from ... import messages
from ... import recipe as rcp
from ...language import own, said
from ..scene import mesh_io, targets
from ..work.modal import RecipeOperator
from .proxies import AtFaces


class _Edit(AtFaces):
    """Mixin of edits at one face of each region that has a selected face."""

    def each(self, scan) -> list:
        """Return one of the faces to edit for each of their regions."""
        faces, regions = np.array(self.faces(scan)), mesh_io.read_regions(scan)
        if faces.max() >= len(regions):
            return faces.tolist()  # the step fails with a message about the missing face
        return faces[np.sort(np.unique(regions[faces], return_index=True)[1])].tolist()


class ISIMP_OT_merge(_Edit, bpy.types.Operator):
    """Merge the regions of the selected faces into one. The regions must be neighbours"""

    bl_idname = "isimp.merge"
    bl_label = "Merge Regions"

    other: IntProperty(
        name="Other",
        description="A face of the region to merge with; -1: use the selection",
        default=-1,
        min=-1,
        options={"SKIP_SAVE"},
    )

    def wanted(self, context, target):
        faces = [self.face, self.other] if self.other >= 0 else self.each(target.scan)
        if len(faces) < 2:
            raise mesh_io.Unusable(
                said(
                    "Only one region is chosen: drag from one to the other with the Region tool, or select faces of "
                    "both in Edit Mode."
                )
            )
        return target.recipe.then(*(rcp.MergeRegions(face=faces[0], other=other) for other in faces[1:]))


class _Split(_Edit):
    """Mixin of splits, which differ in the names of their undo steps."""

    def wanted(self, context, target):
        return target.recipe.then(*(rcp.SplitRegion(face=face) for face in self.each(target.scan)))


class ISIMP_OT_split(_Split, bpy.types.Operator):
    """Split each region with a selected face in two where its halves differ most"""

    bl_idname = "isimp.split"
    bl_label = "Split Region"


class ISIMP_OT_finer(_Split, bpy.types.Operator):
    """Split each region under a stroke in two where its halves differ most"""

    bl_idname = "isimp.finer"
    bl_label = "Finer Here"


class ISIMP_OT_lock(_Edit, bpy.types.Operator):
    """Protect the regions of the selected faces: edits of other regions and Partition leave them unchanged"""

    bl_idname = "isimp.lock"
    bl_label = "Lock Regions"
    adjusted = ("unlock",)

    unlock: BoolProperty(name="Unlock", description="Remove the protection", options={"SKIP_SAVE"})

    @classmethod
    def description(cls, context, properties):
        free = said("Allow changes to the regions of the selected faces again, and make polygons of left-out regions")
        return free if properties.unlock else said(cls.__doc__)

    @property
    def may_be_all(self) -> bool:
        return self.unlock

    def wanted(self, context, target):
        step = rcp.UnlockRegions if self.unlock else rcp.LockRegions
        return target.recipe.then(step(faces=tuple(self.each(target.scan))))

    def told(self, before, numbers):
        return messages.locked(numbers)


class ISIMP_OT_leave_out(_Edit, bpy.types.Operator):
    """Make no polygons of the regions of the selected faces, such as a table or clutter; Unlock restores them"""

    bl_idname = "isimp.leave_out"
    bl_label = "Leave Out Regions"
    adjusted = ("box",)

    may_be_all = True

    box: BoolProperty(name="Box", description="A box replaces each group of adjacent regions", options={"SKIP_SAVE"})

    def wanted(self, context, target):
        step = rcp.LeaveOutRegions(faces=tuple(self.each(target.scan)), box=self.box)
        return target.recipe.then(step)

    def told(self, before, numbers):
        return messages.left_out(numbers)


class ISIMP_OT_grow(_Edit, bpy.types.Operator):
    """Grow each region with a selected face by its adjacent faces"""

    bl_idname = "isimp.grow"
    bl_label = "Grow Region"
    adjusted = ("rings", "shrink")

    rings: IntProperty(
        name="Rings", description="Width of the change in faces", default=1, min=1, soft_max=20, options={"SKIP_SAVE"}
    )
    shrink: BoolProperty(name="Shrink", description="Shrink the region", options={"SKIP_SAVE"})

    @classmethod
    def description(cls, context, properties):
        shrink = said("Shrink each region with a selected face: its neighbours take the faces along its border")
        return shrink if properties.shrink else said(cls.__doc__)

    def wanted(self, context, target):
        return target.recipe.then(*(self.step(face, self.rings, self.shrink) for face in self.each(target.scan)))

    @staticmethod
    def step(face: int, rings: int, shrink: bool):
        return (rcp.ShrinkRegion if shrink else rcp.GrowRegion)(face=face, rings=rings)


class _Strokes(AtFaces):
    """Mixin of strokes, which differ in the names of their undo steps."""

    painted: StringProperty(
        name="Faces",
        description="Strokes, as 'onto:face,face;onto:face': onto is a face of the region that they join, -1 for a new "
        "region. Empty: the selected faces become a new region",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def problem(cls, context, scan):
        return targets.needs_regions(scan)

    def wanted(self, context, target):
        return target.recipe.then(*(self.step(onto, faces) for onto, faces in self.strokes(target.scan)))

    def step(self, onto: int, faces: tuple):
        return rcp.PaintFaces(faces=faces, onto=onto)

    def strokes(self, scan) -> list:
        if not self.painted:
            if self._pressed_on:  # the faces of a clicked region form a region already
                raise mesh_io.Unusable(said(messages.NO_FACE))
            return [(-1, tuple(self.faces(scan)))]
        try:
            parts = [stroke.split(":") for stroke in self.painted.split(";")]
            return [(int(onto), tuple(map(int, faces.split(",")))) for onto, faces in parts]
        except ValueError:
            text = own("'{text}' is not a list of strokes: write 'onto:face,face'.")
            raise mesh_io.Unusable(said(text, text=self.painted[:40])) from None


class ISIMP_OT_paint_faces(_Strokes, bpy.types.Operator):
    """Make one region of exactly the selected faces"""

    bl_idname = "isimp.paint_faces"
    bl_label = "Paint Faces"
    adjusted = ("lock",)

    lock: BoolProperty(name="Lock", description="Lock the region if it is new", options={"SKIP_SAVE"})

    def step(self, onto, faces):
        return rcp.PaintFaces(faces=faces, onto=onto, lock=self.lock and onto < 0)


class ISIMP_OT_move_border(_Strokes, bpy.types.Operator):
    """Move a border or a corner: each region gets the faces of its stroke"""

    bl_idname = "isimp.move_border"
    bl_label = "Move Border"


class ISIMP_OT_erase_faces(_Strokes, bpy.types.Operator):
    """Erase faces from the region of the first one; its neighbours take them"""

    bl_idname = "isimp.erase_faces"
    bl_label = "Erase Faces"

    def step(self, onto, faces):
        return rcp.EraseFaces(faces=faces)


class ISIMP_OT_smooth_faces(_Strokes, bpy.types.Operator):
    """Smooth the region borders inside the faces"""

    bl_idname = "isimp.smooth_faces"
    bl_label = "Smooth Borders"

    def step(self, onto, faces):
        return rcp.SmoothFaces(faces=faces)


class ISIMP_OT_cut_region(AtFaces, bpy.types.Operator):
    """Cut a region along a line, swept along a direction; both in the scan's coordinates"""

    bl_idname = "isimp.cut_region"
    bl_label = "Cut Region"

    line: FloatVectorProperty(name="Line", description="Start and end point", size=6, options={"SKIP_SAVE"})
    direction: FloatVectorProperty(name="Direction", description="View direction", size=3, options={"SKIP_SAVE"})

    def wanted(self, context, target):
        line, sight = (tuple(self.line[:3]), tuple(self.line[3:])), tuple(self.direction)
        sight = sight if any(sight) else ()
        step = rcp.CutRegion(face=self.faces(target.scan)[0], line=line, direction=sight)
        return target.recipe.then(step)


class _Times(RecipeOperator):
    """Mixin of edits at the N places that the error chooses."""

    adjusted = ("times",)

    times: IntProperty(name="Times", description="Number of edits", default=1, min=1, soft_max=50)

    def wanted(self, context, target):
        return target.recipe.then(self.step(times=self.times))


class ISIMP_OT_add_worst(_Times, bpy.types.Operator):
    """Add N regions, each where a split lowers the error most"""

    bl_idname = "isimp.add_worst"
    bl_label = "Add at Worst"
    step = rcp.AddWorst


class ISIMP_OT_delete_least(_Times, bpy.types.Operator):
    """Delete the N regions whose removal adds least error"""

    bl_idname = "isimp.delete_least"
    bl_label = "Delete Least"
    step = rcp.DeleteLeast


class ISIMP_OT_merge_cheapest(_Times, bpy.types.Operator):
    """Merge N pairs of neighbouring regions, each time the pair that adds least error"""

    bl_idname = "isimp.merge_cheapest"
    bl_label = "Merge Cheapest"
    step = rcp.MergeCheapest


class ISIMP_OT_improve(RecipeOperator, bpy.types.Operator):
    """Move regions to places where they lower the error more, until it no longer falls. Their number stays"""

    bl_idname = "isimp.improve"
    bl_label = "Improve"

    def wanted(self, context, target):
        return target.recipe.then(rcp.Improve())


class ISIMP_OT_even_borders(RecipeOperator, bpy.types.Operator):
    """Make the borders of all regions short and straight. Creases stay borders, locked regions do not change"""

    bl_idname = "isimp.even_borders"
    bl_label = "Even Out Borders"
    adjusted = ("strength",)

    strength: FloatProperty(
        name="Strength",
        description="Weight of short borders relative to the error. 0: only teeth are removed",
        default=1.0,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
    )

    def wanted(self, context, target):
        return target.recipe.then(rcp.EvenBorders(strength=self.strength))

    def told(self, before, numbers):
        return messages.evened(numbers)


CLASSES = (
    ISIMP_OT_merge,
    ISIMP_OT_split,
    ISIMP_OT_finer,
    ISIMP_OT_lock,
    ISIMP_OT_leave_out,
    ISIMP_OT_grow,
    ISIMP_OT_paint_faces,
    ISIMP_OT_move_border,
    ISIMP_OT_erase_faces,
    ISIMP_OT_smooth_faces,
    ISIMP_OT_cut_region,
    ISIMP_OT_add_worst,
    ISIMP_OT_delete_least,
    ISIMP_OT_merge_cheapest,
    ISIMP_OT_improve,
    ISIMP_OT_even_borders,
)
