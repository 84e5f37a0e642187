"""Calls that give the same bits on any number of threads, and again."""

import pickle
from types import SimpleNamespace

import numpy as np
import pytest

import isimp_engine as engine
import shapes


@pytest.fixture(scope="module")
def model():
    """A scan with an image and two layers, and all that is made of it."""
    vertices, triangles = shapes.bumpy(24)
    grey = np.add.outer(np.arange(32), np.arange(64)).astype(np.uint8)
    color = np.stack([grey, 2 * grey, 255 - grey], axis=2)
    layers = {"roughness": engine.TextureLayer([grey]), "normal": engine.TextureLayer([color])}
    soup = engine.TexturedSoup(vertices * [1, 1, 4], triangles, vertices[:, :2], images=[color], layers=layers)
    mesh = engine.clean(soup.vertices, soup.triangles)
    part = engine.partition(mesh, engine.PartitionOptions(proxies=30))
    return SimpleNamespace(soup=soup, mesh=mesh, part=part, poly=engine.polygonize(mesh, part))


def partition(method):
    def call(model, threads):
        options = engine.PartitionOptions(proxies=30, method=method, iterations=3, threads=threads)
        return engine.partition(engine.Mesh(model.mesh.vertices, model.mesh.triangles), options)

    return call


def texture(model, threads):
    options = engine.TextureOptions(size=300, occlusion=True, threads=threads)
    return engine.texture(model.mesh, model.part, model.poly, model.soup, options)


CALLS = {
    "Mesh": lambda m, threads: engine.Mesh(m.mesh.vertices, m.mesh.triangles, threads=threads),
    "merge_flat": lambda m, threads: engine.merge_flat(m.mesh, 5.0),
    "polygonize": lambda m, threads: engine.polygonize(m.mesh, m.part, engine.MeshingOptions(threads=threads)),
    "texture": texture,
} | {method: partition(method) for method in ("hierarchy", "lloyd", "naive", "queued")}


@pytest.mark.parametrize("name", CALLS)
def test_the_bits_are_the_same_on_any_number_of_threads_and_again(model, name):
    one, *others = (pickle.dumps(CALLS[name](model, threads)) for threads in (1, 3, 1))
    assert others == [one, one]


def test_fewer_threads_than_none_are_refused():
    with pytest.raises(engine.InvalidInput, match="threads must be at least 0, got -1"):
        engine.Mesh(*shapes.plane(2), threads=-1)
