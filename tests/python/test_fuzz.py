"""Arrays of all kinds: either the call works and keeps its promises, or it raises InvalidInput; never anything else."""

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
coordinate = st.one_of(
    st.integers(-2, 2).map(float), st.floats(width=32), st.sampled_from([np.nan, np.inf, -np.inf, 1e300, 1e-300])
)


@st.composite
def soups(draw):
    """Few vertices, many faces: folded, doubled, crossing, open, with anything as a coordinate."""
    vertices = draw(hnp.arrays(np.float64, st.tuples(st.integers(1, 9), st.just(3)), elements=coordinate))
    shape = st.tuples(st.integers(0, 24), st.just(3))
    return vertices, draw(hnp.arrays(np.int64, shape, elements=st.integers(0, len(vertices) - 1)))


@pytest.mark.parametrize("make", [engine.Mesh, engine.clean])
@quick
@given(any_array, any_array)
def test_any_arrays_at_all(make, vertices, triangles):
    try:
        mesh = make(vertices, triangles)
    except engine.InvalidInput:
        return
    assert mesh.report["faces"] >= 1


@quick
@given(soups(), st.integers(1, 24), st.sampled_from([0.0, 0.001, 0.5]))
def test_any_soup_gets_through_or_is_refused(soup, proxies, leave_out):
    try:
        mesh = engine.clean(*soup)
    except engine.InvalidInput:
        return
    engine.Mesh(mesh.vertices, mesh.triangles)
    faces = len(mesh.triangles)
    part = engine.partition(mesh, engine.PartitionOptions(proxies=min(proxies, faces), leave_out=leave_out))
    regions = part.region_count
    assert set(part.face_region) - {-1} == set(range(regions))
    assert part.parts_left_out > 0 or part.face_region.min() >= 0
    poly = engine.polygonize(mesh, part)
    assert poly.report["manifold"]
    assert np.isfinite(poly.vertices).all()
    assert set(poly.loops) == set(range(len(poly.vertices)))
    sizes = np.diff(np.append(poly.loop_start, len(poly.loops)))
    assert (sizes >= 3).all()
    with_polygons = set(poly.polygon_region)
    assert with_polygons <= set(range(regions))
    assert len(with_polygons) == regions - poly.report["merged_without_area"]
