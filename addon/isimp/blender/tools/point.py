"""The Region tool, the highlight under the mouse, and shared code of all tools."""

from contextlib import suppress

import bpy
from bpy.props import BoolProperty, StringProperty

from ... import messages
from ...gestures import Pointing, is_far
from ...language import own, said
from ..scene import pointed, runtime, targets
from ..view import overlay
from ..work.modal import PROBLEMS, why
from . import under

_LIGHT = (1.0, 0.75, 0.4, 0.35)
_VERBS = {"add": "isimp.add_proxy", "delete": "isimp.delete_proxy"}
_HOLD = (1.0, 0.95, 0.3, 1.0)
_JOIN = (1.0, 0.85, 0.2, 0.45)
_EDGE = (1.0, 0.55, 0.05, 1.0)  # differs from the colours of borders and outline


def show_hover(context, ground, hit, at, joined=None, held=None) -> None:
    """Highlights and describes the region under the mouse.

    joined: the hit of the other region of a merge. held: the border or corner that a drag would move; see Ground.held.
    """
    current = runtime.get()
    before = current.hover
    key = None if hit is None else (ground.state, hit.region, joined, held and held[0])
    if hit is None:
        current.hover = None
    elif before is not None and before.key == key:
        before.at = at
    else:
        hover = current.hover = under.Hover(ground.name, hit.region, at=at, key=key)
        for region in [hit.region] if joined is None else [joined.region, hit.region]:
            triangles = ground.triangles_of(region)
            hover.fills.append((ground.points(triangles), _LIGHT if joined is None else _JOIN))
            hover.lines.append((ground.border(region), _EDGE, 4.0))
        told = ground.told(context.scene.unit_settings, hit.region)
        hover.text = told if joined is None else said("Release to merge both")
        if held is not None:
            is_corner = held[0][0] == "corner"
            hover.lines.append((held[1], _HOLD, 7.0))
            hover.ring = 10.0 if is_corner else 0.0
            hover.text = said("Drag to move this corner") if is_corner else said("Drag to move this border")
    if before is not None or current.hover is not None:
        overlay.redraw()


def do(operator: str, **settings) -> None:
    """Runs an operator like its button; the operator reports its errors."""
    if settings.get("face", -1) >= 0:
        pointed.note(bpy.context.view_layer.objects.active, settings["face"])
    group, name = operator.split(".")
    with suppress(RuntimeError):  # reported by the operator
        getattr(getattr(bpy.ops, group), name)("INVOKE_DEFAULT", True, **settings)


def in_viewport(context) -> bool:
    """Return whether the mouse is in the 3D view itself, not in a sidebar or header."""
    return context.region is not None and context.region.type == "WINDOW" and context.region_data is not None


def nothing_here(problem: str = "") -> str:
    """Return the message that there are no regions, with the place of the panel."""
    return said("{why} (sidebar: N, tab iSimp).", why=said(problem or own("There are no regions here")))


class ISIMP_OT_leave(bpy.types.Operator):
    """Remove the highlight while the mouse is in a sidebar or in another editor"""

    bl_idname = "isimp.leave"
    bl_label = "Leave the View"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context):
        return runtime.get() is not None and runtime.get().hover is not None and not in_viewport(context)

    def invoke(self, context, event):
        runtime.get().hover = None
        overlay.redraw()
        return {"PASS_THROUGH"}


class ISIMP_OT_turn(bpy.types.Operator):
    """Turn the view by a drag that begins off the scan. A click does nothing"""

    bl_idname = "isimp.turn"
    bl_label = "Turn the View"
    bl_options = {"INTERNAL"}

    def invoke(self, context, event):
        self._from = event.mouse_x, event.mouse_y
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "MOUSEMOVE" and is_far(self._from, (event.mouse_x, event.mouse_y)):
            with suppress(RuntimeError):  # for a view that can't be turned
                bpy.ops.view3d.rotate("INVOKE_DEFAULT")
            return {"FINISHED"}
        if event.type in {"LEFTMOUSE", "ESC", "RIGHTMOUSE"}:
            return {"FINISHED"}
        return {"RUNNING_MODAL"}


