"""Writes an outcome to the scene: regions on the scan, or polygons as a result object."""

import uuid
from dataclasses import replace

from ... import edit_shares, messages, stored
from ...language import said
from ..drawing import late
from ..scene import mesh_io, result, selection, store, targets, transfer, unread_layers
from ..texts import text
from ..texturing import texture
from ..view import display, overlay, quick_start


def _save(scan, work, numbers: dict, face_region=None) -> int:
    """Stores the recipe and returns its state. Steps and layers that can't be read are kept elsewhere first.

    face_region: the regions, to compare its edits with the number of regions before; None: they have not changed.
    """
    before = store.numbers(scan)
    if face_region is not None:
        numbers = numbers | edit_shares.compared(work.recipe, face_region, before)
    store.keep(scan)
    unknown = not mesh_io.state_of(scan) and mesh_io.own_layer(scan.data, mesh_io.REGION) is not None
    unread_layers.rename(scan, regions_too=bool(store.read(scan).problem) or unknown)
    state = store.save(scan, work.recipe, numbers)
    work.states |= {mesh_io.state_of(scan), state}
    return state


def show_texture(scan, work, outcome, made) -> dict:
    """Writes the texture on an existing result without changing its polygons; returns the engine's report.

    Raises Unusable, before any change, if the result was changed since Mesh.
    """
    was_edited = result.is_edited(made)
    report = work.baking.put(made, outcome)
    if not was_edited:
        result.sign(made)
    mesh_io.write_state(scan, _save(scan, work, outcome.numbers, outcome.face_region))
    return report


def show_regions(context, scan, work, outcome) -> None:
    """Writes regions and colours on the scan and brings it to the front."""
    state = _save(scan, work, outcome.numbers, outcome.face_region)
    _write(scan, work, outcome, state)
    if context.view_layer.objects.active != scan or not scan.visible_get():
        bring_to_front(context, scan, targets.result_of(context.scene, scan))
    display.show(context)
    quick_start.end(context)


def show_polygons(context, scan, work, outcome):
    """Creates or refills the result, brings it to the front and hides the scan.

    Returns [(name, reason)] of kept results, which the user has edited or copied.
    """
    selection.leave_modes(context, scan)
    state = _save(scan, work, outcome.numbers, outcome.face_region)
    _write(scan, work, outcome, state)
    made, kept = result.to_fill(context, scan)
    selection.leave_modes(context, made)
    scan.isimp.key = scan.isimp.key or uuid.uuid4().hex
    made.isimp.scan_key, made.isimp.scan_name, made.isimp.scan_mesh = scan.isimp.key, scan.name, scan.data.name
    slid = transfer.values_of_keys(made)
    turn = result.fill(made, scan, outcome)
    transfer.bones(made, scan, work.scan, outcome)
    transfer.layers(made, scan, work.scan, outcome, turn, slid)
    if work.baking is None and not texture.is_textured(scan):  # a texture replaces the scan's materials
        result.take_materials(made, scan, outcome)
    if work.baking is not None:
        try:
            work.baking.put(made, outcome)
        except mesh_io.Unusable:
            work.baking = None
            work.untextured = said("Blender removed polygons that it takes as invalid")
    result.sign(made)
    mesh_io.give_color_back(scan.data)
    for old, why in kept:
        if why != result.COPIED or old.matrix_world == made.matrix_world:  # a copy at another place stays visible
            hide(context, old)
    bring_to_front(context, made, scan)
    display.show_result(context, made)
    return [(old.name, why) for old, why in kept]


def _color(work, outcome):
    return work.face_color if work.face_color is not None else outcome.face_color


def _write(scan, work, outcome, state) -> None:
    color, patch = _color(work, outcome), work.patch if late.fits(scan, work.patch) else None
    mesh_io.write_regions(scan, outcome.face_region, color, state, work.corner_color, tells=patch is None)
    work.corner_color = work.patch = None
    if scan.mode == "OBJECT":
        late.note(scan, state, color, patch)
        overlay.redraw()
        overlay.tell_late()


def writing(scan, work, outcome):
    """Writes regions in Edit Mode face by face, in pieces, so that the window stays responsive.

    Yields the completed share. In Object Mode, and for polygons, it does nothing: `show_outcome` writes them at once.
    """
    if scan.mode != "EDIT" or outcome.polygons is not None:
        return
    state = _save(scan, work, outcome.numbers, outcome.face_region)
    yield from mesh_io.writing(scan, outcome.face_region, _color(work, outcome), state)


def show_outcome(context, scan, work, outcome):
    """Shows the outcome of a recipe: polygons if it ends in Mesh, else regions. Returns like `show_polygons`."""
    return (show_regions if outcome.polygons is None else show_polygons)(context, scan, work, outcome)


def show_failed(context, scan, work, error) -> None:
    """Stores a recipe with a failed step and the reason. The previous result stays visible."""
    failed = {"failed": error.index, "reason": stored.line(messages.reason(error.reason, text.in_scene))}
    outcome = error.outcome
    if outcome is None or (mesh_io.state_of(scan) and not store.read(scan).problem):
        state = _save(scan, work, store.numbers(scan) | failed)
        mesh_io.write_state(scan, state)
    else:  # there is no previous result
        show_regions(context, scan, work, replace(outcome, numbers=outcome.numbers | failed))


def bring_to_front(context, shown, hidden) -> None:
    """Shows and selects one object, alone and active, and hides another (which may be None)."""
    for other in context.selected_objects:
        other.select_set(False)
    if hidden is not None:
        hide(context, hidden)
    if shown.isimp.unrendered:
        shown.hide_render, shown.isimp.unrendered = False, ""
    if shown.name in context.view_layer.objects:
        shown.hide_viewport = False
        shown.hide_set(False)
        shown.select_set(True)
        context.view_layer.objects.active = shown


def hide(context, obj) -> None:
    """Hides an object in viewports and renders. `bring_to_front` reverts both."""
    if not obj.hide_render:
        obj.hide_render, obj.isimp.unrendered = True, "yes"
    if obj.name in context.view_layer.objects:
        obj.hide_set(True)
