"""The engine's objects as Python treats any: copied, pickled, sent to other processes, made without __init__."""

import copy
import inspect
import multiprocessing
import pickle

import numpy as np
import pytest

import isimp_engine as engine
import shapes

CLASSES = [
    engine.Mesh,
    engine.Partition,
    engine.PolygonMesh,
    engine.Job,
    engine.CleanOptions,
    engine.PartitionOptions,
    engine.MeshingOptions,
]


def members(kind):
    return [name for name in dir(kind) if not name.startswith("_")]


def ask(thing, name):
    value = getattr(thing, name)
    return value() if callable(value) else value


def assert_equal(one, other):
    assert type(one) is type(other)
    for name in members(type(one)):
        mine, theirs = ask(one, name), ask(other, name)
        if isinstance(mine, np.ndarray):
            assert mine.dtype == theirs.dtype
            np.testing.assert_array_equal(mine, theirs)
        else:
            assert mine == theirs, name


def made():
    """One of each, with what only some have: repairs, weights, barriers, a bound, locks."""
    vertices, triangles = shapes.bumpy(20)
    mesh = engine.clean(vertices, np.concatenate([triangles, triangles[:1]]))
    weights = np.linspace(1, 3, len(mesh.triangles))
    barriers = engine.guides.sharp_edges(mesh, 0.2)
    part = engine.partition(mesh, engine.PartitionOptions(bound=0.05), weights=weights, barriers=barriers)
    part = engine.lock_regions(mesh, part, [3])
    return mesh, part, engine.polygonize(mesh, part), engine.PartitionOptions(proxies=7, method="lloyd")


@pytest.mark.parametrize(
    "again",
    [copy.copy, copy.deepcopy, *(lambda x, p=p: pickle.loads(pickle.dumps(x, p)) for p in (2, 5))],  # noqa: S301
    ids=["copy", "deepcopy", "pickle2", "pickle5"],
)
def test_what_comes_back_is_equal_and_can_be_worked_on(again):
    results = made()
    copies = [again(result) for result in results]
    for one, other in zip(results, copies, strict=True):
        assert one is not other
        assert_equal(one, other)
    face = int(np.flatnonzero(~results[1].region_locked[results[1].face_region])[0])
    assert_equal(engine.add_proxy(*results[:2], face), engine.add_proxy(*copies[:2], face))
    assert_equal(engine.polygonize(*results[:2]), engine.polygonize(*copies[:2]))


def test_they_go_to_another_process_and_come_back():
    mesh, part, polygons, options = made()
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        assert_equal(pool.apply(engine.polygonize, (mesh, part)), polygons)
        assert_equal(pool.apply(engine.partition, (mesh, options)), engine.partition(mesh, options))


def test_a_damaged_pickle_gives_no_object():
    for result in made()[:3]:
        kind, state = type(result), result.__getstate__()
        for damaged in ((), state[:1], (*state, 1)):
            with pytest.raises(engine.InvalidInput, match="pickle is damaged"):
                kind.__new__(kind).__setstate__(damaged)
    part = made()[1]
    numbers, guided = part.__getstate__()
    outside = (np.full(len(part.face_region), 10**6, np.int32).tobytes(), *numbers[1:])
    with pytest.raises(engine.InvalidInput, match="pickle is damaged"):
        part.__new__(type(part)).__setstate__((outside, guided))


@pytest.mark.parametrize("kind", CLASSES, ids=lambda kind: kind.__name__)
def test_an_object_that_was_never_made_raises(kind):
    class Own(kind):
        def __init__(self):
            pass

    for empty in (kind.__new__(kind), Own.__new__(Own)):
        for name in members(kind):
            if isinstance(inspect.getattr_static(kind, name), staticmethod):
                continue  # asks of no object
            with pytest.raises(TypeError, match="never made"):
                ask(empty, name)
        with pytest.raises(TypeError, match="never made"):
            repr(empty)
    with pytest.raises(TypeError):
        Own()


def test_an_object_that_was_never_made_is_no_argument():
    empty = engine.Mesh.__new__(engine.Mesh)
    with pytest.raises(TypeError, match="never made"):
        engine.partition(empty)
    with pytest.raises(TypeError, match="never made"):
        engine.partition(engine.Mesh(*shapes.cube()), engine.PartitionOptions.__new__(engine.PartitionOptions))