def miss():
    """Ends a tool whose press missed the scan. A drag then turns the view.

    The press must not reach Blender, which would select other objects, or move the scan by a drag.
    """
    runtime.get().pointed = None
    overlay.redraw()
    bpy.ops.isimp.turn("INVOKE_DEFAULT")
    return {"CANCELLED"}


class ModalTool:
    """Mixin of tools that run from a press of the mouse to its release.

    A subclass defines `start` and `heard`. If the scan can't be used or a step fails, the tool ends with a report.
    """

    bl_options = {"INTERNAL"}

    def invoke(self, context, event):
        try:
            return self.start(context, event)
        except PROBLEMS as problem:
            self.report({"ERROR"}, why(problem))
            return {"CANCELLED"}

    def place(self, event):
        return event.mouse_x - self._region.x, event.mouse_y - self._region.y

    def ray(self, event):
        return self._ground.ray(self._region, self._view, self.place(event))

    def begin(self, context, event) -> bool:
        """Prepares the scan under the mouse. Returns whether it has regions; else the reason is reported."""
        if not in_viewport(context):
            return False
        self._region, self._view = context.region, context.region_data
        scan, problem = targets.find(context)
        if not problem and context.view_layer.objects.active != scan:
            self.report({"INFO"}, f"{said(messages.RESULT_TOOL)}.")
            return False
        problem = problem or targets.needs_regions(scan)
        self._ground = under.ground_of(context, scan, wait=True) if not problem else None
        if self._ground is None:
            self.report({"INFO"}, nothing_here(problem))
        return self._ground is not None

    def go(self, context, keys: str):
        overlay.tell(context, keys)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def cancel(self, context):
        """Ends the tool without an effect. Blender calls this if the window or the file is closed."""
        self.end(context)

    def modal(self, context, event):
        """Drops the tool by Esc, the right button or undo. `heard` handles all other events."""
        undo = event.type == "Z" and (event.ctrl or event.oskey)
        if event.value == "PRESS" and (event.type in {"ESC", "RIGHTMOUSE"} or undo):
            self.cancel(context)
            return {"CANCELLED"}
        try:
            return self.heard(context, event)
        except PROBLEMS as problem:
            self.report({"ERROR"}, why(problem))
            self.cancel(context)
            return {"CANCELLED"}

    def end(self, context, redraws: bool = True) -> None:
        """Removes the highlight. redraws: False if a step follows, which redraws the view."""
        runtime.get().hover = None
        overlay.tell(context, "")
        if redraws:
            overlay.redraw()


class ISIMP_OT_hover(bpy.types.Operator):
    """Highlight and describe the region under the mouse"""

    bl_idname = "isimp.hover"
    bl_label = "Highlight Region"
    bl_options = {"INTERNAL"}

    keys: StringProperty(name="Keys", description="Text of the status bar", options={"SKIP_SAVE"})
    borders: BoolProperty(name="Borders", description="Show borders that a drag moves", options={"SKIP_SAVE"})

    def invoke(self, context, event):
        if not in_viewport(context):
            return {"PASS_THROUGH"}
        ground = under.ground(context)
        at = (event.mouse_region_x, event.mouse_region_y)
        hit = ground.hit(ground.ray(context.region, context.region_data, at)) if ground is not None else None
        held = None
        if hit is not None and self.borders and context.window_manager.isimp.hand == "add":
            held = ground.held(ground.reach(context.region, context.region_data, at, hit), hit)
        show_hover(context, ground, hit, at, held=held)
        overlay.tell(context, self.keys)
        return {"PASS_THROUGH"}


class ISIMP_OT_lock_here(ModalTool, bpy.types.Operator):
    """Lock the region under the mouse, or unlock it"""

    bl_idname = "isimp.lock_here"
    bl_label = "Lock or Unlock Region"

    def start(self, context, event):
        hit = self._ground.hit(self.ray(event)) if self.begin(context, event) else None
        if hit is None:
            return {"CANCELLED"}
        do("isimp.lock", face=hit.face, unlock=hit.region in self._ground.locked)
        return {"FINISHED"}


