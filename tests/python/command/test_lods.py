"""`isimp simplify --lods`: several results of one scan."""

import json

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
from isimp_engine import cli


@pytest.fixture
def painted(tmp_path):
    """A scan with a colour for each vertex."""
    vertices, triangles = shapes.bumpy(30)
    colors = np.round(127 + 120 * np.sin(7 * vertices)).astype(np.uint8)
    path = tmp_path / "painted.ply"
    columns = dict(zip("xyz", vertices.T.astype(np.float32), strict=True))
    columns |= dict(zip(("red", "green", "blue"), colors.T, strict=True))
    meshfiles.ply_columns(path, columns, [(t,) for t in triangles])
    return path


def run(*arguments):
    return cli.main([str(argument) for argument in arguments])


def test_each_level_equals_the_result_for_its_number_alone(scan, tmp_path, capsys):
    out, labels, report = tmp_path / "stone.obj", tmp_path / "l.npy", tmp_path / "r.json"
    assert run("simplify", scan, out, "--lods", "60,20,8", "--labels", labels, "--report", report) == 0
    said = capsys.readouterr().out
    assert said.count(str(scan)) == 1
    levels = json.loads(report.read_text())["lods"]
    assert [level["options"]["proxies"] for level in levels] == [60, 20, 8]
    assert json.loads(report.read_text())["regions"] == 60
    for number, regions in enumerate((60, 20, 8)):
        alone, alone_labels = tmp_path / "alone.obj", tmp_path / "alone.npy"
        assert run("simplify", scan, alone, "--proxies", regions, "--labels", alone_labels, "--quiet") == 0
        level = tmp_path / f"stone_LOD{number}.obj"
        assert level.read_bytes() == alone.read_bytes()
        np.testing.assert_array_equal(np.load(tmp_path / f"l_LOD{number}.npy"), np.load(alone_labels))
        assert str(level) in said
    assert not out.exists()


def test_images_are_halved_from_level_to_level(painted, tmp_path, capsys):
    for size, sides in (("256", (256, 128, 64)), (None, None)):
        report = tmp_path / "r.json"
        texture = ["--texture", size] if size else ["--texture"]
        assert run("simplify", painted, tmp_path / "t.obj", "--lods", "40,12,5", "--report", report, *texture) == 0
        made = [level["texture"]["size"] for level in json.loads(report.read_text())["lods"]]
        first = made[0]
        assert made == list(sides or (first, max(16, first // 2), max(16, first // 4)))
        for number in range(3):
            soup = engine.read_textured(tmp_path / f"t_LOD{number}.obj")
            assert [image.shape[0] for image in soup.images if image is not None] == [made[number]]
    capsys.readouterr()


@pytest.mark.parametrize("text", ["", "a", "8,20", "20,20", "20,0", "20,-1", "5.5"])
def test_numbers_that_do_not_fall_are_refused(scan, tmp_path, capsys, text):
    with pytest.raises(SystemExit) as ended:
        run("simplify", scan, tmp_path / "o.ply", f"--lods={text}")
    assert ended.value.code == 2
    assert "each below the one before" in capsys.readouterr().err


def test_options_that_contradict_levels_are_refused_before_the_work(scan, tmp_path, capsys):
    assert run("simplify", scan, tmp_path / "o.ply", "--lods", "20,8", "--detail", ".01") == 2
    assert "leave out --detail" in capsys.readouterr().err
    assert not list(tmp_path.glob("o*"))


def test_a_recipe_gives_all_but_the_number(scan, tmp_path, capsys):
    recipe, report = tmp_path / "r.json", tmp_path / "report.json"
    recipe.write_text(json.dumps({"isimp_recipe": 1, "steps": [{"step": "partition", "detail": 0.02, "smooth": 1.0}]}))
    assert run("simplify", scan, tmp_path / "o.ply", "--lods", "20,8", "--recipe", recipe, "--report", report) == 0
    for level, regions in zip(json.loads(report.read_text())["lods"], (20, 8), strict=True):
        assert (level["regions"], level["options"]["smooth"]) == (regions, 1)
        assert level["options"]["detail"] is None
    capsys.readouterr()


def test_a_preset_for_a_scan_with_noise_gives_all_but_the_number(tmp_path, capsys):
    vertices, triangles = shapes.cube(24)
    noisy = vertices + np.random.default_rng(1).normal(0, 0.002, vertices.shape)
    scan, report = tmp_path / "noisy.ply", tmp_path / "report.json"
    meshfiles.ply_binary(scan, noisy, triangles.tolist())
    options = ["--lods", "12,6", "--preset", "cad", "--report", report]
    assert run("simplify", scan, tmp_path / "o.ply", *options) == 0
    assert [level["options"]["proxies"] for level in json.loads(report.read_text())["lods"]] == [12, 6]
    capsys.readouterr()


def test_a_level_that_fails_leaves_nothing(scan, tmp_path, capsys):
    (tmp_path / "o_LOD1.ply").mkdir()
    assert run("simplify", scan, tmp_path / "o.ply", "--lods", "20,8") == 2
    assert "o_LOD1.ply: is a folder" in capsys.readouterr().err
    assert not (tmp_path / "o_LOD0.ply").exists()
    assert run("simplify", scan, tmp_path / "p.ply", "--lods", "20000,8") == 2
    assert "proxies must be" in capsys.readouterr().err
    assert not list(tmp_path.glob("p*"))


def test_the_scan_is_not_overwritten_by_a_level(tmp_path, capsys):
    scan = tmp_path / "s_LOD1.ply"
    vertices, triangles = shapes.bumpy(10)
    meshfiles.ply_binary(scan, vertices, triangles.tolist())
    before = scan.read_bytes()
    assert run("simplify", scan, tmp_path / "s.ply", "--lods", "20,8") == 2
    assert "named twice" in capsys.readouterr().err
    assert scan.read_bytes() == before
