"""Operator that selects regions by a property: size, flatness, direction, number of polygons."""

import bpy
import numpy as np
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty

from ... import messages
from ... import recipe as rcp
from ...engine import engine
from ...language import said
from ...session import StepFailed
from .. import reading
from ..scene import mesh_io, pointed, runtime, selection, store, targets
from ..view import overlay
from ..work.selecting import SelectOperator


class ISIMP_OT_select_by(SelectOperator, bpy.types.Operator):
    """Select the faces of all regions that are small or bent, face a direction, or have many polygons"""

    bl_idname = "isimp.select_by"
    bl_label = "Select Regions By"

    by: EnumProperty(
        name="By",
        items=(
            ("SIZE", "Small", "Regions below a share of the area"),
            ("FLATNESS", "Bent", "Regions whose normals differ by more than an angle on average"),
            ("DIRECTION", "Facing", "Regions that face a direction, up to an angle"),
            ("CLUTTER", "Clutter", "Regions that take more than 8 polygons each, such as foliage. Press Mesh first"),
        ),
    )
    share: FloatProperty(
        name="Below",
        description="Share of the area of all regions",
        default=0.2,
        min=0.0,
        max=100.0,
        soft_max=5.0,
        precision=2,
        subtype="PERCENTAGE",
    )
    angle: FloatProperty(name="Angle", default=np.radians(20.0), min=0.0, max=np.pi, subtype="ANGLE")
    direction: FloatVectorProperty(
        name="Direction", description="In the world", default=(0.0, 0.0, 1.0), subtype="DIRECTION"
    )
    extend: BoolProperty(name="Extend", description="Keep the present selection", options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context):
        return targets.allows(cls, context, targets.needs_regions)

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "by")
        if self.by != "CLUTTER":
            layout.prop(self, "share" if self.by == "SIZE" else "angle")
        if self.by == "DIRECTION":
            layout.prop(self, "direction")
        layout.prop(self, "extend")

    def wanted(self, context):
        scan, _ = targets.find(context)
        recipe = store.load(scan) or rcp.Recipe()
        arrays = reading.read(context, scan, recipe.layers())
        regions = reading.regions(scan, arrays, recipe)
        if self.by == "CLUTTER":
            chosen = _cluttered(arrays, recipe)
            if chosen is None:
                self.report({"ERROR"}, said("No polygons show which regions are clutter: press Mesh first."))
                return None
        else:
            chosen = self.chosen(scan, arrays, regions)
        faces = np.append(chosen, False)[regions]
        if self.extend:
            faces[selection.selected_faces(scan)] = True
        self._count = int(chosen.sum())
        found, first = np.unique(regions, return_index=True)
        self._first = tuple(first[np.append(chosen, False)[found]].tolist())
        return scan, faces

    def conclude(self, context, scan):
        context.view_layer.objects.active = scan
        if scan.mode != "EDIT":  # where selected faces are not visible
            pointed.choose(scan, self._first)
            overlay.redraw()
        self.report({"INFO"}, said("{regions} selected", regions=messages.count(self._count, "region")))

    def chosen(self, scan, arrays, regions) -> np.ndarray:
        """Return (R,) bool: the regions to select."""
        label, count = regions[arrays.triangle_face], int(regions.max(initial=-1)) + 1
        area, normal = engine.regions.region_sides(arrays.vertices, arrays.triangles, label, count)
        length, there = np.linalg.norm(normal, axis=1), area > 0
        if self.by == "SIZE":
            return there & (area < 0.01 * self.share * area.sum())
        if self.by == "FLATNESS":
            # The mean normal of a spherical cap of this half-angle has the length cos(angle / 2) squared.
            return there & (length < area * np.cos(0.5 * self.angle) ** 2)
        place = mesh_io.place_matrix(scan)[:3, :3]
        wanted = np.array(self.direction, np.float64) @ place  # orthogonal, possibly mirrored
        wanted /= max(np.linalg.norm(wanted), 1e-30)
        return there & (normal @ wanted > length * np.cos(self.angle))


def _cluttered(arrays, recipe) -> np.ndarray | None:
    """Return (R,) bool: the cluttered regions; None if the recipe makes no polygons."""
    try:
        outcome = runtime.get().session.replay(arrays, recipe)
    except StepFailed:
        return None
    if outcome.polygons is None:
        return None
    chosen = np.zeros(outcome.partition.region_count, bool)
    chosen[[each.region for each in engine.clutter.clutter(outcome.polygons)]] = True
    return chosen


CLASSES = (ISIMP_OT_select_by,)
