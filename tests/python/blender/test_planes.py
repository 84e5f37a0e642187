"""Regularise and planes set by hand: at the selection, in the panel and before Mesh."""

import bpy
import numpy as np
import pytest
import scans
from drawing import controls

from isimp import recipe as rcp
from isimp.blender.controls import settings, up_direction
from isimp.blender.panel import planes
from isimp.blender.scene import runtime, store
from isimp.blender.texts import text
from isimp.blender.work import panel_changes

OPS = bpy.ops.isimp


@pytest.fixture(autouse=True)
def fresh():
    yield
    panel = bpy.context.window_manager.isimp
    panel.regularise_first = panel.directions = False
    settings.show(bpy.context, None)
    settings.copy(rcp.AlignPlanes, rcp.AlignPlanes(faces=(0,)), panel.align)


def leaning(name="Scan", slope=0.03, cells=6):
    """A cube whose top slopes and one side of which leans."""
    obj = scans.cube(name, cells)
    points = scans.coordinates(obj.data)
    top, side = points[:, 2] > 0.999, points[:, 0] > 0.999
    points[top, 2] += slope * points[top, 0]
    points[side, 0] += slope * points[side, 2]
    obj.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    obj.data.update()
    return obj


def parted(**more):
    scan = leaning(**more)
    assert OPS.partition(proxies=6) == {"FINISHED"}
    return scan


def face_along(scan, *axis):
    """A face in the middle of the side that faces along an axis."""
    normals = np.array([polygon.normal for polygon in scan.data.polygons])
    centers = np.array([polygon.center for polygon in scan.data.polygons])
    facing = np.flatnonzero(normals @ axis > 0.9)
    return int(facing[np.argmin(np.linalg.norm(centers[facing] - np.array(axis), axis=1))])


def outcome(scan):
    recipe = store.load(scan)
    from isimp.blender import reading

    return runtime.get().session.replay(reading.read(bpy.context, scan, recipe.layers()), recipe)


def plane(scan, face):
    found = outcome(scan)
    region = found.face_region[face]
    held = found.partition.region_held
    return np.array(found.partition.region_normal[region]), int(held[region]) if len(held) else 0


def test_alignments_act_on_the_selection_and_the_active_face_leads():
    scan = parted()
    side, back, top = (face_along(scan, *axis) for axis in ((1, 0, 0), (-1, 0, 0), (0, 0, 1)))
    scans.mode("EDIT")
    scans.select_faces(scan, side, back)
    scans.mode("OBJECT")
    scan.data.polygons.active = back
    scans.mode("EDIT")
    assert OPS.align(to="parallel") == {"FINISHED"}
    step = store.load(scan).steps[-1]
    assert step.faces == (back, side)
    ahead, held = plane(scan, side)
    assert held == 2
    assert np.allclose(ahead, (1, 0, 0), atol=1e-6), "the plane of the back stays as it is"
    scans.mode("EDIT")
    scans.select_faces(scan, side, top)
    assert OPS.align(to="perpendicular", length=0.1) == {"FINISHED"}
    assert abs(plane(scan, side)[0] @ plane(scan, top)[0]) < 1e-12


def test_the_larger_region_leads_where_no_face_is_active():
    scan = parted()
    top, side = face_along(scan, 0, 0, 1), face_along(scan, 1, 0, 0)
    small = [side]
    OPS.paint_faces(painted=f"-1:{','.join(map(str, small))}")
    scans.mode("EDIT")
    scans.select_faces(scan, *small, top)
    scans.mode("OBJECT")
    scan.data.polygons.active = face_along(scan, 0, 1, 0)  # not selected
    scans.mode("EDIT")
    assert OPS.align(to="perpendicular") == {"FINISHED"}
    assert store.load(scan).steps[-1].faces == (top, small[0])


def test_up_is_the_scenes_however_the_scan_is_turned():
    scan = parted(slope=0.0)
    assert up_direction.direction(scan) == ()
    scan.rotation_euler = (np.pi / 2, 0, 0)  # +y points up now
    bpy.context.view_layer.update()
    assert np.allclose(up_direction.direction(scan), (0, 1, 0), atol=1e-6)
    OPS.align(face=face_along(scan, 0, 1, 0), to="level")
    assert store.load(scan).steps[-1].direction == (0, 1, 0), "without the noise of float32"
    assert np.allclose(store.load(scan).steps[-1].direction, (0, 1, 0), atol=1e-6)
    assert np.allclose(np.abs(plane(scan, face_along(scan, 0, 1, 0))[0]), (0, 1, 0), atol=1e-6)
    OPS.regularise()
    assert outcome(scan).partition.regularity["snapped_to"] == {
        "level": 1, "upright": 4, "slope": 0, "parallel": 0, "free": 0, "by_hand": 1,
    }  # fmt: skip
    OPS.regularise(up="none")
    assert outcome(scan).partition.regularity["snapped_to"]["upright"] == 0
    OPS.regularise(up="region", face=face_along(scan, 1, 0, 0))
    step = store.load(scan).steps[-1]
    assert (step.up, step.face, step.direction) == ("region", face_along(scan, 1, 0, 0), ())
    panel_changes.follow(bpy.context)
    OPS.align(face=face_along(scan, 1, 0, 0), to="level")
    assert store.load(scan).steps[-1].up == "region", "as in the panel"


