"""Finds the scan for all operators and the panel, or the reason why there is no usable one."""

import re

import bpy

from ... import messages, session
from ...language import own, said
from . import mesh_io, runtime, store, unread_layers

NO_RESULT = own("There is no result yet: press Mesh first")
KEPT = "kept"  #: value of `isimp.made` on a result that Mesh must not overwrite, in place of a digest
_LONGEST = 50  # bytes of a name: Blender stores 63, and names of colliders add up to 13
_OTHER = {
    "CURVE": own("a curve"),
    "EMPTY": own("an empty"),
    "SURFACE": own("a surface"),
    "META": own("a metaball"),
    "FONT": own("a text"),
    "CAMERA": own("a camera"),
    "LIGHT": own("a light"),
    "ARMATURE": own("an armature"),
    "POINTCLOUD": own("a point cloud"),
    "CURVES": own("hair curves"),
    "VOLUME": own("a volume"),
    "LATTICE": own("a lattice"),
}
_MAKES_MESH = {"CURVE", "SURFACE", "META", "FONT"}


def scan_of(obj):
    """Return the scan of a result; None if it was deleted, or the object is a scan itself."""
    wanted = obj.isimp.scan_key if obj is not None else ""
    if not wanted or obj.isimp.key:
        return None
    name, mesh = obj.isimp.scan_name, obj.isimp.scan_mesh
    named = bpy.data.objects.get(name)
    if named is not None and (named.isimp.key, named.data.name) == (wanted, mesh):
        return named
    same = [other for other in bpy.data.objects if other.isimp.key == wanted]  # a copy of the scan has its key too
    meshes, names = ([o for o in same if o.data.name == mesh], [o for o in same if o.name == name])
    return next((found[0] for found in (meshes, names, same) if len(found) == 1), None)


def result_of(scene, scan):
    """Return the result of a scan in the scene; None if there is none."""
    return next(iter(results_of(scene, scan)), None)


def results_of(scene, scan) -> list:
    """Return the results of a scan: first the result of Mesh, then the user's copies of it.

    Excludes objects that share the scan's mesh, and results that were edited by hand and kept.
    """
    key = scan.isimp.key
    if not key:
        return []
    made = (obj for obj in scene.objects if obj.isimp.scan_key == key and obj.type == "MESH")
    made = (obj for obj in made if obj.isimp.made != KEPT)
    made = [obj for obj in made if obj.data != scan.data and scan_of(obj) == scan]
    return sorted(made, key=is_copy)


def is_copy(result) -> bool:
    """Return whether a result is a copy of another one, judged by its name."""
    named = result.isimp.named
    return named not in ("", result.name) and named in bpy.data.objects


def named(stem: str, suffix: str) -> str:
    """Return stem and suffix as Blender can store them, also in names of colliders: a long stem is cut."""
    return stem.encode()[: _LONGEST - len(suffix.encode())].decode(errors="ignore") + suffix


def levels(scan) -> list:
    """Return [(number, object)] of the levels of detail of a scan, NAME_LOD0 and so on, from fine to coarse."""
    numbered = ((re.search(r"_LOD(\d+)$", obj.name), obj) for obj in bpy.data.objects if scan_of(obj) == scan)
    found = [(int(end[1]), obj) for end, obj in numbered if end and obj.name == named(scan.name, end[0])]
    return sorted(found, key=lambda level: level[0])


def find(context):
    """Return (scan, "") or (None, reason). The scan is the active object, or the scan of the active result."""
    problem = _not_now()
    return (None, problem) if problem else seen(context)


def selected(context) -> list:
    """Return the usable scans among selected objects and the scans of selected results, each once."""
    scans = [scan_of(obj) or obj for obj in context.selected_objects if obj.type == "MESH"]
    return list(dict.fromkeys(scan for scan in scans if not _unusable(scan)))


def allows(operator, context, needs=lambda scan: "") -> bool:
    """Poll of an operator that works on a scan. If it can't run, its tooltip has the reason.

    needs: function of the scan that returns why the operator can't run on it, or an empty text.
    """
    scan, problem = find(context)
    problem = problem or needs(scan)
    if problem:
        operator.poll_message_set(said(problem))
    return not problem


def allows_with_result(operator, context) -> bool:
    """Poll of an operator that works on a scan and its result in Object Mode."""
    _, _, problem = find_result(context)
    if not problem and context.mode != "OBJECT":
        problem = own("Leave Edit Mode first (Tab)")
    if problem:
        operator.poll_message_set(said(problem))
    return not problem


