"""The scan under the mouse, and errors in tools, without a window."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
import scans

from isimp.blender import reading, tools
from isimp.blender.scene import mesh_io, runtime, store
from isimp.blender.tools import opening, part, point, under
from isimp.blender.view import overlay
from isimp.recipe import Mesh
from isimp.session import Session, StepFailed

OPS = bpy.ops.isimp
PRESS = SimpleNamespace(type="LEFTMOUSE", value="PRESS", ctrl=False, oskey=False)
ERRORS = [
    (mesh_io.Unusable("'Scan' is scaled to nothing."), "'Scan' is scaled to nothing."),
    (StepFailed(1, Mesh(), "there are no regions yet", None), "Step 2, Mesh: there are no regions yet."),
    (ValueError("The mesh has no faces."), "The mesh has no faces."),
]


class Tool(point.ModalTool):
    """A tool that fails."""

    def __init__(self, problem):
        self.problem, self.told, self.is_ended = problem, [], False

    def report(self, kind, told):
        self.told.append((kind, told))

    def start(self, context, event):
        raise self.problem

    heard = start

    def end(self, context, redraws=True):
        self.is_ended = True


@pytest.mark.parametrize(("problem", "told"), ERRORS)
def test_an_error_ends_a_tool_with_a_report(problem, told):
    tool = Tool(problem)
    assert tool.invoke(bpy.context, PRESS) == {"CANCELLED"}
    assert (tool.told, tool.is_ended) == ([({"ERROR"}, told)], False)
    tool = Tool(problem)
    assert tool.modal(bpy.context, PRESS) == {"CANCELLED"}
    assert (tool.told, tool.is_ended) == ([({"ERROR"}, told)], True)


def test_every_tool_of_the_mouse_begins_by_start():
    found = [each for each in tools.CLASSES if issubclass(each, point.ModalTool)]
    assert len(found) == 11
    assert all("start" in vars(each) and "invoke" not in vars(each) for each in found)


def test_a_scan_without_extent_is_not_shown_and_has_no_ground():
    scan = scans.cube()
    OPS.partition(proxies=6)
    assert overlay.scan_shown(bpy.context) == scan
    assert under.ground_of(bpy.context, scan, wait=True) is not None
    assert opening.found(bpy.context, scan) == []
    runtime.get().openings = None
    scan.scale.x = 0
    bpy.context.view_layer.update()
    assert overlay.scan_shown(bpy.context) is None
    assert overlay.previewed(bpy.context, scan) == {}
    assert under.ground_of(bpy.context, scan, wait=True) is None
    assert opening.found(bpy.context, scan) is None
    with pytest.raises(mesh_io.Unusable):
        opening.found(bpy.context, scan, wait=True)


def test_locked_regions_are_known_once_the_outcome_is_cached(monkeypatch):
    scan = scans.cube()
    OPS.partition(proxies=6)
    OPS.lock(face=0)
    session, region = Session(), scans.regions(scan)[0]
    monkeypatch.setattr(runtime.get(), "session", session)  # as after a file is opened
    monkeypatch.setattr(under, "_fits", lambda known, scan: True)  # as with a window, where arrays are kept
    runtime.get().ground = None
    assert region not in under.ground_of(bpy.context, scan, wait=True).locked
    session.replay(reading.read(bpy.context, scan), store.load(scan))
    assert list(under.ground_of(bpy.context, scan, wait=True).locked) == [region]


def test_a_part_is_found_on_the_mesh_that_is_split(monkeypatch):
    scan = scans.pierced()
    OPS.partition(proxies=8)
    monkeypatch.setattr(under, "_fits", lambda known, scan: True)  # as with a window, where arrays are kept
    runtime.get().ground = None
    ground = under.ground_of(bpy.context, scan, wait=True)
    shown = []
    tool = SimpleNamespace(
        _ground=ground,
        begin=lambda *given: True,
        ray=lambda event: (np.array([0.3, 0.2, 9.0]), np.array([0.0, 0.0, -1.0])),
        place=lambda event: (0, 0),
        show=shown.append,
        go=lambda *given: {"RUNNING_MODAL"},
    )
    assert part.ISIMP_OT_find_part.start(tool, bpy.context, PRESS) == {"RUNNING_MODAL"}
    outcome = runtime.get().session.replay(ground.scan, store.load(scan))
    mesh = runtime.get().session.prepare(ground.scan, repair=outcome.repair).mesh
    assert len(tool._found.away) == len(mesh.triangles) > len(scan.data.polygons), "the holes are closed"
    assert shown == [PRESS]


def test_a_hover_does_not_repair_the_scan(monkeypatch):
    scan = scans.cube()
    scan.rotation_euler.x = 0.02
    bpy.context.view_layer.update()
    OPS.partition(proxies=6)
    monkeypatch.setattr(under, "_fits", lambda known, scan: True)  # as with a window, where arrays are kept
    runtime.get().ground = None
    ground, unit = under.ground_of(bpy.context, scan, wait=True), bpy.context.scene.unit_settings
    assert "° off" in ground.told(unit, 0)
    monkeypatch.setattr(runtime.get(), "session", Session())  # one that has dropped the mesh
    assert "planar within" in ground.told(unit, 0)
    assert "° off" not in ground.told(unit, 0)
    assert not runtime.get().session.is_prepared(ground.scan, ground._repair)
