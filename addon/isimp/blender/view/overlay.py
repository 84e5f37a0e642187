"""The overlay of the scan in the viewports: region borders, outline of the polygons, highlights of the tools.

A thread computes the sketch (see sketch.py) once for each state of a scan, and the sketch is cached. Draw handlers only
upload arrays to the graphics card, and never change data of the file.
"""

import bpy
import gpu
import numpy as np

from ... import messages, sketch
from ... import recipe as rcp
from ...language import said
from ...task import Status, Task
from .. import preferences, reading
from ..controls import settings, up_direction
from ..drawing import late, sketches
from ..drawing.space import ON, Over
from ..scene import mesh_io, pointed, runtime, store, targets
from ..texts import text, viewport_text

_KEPT = 8  # cached sketches
_OLD = 0.4  # strength of the former polygons until the new ones are ready
_MARK = (1.0, 0.55, 0.05, 0.8)
_TICK = 0.1
_MOST_EDGES = 20_000  # edges of a result that are drawn
_THIN = (0.0, 0.0, 0.0, 0.5)
_LATE, _UNDER = 0.0003, 0.0015  # like ON, for delayed colours and previews, which lie under the lines


def scan_shown(context):
    """Return the active scan if its regions are visible, or None."""
    scan, problem = targets.seen(context)
    seen = not problem and context.view_layer.objects.active == scan and scan.visible_get()
    if not (seen and mesh_io.state_of(scan) and mesh_io.has_shape(scan)) or targets.needs_regions(scan):
        return None
    return scan


def hover_shown(context):
    """Return the highlight under the mouse; None if there is none, or its scan is not shown."""
    hover = runtime.get().hover
    if hover is None or not context.space_data.overlay.show_overlays:
        return None
    scan = scan_shown(context) if hover.scan else None
    return hover if not hover.scan or (scan is not None and scan.name == hover.scan) else None


def _key(context, scan):
    """Return the key of a sketch: scan, state, shape and box, and the steps that make polygons (None without).

    The box detects that vertices were moved, or that another mesh has the same name and recipe.
    """
    panel, shown = context.window_manager.isimp, runtime.get().live.shown_of(scan)
    wants = panel.outline or panel.heat or panel.away or panel.directions or panel.summary
    first = up_direction.first(context, scan) if wants and panel.regularise_first else None
    meshing = (settings.to_step(rcp.Mesh, panel.mesh), first) if wants else None
    state = mesh_io.state_of(scan) if shown is None else shown.work.recipe
    shape = mesh_io.shape_matrix(scan).tobytes() + np.array(scan.bound_box).tobytes()
    return scan.name, state, shape, meshing


def _drawing(context, scan):
    """Return the present drawing, possibly without polygons, or None; requests the missing part."""
    drawings, key = runtime.get().drawings, _key(context, scan)
    if key in drawings:
        drawings.move_to_end(key)
        return drawings[key]
    if not bpy.app.timers.is_registered(_tick):
        bpy.app.timers.register(_tick, first_interval=_TICK)
    same = next((drawings[other] for other in reversed(drawings) if other[:3] == key[:3]), None)
    if same is None and runtime.get().live.shown_of(scan) is None:
        made = _at_once(scan)
        same = None if made is None else _store(_without_polygons(key), made)
    return same


def _at_once(scan):
    """Return a sketch without polygons if all its data are cached; else None."""
    known, recipe = runtime.get().scans.get(scan.name), store.load(scan)
    if known is None or recipe.layers():
        return None
    return sketch.at_once(runtime.get().session, known.scan, recipe)


def _former(context, scan):
    """Return the drawing with former polygons while the visible regions have none; else None."""
    drawings, key = runtime.get().drawings, _key(context, scan)
    if key[3] is None or any(other[:3] == key[:3] and other[3] is not None for other in drawings):
        return None
    same = (drawings[other] for other in reversed(drawings) if (other[0], other[2]) == (key[0], key[2]))
    return next((drawing for drawing in same if len(drawing.sketch.outline)), None)


def _missing(context, scan):
    """Return the key of the next sketch to make; None if all are ready. Borders are made before polygons."""
    drawings, key = runtime.get().drawings, _key(context, scan)
    if key in drawings:
        return None
    plain = _without_polygons(key)
    return key if plain in drawings else plain


def _without_polygons(key):
    return (*key[:3], None)


def _tick():
    """Starts the missing sketch, or stores a finished one. A timer calls it. Other work has priority."""
    current, context = runtime.get(), bpy.context
    if current is None or not context.window_manager.isimp.overlay:
        return None
    if current.running is not None or current.live.work is not None or current.live.held:
        return _TICK
    scan = scan_shown(context)
    key = None if scan is None else _missing(context, scan)
    if current.sketching is not None:
        if current.sketching[1].status is Status.RUNNING and current.sketching[0] == key:
            return _TICK
        _take(current)
        key = None if scan is None else _missing(context, scan)
    return None if key is None else _start(context, scan, key)


