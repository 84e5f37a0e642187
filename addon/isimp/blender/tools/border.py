"""Dragging the border between two regions; a click instead selects the faces of the region."""

import bpy
import numpy as np

from ...border_drag import swept
from ...gestures import is_far
from ...language import own, said
from ..scene import runtime
from ..view import overlay
from . import under
from .point import ModalTool, do, miss

_TAKEN = (1.0, 0.85, 0.2, 0.6)


class ISIMP_OT_drag_border(ModalTool, bpy.types.Operator):
    """Alt-click: select the faces of the region. Alt-drag: move the border nearest to it by the drag. Esc: cancel"""

    bl_idname = "isimp.drag_border"
    bl_label = "Drag Border"

    def invoke(self, context, event):
        if not self.begin(context, event):
            return {"CANCELLED"}
        self._ray = self.ray(event)
        self._hit = self._ground.hit(self._ray)
        if self._hit is None:
            return miss()
        self._from, self._is_dragged = self.place(event), False
        self._pair, self._faces = None, ()  # the two regions at the border; the faces that the border passes
        return self.go(context, own("Drag: move the border · Release here: select the region · Esc: cancel"))

    def modal(self, context, event):
        if self.is_dropped(event):
            self.end(context)
            return {"CANCELLED"}
        if event.type == "MOUSEMOVE":
            self._is_dragged = self._is_dragged or is_far(self._from, self.place(event))
            if self._is_dragged:
                self.follow(event)
        elif event.type == "LEFTMOUSE" and event.value == "RELEASE":
            self.end(context)
            if not self._is_dragged:
                do("isimp.select_region", face=self._hit.face)
            elif len(self._faces):
                start = self._faces[0]
                joined = self._ground.joined(list(self._faces), start)
                do("isimp.paint_faces", painted=f"{start}:{','.join(map(str, joined))}")
            else:
                self.report({"INFO"}, said("No border was moved: drag across one into a region that is not locked"))
            return {"FINISHED"}
        return {"RUNNING_MODAL"}

    def follow(self, event) -> None:
        """Finds and shows the faces that change their region."""
        ground = self._ground
        triangles = self.moved(event)
        faces = ground.scan.triangle_face[triangles]
        hover = under.Hover(ground.name, -1, at=self.place(event), stretch=(self._from, self.place(event)))
        self._faces = tuple(dict.fromkeys(faces.tolist()))
        if len(triangles):
            hover.fills.append((ground.points(triangles[ground.label[faces] != ground.label[faces[0]]]), _TAKEN))
        runtime.get().hover = hover
        overlay.redraw()

    def moved(self, event) -> np.ndarray:
        """The triangles of the growing region, then the triangles that it takes."""
        if self._pair is None and not self.find_pair():
            return np.empty(0, np.int64)
        ground, place = self._ground, np.array(self._hit.place)
        origin, direction = self.ray(event)
        sight = self._ray[1]
        drag = origin + direction * ((place - origin) @ sight / (direction @ sight)) - place
        triangles, centers, pairs, ends, near = self._pair
        label = ground.label[ground.scan.triangle_face[triangles]]
        grows = (label == self._hit.region) == bool(drag @ (near - place) > 0)
        if np.isin(label[~grows][:1], ground.locked).any():
            return np.empty(0, np.int64)
        found = swept(centers, grows, ends, pairs, drag, sight)
        found = np.concatenate([found[grows[found]], found[~grows[found]]])
        return triangles[found]

    def find_pair(self) -> bool:
        """Finds the border nearest to the press and the visible triangles of both its regions."""
        ground, scan, region = self._ground, self._ground.scan, self._hit.region
        faces, edges = ground.between()
        beside = ground.label[faces]
        mine = (beside == region).any(axis=1) & (beside >= 0).all(axis=1)
        if region < 0 or not mine.any():
            return False
        beside, ends = beside[mine], scan.vertices[edges[mine]]
        place = np.array(self._hit.place)
        first = int(np.argmin(np.linalg.norm(ends.mean(axis=1) - place, axis=1)))
        other = int(beside[first].sum()) - region
        ends, near = ends[(beside == other).any(axis=1)], ends[first].mean(axis=0)
        triangles = np.concatenate([ground.triangles_of(region), ground.triangles_of(other)])
        corners = scan.vertices[scan.triangles[triangles]].astype(np.float64)
        toward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) @ self._ray[1]
        seen = toward * toward[np.argmin(np.linalg.norm(corners.mean(axis=1) - place, axis=1))] > 0
        triangles, corners = triangles[seen], corners[seen]
        number = np.full(len(scan.triangles), -1)
        number[triangles] = np.arange(len(triangles))
        pairs = number[scan.edges[0]]
        self._pair = triangles, corners.mean(axis=1), pairs[(pairs >= 0).all(axis=1)], ends, near
        return True


CLASSES = (ISIMP_OT_drag_border,)
