"""The engine's objects as Python treats any: copied, pickled, sent to other processes, made without __init__."""

import copy
import gc
import inspect
import multiprocessing
import pickle

import numpy as np
import pytest

import isimp_engine as engine
import shapes
from headers import struct_fields
from isimp_engine import _core

CLASSES = [
    engine.Mesh,
    engine.Partition,
    engine.PolygonMesh,
    engine.Job,
    engine.CleanOptions,
    engine.PartitionOptions,
    engine.MeshingOptions,
    engine.RegulariseOptions,
    engine.TextureOptions,
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
        if name == "faces":  # a list of arrays
            assert list(map(len, mine)) == list(map(len, theirs))
            mine, theirs = np.concatenate(mine), np.concatenate(theirs)
        if isinstance(mine, np.ndarray):
            assert mine.dtype == theirs.dtype
            np.testing.assert_array_equal(mine, theirs)
        else:
            assert mine == theirs, name


def made():
    """One of each, with optional contents: repairs, weights, barriers, a bound, locks."""
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
def test_copies_are_equal_and_usable(again):
    results = made()
    copies = [again(result) for result in results]
    for one, other in zip(results, copies, strict=True):
        assert one is not other
        assert_equal(one, other)
    face = int(np.flatnonzero(~results[1].region_locked[results[1].face_region])[0])
    assert_equal(engine.add_proxy(*results[:2], face), engine.add_proxy(*copies[:2], face))
    assert_equal(engine.polygonize(*results[:2]), engine.polygonize(*copies[:2]))


def test_they_travel_to_another_process_and_back():
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
    numbers, guided, *curved = part.__getstate__()
    outside = (np.full(len(part.face_region), 10**6, np.int32).tobytes(), *numbers[1:])
    with pytest.raises(engine.InvalidInput, match="pickle is damaged"):
        part.__new__(type(part)).__setstate__((outside, guided, *curved))


def changed(state, at, k, value):
    """A state with number k of its array `at` replaced."""
    numbers = list(state)
    array = np.frombuffer(numbers[at], type(value)).copy()
    array[k] = value
    numbers[at] = array.tobytes()
    return tuple(numbers)


def refuses(thing, state):
    with pytest.raises(engine.InvalidInput, match="pickle is damaged"):
        type(thing).__new__(type(thing)).__setstate__(state)


def test_a_pickle_whose_numbers_do_not_fit_together_gives_no_object():
    mesh, part, polygons = made()[:3]
    refuses(mesh, changed(mesh.__getstate__(), 2, 0, np.int32(-2)))  # source_face
    refuses(mesh, changed(mesh.__getstate__(), 3, 0, np.int32(-2)))  # source_vertex
    numbers, guided, *curved = part.__getstate__()
    for at, k, value in [
        (0, 3, np.int32(part.face_region[3] ^ 1)),  # a region has another number of faces than its sum
        (1, 1, np.int32(part.region_seed[0])),  # a seed outside its region
        (2, 0, np.float64(3.0)),  # a normal that is not unit
        (2, 0, np.float64(np.nan)),
        (12, 0, np.float64(np.inf)),  # an offset
    ]:
        refuses(part, (changed(numbers, at, k, value), guided, *curved))
    refuses(part, ((*numbers[:8], float("nan"), *numbers[9:]), guided, *curved))  # noise
    # labels, neighbours, and the two orders of faces of the guided graph
    refuses(part, (numbers, changed(guided, 5, 0, np.int32(np.frombuffer(guided[5], np.int32)[1])), *curved))
    refuses(part, (numbers, changed(guided, 3, 3, np.float32(np.nan)), *curved))
    arrays, report = polygons.__getstate__()
    refuses(polygons, (changed(arrays, 0, 0, np.float64(np.inf)), report))
    refuses(polygons, (changed(arrays, 2, 0, np.int32(1)), report))
    refuses(polygons, (changed(arrays, 3, 0, np.int32(-1)), report))


@pytest.mark.parametrize("kind", CLASSES, ids=lambda kind: kind.__name__)
def test_an_object_that_was_never_made_raises(kind):
    class Own(kind):
        def __init__(self):
            pass

    for empty in (kind.__new__(kind), Own.__new__(Own)):
        for name in members(kind):
            if isinstance(inspect.getattr_static(kind, name), staticmethod):
                continue  # uses no object
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


def test_nor_is_one_of_a_private_class():
    polygons = made()[2]
    search = _core._BoundSearch
    for kind, use in [
        (_core._Atlas, lambda empty: _core._uv(polygons, empty)),
        (_core._Atlas, lambda empty: empty.side),
        (search, lambda empty: empty.next()),
        (search.Step, lambda empty: empty.share),
        (_core._Stretch, lambda empty: empty.__enter__()),
    ]:
        with pytest.raises(TypeError, match="never made"):
            use(kind.__new__(kind))


def test_an_atlas_of_other_polygons_is_refused():
    mesh, part, polygons = made()[:3]
    others = engine.polygonize(mesh, engine.partition(mesh, engine.PartitionOptions(proxies=5)))
    options = engine.TextureOptions(size=64, occlusion=True)
    atlas = _core._unwrap(others, options, 10.0)
    with pytest.raises(engine.InvalidInput, match="atlas is not of these polygons"):
        _core._uv(polygons, atlas)
    with pytest.raises(engine.InvalidInput, match="atlas is not of these polygons"):
        _core._occlusion(mesh, part, polygons, atlas, options)


#: the arrays of an object of made()
VIEWS = [
    (0, ["vertices", "triangles", "source_face", "component"]),
    (1, ["face_region", "region_seed", "region_normal", "history"]),
    (2, ["vertices", "loops", "loop_start", "polygon_region", "planarity", "source_vertex"]),
]


@pytest.mark.parametrize(("which", "names"), VIEWS)
def test_views_are_read_only_and_keep_their_object_alive(which, names):
    results = list(made())
    views = {name: getattr(results[which], name) for name in names}
    expected = {name: array.copy() for name, array in views.items()}
    for array in views.values():
        assert not array.flags.writeable
        assert not array.flags.owndata
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    results.clear()
    gc.collect()
    made()  # would land on freed memory
    for name, array in views.items():
        np.testing.assert_array_equal(array, expected[name])


def test_every_number_and_array_of_the_headers_is_there():
    _, part, poly, _ = made()
    hidden = {"region_sum", "region_cell", "guided", "off_planes"}  # the start of edits, of no use outside
    assert set(struct_fields("partition/partition.h", "Partition")) - hidden <= set(members(type(part)))
    assert set(struct_fields("meshing/polygonize.h", "PolygonMesh")) <= set(members(type(poly)))
    assert set(struct_fields("meshing/polygonize.h", "MeshingReport")) <= set(poly.report)
