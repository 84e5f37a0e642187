"""No region may hide two: a split of it would lower the error by little."""

import pytest

import isimp_engine as engine
from bench.generators import houses

DATA = (
    "scan/bunny_69k.ply",
    "scan/rockerarm_20k.ply",
    "building/fandisk_13k.ply",
    "building/frankfurt_tile_49k.ply",
    "nasty/lionstatue_63k_misoriented.ply",
    "real/office_27k.ply",
)
MOST = 4  # times the cost up to which regions merge


def street(count):
    """Above 50,000 faces merging begins with patches of faces."""
    made = houses.street(count)
    return engine.Mesh(made.vertices, made.triangles)


def largest_gain(mesh, part):
    """The decrease of the error by the best split of a region, in units of 16 t^2."""
    unit = 16 * max(part.tolerance, 3.5 * part.noise) ** 2
    errors = [region["error"] for region in engine.regions.all_statistics(mesh, part)]
    seeds = [int(part.region_seed[r]) for r, error in enumerate(errors) if error > MOST * unit]
    return max((part.error - engine.split_region(mesh, part, seed).error for seed in seeds), default=0) / unit


@pytest.mark.parametrize("detail", [0.0005, 0.00125])
def test_no_region_of_a_street_runs_around_a_corner(detail):
    mesh = street(3)
    assert len(mesh.triangles) > 50_000
    assert largest_gain(mesh, engine.partition(mesh, engine.PartitionOptions(detail=detail))) < MOST


def test_a_given_number_of_regions_follows_corners_too():
    mesh = street(3)
    found = engine.partition(mesh, engine.PartitionOptions(detail=0.0005, metric="normals"))
    given = engine.partition(mesh, engine.PartitionOptions(proxies=found.region_count, metric="normals"))
    assert given.error < 1.4 * found.error  # 1.5 where patches merge around corners at any price


@pytest.mark.parametrize("name", DATA)
@pytest.mark.parametrize("detail", [0.01, 0.005, 0.0025])
def test_no_region_of_a_scan_hides_two(data, name, detail):
    mesh = engine.clean(*engine.read(data / name))
    assert largest_gain(mesh, engine.partition(mesh, engine.PartitionOptions(detail=detail))) < MOST
