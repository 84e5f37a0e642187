"""`--preset`: the settings of the panel in one command, with the texture or the colours of the scan."""

import json

import numpy as np

import isimp_engine as engine
import meshfiles
import shapes
from commands import called, check_line, ran
from isimp_engine.recipe.presets import BY_NAME
from test_tileset import glb


def colored(path, vertices, triangles, colors):
    """A GLB file with COLOR_0."""
    document, body = meshfiles.of_glb(glb(vertices, triangles))
    data = colors.astype(np.uint8).tobytes()
    document["bufferViews"].append({"buffer": 0, "byteOffset": len(body), "byteLength": len(data)})
    color = {"bufferView": 2, "componentType": 5121, "count": len(colors), "type": "VEC4", "normalized": True}
    document["accessors"].append(color)
    document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = 2
    document["buffers"][0]["byteLength"] = len(body + data)
    path.write_bytes(meshfiles.glb(document, body + data))


def shares(path):
    """Shares of red and of blue pixels of the base colour."""
    (image,) = engine.read_textured(path).images
    pixels = image[..., :3].reshape(-1, 3).astype(int)
    return [(pixels[:, k] > 200).mean() for k in (0, 2)]


def test_a_generated_mesh_keeps_its_colours_and_then_its_texture(tmp_path):
    vertices, triangles = shapes.cube(12)
    colors = np.where(vertices[:, :1] < vertices[:, 0].mean(), [[255, 0, 0, 255]], [[0, 0, 255, 255]])
    scan, first, second = (tmp_path / name for name in ("scan.glb", "first.glb", "second.glb"))
    colored(scan, vertices, triangles, colors)
    for source, out in ((scan, first), (first, second)):
        done = ran("simplify", source, out, "--preset", "generated")
        assert "6 polygons of 6 regions" in done.stdout
        assert "texture:" in done.stdout
        assert min(shares(out)) > 0.25, "the rest is space between charts, and the seam of both"


def test_a_scan_without_a_texture_has_none_and_options_come_first(tmp_path):
    vertices, triangles = shapes.cube(12)
    scan, out, report = tmp_path / "scan.ply", tmp_path / "out.glb", tmp_path / "report.json"
    meshfiles.ply_binary(scan, vertices, triangles.tolist())
    done = ran("simplify", scan, out, "--preset", "generated", "--detail", "0.02", "--report", report)
    assert "texture:" not in done.stdout
    options = json.loads(report.read_text())["options"]
    assert options["detail"] == 0.02
    assert options["leave_out"] == BY_NAME["generated"].partition.leave_out
    recipe = tmp_path / "recipe.json"
    recipe.write_text(BY_NAME["generated"].recipe.to_json())
    check_line(called("simplify", scan, out, "--preset", "cad", "--recipe", recipe), 2, "exclude each other")


def test_a_machine_part_has_the_detail_of_its_noise():
    vertices, triangles = shapes.cube(24)
    preset = BY_NAME["cad"]
    noisy = vertices + np.random.default_rng(1).normal(0, 0.002, vertices.shape)
    for scan, detail in ((vertices, preset.partition.detail), (noisy, preset.scanned_detail)):
        made = engine.simplify((scan, triangles), preset="cad")
        assert (made.report["options"]["detail"], made.partition.region_count) == (detail, 6)
