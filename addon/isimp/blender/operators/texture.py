import bpy

from ... import messages
from ... import recipe as rcp
from ...language import said
from .. import display, mesh_io, pending, show, store, targets
from ..modal import RecipeOperator


class ISIMP_OT_texture(RecipeOperator, bpy.types.Operator):
    """Put the texture of the scan on the result: a UV map, and a material with colours and normals"""

    bl_idname = "isimp.texture"
    bl_label = "Keep Texture"
    adjusted = ("size", "tiles", "occlusion")

    size: bpy.props.IntProperty(
        name="Size",
        description="Width and height of the image in pixels; 0: as dense as the scan's images",
        default=0,
        min=0,
        max=16384,
    )

    occlusion: bpy.props.BoolProperty(
        name="Ambient Occlusion",
        description="Make an image of how much light from all directions reaches the scan, for glTF and other tools",
        default=False,
    )
    occlusion_distance: bpy.props.FloatProperty(
        name="Occlusion Distance",
        description="How far away faces may lie that keep light off; 0: at any distance, which is dark inside a "
        "closed room",
        default=0.0,
        min=0.0,
        soft_max=10.0,
        subtype="DISTANCE",
    )

    height: bpy.props.BoolProperty(
        name="Height Map",
        description="Make an image of how far the scan lies above or below each polygon, with a Displacement node that "
        "is not linked: the normal map shows the same relief",
        default=False,
    )

    tiles: bpy.props.IntProperty(
        name="Tiles",
        description="How many images of that size, as UDIM tiles; 0: one, or if Size is 0 as many as the density needs",
        default=0,
        min=0,
        max=100,
    )
    materials: bpy.props.BoolProperty(
        name="Keep Materials Apart",
        description="Make a material with images of its own for each material of the scan. A polygon belongs to the "
        "one that most of its region shows",
        default=False,
    )

    @classmethod
    def problem(cls, context, scan):
        return "" if targets.result_of(context.scene, scan) else targets.NO_RESULT

    def wanted(self, context, scan):
        recipe = store.load(scan)
        if recipe is None or not recipe.ends_in_mesh():
            raise mesh_io.Unusable(said(messages.REGIONS_CHANGED))
        distance = round(self.occlusion_distance, 6)
        step = rcp.Texture(self.size, self.occlusion, distance, self.height, self.tiles, self.materials)
        return recipe.then(step)

    def _begin(self, context):
        work = super()._begin(context)
        if work is not None and work.untextured:
            self.report({"ERROR"}, work.untextured)
            return None
        return work

    def _finish(self, context, work, outcome):
        """The polygons stay as they are, and the scan's colours do."""
        pending.go_on()
        if context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        scan = self._target(work)
        made = targets.result_of(context.scene, scan) if scan is not None else None
        if made is None:
            return {"CANCELLED"}
        if work.baking is None:  # too many charts for the size
            self.report({"ERROR"}, work.untextured)
            return {"CANCELLED"}
        try:
            report = show.show_texture(scan, work, outcome, made)
        except mesh_io.Unusable as problem:
            self.report({"ERROR"}, str(problem))
            return {"CANCELLED"}
        for note in work.baking.notes:
            self.report({"WARNING"}, note)
        show.bring_to_front(context, made, scan)
        display.show_result(context, made)
        self.report({"INFO"}, messages.textured(report))
        return {"FINISHED"}


CLASSES = (ISIMP_OT_texture,)
