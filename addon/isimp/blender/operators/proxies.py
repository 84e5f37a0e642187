import re

import bpy
import numpy as np
from bpy.props import IntProperty, StringProperty

from ... import messages
from ... import recipe as rcp
from ...language import own, said
from ..scene import mesh_io, pointed, selection, targets
from ..work.modal import RecipeOperator

_MOST_FACES = 100
_MOST_REGIONS = 20  # most regions that an edit changes if all faces are selected


class AtFaces(RecipeOperator):
    """Mixin of edits at the selected faces, or at faces given by number."""

    face: IntProperty(
        name="Face",
        description="Number of the face to edit; -1: the selected faces",
        default=-1,
        min=-1,
        options={"SKIP_SAVE"},
    )

    chosen: StringProperty(
        name="Faces",
        description="Numbers of the faces to edit, with commas between them; empty: the face above",
        options={"SKIP_SAVE", "HIDDEN"},
    )

    #: Whether the edit is useful on all faces of the scan
    may_be_all = False

    _pressed_on = ""  #: the name of the scan, if a button was pressed in Object Mode

    @classmethod
    def problem(cls, context, scan):
        missing = targets.needs_regions(scan)
        if not missing and scan.mode == "EDIT" and scan.data.total_face_sel == 0:
            missing = own("No face is selected: click one in face select mode (press 3)")
        return missing

    def press(self, target):
        if self.face < 0 and not self.chosen and not target.problem and target.scan.mode == "OBJECT":
            self.choose(pointed.faces(target.scan))
            self._pressed_on = target.scan.name

    def choose(self, faces) -> None:
        """Sets the faces to edit, in place of the selected ones."""
        self.face = faces[-1] if len(faces) else -1
        self.chosen = ",".join(map(str, faces)) if len(faces) > 1 else ""

    def faces(self, scan) -> list:
        """Return the faces to edit. Raises Unusable if there are none, or if all are selected by an importer."""
        if self.chosen:
            return self._parsed()
        if self._pressed_on and (self.face < 0 or self._pressed_on != scan.name):
            raise mesh_io.Unusable(f"{said(pointed.NONE)}.")
        if self.face >= 0:
            return [self.face]
        faces = selection.selected_faces(scan).tolist()
        if not faces:
            raise mesh_io.Unusable(said(messages.NO_FACE))
        is_all = len(faces) == len(scan.data.polygons) and not self.may_be_all  # importers select all faces
        if is_all and len(np.unique(mesh_io.read_regions(scan))) > _MOST_REGIONS:
            text = own("All {faces} are selected: select a few.")
            raise mesh_io.Unusable(said(text, faces=messages.count(len(faces), "face")))
        return faces

    def _parsed(self) -> list:
        try:
            return [int(face) for face in self.chosen.split(",")]
        except ValueError:
            text = own("'{text}' is not a list of faces: write numbers with commas between them.")
            raise mesh_io.Unusable(said(text, text=self.chosen[:40])) from None

    def _reason(self, work, error):
        """Return the reason, with the number of the region unless the user has just clicked it."""
        told, scan = super()._reason(work, error), work.target()
        found = re.search("face ([0-9]+)", error.reason)
        if found is None or scan is None or not (self.face < 0 or self.chosen or self._pressed_on):
            return told
        regions, face = mesh_io.read_regions(scan), int(found[1])
        number = int(regions[face]) if face < len(regions) else -1
        return said("Region {number}: {why}", number=number, why=told) if number >= 0 else told


class ISIMP_OT_add_proxy(AtFaces, bpy.types.Operator):
    """Add a region at each selected face of the scan"""

    bl_idname = "isimp.add_proxy"
    bl_label = "Add Region"

    def wanted(self, context, target):
        faces = self.faces(target.scan)
        if len(faces) > _MOST_FACES:
            text = own("{faces} are selected, and each would become a region: select at most {most}.")
            raise mesh_io.Unusable(said(text, faces=messages.count(len(faces), "face"), most=_MOST_FACES))
        return target.recipe.then(*(rcp.AddProxy(face=face) for face in faces))


class ISIMP_OT_delete_proxy(AtFaces, bpy.types.Operator):
    """Delete each region with a selected face; its neighbours take its faces"""

    bl_idname = "isimp.delete_proxy"
    bl_label = "Delete Region"

    def wanted(self, context, target):
        faces, regions = self.faces(target.scan), mesh_io.read_regions(target.scan)
        steps, gone = [], set()
        for face in faces:
            region = int(regions[face]) if face < len(regions) else -1
            if region < 0 or region not in gone:
                gone.add(region)
                steps.append(rcp.DeleteProxy(face=face))
        return target.recipe.then(*steps)


CLASSES = (ISIMP_OT_add_proxy, ISIMP_OT_delete_proxy)
