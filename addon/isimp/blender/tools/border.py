"""Operator that drags a border between two regions, or a corner of several; a click there adds a region."""

import bpy
import numpy as np

from ... import corner_drag
from ...border_drag import one_border, swept
from ...gestures import is_far
from ...language import own, said
from ..scene import runtime
from ..view import overlay
from . import under
from .point import ModalTool, do, miss

_TAKEN = (1.0, 0.85, 0.2, 0.6)


class ISIMP_OT_drag_border(ModalTool, bpy.types.Operator):
    """Drag: move the corner or the border nearest to the press. Click: add a region. Esc: cancel"""

    bl_idname = "isimp.drag_border"
    bl_label = "Drag Border"

    def start(self, context, event):
        if not self.begin(context, event):
            return {"CANCELLED"}
        self._ray = self.ray(event)
        self._hit = self._ground.hit(self._ray)
        if self._hit is None:
            return miss()
        self._from, self._is_dragged = self.place(event), False
        self._pair, self._strokes = None, []  # arrays of the two regions at the border; faces for each growing region
        reach = self._ground.reach(self._region, self._view, self._from, self._hit)
        self._around = self.corner(self._ground.corner(reach, self._hit))
        if self._around is not None:
            return self.go(context, own("Drag: move the corner · Release here: add a region · Esc: cancel"))
        return self.go(context, own("Drag: move the border · Release here: add a region · Esc: cancel"))

    def heard(self, context, event):
        if event.type == "MOUSEMOVE":
            self._is_dragged = self._is_dragged or is_far(self._from, self.place(event))
            if self._is_dragged:
                self.follow(event)
        elif event.type == "LEFTMOUSE" and event.value == "RELEASE":
            self.end(context)
            if not self._is_dragged:
                do("isimp.add_proxy", face=self._hit.face)
            elif self._strokes:
                do("isimp.move_border", painted=";".join(map(self.painted, self._strokes)))
            else:
                self.report({"INFO"}, said("No border was moved: drag across one into a region that is not locked"))
            return {"FINISHED"}
        return {"RUNNING_MODAL"}

    def follow(self, event) -> None:
        """Finds and shows the faces that change their region."""
        ground = self._ground
        hover = under.Hover(ground.name, -1, at=self.place(event), stretch=(self._from, self.place(event)))
        self._strokes = []
        for triangles in [self.moved(event)] if self._around is None else self.moved_by_corner(event):
            faces = ground.scan.triangle_face[triangles]
            if len(faces):
                self._strokes.append(tuple(dict.fromkeys(faces.tolist())))
                hover.fills.append((ground.points(triangles[ground.label[faces] != ground.label[faces[0]]]), _TAKEN))
        runtime.get().hover = hover
        overlay.redraw()

    def painted(self, faces: tuple) -> str:
        """Return a stroke for the Paint operator: the region of the first face gets the faces."""
        return f"{faces[0]}:{','.join(map(str, self._ground.joined(list(faces), faces[0])))}"

    def drag(self, event) -> np.ndarray:
        """Return the drag as a vector perpendicular to the view direction, in the scan's space."""
        place, sight = np.array(self._hit.place), self._ray[1]
        origin, direction = self.ray(event)
        moved: np.ndarray = origin + direction * ((place - origin) @ sight / (direction @ sight)) - place
        return moved

    def moved(self, event) -> np.ndarray:
        """Return triangles of the growing region near the border, then the triangles that it gets."""
        if self._pair is None and not self.find_pair():
            return np.empty(0, np.int64)
        ground, place, drag = self._ground, np.array(self._hit.place), self.drag(event)
        triangles, centers, pairs, ends, near = self._pair
        label = ground.label[ground.scan.triangle_face[triangles]]
        grows = (label == self._hit.region) == bool(drag @ (near - place) > 0)
        if np.isin(label[~grows][:1], ground.locked).any():
            return np.empty(0, np.int64)
        found = swept(centers, grows, ends, pairs, drag, self._ray[1])
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
        beside, edges, place = beside[mine], edges[mine], np.array(self._hit.place)
        first = int(np.argmin(np.linalg.norm(scan.vertices[edges].mean(axis=1) - place, axis=1)))
        other = int(beside[first].sum()) - region
        near = scan.vertices[edges[first]].mean(axis=0)
        ends = scan.vertices[one_border(edges[(beside == other).any(axis=1)], edges[first, 0])]
        triangles, centers = self.seen((region, other))
        number = np.full(len(scan.triangles), -1)
        number[triangles] = np.arange(len(triangles))
        pairs = number[scan.edges[0]]
        self._pair = triangles, centers, pairs[(pairs >= 0).all(axis=1)], ends, near
        return True

    def seen(self, regions) -> tuple[np.ndarray, np.ndarray]:
        """Return triangles of regions that face the same side as the one at the press, and (T, 3) their centers."""
        scan, place = self._ground.scan, np.array(self._hit.place)
        triangles = np.concatenate([self._ground.triangles_of(region) for region in regions])
        corners = scan.vertices[scan.triangles[triangles]].astype(np.float64)
        toward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) @ self._ray[1]
        is_seen = toward * toward[np.argmin(np.linalg.norm(corners.mean(axis=1) - place, axis=1))] > 0
        return triangles[is_seen], corners[is_seen].mean(axis=1)

    def corner(self, corner):
        """Return (triangles, corner_drag.Around) of a corner, None of None. corner: a vertex."""
        if corner is None:
            return None
        ground, scan = self._ground, self._ground.scan
        faces, edges = ground.between()
        beside = ground.label[faces]
        regions = np.unique(beside[(edges == corner).any(axis=1)])
        regions = regions[regions >= 0]
        own_edges = np.isin(beside, regions).all(axis=1)
        triangles, centers = self.seen(regions.tolist())
        label = ground.label[scan.triangle_face[triangles]]
        vertices = scan.vertices.astype(np.float64)
        around = corner_drag.Around(centers, label, vertices, edges[own_edges], beside[own_edges], corner)
        return triangles, around

    def moved_by_corner(self, event) -> list:
        """Return, for each growing region, its triangles near the corner and then the triangles that it gets."""
        ground, (triangles, around), drag = self._ground, self._around, self.drag(event)
        found, strokes = corner_drag.swept(around, drag, self._ray[1]), []
        away = np.linalg.norm(around.centers - around.vertices[around.corner], axis=1)
        for region, passed in found.items():
            taken = passed[~np.isin(around.label[passed], ground.locked)]
            home = np.flatnonzero((around.label == region) & (away <= 4 * np.linalg.norm(drag)))
            if len(taken) and len(home):
                home = home[np.argsort(away[home], kind="stable")]
                strokes.append(triangles[np.concatenate([home, taken])])
        return strokes


CLASSES = (ISIMP_OT_drag_border,)
