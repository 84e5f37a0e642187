"""How an outcome comes to the screen: regions on the scan, or polygons as an object beside it."""

import uuid
from dataclasses import replace

import bpy
import numpy as np
from mathutils import Matrix

from .. import stored
from . import aside, display, mesh_io, raw, store, targets


def _save(scan, work, numbers: dict) -> int:
    """Stores the recipe and returns its state. Unreadable data are moved aside first, and stay in the file."""
    unknown = not mesh_io.state_of(scan) and aside.has_regions(scan.data)
    aside.set_aside(scan, regions_too=bool(store.read(scan).problem) or unknown)
    state = store.save(scan, work.recipe, numbers)
    work.states |= {mesh_io.state_of(scan), state}
    return state


def show_regions(context, scan, work, outcome) -> None:
    """Writes regions and colours on the scan and brings it to the front."""
    state = _save(scan, work, outcome.numbers)
    _write(scan, work, outcome, state)
    result = targets.result_of(context.scene, scan)
    if context.view_layer.objects.active != scan:
        bring_to_front(context, scan, result)
    display.show(context)


def show_polygons(context, scan, work, outcome) -> None:
    """Makes or refreshes the result beside the scan, which is hidden, and brings it to the front."""
    if scan.mode == "EDIT":
        bpy.ops.object.mode_set(mode="OBJECT")
    state = _save(scan, work, outcome.numbers)
    _write(scan, work, outcome, state)
    result = targets.result_of(context.scene, scan) or _new_result(context, scan)
    for obj in (scan, result):
        raw.make_way(obj)
    scan.isimp.key = scan.isimp.key or uuid.uuid4().hex
    result.isimp.scan_key, result.isimp.scan_name = scan.isimp.key, scan.name
    _fill(result, scan, outcome)
    mesh_io.give_color_back(scan.data)
    bring_to_front(context, result, scan)
    display.give_back(context)


def _color(work, outcome):
    return work.face_color if work.face_color is not None else outcome.face_color


def _write(scan, work, outcome, state) -> None:
    mesh_io.write_regions(scan, outcome.face_region, _color(work, outcome), state, work.corner_color)
    work.corner_color = None


def writing(scan, work, outcome):
    """Writes face by face what `show_outcome` shows, in pieces, so that the window stays responsive.

    Yields what share is done. Nothing is left for later in Edit Mode; nothing is done in Object Mode.
    """
    if scan.mode != "EDIT" or outcome.polygons is not None:
        return
    state = _save(scan, work, outcome.numbers)
    yield from mesh_io.writing(scan, outcome.face_region, _color(work, outcome), state)


def show_outcome(context, scan, work, outcome) -> None:
    """Shows the outcome of a recipe: polygons if it ends in Mesh, else regions."""
    (show_regions if outcome.polygons is None else show_polygons)(context, scan, work, outcome)


def show_failed(context, scan, work, error) -> None:
    """Stores a recipe with a failed step, and the reason; the previous result stays visible."""
    failed = {"failed": error.index, "reason": stored.line(error.reason)}
    outcome = error.outcome
    if outcome is None or (mesh_io.state_of(scan) and not store.read(scan).problem):
        state = _save(scan, work, store.numbers(scan) | failed)
        mesh_io.write_state(scan, state)
    else:  # nothing was seen before
        show_regions(context, scan, work, replace(outcome, numbers=outcome.numbers | failed))


def bring_to_front(context, shown, hidden) -> None:
    """Shows and selects one object, alone and active, and hides another (which may be None)."""
    for other in context.selected_objects:
        other.select_set(False)
    if hidden is not None and hidden.name in context.view_layer.objects:
        hidden.hide_set(True)
    if shown.name in context.view_layer.objects:
        shown.hide_viewport = False
        shown.hide_set(False)
        shown.select_set(True)
        context.view_layer.objects.active = shown


def _new_result(context, scan):
    name = f"{scan.name[:52]}.simplified"  # a name holds 63 bytes
    result = bpy.data.objects.new(name, bpy.data.meshes.new(name))
    for collection in scan.users_collection or (context.scene.collection,):
        collection.objects.link(result)
    result.show_wire = True
    result.show_all_edges = True
    return result


def _fill(result, scan, outcome) -> None:
    """Puts the polygons where the scan is: in its own space, or in the world's if its transform is sheared.

    Those of a scan far from its own zero are put relative to the outcome's origin, and the result's place has the rest.
    """
    polygons = outcome.polygons
    loops, start = np.array(polygons.loops), np.array(polygons.loop_start)
    unshaped, place = np.linalg.inv(mesh_io.shape_matrix(scan)), np.array(scan.matrix_world, np.float64)
    vertices = (np.asarray(polygons.vertices) - outcome.origin) @ unshaped
    matrix = place[:3, :3].copy()
    place[:3, 3] += matrix @ (outcome.origin @ unshaped)
    unsheared = np.array(Matrix.LocRotScale(*scan.matrix_world.decompose()), np.float64)[:3, :3]
    if not np.allclose(unsheared, matrix, rtol=0, atol=1e-5 * np.abs(matrix).max()):
        place[:3, :3] = np.eye(3)
        vertices = vertices @ matrix.T
        if np.linalg.det(matrix) < 0:
            loops = turned(loops, start)
    result.matrix_world = Matrix(place.tolist())
    # Blender rounds a location to float32. The rounding error of a far one goes to the vertices.
    rounded = place[:3, 3] - place[:3, 3].astype(np.float32)
    vertices += np.linalg.solve(place[:3, :3], rounded)
    defective = np.zeros(len(start), np.int32)
    for found in outcome.numbers["flaws"].values():
        defective[found] = 1
    layers = {mesh_io.REGION: np.asarray(polygons.polygon_region), mesh_io.FLAW: defective}
    mesh_io.fill_polygons(result.data, vertices, loops, start, layers)


def turned(loops: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Every polygon the other way round."""
    totals = np.diff(start, append=len(loops))
    within = np.arange(len(loops)) - np.repeat(start, totals)
    return loops[np.repeat(start + totals - 1, totals) - within]
