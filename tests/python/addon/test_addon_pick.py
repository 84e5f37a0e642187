"""Rays and brushes against the plain way: all faces, one by one."""

import numpy as np
import pytest

from isimp.pick import Surface


@pytest.fixture(scope="module")
def soup():
    """Triangles all over the place."""
    rng = np.random.default_rng(3)
    middle = rng.uniform(-1, 1, (9000, 1, 3))
    vertices = (middle + rng.normal(0, 0.03, (9000, 3, 3))).reshape(-1, 3)
    return vertices.astype(np.float32), np.arange(27000, dtype=np.int32).reshape(-1, 3)


def plain_cast(vertices, triangles, origin, direction):
    """(triangle, distance) by solving three equations for each."""
    a, b, c = np.moveaxis(vertices.astype(float)[triangles], 1, 0)
    system = np.stack([b - a, c - a, np.broadcast_to(-np.asarray(direction), a.shape)], axis=-1)
    u, v, far = np.linalg.solve(system, (origin - a)[..., None])[..., 0].T
    hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (far >= 0)
    return (int(np.flatnonzero(hit)[np.argmin(far[hit])]), far[hit].min()) if hit.any() else None


def test_rays_meet_the_right_triangles(soup):
    surface, rng, met = Surface(*soup), np.random.default_rng(5), 0
    for _ in range(200):
        origin, direction = rng.uniform(-2, 2, 3), rng.normal(size=3)
        wanted, got = plain_cast(*soup, origin, direction), surface.cast(origin, direction)
        assert (wanted is None) == (got is None)
        if wanted is not None:
            met += 1
            assert got[0] == wanted[0]
            assert got[1] == pytest.approx(origin + wanted[1] * direction, abs=1e-5)
    assert 20 < met < 200


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("sign", [-1, 1])
def test_rays_along_an_axis(axis, sign):
    """A ray that lies in the plane of no box must not be lost, nor one that starts behind find anything."""
    vertices = np.roll(np.array([[0.0, 0, 0], [0, 1, 0], [0, 0, 1]], np.float32), axis, axis=1)
    surface = Surface(vertices, np.array([[0, 1, 2]]))
    direction = np.roll(np.array([sign, 0, 0]), axis)
    origin = np.roll(np.array([-2.0 * sign, 0.25, 0.25]), axis)
    assert surface.cast(origin, direction)[0] == 0
    assert surface.cast(origin, -direction) is None
    assert np.abs(surface.normal(0)).argmax() == axis


def test_a_brush_covers_the_triangles_within_its_radius(soup):
    surface = Surface(*soup)
    corners = soup[0].astype(float)[soup[1]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    for center, radius in (((0, 0, 0), 0.3), ((0.9, -0.9, 0.5), 0.2), ((5, 5, 5), 1.0)):
        within = np.linalg.norm(corners.mean(axis=1) - center, axis=1) <= radius
        assert surface.ball(center, radius).tolist() == np.flatnonzero(within).tolist()
        wanted = np.flatnonzero(within & (normal[:, 2] > 0)).tolist()
        assert surface.ball(center, radius, facing=(0, 0, -1)).tolist() == wanted


def test_faces_that_are_not_finite_or_have_no_area_are_never_met():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [np.nan, 0, 0], [2, 0, 0]], np.float32)
    surface = Surface(vertices, np.array([[0, 1, 3], [0, 1, 4], [0, 1, 2]]))
    assert surface.cast((0.2, 0.2, 1), (0, 0, -1))[0] == 2
    assert surface.cast((0.5, 0, 1), (0, 0, -1))[0] == 2
    assert surface.cast((3, 3, 1), (0, 0, -1)) is None