def _take(current) -> None:
    """Stores the finished sketch, or ends one that is no longer wanted."""
    wanted, task = current.sketching
    current.stop_sketching()
    if task.status is not Status.STOPPED:
        _keep(wanted, task.result or sketch.Sketch(reason=str(task.error)))


def _start(context, scan, key):
    """Starts a sketch when its scan is read."""
    current, recipe = runtime.get(), None
    if current.live.shown_of(scan) is None:
        recipe = store.load(scan)
        if not reading.ready(context, scan, recipe.layers(), reading.SPAN):
            return _TICK
    try:
        recipe, arrays, regions = _seen(context, scan, recipe)
    except mesh_io.Unusable as problem:
        _keep(_key(context, scan), sketch.Sketch(reason=str(problem)))
        return None
    session, (meshing, first) = current.session, key[3] or (None, None)
    task = Task(lambda watch: sketch.draw(session, arrays, regions, recipe, meshing, watch, first))
    current.sketching = (key, task)
    return _TICK


def tell_late() -> None:
    """Starts a timer that reports delayed colours to Blender (late.py) when no other work is running."""
    if not bpy.app.background and not bpy.app.timers.is_registered(_rest):
        bpy.app.timers.register(_rest, first_interval=_TICK)


def _rest():
    current = runtime.get()
    is_due = None if current is None else late.is_due()
    if is_due is None:
        return None
    others = current.running or current.live.work or current.sketching or bpy.app.timers.is_registered(_tick)
    if others or not is_due:
        return _TICK
    late.settle()
    return None


def _seen(context, scan, recipe):
    """Return recipe, arrays and regions of a visible scan, or of its preview. Raises Unusable.

    recipe: as stored; None: there is a preview.
    """
    shown = runtime.get().live.shown_of(scan)
    if shown is not None:
        return shown.work.recipe, shown.work.scan, shown.work.task.result.face_region
    arrays = reading.read(context, scan, recipe.layers())
    return recipe, arrays, reading.regions(scan, arrays, recipe)


def _keep(key, made) -> None:
    _store(key, made)
    late.settle()  # one redraw for both changes
    redraw()


def _store(key, made):
    drawings = runtime.get().drawings
    drawings.pop(_without_polygons(key), None)
    drawings[key] = sketches.Drawing(made)
    while len(drawings) > _KEPT:
        drawings.popitem(last=False)
    return drawings[key]


def redraw() -> None:
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def tell(context, keys: str) -> None:
    """Shows the keys in the status bar until another tool is chosen; an empty text clears it."""
    current = runtime.get()
    if current.status != keys:
        current.status = keys
        context.workspace.status_text_set(said(keys) if keys else None)


def _tool_is_ours(context) -> bool:
    tool = context.workspace.tools.from_space_view3d_mode(context.mode, create=False)
    return tool is not None and tool.idname.startswith("isimp.")


def _leave():
    """Clears highlight and status bar after another tool was chosen."""
    if runtime.get() is not None and runtime.get().status:
        runtime.get().hover = None
        tell(bpy.context, "")
        redraw()


def _draw():
    current, context = runtime.get(), bpy.context
    if current is None:
        return
    if current.status and not _tool_is_ours(context) and not bpy.app.timers.is_registered(_leave):
        bpy.app.timers.register(_leave, first_interval=0.0)  # draw handlers must not change data
    _draw_result(context)
    scan = scan_shown(context)
    if scan is None:
        return
    shown, lines_too = current.live.shown_of(scan), context.space_data.overlay.show_overlays
    with Over(context.region_data, scan) as space:
        if context.space_data.shading.type == "SOLID":
            space.nearer(_LATE if shown is None else _UNDER)
            if shown is not None:
                shown.draw()
            elif context.space_data.shading.color_type == "VERTEX":
                late.draw(scan)
            space.nearer(ON)
        if lines_too and context.window_manager.isimp.overlay:
            _draw_lines_over(context, space, scan, shown)
        if (hover := hover_shown(context)) is not None:
            sketches.draw_hover(hover)
        if lines_too and shown is None and _is_chosen_shown(context, scan):
            sketches.lines(pointed.outline(scan), _MARK, 2.5)


def _draw_result(context) -> None:
    """Draws the edges of the active result, thin and dark. Blender's wires of selected objects would be orange."""
    made = context.view_layer.objects.active
    if targets.scan_of(made) is None or made.mode != "OBJECT" or not made.visible_get() or made.show_wire:
        return
    if not mesh_io.has_shape(made):
        return
    if context.space_data.overlay.show_overlays and 0 < len(made.data.edges) <= _MOST_EDGES and not made.modifiers:
        with Over(context.region_data, made):
            sketches.lines(mesh_io.edge_lines(made.data), _THIN, 1.0)


