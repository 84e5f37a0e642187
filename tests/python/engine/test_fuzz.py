"""Arrays of all kinds: either the call works and keeps its promises, or it raises InvalidInput."""

import numpy as np
import pytest

import isimp_engine as engine

hypothesis = pytest.importorskip("hypothesis")
from hypothesis import given, settings  # noqa: E402
from hypothesis import strategies as st  # noqa: E402
from hypothesis.extra import numpy as hnp  # noqa: E402

quick = settings(max_examples=150, deadline=None, derandomize=True)

any_array = hnp.arrays(
    dtype=st.one_of(hnp.scalar_dtypes(), hnp.unicode_string_dtypes(), st.just(np.dtype(object))),
    shape=hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4),
)


@pytest.mark.parametrize("make", [engine.Mesh, engine.clean])
@quick
@given(any_array, any_array)
def test_any_arrays_at_all(make, vertices, triangles):
    try:
        mesh = make(vertices, triangles)
    except engine.InvalidInput:
        return
    assert mesh.report["faces"] >= 1


def rings(n=10):
    """A sphere of n rings, 8 n^2 or so faces."""
    u, v = np.linspace(0, np.pi, n)[1:-1], np.linspace(0, 2 * np.pi, 2 * n, endpoint=False)
    around = np.stack([np.cos(v), np.sin(v), 0 * v], 1)
    vertices = np.concatenate([[[0, 0, 1.0]], *(np.sin(a) * around + [0, 0, np.cos(a)] for a in u), [[0, 0, -1.0]]])
    m, last = len(v), len(vertices) - 1
    j, k = np.arange(m), (np.arange(m) + 1) % m
    faces = [np.stack([0 * j, 1 + j, 1 + k], 1), np.stack([last - m + j, 0 * j + last, last - m + k], 1)]
    for i in range(n - 3):
        a, b = 1 + i * m + j, 1 + i * m + k
        faces += [np.stack([a, a + m, b], 1), np.stack([b, a + m, b + m], 1)]
    return vertices, np.concatenate(faces).astype(np.int32)


def with_outliers(distance, seed, vertices):
    """Up to three vertices moved far away."""
    rng = np.random.default_rng(seed)
    places = rng.integers(0, len(vertices), 1 + seed % 3)
    away = rng.normal(size=(len(places), 3))
    vertices = vertices.copy()
    vertices[places] = distance * away / np.linalg.norm(away, axis=1)[:, None]
    return vertices


FLATTENED = [(1, 1, 0), (1, 0, 0), (0, 0, 0), (1, 1e-9, 1e-9), (1, 1, 1e-9), (1e-200,) * 3, (1e30,) * 3, (1e20, 1, 1)]


def degenerate():
    """Spheres flattened to discs, needles and points, very large, very small, and with vertices far away."""
    vertices, triangles = rings(8)
    for by in FLATTENED:
        yield f"times {by}", vertices * by, triangles
    for power in (3, 9, 10, 25):
        for seed in range(2):
            yield f"outliers 1e{power} seed {seed}", with_outliers(10.0**power, seed, vertices), triangles


def textured(vertices, triangles):
    image = np.full((4, 4, 4), 99, np.uint8)
    return engine.TexturedSoup(vertices, triangles, np.zeros((len(triangles), 3, 2)), images=[image])


def test_degenerate_shapes_get_polygons_and_textures_or_are_refused():
    done, why = 0, []
    for name, vertices, triangles in degenerate():
        for proxies in (1, 12):
            try:
                mesh = engine.clean(vertices, triangles)
                options = engine.PartitionOptions(proxies=proxies, threads=1)
                part = engine.partition(mesh, options)
            except engine.InvalidInput as refused:
                why.append(str(refused))
                continue
            assert set(part.face_region) == set(range(part.region_count)), name
            polygons = engine.polygonize(mesh, part, engine.MeshingOptions(threads=1))
            assert np.isfinite(polygons.vertices).all(), name
            try:
                options = engine.TextureOptions(size=128, threads=1)
                made = engine.texture(mesh, part, polygons, textured(vertices, triangles), options)
                assert made.report["size"] == 128, name
            except engine.InvalidInput as refused:
                why.append(str(refused))
            done += 1
    assert done > 8
    assert all("charts do not fit" in text for text in why)