def find_result(context):
    """Return (scan, result, "") or (None, None, reason)."""
    scan, problem = find(context)
    result = None if problem else result_of(context.scene, scan)
    if not problem and result is None:
        problem = NO_RESULT
    return (None, None, problem) if problem else (scan, result, "")


def seen(context):
    """Return like `find`, also while other work is running. The caller must not change the scan."""
    active = context.view_layer.objects.active
    scan = scan_of(active) or active
    problem = _no_engine() or _unusable(scan)
    return (None, problem) if problem else (scan, "")


def install_problem() -> str:
    """Return the problem of the installed add-on; empty if there is none."""
    if runtime.get() is not None and runtime.get().is_replaced:
        return said("Another version of iSimp was installed: start Blender again")
    return _no_engine()


def _no_engine() -> str:
    if session.ENGINE_PROBLEM:
        text = own("The iSimp engine does not load: install the zip for this system ({why})")
        return said(text, why=said(session.ENGINE_PROBLEM))
    return ""


def _not_now() -> str:
    running = runtime.get().running
    if running is not None:
        return said("Work on '{name}' is not finished: wait, or press Esc", name=running.name)
    return ""


def _unusable(obj) -> str:
    if obj is None:
        return said("No object is active: click the scan first")
    if obj.type != "MESH":
        kind = said(_OTHER[obj.type]) if obj.type in _OTHER else obj.type.capitalize()
        if obj.type in _MAKES_MESH:
            text = own("'{name}' is {kind}, not a mesh: convert it first (Object > Convert > Mesh)")
        else:
            text = own("'{name}' is {kind}, not a mesh: click the scan first")
        return said(text, name=obj.name, kind=kind)
    override = obj.data.override_library  # no steps can be stored on such a mesh
    for block in (obj, obj.data if override is None else override.reference):
        if block.library is not None:
            return said(
                "'{name}' is linked from {file} and can't be changed: "
                "make it local first (Object > Relations > Make Local)",
                name=block.name,
                file=block.library.filepath,
            )
    if obj.mode not in {"OBJECT", "EDIT"}:
        return said("Leave this mode first: iSimp works in Object and Edit Mode")
    points, faces = mesh_io.counts(obj)
    if faces == 0:
        if points:
            return said("'{name}' has points but no faces: reconstruct a surface first", name=obj.name)
        return said("'{name}' is empty: import a scan first", name=obj.name)
    return ""


def has_regions(scan) -> bool:
    recipe = store.load(scan)
    return recipe is None or bool(recipe.steps)


def needs_steps(scan) -> str:
    """Return why the recipe of a scan cannot be edited; empty if it can."""
    stored = store.read(scan)
    if stored.recipe is None:
        return said("{problem}: press Partition to start again", problem=stored.problem)
    return "" if stored.recipe.steps else said("There are no regions yet: press Partition first")


def notes(scan) -> list:
    """Return messages about a scan: unreadable steps and where they will be kept, objects that share its mesh."""
    lines, found = [], store.read(scan)
    if found.problem:
        text = own("{problem}. Nothing is lost: Partition starts again and keeps this as {names}.")
        names = [store.text_name(scan)] * bool(found.text) + [mesh_io.REGION + unread_layers.KEPT]
        lines.append(said(text, problem=found.problem, names=", ".join(f"'{name}'" for name in names)))
    lines += [f"{line}." for line in (found.recipe.gone if found.recipe else ())]
    twins = [obj.name for obj in bpy.data.objects if obj.data == scan.data and obj != scan]
    if twins:
        lines.append(messages.shared(twins))
    for layer in unread_layers.foreign_layers(scan.data):
        text = own("'{name}' is no layer of iSimp's ({kind}): Partition keeps it as '{kept}'.")
        kind, kept = f"{layer.data_type} of {layer.domain}", layer.name + unread_layers.KEPT
        lines.append(said(text, name=layer.name, kind=kind, kept=kept))
    return lines


def needs_regions(scan) -> str:
    """Return why the regions of a scan cannot be edited; empty if they can."""
    missing = needs_steps(scan)
    if missing:
        return missing
    known, now = store.numbers(scan).get("faces"), len(scan.data.polygons)
    if scan.mode == "OBJECT" and known is not None and known != now:
        return said(
            "'{name}' has changed since ({before} -> {now} faces): press Partition to start again",
            name=scan.name,
            before=f"{known:,}",
            now=f"{now:,}",
        )
    return ""
