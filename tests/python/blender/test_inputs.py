"""Unusual scans: handled rightly, or refused clearly. No traceback, and nothing changed."""

import bpy
import numpy as np
import pytest
import scans

from isimp.blender.scene import store, targets


def why_not():
    assert not bpy.ops.isimp.partition.poll()
    return targets.find(bpy.context)[1]


def test_no_faces_in_edit_mode():
    scans.add("Cloud", [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [])
    scans.mode("EDIT")
    assert "points but no faces" in why_not()
    bpy.ops.mesh.primitive_cube_add()  # into the mesh
    assert bpy.ops.isimp.partition.poll()
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.delete(type="VERT")
    assert "is empty" in why_not()


def test_linked_library_data(tmp_path):
    scans.cube()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (source, target):
        target.objects, target.meshes = source.objects, source.meshes
    bpy.context.scene.collection.objects.link(target.objects[0])
    bpy.context.view_layer.objects.active = target.objects[0]
    assert "linked from" in why_not()
    own = bpy.data.objects.new("Own", target.meshes[0])
    bpy.context.scene.collection.objects.link(own)
    scans.activate(own)
    assert "make it local" in why_not()
    own.data = target.meshes[0].override_create()
    assert (own.data.library, "make it local" in why_not()) == (None, True)


def labelled(scan, proxies):
    assert bpy.ops.isimp.partition(proxies=proxies) == {"FINISHED"}
    return scans.regions(scan)


def test_modifiers_that_only_move_vertices():
    """A cast to a sphere: regions are of the sphere, the scan stays a cube."""
    scan, sphere = scans.cube(name="Cast"), scans.cube(name="Applied")
    for obj in (scan, sphere):
        obj.modifiers.new("Cast", "CAST").factor = 1.0
    scans.activate(sphere)
    bpy.ops.object.modifier_apply(modifier="Cast")
    wanted = labelled(sphere, 8)
    scans.activate(scan)
    before = scans.geometry(scan.data)
    assert (labelled(scan, 8) == wanted).all()
    assert scans.geometry(scan.data) == before
    bpy.ops.isimp.mesh()
    assert np.linalg.norm(scans.coordinates(bpy.context.object.data), axis=1).min() > 0.75
    assert sorted(obj.name for obj in bpy.data.objects) == ["Applied", "Cast", "Cast.simplified"]


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_modifiers_that_make_faces(mode):
    """Every face of the scan gets the region of most of the faces made from it; the result is that of the whole."""
    scan = scans.cube(cells=2, quads=True)
    scan.modifiers.new("Mirror", "MIRROR").use_axis = (False, False, True)
    scan.modifiers.new("Subdivision", "SUBSURF").levels = 2
    for vertex in scan.data.vertices:
        vertex.co.z += 1.5
    before = scans.geometry(scan.data)
    scans.mode(mode)
    label = labelled(scan, 12)
    assert label.min() >= 0
    assert len(label) == len(scan.data.polygons) == 24
    scans.mode("OBJECT")
    assert scans.geometry(scan.data) == before
    bpy.ops.isimp.mesh()
    heights = scans.coordinates(bpy.context.object.data)[:, 2]
    assert heights.min() < -1.5
    assert heights.max() > 1.5


def test_modifiers_that_lose_track_of_faces():
    scan = scans.cube()
    scan.modifiers.new("Remesh", "REMESH").mode = "VOXEL"
    before = len(bpy.data.objects), len(bpy.data.meshes)
    with pytest.raises(RuntimeError, match=r"Remesh.*can't be traced back.*apply them first"):
        bpy.ops.isimp.partition(proxies=6)
    assert (len(bpy.data.objects), len(bpy.data.meshes)) == before


def test_modifiers_that_are_switched_off_do_nothing():
    scan = scans.cube()
    scan.modifiers.new("Remesh", "REMESH").show_viewport = False
    assert len(np.unique(labelled(scan, 6))) == 6


def test_shape_keys_count_as_seen():
    scan, flat = scans.cube(name="Keys"), scans.cube(name="Flat")
    scan.shape_key_add(name="Basis")
    key = scan.shape_key_add(name="Flat")
    for point in key.data:
        point.co.z *= 0.1
    key.value = 1.0
    for vertex in flat.data.vertices:
        vertex.co.z *= 0.1
    wanted = labelled(flat, 6)
    scans.activate(scan)
    assert (labelled(scan, 6) == wanted).all()
    bpy.ops.isimp.mesh()
    result = bpy.context.object.evaluated_get(bpy.context.evaluated_depsgraph_get())
    assert abs(scans.coordinates(result.data)[:, 2]).max() == pytest.approx(0.1, abs=1e-5)


def test_faces_that_scanners_leave_broken():
    """Duplicates, a face without area, three faces at one edge: mended for the result, labelled where it can be."""
    scan = scans.cube()
    points = [tuple(vertex.co) for vertex in scan.data.vertices] + [(0, 0, 3)]
    faces = [tuple(polygon.vertices) for polygon in scan.data.polygons]
    fin = (faces[0][0], faces[0][1], len(points) - 1)
    broken = scans.add("Broken", points, [*faces, fin])
    label = labelled(broken, 8)
    assert len(label) == len(faces) + 1
    assert bpy.ops.isimp.mesh() == {"FINISHED"}
    assert not bpy.context.object.data.validate()


def test_the_scan_of_a_deleted_scan_is_not_missed():
    scan = scans.cube()
    bpy.ops.isimp.partition(proxies=6)
    bpy.ops.isimp.mesh()
    bpy.data.objects.remove(scan)
    assert bpy.ops.isimp.partition.poll()
    assert bpy.ops.isimp.partition(proxies=5) == {"FINISHED"}


def test_defects_are_listed_by_kind_without_unused_vertices():
    from isimp.blender.texts import text

    scan = scans.cube(cells=4)
    assert text.repair_lines(store.numbers(scan), "NONE", 1.0) == []
    flipped = [face.vertices[:][:: -1 if face.index in (3, 9) else 1] for face in scan.data.polygons]
    points = [*scans.coordinates(scan.data), (5, 5, 5)]
    defective = scans.add("Defective", points, flipped)
    bpy.ops.isimp.partition(proxies=6)
    assert text.repair_lines(store.numbers(defective), "NONE", 1.0) == ["Mended: 2 reversed faces"]