def _is_chosen_shown(context, scan) -> bool:
    """Return whether to outline the clicked regions: several always, one only if no region is under the mouse."""
    count = len(pointed.faces(scan))
    return count > 1 or (count == 1 and context.mode == "OBJECT" and hover_shown(context) is None)


def _draw_lines_over(context, space, scan, shown) -> None:
    wish, drawing, former = preferences.get(context), _drawing(context, scan), _former(context, scan)
    if drawing is not None:
        with space.at(drawing.sketch.origin):
            sketches.draw_sketch(context, space, drawing)
    if former is not None and context.window_manager.isimp.outline:
        with space.at(former.sketch.origin):
            space.nearer(sketches.OVER)
            sketches.draw_outline(former, space.pixels(context), wish, _OLD)
            space.nearer(ON)
    if drawing is not None:
        return
    if shown is not None and len(shown.work.borders):
        shown.draw_borders(sketches.line_shader(wish.border_color, wish.line_width))


def reported(context, scan) -> tuple:
    """Return (numbers of the polygons drawn over a scan, whether they belong to its present regions)."""
    made, current = previewed(context, scan), runtime.get()
    if made:
        current.report = scan.name, made
        return made, True
    name, former = current.report
    return (former if name == scan.name else {}), False


def problem_faces(context, scan) -> tuple:
    """Return a face of each region whose polygons are drawn as defective over the scan."""
    drawing = runtime.get().drawings.get(_key(context, scan)) if previewed(context, scan) else None
    return () if drawing is None else drawing.sketch.problem_faces


def previewed(context, scan) -> dict:
    """Return the numbers of the polygons drawn over a scan if they belong to its present regions; else {}."""
    if scan_shown(context) is None:
        return {}
    try:
        drawing = runtime.get().drawings.get(_key(context, scan))
    except ValueError:  # unusable settings
        return {}
    made = drawing.sketch.numbers if drawing is not None else {}
    return made if made.get("regions_before") == store.numbers(scan).get("regions") else {}


def _draw_summary(context) -> None:
    """Draws the numbers of regions and polygons in the corner of the view."""
    if not (context.window_manager.isimp.summary and context.space_data.overlay.show_overlays):
        return
    scan, problem = targets.seen(context)
    if problem or not targets.has_regions(scan):
        return
    numbers = store.numbers(scan)
    if scan_shown(context) is not None:
        shown, drawing = runtime.get().live.shown_of(scan), _drawing(context, scan)
        made = drawing.sketch.numbers if drawing is not None else {}
        numbers = shown.work.task.result.numbers if shown is not None else numbers
        numbers = made if made.get("regions_before") == numbers.get("regions") else {"regions": numbers.get("regions")}
    if numbers.get("regions") is None:
        return
    unit = context.scene.unit_settings
    away = text.amount(numbers, "away_mean", unit.system, unit.scale_length) if "away_mean" in numbers else ""
    told = messages.summary(numbers["regions"], numbers.get("polygons"), away)
    legend = messages.magenta(len(problem_faces(context, scan)))
    viewport_text.draw_corner(context, f"{told} · {legend}" if legend else told)


def _draw_text():
    """Draws the summary, the text next to the mouse, and the brush's circle."""
    context = bpy.context
    if runtime.get() is None:
        return
    _draw_summary(context)
    hover = hover_shown(context)
    if hover is None:
        return
    if hover.ring:
        angle = np.linspace(0, 2 * np.pi, 49)
        circle = np.stack([np.cos(angle), np.sin(angle)], axis=1) * hover.ring + hover.at
        points = np.repeat(np.column_stack([circle, np.zeros(49)]), 2, axis=0)[1:-1].astype(np.float32)
        gpu.state.blend_set("ALPHA")
        sketches.lines(points, (1.0, 1.0, 1.0, 0.9), 1.5)
        gpu.state.blend_set("NONE")
    if hover.stretch:
        gpu.state.blend_set("ALPHA")
        sketches.lines(np.array([(*at, 0.0) for at in hover.stretch], np.float32), (1.0, 0.85, 0.2, 1.0), 2.0)
        gpu.state.blend_set("NONE")
    if hover.text:
        viewport_text.draw_hover(context, hover)


def register() -> None:
    if not bpy.app.background:
        add = bpy.types.SpaceView3D.draw_handler_add
        handles = (add(_draw, (), "WINDOW", "POST_VIEW"), add(_draw_text, (), "WINDOW", "POST_PIXEL"))
        runtime.get().handles = handles


def unregister() -> None:
    for handle in runtime.get().handles:
        bpy.types.SpaceView3D.draw_handler_remove(handle, "WINDOW")
    for tick in (_tick, _rest):
        if bpy.app.timers.is_registered(tick):
            bpy.app.timers.unregister(tick)
