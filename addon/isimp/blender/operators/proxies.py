import bpy
from bpy.props import IntProperty

from ... import messages
from ... import recipe as rcp
from ...language import own, said
from .. import mesh_io, pending, targets
from ..modal import RecipeOperator
from ..show import show_regions

_MOST_FACES = 100


class AtFaces(RecipeOperator):
    """Mixin of edits at the selected faces, or at one given by number."""

    face: IntProperty(
        name="Face",
        description="Number of the face to edit; -1: the selected faces",
        default=-1,
        min=-1,
        options={"SKIP_SAVE"},
    )

    @classmethod
    def problem(cls, context, scan):
        missing = targets.needs_regions(scan)
        if not missing and scan.mode == "EDIT" and scan.data.total_face_sel == 0:
            missing = own("No face is selected: click one in face select mode (press 3)")
        return missing

    def faces(self, scan) -> list:
        """The faces to edit. Raises Unusable if there are none."""
        if self.face >= 0:
            return [self.face]
        faces = mesh_io.selected_faces(scan).tolist()
        if not faces:
            raise mesh_io.Unusable(said(messages.NO_FACE))
        return faces

    show = staticmethod(show_regions)

    def told(self, before, numbers):
        return messages.changed(before, numbers)


class ISIMP_OT_add_proxy(AtFaces, bpy.types.Operator):
    """Add a region at each selected face of the scan"""

    bl_idname = "isimp.add_proxy"
    bl_label = "Add Region"

    def wanted(self, context, scan):
        faces = self.faces(scan)
        if len(faces) > _MOST_FACES:
            text = own("{faces} are selected, and each would become a region: select at most {most}.")
            raise mesh_io.Unusable(said(text, faces=messages.count(len(faces), "face"), most=_MOST_FACES))
        recipe = pending.recipe_of(context, scan)
        for face in faces:
            recipe = recipe.then(rcp.AddProxy(face=face))
        return recipe


class ISIMP_OT_delete_proxy(AtFaces, bpy.types.Operator):
    """Delete each region with a selected face; its neighbours take its faces"""

    bl_idname = "isimp.delete_proxy"
    bl_label = "Delete Region"

    def wanted(self, context, scan):
        faces, regions = self.faces(scan), mesh_io.read_regions(scan)
        recipe, gone = pending.recipe_of(context, scan), set()
        for face in faces:
            region = int(regions[face]) if face < len(regions) else -1
            if region < 0 or region not in gone:
                gone.add(region)
                recipe = recipe.then(rcp.DeleteProxy(face=face))
        return recipe


CLASSES = (ISIMP_OT_add_proxy, ISIMP_OT_delete_proxy)
