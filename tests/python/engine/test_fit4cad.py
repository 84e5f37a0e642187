"""The adapter of Fit4CAD reads its files, and its measure equals that of the benchmark."""

import numpy as np
import pytest

import shapes
from bench.peers import fit4cad


def write(folder, points, primitives, name="PC3"):
    """Files as the benchmark has them: points in brackets, primitives with numbers from 1 and empty lines."""
    (folder / "pointCloud").mkdir(parents=True)
    (folder / "pointCloud_primitives").mkdir()
    rows = ", \n".join("[" + ", ".join(f"{x:.12f}" for x in point) + "]" for point in points)
    (folder / "pointCloud" / f"{name}.txt").write_text(f"Points:=[\n{rows}];\n")
    lists = [f"Primitive{k}:=[{' '.join(str(i + 1) for i in one)}];\n" for k, one in enumerate(primitives, 1)]
    (folder / "pointCloud_primitives" / f"{name}_primitives.txt").write_text("\n".join(lists))


def cube():
    """Points on a cube, and its sides, with the points of edges in two or three of them."""
    points = np.unique(np.round(shapes.cube(12)[0], 9), axis=0)
    ends = points.min(axis=0), points.max(axis=0)
    return points, [np.flatnonzero(points[:, axis] == end[axis]) for axis in range(3) for end in ends]


def test_files_of_the_benchmark_are_read(tmp_path):
    points, sides = cube()
    write(tmp_path / "test_set", points, [*sides, []])
    ((cloud, truth),) = fit4cad.clouds(tmp_path)
    assert np.allclose(fit4cad.read_points(cloud), points, atol=1e-11)
    found = fit4cad.read_primitives(truth, len(points))
    assert [one.tolist() for one in found] == [side.tolist() for side in sides] + [[]]
    truth.write_text("Primitive1 := [1, 2e0,\n 3];\nPrimitive2:=[];")
    assert [one.tolist() for one in fit4cad.read_primitives(truth, 3)] == [[0, 1, 2], []]
    with pytest.raises(ValueError, match="names a point that is not among the 2"):
        fit4cad.read_primitives(truth, 2)
    cloud.write_text("1.5 -2 3e-1\n0,1,.5\n")
    assert fit4cad.read_points(cloud).tolist() == [[1.5, -2, 0.3], [0, 1, 0.5]]


def test_dice_is_of_the_found_primitive_with_most_common_points():
    truth = [np.arange(10), np.arange(10, 14)]
    found = [np.arange(4), np.arange(2, 10), np.arange(20, 30)]
    assert fit4cad.dice(truth, found).tolist() == [2 * 8 / 18, 0]
    assert fit4cad.dice(truth, []).tolist() == [0, 0]


@pytest.mark.parametrize("height", [1, 0.25])
def test_the_mesh_is_closed_and_has_all_points_at_thin_walls(height):
    pytest.importorskip("scipy")
    points = cube()[0] * [1, 1, height]
    triangles = fit4cad.meshed(points)
    assert len(np.unique(triangles)) == len(points)
    edges = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    assert np.unique(edges, axis=0).tolist() == np.unique(edges[:, ::-1], axis=0).tolist()
    assert len(np.unique(edges, axis=0)) == len(edges)  # two triangles at each edge, in opposite directions
    a, b, c = points[triangles].swapaxes(0, 1)
    volume = (np.cross(a, b) * c).sum() / 6
    assert volume == pytest.approx(np.ptp(points, axis=0).prod())


def test_a_profile_is_a_line_for_each_straight_part_and_an_arc_for_each_round_one():
    angle = np.linspace(0, np.pi / 2, 60)
    along = np.linspace(0, 1, 60)
    line = np.stack([np.full(60, 2.0), along - 1], axis=1)
    arc = np.stack([1 + np.cos(angle), np.sin(angle)], axis=1)
    disc = np.stack([1 - along, np.ones(60)], axis=1)
    profile = np.concatenate([line, arc, disc])
    curves = fit4cad.curves_of(profile, profile[::6], 0.004)
    assert len(curves) == 3
    for curve, part in zip(curves, (line, arc, disc), strict=True):
        assert curve(part).max() < 0.004
    assert curves[0](np.array([[2.0, -5.0]])) < 0.1  # a line with no end
    assert len(fit4cad.curves_of(arc, arc[::6], 0.004)) == 1


def test_a_cube_of_points_is_found(tmp_path):
    pytest.importorskip("scipy")
    points, sides = cube()
    write(tmp_path, points, sides)
    row = fit4cad.measured(*fit4cad.clouds(tmp_path)[0])
    assert (row["primitives"], row["found"], row["meshed"]) == (6, 6, 1)
    assert row["dice"] > 0.98