def test_a_plane_that_can_not_be_kept_is_marked_with_the_amount():
    scan = parted()
    top = face_along(scan, 0, 0, 1)
    bpy.context.scene.unit_settings.system = "METRIC"
    OPS.align(face=top, to="level", length=0.5)
    panel = bpy.context.window_manager.isimp
    panel_changes.follow(bpy.context)
    assert panel.align.length == pytest.approx(0.5)
    with runtime.get().live.quiet():
        panel.align.length = 0.001
    runtime.get().live.pending, runtime.get().live.scan = True, scan.name
    bpy.ops.isimp.settle()
    numbers = store.numbers(scan)
    assert numbers["failed"] == 1
    assert numbers["reason"].startswith("this region needs 1.7")
    assert numbers["reason"].endswith("cm, allowed 1 mm")
    assert store.load(scan).steps[1].length == pytest.approx(0.001)


def test_the_line_of_the_panel_describes_the_planes():
    scan = parted()
    assert text.planes_line(store.numbers(scan), "METRIC", 1.0) == "As scanned"
    OPS.regularise(length=0.1)
    line = text.planes_line(store.numbers(scan), "METRIC", 1.0)
    assert line.startswith("6 regions -> 6 planes in 3 directions, adds ")
    assert line.endswith(" cm")
    OPS.add_proxy(face=face_along(scan, 0, 0, 1))
    line = text.planes_line(store.numbers(scan), "METRIC", 1.0)
    assert line.endswith("of 7 regions keep their planes: press Regularise again")
    OPS.regularise(length=0.1)
    OPS.mesh()
    assert text.planes_line(store.numbers(scan), "METRIC", 1.0).startswith("7 regions -> ")
    assert [step.kind for step in store.load(scan).steps] == ["partition", "add_proxy", "regularise", "mesh"]


def test_a_changed_setting_runs_regularise_again():
    scan = parted()
    OPS.regularise(length=0.1)
    before = store.numbers(scan)["directions"]
    panel_changes.follow(bpy.context)
    panel = bpy.context.window_manager.isimp
    assert panel.regularise.length == pytest.approx(0.1)
    panel.regularise.angle_turn = np.radians(0.1)
    assert panel.regularise.angle == pytest.approx(0.1, abs=1e-5)
    changed = settings.from_panel(bpy.context, store.load(scan))
    assert changed.steps[1].angle == pytest.approx(0.1, abs=1e-5)
    assert changed.steps[1].length == pytest.approx(0.1)
    runtime.get().live.pending, runtime.get().live.scan = True, scan.name
    bpy.ops.isimp.settle()
    assert store.load(scan).steps[1].angle == pytest.approx(0.1, abs=1e-5)
    assert (before, store.numbers(scan)["directions"]) == (3, 5)


def test_mesh_regularises_first_if_the_panel_has_it_on():
    scan = parted()
    bpy.context.window_manager.isimp.regularise.length = 0.1
    OPS.mesh(regularise=True)
    assert [step.kind for step in store.load(scan).steps] == ["partition", "regularise", "mesh"]
    scans.activate(scan)
    scan.hide_set(False)
    OPS.mesh(regularise=True, planar=True)
    assert [step.kind for step in store.load(scan).steps] == ["partition", "regularise", "mesh"]
    normals = np.abs([polygon.normal for polygon in bpy.context.object.data.polygons])
    assert (normals.max(axis=1) > 1 - 1e-6).all(), "the sides of a box"


def test_the_preset_for_buildings_regularises_and_is_exactly_planar():
    panel = bpy.context.window_manager.isimp
    for other in ("figure", "city"):
        OPS.preset(name="building")
        assert panel.regularise_first
        assert panel.mesh.planar
        OPS.preset(name=other)
        assert not panel.regularise_first
        assert not panel.mesh.planar


def test_every_button_of_the_panel_is_drawn():
    parted()
    drawn = controls(planes.ISIMP_PT_planes, planes.ISIMP_PT_regularise)
    for name in ("Level", "Upright", "Parallel", "Perpendicular", "Coplanar", "Free"):
        assert ("operator", name) in drawn
    names = [name for _, name in drawn]
    assert {"angle_turn", "up", "regularise_first"} <= set(names)
    assert names.count("length_automatic") == 2
    assert "length" not in names
    bpy.context.window_manager.isimp.align.length_automatic = False
    assert ("prop", "length") in controls(planes.ISIMP_PT_regularise)
    assert bpy.context.window_manager.isimp.align.length == pytest.approx(0.05)
    bpy.context.window_manager.isimp.align.length_automatic = True
    assert bpy.context.window_manager.isimp.align.length == 0


def test_the_hover_text_has_the_angle_of_a_plane():
    from isimp.blender.tools import under

    scan = parted()
    bpy.context.scene.unit_settings.system = "METRIC"
    ground = under.ground_of(bpy.context, bpy.context.object, wait=True)
    unit, label = bpy.context.scene.unit_settings, scans.regions(scan)
    top, side = label[face_along(scan, 0, 0, 1)], label[face_along(scan, 1, 0, 0)]
    assert ground.told(unit, top).endswith("° off level; snapping moves 1.7 cm")
    assert "1.7° off upright" in ground.told(unit, side)
    scan.rotation_euler = (0, np.pi / 4, 0)
    bpy.context.view_layer.update()
    assert "off" not in under.ground_of(bpy.context, bpy.context.object, wait=True).told(unit, top)
    scan.rotation_euler = (0, 0, 0)
    bpy.context.view_layer.update()
    OPS.align(face=face_along(scan, 0, 0, 1), to="level")
    told = under.ground_of(bpy.context, bpy.context.object, wait=True).told(unit, top)
    assert told.endswith("plane fixed")
