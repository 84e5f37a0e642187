"""The panel Planes: Regularise, its settings, Level and Upright; colours by direction, and hover texts."""

import bpy
import numpy as np
from scenario_buttons import select
from scenario_main import same, scan
from scenario_steps import settings, settled
from scenario_tools import begin, sketched, tool, undone_and_redone

from isimp.blender.scene import runtime, store


def house():
    """A rough box of 2 x 2 x 2 whose roof slopes and one wall of which leans."""
    import scans

    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()
    obj = scans.cube(cells=16)
    points = scans.coordinates(obj.data)
    top, side = points[:, 2] > 0.999, points[:, 0] > 0.999
    points[top, 2] += 0.04 * points[top, 0]
    points[side, 0] += 0.03 * points[side, 2]
    points += np.random.default_rng(1).normal(0, 0.004, points.shape)
    obj.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    obj.data.update()
    bpy.ops.ed.undo_push(message="scan")


def open_planes():
    """Opens the panels from the beginning; before the add-on is switched on."""
    from isimp.blender.panel import edit, planes

    for panel in (edit.ISIMP_PT_clean_up, planes.ISIMP_PT_planes):
        panel.bl_options = set()


def numbers():
    return store.numbers(scan())


def found():
    """The engine's figures of the planes."""
    from isimp.blender import reading

    recipe = store.load(scan())
    arrays = reading.read(bpy.context, scan(), recipe.layers())
    return runtime.get().session.replay(arrays, recipe).partition.regularity


def snapped():
    return found()["snapped_to"]


def side(axis, sign):
    """Faces of the middle of a side."""
    centers = np.array([polygon.center for polygon in scan().data.polygons])
    middle = np.zeros(3)
    middle[axis] = sign
    return np.argsort(np.linalg.norm(centers - middle, axis=1))[:4].tolist()


def colours():
    """The number of colours of the drawn polygons."""
    drawing = next(reversed(runtime.get().drawings.values()))
    return len(np.unique(drawing.sketch.directions.round(3), axis=0))


def run(hand):
    open_planes()
    yield from begin(hand, house, proxies=6)
    settings().directions = True
    yield from sketched()
    same("all planes are free", colours(), 1)

    yield from hand.press("isimp.regularise")
    same("one step more", [step.kind for step in store.load(scan()).steps], ["partition", "regularise"])
    same("level and upright", snapped()["level"] + snapped()["upright"] >= 4, True)
    yield from undone_and_redone(hand, "Regularise", lambda: numbers().get("planes"))
    yield from sketched()
    same("hues of directions", colours() > 3, True)
    yield from hand.shot("planes-1-regularised")

    before = found()
    settings().regularise.length = 0.5
    yield 0.3
    yield from settled()
    same("a changed setting runs it again", found()["length"], 0.5)
    same("and is one step", [step.kind for step in store.load(scan()).steps], ["partition", "regularise"])
    yield from hand.undo()
    same("undone", found(), before)

    yield from hand.into_view()
    yield from hand.key("TAB")
    yield 0.5
    select(side(2, 1))
    yield from hand.press("isimp.align")
    same("Level", (snapped()["by_hand"], store.load(scan()).steps[-1].to), (1, "level"))
    yield from undone_and_redone(hand, "Level", found)
    select(side(0, 1))
    yield from hand.find("bpy.ops.isimp.align")
    bar = hand.region("UI")
    yield from hand.click(bar.x + (bar.width - 20) * 0.75, hand.at[1])
    yield from hand.settle()
    same("Upright", (snapped()["by_hand"], store.load(scan()).steps[-1].to), (2, "upright"))
    yield from hand.into_view()
    yield from hand.key("TAB")
    yield 0.5

    yield from tool(hand, "isimp.region_tool.object")
    yield from hand.into_view()
    for _ in range(20):
        if runtime.get().hover is not None:
            break
        yield from hand.move(hand.at[0] + 3, hand.at[1])
        yield 0.2
    print(runtime.get().hover.text, flush=True)
    same("the hover text tells of the plane", any(w in runtime.get().hover.text for w in ("fixed", "off")), True)
    yield from sketched()
    yield from hand.shot("planes-2-by-hand")
    yield from hand.press("isimp.mesh")
    same("the result keeps them", snapped()["by_hand"], 2)
    made = bpy.context.view_layer.objects.active
    normals = np.array([polygon.normal for polygon in made.data.polygons])
    same("a level roof", bool((normals[:, 2] > 1 - 1e-4).any()), True)
    same("an upright wall", bool(((normals[:, 0] > 0.99) & (np.abs(normals[:, 2]) < 1e-2)).any()), True)
