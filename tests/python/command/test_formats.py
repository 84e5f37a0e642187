"""Every kind of file that is read, with every kind that is written: areas, polygons, names, colours and materials."""

import json
from pathlib import Path

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
from isimp_engine import exporting
from isimp_engine.cli import main
from isimp_engine.reading import KINDS
from test_exporting import cityjson_rings, zones_of

SIZES = np.array([1.0, 2.0, 3.0])
AREAS = [6.0, 6.0, 3.0, 3.0, 2.0, 2.0]  # sides towards -x, x, -y, y, -z and z
COLORS = np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 0], [0, 255, 255], [255, 0, 255]], np.uint8)
NAME = "Häuser 1"
OF_TRIANGLES = (".glb", ".gltf", ".stl", ".3mf")


def side_of(areas: np.ndarray) -> np.ndarray:
    """The sides, as in AREAS, of faces with these vector areas."""
    axis = np.abs(areas).argmax(axis=1)
    return 2 * axis + (np.take_along_axis(areas, axis[:, None], axis=1)[:, 0] > 0)


def vector_areas(rings: list[np.ndarray]) -> np.ndarray:
    around = (np.cross(ring - ring[0], np.roll(ring, -1, axis=0) - ring[0]).sum(axis=0) for ring in rings)
    return np.array(list(around)) / 2


