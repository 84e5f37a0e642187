"""The thesis's parallel methods and its hybrid, through the module, the recipe and a session."""

import numpy as np
import pytest

import isimp_engine as engine
from isimp.recipe import METHODS, Partition, Recipe
from isimp.session import Session, StepFailed, backends
from session_scans import scan_of
from shapes import cube as cube_arrays

PARALLEL = ("naive", "queued")
THESIS = (*PARALLEL, "hybrid")


@pytest.fixture(scope="module")
def mesh():
    vertices, triangles = cube_arrays(16)
    noise = np.random.default_rng(3).normal(0, 0.002, vertices.shape)
    return engine.Mesh(vertices + noise, triangles)


def split(mesh, **values):
    return engine.partition(mesh, engine.PartitionOptions(proxies=40, **values))


@pytest.mark.parametrize("method", THESIS)
@pytest.mark.parametrize("power", [-30, 30])
def test_each_method_gives_the_same_in_any_unit(mesh, method, power):
    other = engine.Mesh(mesh.vertices * 2.0**power, mesh.triangles)
    one, same = (split(each, method=method, fraction=0.25) for each in (mesh, other))
    assert np.array_equal(one.face_region, same.face_region)


@pytest.mark.parametrize("method", PARALLEL)
def test_every_back_end_and_thread_count_gives_the_same_labels(mesh, method):
    one = split(mesh, method=method, threads=1)
    for backend in engine.backends():
        for threads in (2, 3, 8):
            assert np.array_equal(
                split(mesh, method=method, threads=threads, backend=backend).face_region, one.face_region
            )


@pytest.mark.parametrize("method", THESIS)
def test_guides_hold_and_another_mesh_does_not_use_the_kept_one(mesh, method):
    plain = split(mesh, method=method, fraction=0.25)
    options = engine.PartitionOptions(proxies=40, method=method, fraction=0.25)
    weights = np.where(mesh.vertices[mesh.triangles].mean(axis=1)[:, 2] > 0.5, 9.0, 1.0)
    heavy = engine.partition(mesh, options, weights=weights)
    assert heavy.error > plain.error
    assert np.array_equal(engine.partition(mesh, options, weights=weights).face_region, heavy.face_region)
    assert np.array_equal(split(mesh, method=method, fraction=0.25).face_region, plain.face_region)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"nearest": 0}, r"nearest must be in \[1, 32\], got 0"),
        ({"nearest": 33}, r"nearest must be in \[1, 32\], got 33"),
        ({"fraction": 0.0}, r"fraction must be in \(0, 1\], got 0"),
        ({"method": "hybrid", "fraction": 0.001}, "too few for 40 regions"),
    ],
)
def test_options_out_of_range_are_named(mesh, values, message):
    with pytest.raises(engine.InvalidInput, match=message):
        split(mesh, **values)


@pytest.mark.skipif("cuda" in engine.backends(), reason="there is a device")
def test_a_missing_back_end_is_refused_with_the_reason_and_the_choices(mesh):
    for method in (*THESIS, "hierarchy"):
        with pytest.raises(engine.InvalidInput, match=r"back end 'cuda' is not available here: .*; there is: cpu"):
            split(mesh, method=method, backend="cuda")


def test_a_device_that_fails_stops_the_recipe_with_its_reason(mesh, monkeypatch):
    def fail(*_, **__):
        raise RuntimeError("ran out of memory; back end 'cpu' can do the same")

    monkeypatch.setattr(engine.states, "partition_guided", fail)
    scan = scan_of(mesh.vertices, mesh.triangles)
    with pytest.raises(StepFailed, match=r"^Step 1, .*: ran out of memory; back end 'cpu' can do the same"):
        Session().replay(scan, Recipe((Partition(proxies=12, method="queued"),)))


def test_the_recipe_knows_every_method_of_the_engine_and_a_session_the_back_ends(mesh):
    for method in METHODS:
        engine.PartitionOptions(method=method)
    assert backends() == engine.backends()
    scan = scan_of(mesh.vertices, mesh.triangles)
    recipe = Recipe((Partition(proxies=12, method="queued"),))
    outcome = Session(backend=backends()[-1]).replay(scan, recipe)
    assert np.array_equal(outcome.face_region, Session().replay(scan, recipe).face_region)
    with pytest.raises(StepFailed, match="there is: cpu"):
        Session(backend="abacus").replay(scan, recipe)
