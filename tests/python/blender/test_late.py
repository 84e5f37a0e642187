"""Colours that are reported to Blender later than they are written (late.py); window tests check the drawing."""

import bpy
import numpy as np
import pytest
import scans

from isimp.blender import reading
from isimp.blender.drawing import late
from isimp.blender.scene import mesh_io, runtime


@pytest.fixture
def written(scene, monkeypatch):
    """A cube of 432 triangles with colours that Blender shows, and its arrays; as if there were a window."""
    obj = scans.cube()
    color = np.zeros(len(obj.data.polygons), np.uint8)
    mesh_io.write_regions(obj, color.astype(np.int32), color, 1)
    scan = mesh_io.read(bpy.context, obj)
    late.note(obj, 1, color, None)

    monkeypatch.setattr(late, "IS_QUIET", True)
    yield obj, scan, color
    runtime.get().late = None


def painted(color, faces):
    after = color.copy()
    after[:faces] = 3
    return after


def test_a_patch_has_the_triangles_of_the_changed_faces(written):
    obj, scan, color = written
    patch = late.patch_of(scan, late.shown(obj), painted(color, 50))
    assert patch.count == 50
    assert late.fits(obj, patch)


def test_many_faces_or_unknown_colours_make_no_patch(written):
    obj, scan, color = written
    assert late.patch_of(scan, late.shown(obj), painted(color, 109)) is None
    assert late.patch_of(scan, None, painted(color, 1)) is None


def test_patches_add_up_until_the_report_to_blender(written, monkeypatch):
    obj, scan, color = written
    told = []
    monkeypatch.setattr(mesh_io, "tell", lambda mesh: told.append(mesh.name))
    for state, faces in ((2, 10), (3, 30)):
        after = painted(color, faces)
        patch = late.patch_of(scan, late.shown(obj), after)
        mesh_io.write_regions(obj, after.astype(np.int32), after, state, tells=False)
        late.note(obj, state, after, patch)
        assert patch.count == faces
        assert late.shown(obj) is color
    assert told == []
    late.settle()
    late.settle()
    assert told == [obj.data.name]
    assert np.array_equal(late.shown(obj), after)


def test_another_state_on_the_mesh_makes_a_patch_unusable(written):
    obj, scan, color = written
    patch = late.patch_of(scan, late.shown(obj), painted(color, 5))
    mesh_io.write_state(obj, 7)
    assert late.shown(obj) is None
    assert not late.fits(obj, patch)


def test_a_change_of_the_mesh_by_others_is_noticed(written):
    obj, _, _ = written
    runtime.get().own_writes.discard(obj.data.name)
    obj.data.update()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    reading.forget_changed(depsgraph)
    assert late.shown(obj) is None


def test_a_write_on_another_mesh_reports_the_first_one(written, monkeypatch):
    obj, scan, color = written
    late.note(obj, 1, painted(color, 9), late.patch_of(scan, color, painted(color, 9)))
    told = []
    monkeypatch.setattr(mesh_io, "tell", lambda mesh: told.append(mesh.name))
    other = scans.cube("Other")
    late.note(other, 1, color, None)
    assert told == [obj.data.name]