class _Chosen:
    """Mixin for actions on chosen regions. The event passes to Blender if no region is chosen."""

    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context):
        active = context.view_layer.objects.active
        return runtime.get() is not None and active is not None and bool(pointed.faces(active))


class ISIMP_OT_chosen_menu(_Chosen, bpy.types.Operator):
    """Open the menu for the regions that were chosen by shift-clicks"""

    bl_idname = "isimp.chosen_menu"
    bl_label = "Menu for Chosen Regions"

    def invoke(self, context, event):
        bpy.ops.wm.call_menu_pie(name="ISIMP_MT_chosen_pie")
        return {"FINISHED"}


class ISIMP_OT_choose_none(_Chosen, bpy.types.Operator):
    """Clear the chosen regions"""

    bl_idname = "isimp.choose_none"
    bl_label = "Choose No Region"

    def invoke(self, context, event):
        runtime.get().pointed = None
        overlay.redraw()
        return {"FINISHED"}


class ISIMP_OT_point(ModalTool, bpy.types.Operator):
    """Click: add a region. Ctrl: delete it. Drag a border: move it. Drag to another region: merge both"""

    bl_idname = "isimp.point"
    bl_label = "Region"

    def start(self, context, event):
        hand = "delete" if event.ctrl else context.window_manager.isimp.hand
        if hand == "cut":
            return bpy.ops.isimp.cut("INVOKE_DEFAULT")
        if hand == "more":
            return bpy.ops.isimp.find_part("INVOKE_DEFAULT")
        if hand == "finer":
            return bpy.ops.isimp.paint("INVOKE_DEFAULT", finer=True)
        if not self.begin(context, event):
            return {"CANCELLED"}
        hit = self._ground.hit(self.ray(event))
        if hit is None:
            return miss()
        reach = self._ground.reach(self._region, self._view, self.place(event), hit)
        if hand == "add" and self._ground.held(reach, hit) is not None:
            return bpy.ops.isimp.drag_border("INVOKE_DEFAULT")
        self._gesture = Pointing()
        self._gesture.press(hit, self.place(event), hand)
        return self.go(context, own("Drag to another region: merge both · Release: apply · Esc: cancel"))

    def heard(self, context, event):
        if event.type == "MOUSEMOVE":
            hit, at = self._ground.hit(self.ray(event)), self.place(event)
            self._gesture.move(hit, at)
            show_hover(context, self._ground, hit, at, self._gesture.begin if self._gesture.merging else None)
        elif event.type == "LEFTMOUSE" and event.value == "RELEASE":
            wish = self._gesture.release()
            self.end(context, redraws=wish is None or wish.verb == "choose")
            if wish is not None:
                self.fulfil(context, wish)
            return {"FINISHED"}
        return {"RUNNING_MODAL"}

    def fulfil(self, context, wish) -> None:
        if wish.verb == "merge":
            do("isimp.merge", face=wish.into, other=wish.faces[0])
        elif wish.verb == "choose":
            choose(context, wish.faces[0])
        else:
            do(_VERBS[wish.verb], face=wish.faces[0])


def choose(context, face: int) -> None:
    """Adds the region of a face to the chosen ones, or removes it; in Edit Mode its faces are selected too."""
    if context.mode == "EDIT_MESH":
        do("isimp.select_region", face=face, extend=True)
        return
    pointed.collect(context.view_layer.objects.active, face)
    overlay.redraw()


CLASSES = (
    ISIMP_OT_leave,
    ISIMP_OT_turn,
    ISIMP_OT_hover,
    ISIMP_OT_lock_here,
    ISIMP_OT_chosen_menu,
    ISIMP_OT_choose_none,
    ISIMP_OT_point,
)


def register() -> None:
    keys = bpy.context.window_manager.keyconfigs.addon
    if keys is not None:
        keymap = keys.keymaps.new("Screen")  # receives events that no other key map handles
        item = keymap.keymap_items.new("isimp.leave", "MOUSEMOVE", "ANY", any=True)
        runtime.get().keys.append((keymap, item))
