"""The number of regions found by itself: detail, tolerance, noise, snap."""

import itertools
import json

import numpy as np
import pytest

import isimp_engine as engine
import shapes
from isimp_engine.cli import main


def noisy(vertices, triangles, sigma, seed=1):
    rng = np.random.default_rng(seed)
    return vertices + rng.normal(scale=sigma, size=vertices.shape), triangles


def found(mesh, **fields):
    return engine.partition(mesh, engine.PartitionOptions(**fields))


def test_detail_and_tolerance_are_the_same_in_other_units():
    mesh = engine.Mesh(*shapes.bumpy())
    part = found(mesh, detail=0.004)
    same = found(mesh, tolerance=part.report["tolerance"])
    np.testing.assert_array_equal(part.face_region, same.face_region)
    larger = engine.Mesh(mesh.vertices * 50, mesh.triangles)
    assert found(larger, detail=0.004).report["tolerance"] == pytest.approx(50 * part.report["tolerance"])
    assert found(larger, detail=0.004).region_count == part.region_count


def test_finer_detail_gives_more_regions_and_a_report():
    mesh = engine.Mesh(*shapes.torus(240, 120))
    counts = [found(mesh, detail=d).region_count for d in (0.02, 0.01, 0.005, 0.0025)]
    assert [2 * a <= 3 * b and a < b for a, b in itertools.pairwise(counts)] == [True] * 3
    report = found(mesh, detail=0.01, noise=0.0).report
    assert (report["noise"], report["snapped"], report["regions"]) == (0.0, False, counts[1])
    given = found(mesh, proxies=9).report
    assert (given["tolerance"], given["noise"], given["snapped"]) == (None, None, False)


def test_noise_is_estimated_or_taken_as_given():
    mesh = engine.Mesh(*noisy(*shapes.cube(24), 0.004))
    part = found(mesh, detail=0.00125)
    assert part.report["noise"] == pytest.approx(0.004, rel=0.3)
    assert part.region_count == 6
    assert found(mesh, detail=0.0002, noise=0, snap=False).region_count > 20
    assert found(mesh, detail=0.0002, snap=False).region_count == 6


def test_snap_can_be_switched_off():
    vertices, triangles = shapes.cube(12)
    vertices[:, 2] += 0.01 * np.sin(vertices[:, 0] * np.pi)  # top and bottom bend a little, less than the tolerance
    mesh = engine.Mesh(vertices, triangles)
    part = found(mesh, detail=0.02, snap=False)
    assert not part.report["snapped"]
    assert found(mesh, detail=0.02).report["snapped"]


def test_a_bound_in_the_noise_is_warned_of():
    mesh = engine.Mesh(*noisy(*shapes.plane(40), 0.002))
    (text,) = found(mesh, bound=0.004).report["warnings"]
    assert text.startswith("the bound is below 4 times the noise of 0.002")
    assert found(mesh, bound=0.004, noise=0).report["warnings"] == []


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"proxies": 3, "detail": 0.01}, "^proxies and detail are given, but each alone says how many"),
        ({"proxies": 3, "detail": 0.01, "tolerance": 1}, "^proxies and detail and tolerance are given"),
        ({"detail": 0}, r"^detail must be in \(0, 1\], got 0"),
        ({"detail": float("nan")}, r"^detail must be in \(0, 1\], got nan"),
        ({"detail": 1.5}, r"^detail must be in \(0, 1\], got 1.5"),
        ({"tolerance": -1}, "^tolerance must be a finite length above 0, got -1"),
        ({"tolerance": float("inf")}, "^tolerance must be a finite length above 0, got inf"),
        ({"bound": 0}, "^bound must be a finite length above 0, got 0"),
        ({"bound": 1, "detail": 0.1}, "^detail and bound are given"),
        ({"bound": 1, "method": "lloyd"}, "^a bound is kept by method hierarchy only"),
        ({"adaptivity": 1.5}, r"^adaptivity must be in \[0, 1\], got 1.5"),
        ({"noise": -0.5}, "^noise must be a finite length, at least 0, got -0.5"),
    ],
)
def test_bad_options_are_named(fields, message):
    with pytest.raises(engine.InvalidInput, match=message):
        found(engine.Mesh(*shapes.cube(3)), **fields)


def test_the_command_finds_the_number_too(tmp_path, capsys):
    scan, out, report = tmp_path / "scan.ply", tmp_path / "out.obj", tmp_path / "r.json"
    mesh = engine.Mesh(*shapes.cube(8))
    engine.write(scan, engine.polygonize(mesh, found(mesh, proxies=768)))
    for flags, regions in (([], 6), (["--detail", "0.01", "--noise=0"], 6), (["--tolerance=0.3", "--no-snap"], 4)):
        assert main(["simplify", str(scan), str(out), *flags, "--report", str(report)]) == 0
        said = json.loads(report.read_text())
        assert said["regions"] == regions
        assert said["partition"]["tolerance"] > 0
        assert f"{regions} regions found at a tolerance of" in capsys.readouterr().out
    with pytest.raises(SystemExit) as caught:
        main(["simplify", str(scan), str(out), "--detail=0.01", "--proxies=6"])
    assert caught.value.code == 2
    assert "not allowed with" in capsys.readouterr().err


def test_few_large_triangles_are_drawn_and_are_no_noise():
    """Hills of 288 triangles get about as many regions as the same hills of more."""
    vertices, triangles = shapes.plane(12)
    vertices[:, 2] = 0.2 * np.sin(7 * vertices[:, 0]) * np.cos(5 * vertices[:, 1])
    fine, more = shapes.plane(48)
    fine[:, 2] = 0.2 * np.sin(7 * fine[:, 0]) * np.cos(5 * fine[:, 1])
    coarse = found(engine.clean(vertices, triangles))
    assert coarse.report["noise"] == 0
    assert coarse.region_count >= 0.75 * found(engine.clean(fine, more)).region_count
