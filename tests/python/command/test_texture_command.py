"""Textures of the command, by options and by the step of a recipe; wrong use of both."""

import json
from pathlib import Path

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
from commands import called
from test_texture import SIX, sample, write_cube_obj
from test_udim import write_udim_plane


@pytest.fixture
def scans(tmp_path):
    """A folder with cube.obj of six colours, strip.obj of three tiles, and plain.ply without a texture."""
    write_cube_obj(tmp_path)
    write_udim_plane(tmp_path)
    vertices, triangles = shapes.plane(2)
    x, y, z = vertices.T.astype(np.float32)
    meshfiles.ply_columns(tmp_path / "plain.ply", {"x": x, "y": y, "z": z}, [(t,) for t in triangles])
    return tmp_path


def recipe(folder, **texture):
    steps = [{"step": "partition", "proxies": 6, "count_by": "proxies"}, {"step": "mesh"}]
    text = json.dumps({"isimp_recipe": 1, "steps": [*steps, {"step": "texture", "size": 64, **texture}]})
    (folder / "r.json").write_text(text)


def colours(soup):
    return {tuple(c) for c in sample(soup.images[0], soup.uv.mean(axis=1))[:, :3]}


def by_name(soup):
    return {name: tuple(image[16, 16, :3].tolist()) for name, image in zip(soup.names, soup.images, strict=True)}


SIDES = [tuple(map(int, colour)) for colour in SIX]
# Arguments, files of images, a part of stdout, and a condition of the texture when it is read again.
MADE = [
    (["cube.obj", "made.obj", "--texture", "128"], ["made.png", "made_normal.png"], "texture: 128 x 128 pixels",
     lambda soup: colours(soup) == {tuple(c) for c in SIX}),
    (["cube.obj", "made.glb", "--texture"], [], "", lambda soup: len(soup.triangles) == 12),
    (["cube.obj", "made.gltf", "--texture"], ["made.png", "made_normal.png"], "",
     lambda soup: len(soup.triangles) == 12),
    (["cube.obj", "made.obj", "--texture", "32", "--keep-materials"], None, "6 images of 32 x 32 pixels",
     lambda soup: by_name(soup) == {f"side{s}": colour for s, colour in enumerate(SIDES)}),
    (["cube.obj", "made.glb", "--texture", "32", "--keep-materials"], [], "",
     lambda soup: sorted(soup.names) == [f"made-side{s}" for s in range(6)]),
    (["strip.obj", "made.glb", "--texture", "32", "--tiles", "2"], [], "2 images of 32 x 32 pixels",
     lambda soup: len(soup.images) == 2),
    (["cube.obj", "made.glb", "--texture", "64", "--ao"], [], "",
     lambda soup: (soup.layers["occlusion"].images[0][:, :, 0] == 255).all()),
    (["cube.obj", "made.obj", "--texture", "64", "--ao", "0.5"],
     ["made.png", "made_normal.png", "made_occlusion.png"], "", lambda soup: len(soup.images) == 1),
]  # fmt: skip


@pytest.mark.parametrize(("arguments", "images", "said", "holds"), MADE, ids=[" ".join(row[0]) for row in MADE])
def test_the_command_makes_it(scans, arguments, images, said, holds):
    ran = called("simplify", *arguments, "--proxies", "6", "--report", "r.json", cwd=scans)
    assert ran.returncode == 0, ran.stderr
    assert said in ran.stdout
    told = json.loads((scans / "r.json").read_text())["texture"]
    made = sorted(path.name for path in scans.glob("made*.png"))
    assert images is None or made == images
    assert sorted(Path(path).name for path in told["files"] if path.endswith(".png")) == made
    assert holds(engine.read_textured(scans / arguments[1]))


@pytest.mark.parametrize(
    ("texture", "arguments", "size", "layer"),
    [({}, [], 64, ""), ({}, ["--texture", "32"], 32, ""), ({"occlusion": True}, [], 64, "occlusion")],
)
def test_the_step_of_a_recipe_makes_it_and_what_is_given_comes_first(scans, texture, arguments, size, layer):
    recipe(scans, **texture)
    ran = called("simplify", "cube.obj", "out.glb", "--recipe", "r.json", *arguments, cwd=scans)
    assert ran.returncode == 0, ran.stderr
    soup = engine.read_textured(scans / "out.glb")
    assert soup.images[0].shape == (size, size, 4)
    assert ("occlusion" in soup.layers) == (layer == "occlusion")


@pytest.mark.parametrize("arguments", [[], ["--texture", "32"]])
def test_all_settings_of_the_step_are_obeyed(scans, arguments):
    recipe(scans, normals=False, gutter=3, unfold=0.0)
    command = ["cube.obj", "out.glb", "--recipe", "r.json", "--report", "report.json", "--quiet", *arguments]
    ran = called("simplify", *command, cwd=scans)
    assert ran.returncode == 0, ran.stderr
    assert json.loads((scans / "report.json").read_text())["texture"]["gutter"] == 3
    assert "normal" not in engine.read_textured(scans / "out.glb").layers


@pytest.mark.parametrize(
    ("arguments", "texture", "status", "text"),
    [
        (["cube.obj", "x.ply", "--texture"], {}, 2, "must end in one of .obj, .glb, .gltf"),
        (["cube.obj", "x.obj", "--texture", "7"], {}, 2, "whole number in [16, 16384], got '7'"),
        (["plain.ply", "x.obj", "--texture"], {}, 3, "neither an image nor colours"),
        (["cube.obj", "x.fbx"], {}, 2, "OUTPUT must end in"),
        (["strip.obj", "x.obj", "--tiles", "2"], {}, 2, "--tiles needs --texture"),
        (["strip.obj", "x.obj", "--keep-materials"], {}, 2, "--keep-materials needs --texture"),
        (["strip.obj", "x.obj", "--texture", "32", "--tiles", "0"], {}, 2, "must be a whole number in [1, 100]"),
        (["strip.obj", "x.obj", "--texture", "32", "--tiles", "many"], {}, 2, "must be a whole number in [1, 100]"),
        (["cube.obj", "x.obj", "--ao"], {}, 2, "--ao needs --texture"),
        (["cube.obj", "x.obj", "--texture", "--ao", "0"], {}, 2, "must be a finite length above 0, got '0'"),
        (["cube.obj", "x.ply", "--recipe", "r.json"], {}, 2, "with a texture OUTPUT must end in one of .obj"),
        (["cube.obj", "x.glb", "--recipe", "r.json"], {"occlusion": 1}, 2, "step 3: occlusion of texture must be true"),
        (["cube.obj", "x.glb", "--recipe", "r.json"], {"occlusion_distance": -1}, 2, "occlusion_distance must be"),
    ],
)  # fmt: skip
def test_wrong_use_is_named_in_a_line(scans, arguments, texture, status, text):
    recipe(scans, **texture)
    ran = called("simplify", *arguments, "--proxies", "6", cwd=scans)
    assert ran.returncode == status
    assert text in ran.stderr
    assert not any(scans.glob("x.*"))
