"""The Paint tool, which paints regions with a brush, and the Cut tool, which cuts a region along a line."""

import bpy
import numpy as np
from bpy.props import BoolProperty

from ...gestures import Cut, Stroke, painted_over
from ...language import own, said
from ..scene import pointed, runtime
from ..view import overlay
from . import under
from .point import ModalTool, choose, do, miss

_CUT = (1.0, 0.85, 0.2, 1.0)
_COLORS = {
    "paint": (1.0, 0.85, 0.2, 0.6),
    "new": (1.0, 1.0, 1.0, 0.6),
    "smooth": (0.4, 1.0, 0.5, 0.45),
    "erase": (0.3, 0.8, 1.0, 0.5),
    "finer": (1.0, 0.5, 0.3, 0.5),
}
_STROKES = {"erase": "isimp.erase_faces", "smooth": "isimp.smooth_faces"}
_AXES = {"NONE": None, "X": 0, "Y": 1, "Z": 2}


class ISIMP_OT_paint(ModalTool, bpy.types.Operator):
    """Extend the region where it begins. Ctrl: new region. Shift: smooth. Both: erase. Esc: cancel"""

    bl_idname = "isimp.paint"
    bl_label = "Paint Region"

    finer: BoolProperty(name="Finer Here", description="The stroke splits the regions under it", options={"SKIP_SAVE"})

    def start(self, context, event):
        if not self.begin(context, event):
            return {"CANCELLED"}
        ground, panel = self._ground, context.window_manager.isimp
        hit = ground.hit(self.ray(event))
        if hit is None:
            return miss()
        radius = panel.brush * ground.pixel(self._region, self._view, self.place(event), hit.place)
        axis = _AXES[panel.mirror]
        sides = [np.ones(3)] if axis is None else [np.ones(3), np.where(np.arange(3) == axis, -1.0, 1.0)]
        args = (ground.surface, ground.scan.triangle_face, ground.scan.edges[0], radius)
        self._strokes = [(side, Stroke(*args)) for side in sides]
        held = {(True, True): "erase", (True, False): "new", (False, True): "smooth"}
        verb = "finer" if self.finer else held.get((bool(event.ctrl), bool(event.shift)), panel.stroke)
        self._color, self._lock = _COLORS[verb], panel.lock_painted
        for side, stroke in self._strokes:
            place, direction = self.seen(event, side)
            stroke.press(place, direction, verb)
        self.show_stroke(context, event)
        return self.go(context, own("Release: apply · Esc: cancel"))

    def heard(self, context, event):
        if event.type == "MOUSEMOVE":
            for side, stroke in self._strokes:
                stroke.move(*self.seen(event, side))
            self.show_stroke(context, event)
        elif event.type == "LEFTMOUSE" and event.value == "RELEASE":
            wishes = [stroke.release() for _, stroke in self._strokes]
            self.end(context)
            self.fulfil([wish for wish in wishes if wish is not None])
            return {"FINISHED"}
        return {"RUNNING_MODAL"}

    def seen(self, event, side):
        """Return the hit of the mirrored ray, and its direction."""
        origin, direction = (side * part for part in self.ray(event))
        return self._ground.hit((origin, direction)), direction

    def show_stroke(self, context, event) -> None:
        hover = under.Hover(self._ground.name, -1, at=self.place(event), ring=context.window_manager.isimp.brush)
        for _, stroke in self._strokes:
            triangles = np.fromiter(stroke.covered, np.int64, len(stroke.covered))
            hover.fills.append((self._ground.points(triangles), self._color))
        runtime.get().hover = hover
        overlay.redraw()

    def fulfil(self, wishes) -> None:
        """Makes one undo step of the stroke and its mirrored stroke."""
        if wishes and wishes[0].verb == "finer":
            self.refine(wishes)
            return
        taken, strokes = set(), []
        for wish in wishes:
            faces = self._ground.joined(wish.faces, wish.faces[0])
            faces = [face for face in faces if face not in taken]  # both strokes may overlap in the middle
            taken.update(faces)
            if faces and self.changes(wish, faces):
                onto = -1 if wish.into is None else wish.into
                strokes.append(f"{onto}:{','.join(map(str, faces))}")
        if strokes:
            pointed.note(bpy.context.view_layer.objects.active, wishes[0].faces[0])
            verb = wishes[0].verb
            more = {} if verb in _STROKES else {"lock": self._lock}
            do(_STROKES.get(verb, "isimp.paint_faces"), painted=";".join(strokes), **more)
        elif wishes:
            self.report({"INFO"}, said("Nothing to paint: all faces are in that region already, or locked"))

    def refine(self, wishes) -> None:
        """Splits the regions that the strokes covered."""
        ground, faces = self._ground, [face for wish in wishes for face in wish.faces]
        found = painted_over(faces, ground.label, ground.locked)
        if not found:
            self.report({"INFO"}, said("Nothing to split: the regions are locked, or of one face"))
            return
        do("isimp.finer", face=found[-1], chosen=",".join(map(str, found)))

    def changes(self, wish, faces) -> bool:
        """Return whether any face changes; one side of a mirrored stroke may change none."""
        if wish.verb != "paint" or wish.into is None:
            return True
        regions, into = self._ground.label[faces], self._ground.label[wish.into]
        return bool((~np.isin(regions, self._ground.locked) & (regions != into)).any())