@pytest.fixture(scope="module")
def scans(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A box as a file of each kind, with a colour for each side where the kind has colours."""
    folder = tmp_path_factory.mktemp("scans")
    vertices, triangles = shapes.cube(3)
    corners = (vertices * SIZES)[triangles]
    side = side_of(vector_areas(list(corners)))
    places, each = corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3)
    columns = dict(zip("xyz", places.T.astype(np.float32), strict=True))
    columns |= dict(zip(("red", "green", "blue"), np.repeat(COLORS[side], 3, axis=0).T, strict=True))
    meshfiles.ply_columns(folder / f"{NAME}.ply", columns, [(t,) for t in each])
    meshfiles.off(folder / f"{NAME}.off", vertices * SIZES, triangles)
    lines = [f"mtllib {NAME}.mtl", *(f"v {x} {y} {z}" for x, y, z in places), "vt 0.5 0.5"]
    for triangle, number in zip(each.tolist(), side.tolist(), strict=True):
        lines += [f"usemtl side{number}", "f " + " ".join(f"{v + 1}/1" for v in triangle)]
    (folder / f"{NAME}.obj").write_text("\n".join(lines) + "\n", encoding="utf-8")
    colors = (f"newmtl side{k}\nKd {r / 255} {g / 255} {b / 255}\n" for k, (r, g, b) in enumerate(COLORS))
    (folder / f"{NAME}.mtl").write_text("".join(colors))
    result = engine.simplify(folder / f"{NAME}.obj", proxies=6, texture=32, materials=True)
    for kind in (".glb", ".gltf"):
        result.write(folder / f"{NAME}{kind}")
    for kind in (".stl", ".3mf"):
        engine.write(folder / f"{NAME}{kind}", result.polygons)
    assert {path.suffix for path in folder.iterdir()} == {*KINDS, ".mtl", ".png"}
    return folder


def rings_of(path: Path) -> list[np.ndarray]:
    """The faces of a file."""
    if path.suffix in KINDS:
        vertices, loops, start = engine.reading.read_polygons(path)
        return np.split(vertices[loops], start[1:])
    if path.suffix == ".json":
        return cityjson_rings(json.loads(path.read_text()))
    if path.suffix in (".idf", ".hbjson"):
        return [ring for ring, _ in zones_of(path)]
    if path.suffix == ".dxf":
        ezdxf = pytest.importorskip("ezdxf")
        meshes = ezdxf.readfile(path).modelspace().query("MESH")
        return [np.array(mesh.vertices)[list(face)] for mesh in meshes for face in mesh.faces]
    ifcopenshell = pytest.importorskip("ifcopenshell")
    sets = ifcopenshell.open(str(path)).by_type("IfcPolygonalFaceSet")
    return [np.array(of.Coordinates.CoordList)[np.array(f.CoordIndex) - 1] for of in sets for f in of.Faces]


def name_in(path: Path) -> str | None:
    """The name of the model in its file; None where the kind has none."""
    if path.suffix == ".gltf":
        return json.loads(path.read_text())["nodes"][0]["name"]
    if path.suffix == ".glb":
        return meshfiles.of_glb(path.read_bytes())[0]["nodes"][0]["name"]
    if path.suffix == ".json":
        return next(iter(json.loads(path.read_text())["CityObjects"]))
    if path.suffix == ".hbjson":
        return json.loads(path.read_text())["display_name"]
    if path.suffix == ".ifc":
        return pytest.importorskip("ifcopenshell").open(str(path)).by_type("IfcBuilding")[0].Name
    return None


@pytest.mark.parametrize(
    ("kind", "output"),
    [*((kind, ".obj") for kind in KINDS), *((".obj", output) for output in exporting.PLAIN if output != ".obj")],
)
def test_every_kind_is_read_and_written(scans: Path, tmp_path: Path, kind: str, output: str) -> None:
    exporting_step = output in exporting.STEP_KINDS
    if exporting_step:
        pytest.importorskip("OCP", reason="cadquery-ocp-novtk is not installed")
    path = tmp_path / f"{NAME}{output}"
    engine.simplify(scans / f"{NAME}{kind}", proxies=6).write(path)
    if exporting_step:
        from test_step import Read

        assert Read(path).volume == pytest.approx(6, abs=1e-5)
        return
    areas = vector_areas(rings_of(path))
    assert len(areas) == (12 if output in OF_TRIANGLES else 6)
    sums = np.bincount(side_of(areas), np.linalg.norm(areas, axis=1), minlength=6)
    np.testing.assert_allclose(sums, AREAS, atol=1e-5)
    assert name_in(path) in (None, NAME)


@pytest.mark.parametrize("output", exporting.TEXTURED)
@pytest.mark.parametrize("kind", [".obj", ".ply", ".glb", ".gltf"])
def test_colours_and_materials_stay(scans: Path, tmp_path: Path, kind: str, output: str) -> None:
    named = kind != ".ply"
    path = tmp_path / f"made{output}"
    engine.simplify(scans / f"{NAME}{kind}", proxies=6, texture=32, materials=named).write(path)
    soup = engine.read_textured(path)
    side = side_of(vector_areas(list(soup.vertices[soup.triangles])))
    material = np.zeros(len(side), int) if soup.material is None else soup.material
    for triangle, number in enumerate(side):
        image = soup.images[material[triangle]]
        u, v = soup.uv[triangle].mean(axis=0)
        shown = image[int((1 - v) * image.shape[0]), int(u * image.shape[1]), :3]
        assert np.abs(shown.astype(int) - COLORS[number]).max() <= 1
        if named:
            assert soup.names[material[triangle]].endswith(f"side{number}")


@pytest.mark.parametrize("output", ["obj", "glb", "city.json"])
def test_a_batch_reads_all_kinds_and_writes_them(scans: Path, tmp_path: Path, output: str) -> None:
    assert main(["batch", str(scans), str(tmp_path / "out"), "--proxies", "6", "--format", output, "--quiet"]) == 0
    made = [path for path in (tmp_path / "out").iterdir() if path.name.endswith(output)]
    assert {path.name for path in made} == {f"{NAME}{kind}.{output}" for kind in KINDS}


@pytest.mark.parametrize("kind", KINDS)
def test_a_single_tile_may_be_of_every_kind(scans: Path, tmp_path: Path, kind: str) -> None:
    assert main(["tiles", str(scans / f"{NAME}{kind}"), str(tmp_path / "a.ply"), "--proxies", "6", "--quiet"]) == 0
    areas = vector_areas(rings_of(tmp_path / "a.ply"))
    np.testing.assert_allclose(np.bincount(side_of(areas), np.linalg.norm(areas, axis=1)), AREAS, atol=1e-5)


def test_other_kinds_get_the_list_of_what_there_is(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    box = engine.simplify(shapes.cube(2), proxies=6).polygons
    with pytest.raises(engine.FileError, match=", ".join(exporting.PLAIN)):
        engine.write(tmp_path / "a.fbx", box)
    for read in (engine.read, engine.read_textured, engine.simplify):
        with pytest.raises(engine.FileError, match=", ".join(KINDS)):
            read(tmp_path / "a.fbx")
    scan = str(tmp_path / "a.ply")
    engine.write(scan, box)
    for command, kinds in (
        (["simplify", scan, "a.fbx"], exporting.PLAIN),
        (["simplify", scan, "a.stl", "--texture"], exporting.TEXTURED),
        (["batch", scan, str(tmp_path / "out"), "--format", "fbx"], [kind[1:] for kind in exporting.PLAIN]),
        (["tiles", scan, "a.fbx"], exporting.TILES),
    ):
        assert main(command) == 2
        assert ", ".join(kinds) in capsys.readouterr().err
    (tmp_path / "a.fbx").write_bytes(b"\0")
    for command in (["info", str(tmp_path / "a.fbx")], ["batch", str(tmp_path / "a.fbx"), str(tmp_path / "out")]):
        assert main(command) in (2, 3)
        assert ", ".join(KINDS) in capsys.readouterr().err
