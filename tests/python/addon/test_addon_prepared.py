"""The data that a session keeps of scans, and the regions of faces with several triangles."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import shapes
from isimp import sketch
from isimp.recipe import AddProxy, Mesh, Partition, Recipe
from isimp.session import Session, engine
from isimp.task import Watch
from isimp_engine.cache import Cache
from session_scans import scan_of


def test_the_cache_is_bounded_and_keeps_the_values_used_last():
    cache = Cache(budget=10)
    for key in "abc":
        cache.put(key, key.upper(), 4)
    assert (cache.get("a"), cache.get("b"), len(cache)) == (None, "B", 2)
    cache.put("d", "D", 4)
    assert (cache.get("c"), cache.get("b")) == (None, "B")
    cache.put("e", "E", 99)
    assert (cache.get("e"), len(cache)) == ("E", 1)
    cache.put("e", "e", 2)
    cache.put("f", "F", 2)
    assert len(cache) == 2
    cache.put("g", "G", 6)
    assert len(cache) == 3, "the values are as large as the budget"


def test_the_cache_keeps_the_newest_ones_however_large_they_are():
    cache = Cache(budget=10, least=2)
    for key in "abc":
        cache.put(key, key.upper(), 99)
    assert [cache.get(key) for key in "abc"] == [None, "B", "C"]


@pytest.fixture
def made(monkeypatch):
    """The names of the repairs that are made."""
    names = []

    def count(name):
        function = getattr(engine.repairs, name)

        def counted(*args, **named):
            names.append(name)
            return function(*args, **named)

        monkeypatch.setattr(engine.repairs, name, counted)

    count("clean")
    count("close_openings")
    return names


@pytest.mark.parametrize(
    ("options", "closes"),
    [
        ({"stitch": 0.01}, True),
        ({"outside_only": True, "close_openings": False}, False),
        ({"keep_openings": ((9.0, 9.0, 9.0),)}, True),
    ],
)
def test_a_scan_is_repaired_once_by_each_repair(made, options, closes):
    outcome = Session(budget=0).replay(scan_of(*shapes.room(16)), Recipe((Partition(proxies=30, **options), Mesh())))
    assert bool(outcome.repair.lengths) == closes
    assert made == (["clean", "close_openings"] if closes else ["clean"])


def test_a_scan_larger_than_the_cache_is_repaired_once_and_its_openings_are_closed_once(made):
    scan = scan_of(*shapes.room(16))
    session = Session(budget=0)
    recipe = Recipe((Partition(proxies=30),))
    outcome = session.replay(scan, recipe)
    assert outcome.repair.lengths.handles > 0
    session.replay(scan, recipe.then(AddProxy(face=7)).then(Mesh()))
    session.replay(scan, Recipe((Partition(proxies=31),)))
    assert made == ["clean", "close_openings"]


def test_faces_with_several_triangles_take_the_region_with_most_of_their_area():
    random = np.random.default_rng(3)
    scan = scan_of(*shapes.room(4))
    repaired = Session().prepare(scan)
    face = random.integers(0, scan.face_count // 2, len(repaired.faces.mesh_face)).astype(np.int32)
    label = random.integers(-1, 40, len(face)).astype(np.int32)
    triangles, vertices = np.asarray(repaired.mesh.triangles), np.asarray(repaired.mesh.vertices)
    area = np.linalg.norm(np.cross(*(vertices[triangles[:, k]] - vertices[triangles[:, 0]] for k in (1, 2))), axis=1)
    shared = np.flatnonzero(np.bincount(face)[face] > 1)
    faces = replace(repaired.faces)
    vars(faces).update(mesh_face=face, shared=shared, areas=area[shared])
    found = faces.regions(SimpleNamespace(face_region=label, region_count=40, region_seed=np.zeros(0, int)))
    for user_face in range(scan.face_count):
        mine = np.flatnonzero((face == user_face) & (label >= 0))
        sums = np.bincount(label[mine], area[mine], 40)
        assert found[user_face] == (-1 if len(mine) == 0 else np.argmax(sums))


def test_the_sketch_of_regions_needs_no_other_repair(made):
    scan, session = scan_of(*shapes.room(16)), Session(budget=0)
    recipe = Recipe((Partition(proxies=30, stitch=0.01),))
    outcome = session.replay(scan, recipe)
    assert sketch.at_once(session, scan, recipe) is not None
    sketch.draw(session, scan, outcome.face_region, recipe, Mesh(), Watch())
    assert made == ["clean", "close_openings"]