class ISIMP_OT_cut(ModalTool, bpy.types.Operator):
    """Drag a line over a region to cut it, as seen. Click: split it where its halves differ most"""

    bl_idname = "isimp.cut"
    bl_label = "Cut Region"

    collects: BoolProperty(
        name="Choose", description="A click chooses another region and splits none", options={"SKIP_SAVE"}
    )

    def start(self, context, event):
        if not self.begin(context, event):
            return {"CANCELLED"}
        self._cut, self._from = Cut(), self.place(event)
        self._rays = [self.ray(event)]
        hit = self._ground.hit(self._rays[0])
        self._cut.press(hit, self._from)
        if self.collects:
            if hit is None:
                return miss()
            return self.go(context, own("Release here: choose the region too · Drag over it: cut it · Esc: cancel"))
        return self.go(context, own("Release here: split in two · Drag over the region: cut it · Esc: cancel"))

    def heard(self, context, event):
        if event.type == "MOUSEMOVE":
            self._rays = [self._rays[0], self.ray(event)]
            self._cut.move(self._ground.hit(self._rays[1]), self.place(event))
            target = self._cut.target
            hover = under.Hover(self._ground.name, -1, at=self.place(event), stretch=(self._from, self.place(event)))
            if target is not None:
                hover.lines.append((self._ground.border(target.region), _CUT, 3.0))
            runtime.get().hover = hover
            overlay.redraw()
        elif event.type == "LEFTMOUSE" and event.value == "RELEASE":
            self.end(context)
            self.fulfil()
            return {"FINISHED"}
        return {"RUNNING_MODAL"}

    def fulfil(self) -> None:
        """Cuts the region along the line, at the depth of the hit, swept along the view direction."""
        wish, target = self._cut.release(), self._cut.target
        if wish is None:
            return
        if wish.verb == "split" and self.collects:
            choose(bpy.context, wish.faces[0])
            return
        if wish.verb == "split":
            do("isimp.split", face=wish.faces[0])
            return
        place = np.array(target.place)
        line = []
        for origin, direction in self._rays:
            line.append(origin + direction * float((place - origin) @ direction))
        sight = self._rays[0][1] + self._rays[1][1]
        do("isimp.cut_region", face=target.face, line=np.ravel(line).tolist(), direction=sight.tolist())


class ISIMP_OT_brush(ModalTool, bpy.types.Operator):
    """Change the brush's radius: move the mouse, then click"""

    bl_idname = "isimp.brush"
    bl_label = "Brush Radius"

    def start(self, context, event):
        self._before = context.window_manager.isimp.brush
        self._center = (event.mouse_region_x - self._before, event.mouse_region_y)
        self._from = event.mouse_x - self._before
        self.show_ring(context)
        return self.go(context, own("Move: radius · Click: apply · Esc: cancel"))

    def cancel(self, context):
        context.window_manager.isimp.brush = self._before
        super().cancel(context)

    def heard(self, context, event):
        if event.type == "MOUSEMOVE":
            context.window_manager.isimp.brush = max(1, event.mouse_x - self._from)
            self.show_ring(context)
        elif event.type in {"LEFTMOUSE", "RET"} and event.value == "PRESS":
            self.end(context)
            return {"FINISHED"}
        return {"RUNNING_MODAL"}

    def show_ring(self, context) -> None:
        runtime.get().hover = under.Hover("", -1, at=self._center, ring=context.window_manager.isimp.brush)
        overlay.redraw()


CLASSES = (ISIMP_OT_paint, ISIMP_OT_cut, ISIMP_OT_brush)
