"""Before and after: the content at either side of the line. scenario_compare.py checks it in a window."""

import bpy
import numpy as np
import scans

from isimp.blender.operators import compare, problems
from isimp.blender.scene import mesh_io
from isimp.blender.view import comparison


def compared(**more):
    scan = scans.dimple(scans.cube(**more))
    scan.location, scan.scale = (3, 0, 0), (2, 1, 1)
    bpy.context.view_layer.update()
    bpy.ops.isimp.partition(proxies=12)
    bpy.ops.isimp.mesh()
    return comparison.Comparison(bpy.context, scan, bpy.context.object)


def world(side):
    points = side.points.astype(np.float64) + side.origin
    return points @ side.place[:3, :3].T + side.place[:3, 3]


def test_both_sides_are_where_their_objects_are():
    made = compared()
    for side, name in zip(made.sides(), made.names, strict=True):
        wanted = scans.world(bpy.data.objects[name])
        found = np.unique(world(side).round(4), axis=0)
        assert np.allclose(found, np.unique(wanted.round(4), axis=0), atol=2e-4)
    scan, result = made.sides()
    assert (scan.label, result.label) == ("Scan: 432 faces", "Result: 12 polygons")
    assert len(result.lines) == 2 * len(bpy.context.object.data.edges)


def test_regions_have_the_same_colours_at_both_sides():
    made = compared(quads=True)
    made.look = "PLAIN"
    assert all(len(np.unique(side.color, axis=0)) == 1 for side in made.sides())
    made.look = "REGIONS"
    scan, result = ({tuple(color) for color in side.color.tolist()} for side in made.sides())
    assert scan == result
    assert len(scan) > 3
    assert len(made.sides()[0].color) == len(made.sides()[0].points), "a colour for each corner"


def test_a_textured_scan_is_compared_with_its_images():
    scan = scans.cube()
    scan.data.uv_layers.new(name="UV")
    image = bpy.data.images.new("Picture", 8, 8)
    scan.data.materials.append(scans.material_of("Painted", image))
    bpy.ops.isimp.partition(proxies=6)
    bpy.ops.isimp.mesh(keep_texture=False)
    assert comparison.looks_of(scan, bpy.context.object) == ("PLAIN", "REGIONS")
    bpy.ops.isimp.texture(size=32)
    made = comparison.Comparison(bpy.context, scan, bpy.context.object)
    assert made.look == "TEXTURE"
    before, after = made.sides()
    assert before.images == ["Picture"]
    assert after.images == [f"{scan.name}.simplified color"]
    for side in (before, after):
        assert side.uv.shape == (len(side.points), 2)
        assert len(side.slots) == len(side.points) // 3


def test_nothing_is_drawn_of_deleted_objects():
    made = compared()
    assert made.stands()
    bpy.data.objects.remove(bpy.data.objects[made.names[0]])
    assert not made.stands()


def test_it_needs_a_view():
    said = []
    operator = type("Operator", (), {"poll_message_set": said.append})
    assert not compare.ISIMP_OT_compare.poll.__func__(operator, bpy.context)
    assert said == ["This needs a 3D view"]


def test_region_numbers_of_other_programs_need_no_large_arrays():
    made = compared()
    scan, result = (bpy.data.objects[name] for name in made.names)
    for obj in (scan, result):
        obj.data.attributes[mesh_io.REGION].data[0].value = 2_000_000_000
    assert mesh_io.region_of(scan, 0) == -1
    made.look = "REGIONS"
    assert [len(side.color) for side in made.sides()] == [len(side.points) for side in made.sides()]
    assert len(made._color) <= 12
    assert not problems._chosen(result.data, "DIVIDED").any()
