"""The places of polygons' corners on the scan."""

import numpy as np
import pytest

import isimp_engine as engine
import shapes


def made(vertices, triangles, proxies, clean=None):
    mesh = engine.clean(vertices, triangles, clean or engine.CleanOptions())
    part = engine.partition(mesh, engine.PartitionOptions(proxies=proxies))
    return mesh, part, engine.polygonize(mesh, part)


def places(vertices, triangles, triangle, weights):
    return np.einsum("lc,lcn->ln", weights, vertices[triangles[triangle]])


def closest(p, corners):
    """The closest point of a triangle to p, by a fine search of its weights."""
    b, c = np.meshgrid(np.linspace(0, 1, 201), np.linspace(0, 1, 201))
    inside = b + c <= 1 + 1e-12
    b, c = b[inside], c[inside]
    points = (1 - b - c)[:, None] * corners[0] + b[:, None] * corners[1] + c[:, None] * corners[2]
    return np.linalg.norm(points - p, axis=1).min()


def test_places_are_the_closest_of_the_own_region():
    vertices, triangles = shapes.bumpy(10)
    mesh, part, poly = made(vertices, triangles, 8)
    triangle, weights = engine.texturing.corner_sources(mesh, part, poly, vertices, triangles)
    assert triangle.shape == (len(poly.loops),)
    assert np.allclose(weights.sum(axis=1), 1, atol=1e-5)
    assert weights.min() > -1e-5
    ends = np.append(poly.loop_start, len(poly.loops))
    region = np.repeat(poly.polygon_region, np.diff(ends))
    of_source = np.empty(len(triangles), np.int32)
    of_source[mesh.source_face] = part.face_region
    assert np.array_equal(of_source[triangle], region)
    found = np.linalg.norm(places(vertices, triangles, triangle, weights) - poly.vertices[poly.loops], axis=1)
    for i in range(0, len(poly.loops), 7):
        own = triangles[of_source == region[i]]
        least = min(closest(poly.vertices[poly.loops[i]], vertices[t]) for t in own)
        assert found[i] <= least + 1e-8  # weights are of single precision


def test_both_sides_of_a_thin_plate_keep_their_values():
    vertices, triangles = shapes.cube(6)
    vertices = (vertices * [1, 1, 1e-3]).copy()
    mesh = engine.clean(vertices, triangles)
    side = np.arange(len(triangles)) // (2 * 6 * 6)
    part = engine.partition_from(mesh, side.astype(np.int32)[mesh.source_face])
    poly = engine.polygonize(mesh, part)
    triangle, _ = engine.texturing.corner_sources(mesh, part, poly, vertices, triangles)
    ends = np.append(poly.loop_start, len(poly.loops))
    assert np.array_equal(side[triangle], np.repeat(poly.polygon_region, np.diff(ends)))


@pytest.mark.parametrize("threads", [1, 3])
def test_repairs_and_far_places(threads):
    """Reversed faces and a filled hole far from zero: corners lie on the caller's triangles."""
    vertices, triangles = shapes.cube(4)
    vertices = vertices + [2.0**19, -(2.0**21), 2.0**10]
    triangles = np.delete(triangles, 9, axis=0)
    triangles[::5] = triangles[::5, ::-1]
    mesh, part, poly = made(vertices, triangles, 6, engine.CleanOptions(fill_holes=3))
    assert mesh.report["filled_holes"] == 1
    triangle, weights = engine.texturing.corner_sources(mesh, part, poly, vertices, triangles, threads=threads)
    assert triangle.min() >= 0
    assert np.abs(places(vertices, triangles, triangle, weights) - poly.vertices[poly.loops]).max() < 1e-3


def test_parts_must_belong_together():
    vertices, triangles = shapes.cube(4)
    _, part, poly = made(vertices, triangles, 6)
    other = engine.clean(*shapes.plane(4))
    with pytest.raises(engine.InvalidInput):
        engine.texturing.corner_sources(other, part, poly, *shapes.plane(4))


def seamed_plane(n=10):
    """A plane whose UVs jump at x = 0.4: two islands."""
    vertices, triangles = shapes.plane(n)
    uv = vertices[triangles][:, :, :2].astype(np.float64)
    right = uv[:, :, 0].mean(axis=1) > 0.4
    uv[right] += [5, 0]
    return vertices, triangles, uv, right


def test_islands_end_where_uvs_jump():
    _, triangles, uv, right = seamed_plane()
    islands = engine.texturing.uv_islands(triangles, uv)
    assert sorted(np.unique(islands)) == [np.flatnonzero(~right)[0], np.flatnonzero(right)[0]]
    assert len(np.unique(islands[right])) == len(np.unique(islands[~right])) == 1
    alone = engine.texturing.uv_islands(triangles, uv + 10.0 * np.arange(len(uv))[:, None, None])
    assert np.array_equal(alone, np.arange(len(uv)))


def test_a_polygon_across_two_islands_takes_the_larger_one():
    vertices, triangles, uv, right = seamed_plane()
    mesh = engine.clean(vertices, triangles)
    part = engine.partition_from(mesh, np.zeros(len(mesh.triangles), np.int32))
    poly = engine.polygonize(mesh, part)

    def carried(**options):
        triangle, weights = engine.texturing.corner_sources(mesh, part, poly, vertices, triangles, **options)
        return np.einsum("lc,lcn->ln", weights, uv[triangle]), triangle

    across, _ = carried()
    assert np.ptp(across[:, 0]) > 5  # the error without it
    within, triangle = carried(islands=engine.texturing.uv_islands(triangles, uv))
    assert right[triangle].all()
    assert within[:, 0].min() >= 5.4 - 1e-6
    assert np.allclose(within[within[:, 0] > 5.99][:, 1], poly.vertices[poly.loops][within[:, 0] > 5.99][:, 1])


def test_islands_and_uvs_of_other_shapes_are_refused():
    vertices, triangles = shapes.cube(2)
    count = len(triangles)
    mesh, part, poly = made(vertices, triangles, 6)
    for islands in (np.arange(3), np.zeros((count, 1), np.int32), np.zeros(count)):
        with pytest.raises(engine.InvalidInput, match=rf"islands must have the shape \({count},\) and integers"):
            engine.texturing.corner_sources(mesh, part, poly, vertices, triangles, islands=islands)
    for uv in (np.zeros((3, 3, 2)), np.zeros((count, 2)), 0.0, np.full((count, 3, 2), "a")):
        with pytest.raises(engine.InvalidInput, match=rf"uv must have the shape \({count}, 3, 2\) and numbers, got \("):
            engine.texturing.uv_islands(triangles, uv)
    for other in (triangles.ravel(), triangles * 1.0, 3):
        with pytest.raises(engine.InvalidInput, match=r"triangles must have the shape \(T, 3\) and integers, got \("):
            engine.texturing.uv_islands(other, np.zeros((count, 3, 2)))
