"""Files of polygons, read back by libraries that no one here wrote where they are installed."""

import dataclasses
import json
import re
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest

import isimp_engine as engine
import meshfiles
import shapes
from bench.generators import houses
from isimp_engine import reading
from isimp_engine.cli import main
from isimp_engine.cli.lods import named
from isimp_engine.exporting import formats, require, surfaces, surfaces_of, validity

UTM = (450000.25, 5500000.5, 112.0)


def made(at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> engine.PolygonMesh:
    house = houses.make(0.0, 1, at=at)
    mesh = engine.Mesh(house.vertices, house.triangles)
    part = engine.partition_from(mesh, house.label.astype(np.int32))
    return engine.polygonize(mesh, part, engine.MeshingOptions(planar=True))


def box(size: float = 1.0, at: tuple[float, float, float] = (0.0, 0.0, 0.0), top: bool = True) -> engine.PolygonMesh:
    """A closed cube of six polygons, or one without its top."""
    vertices, triangles = shapes.cube()
    sides = triangles.reshape(6, -1, 3)[[4, 5, 2, 3, 0, 1] if top else [4, 5, 2, 3, 0]]  # by axis, the top last
    mesh = engine.Mesh(size * vertices + at, sides.reshape(-1, 3))
    return engine.polygonize(mesh, engine.partition_from(mesh, np.repeat(np.arange(len(sides), dtype=np.int32), 32)))


def rings(poly: engine.PolygonMesh) -> list[np.ndarray]:
    return [np.asarray(poly.vertices)[loop] for loop in np.split(poly.loops, poly.loop_start[1:])]


def same_rings(found: list[np.ndarray], poly: engine.PolygonMesh, within: float) -> None:
    """Each polygon of the file is one of ours, corner by corner."""
    ours = sorted((np.round(r, 3).tolist(), i) for i, r in enumerate(rings(poly)))
    theirs = sorted((np.round(r, 3).tolist(), i) for i, r in enumerate(found))
    assert [r for r, _ in ours] == [r for r, _ in theirs]
    for (_, i), (_, k) in zip(ours, theirs, strict=True):
        assert np.abs(rings(poly)[i] - found[k]).max() <= within


def test_walls_roofs_and_ground_are_distinguished() -> None:
    poly = box()
    found = surfaces_of(poly)
    names = ["WallSurface"] * 4 + ["GroundSurface", "RoofSurface"]
    assert found.kind == names
    assert found.solid
    assert found.volume == pytest.approx(1.0)
    lying = surfaces_of(poly, up=(1.0, 0.0, 0.0))
    assert lying.kind == ["GroundSurface", "RoofSurface"] + ["WallSurface"] * 4


def test_validity_distinguishes_open_from_closed_and_bent_from_planar(monkeypatch: pytest.MonkeyPatch) -> None:
    closed, opened = validity(box()), validity(box(top=False))
    assert (closed["closed"], closed["solid"], closed["components"], closed["non_planar"]) == (True, True, 1, 0)
    assert (opened["closed"], opened["solid"]) == (False, False)
    assert opened["surfaces"] == {"WallSurface": 4, "RoofSurface": 0, "GroundSurface": 1, "OuterCeilingSurface": 0}
    monkeypatch.setattr(surfaces, "PLANAR", -1.0)
    assert validity(made())["non_planar"] == len(made().loop_start)


def cityjson_rings(city: dict) -> list[np.ndarray]:
    (building,) = city["CityObjects"].values()
    (geometry,) = building["geometry"]
    faces = geometry["boundaries"][0] if geometry["type"] == "Solid" else geometry["boundaries"]
    at = np.array(city["vertices"]) * city["transform"]["scale"] + city["transform"]["translate"]
    return [at[face[0]] for face in faces]


def zones_of(path: Path) -> Iterator[tuple[np.ndarray, tuple[str, str]]]:
    """The corners, the class and the boundary condition of each surface of an energy model."""
    if path.suffix == ".hbjson":
        for room in json.loads(path.read_text())["rooms"]:
            for face in room["faces"]:
                kind = face["face_type"].removesuffix("Ceiling")
                yield np.array(face["geometry"]["boundary"]), (kind, face["boundary_condition"]["type"])
        return
    for item in re.sub("!.*", "", path.read_text()).split(";"):
        kind, *fields = (field.strip() for field in item.split(","))
        if kind == "BuildingSurface:Detailed":
            yield np.array(fields[11:], float).reshape(int(fields[10]), 3), (fields[1], fields[5])


@pytest.mark.parametrize("kind", [".idf", ".hbjson"])
@pytest.mark.parametrize("inwards", [False, True])
def test_surfaces_of_an_energy_model_are_convex_and_face_out_of_their_zone(
    tmp_path: Path, kind: str, inwards: bool
) -> None:
    house = houses.make(0.0, 1, turn=0.0, at=UTM)
    mesh = engine.Mesh(house.vertices, house.triangles[:, ::-1] if inwards else house.triangles)
    poly = engine.polygonize(mesh, engine.partition_from(mesh, house.label.astype(np.int32)))
    engine.write(path := tmp_path / f"house{kind}", poly)
    found = list(zones_of(path))
    low, volume = min(ring[:, 2].min() for ring, _ in found), 0.0
    for ring, told in found:
        along = np.roll(ring, -1, axis=0) - ring
        area = np.cross(ring - ring[0], np.roll(ring, -1, axis=0) - ring[0]).sum(axis=0) / 2
        volume += float(ring[0] @ area) / 3
        assert (np.cross(np.roll(along, 1, axis=0), along) @ area >= 0).all()
        rise = area[2] / np.linalg.norm(area)
        beyond = "Ground" if rise < -0.9 and ring[:, 2].max() < low + 0.1 else "Outdoors"
        assert told == ("Floor" if rise < -0.9 else "Roof" if rise > 0.2 else "Wall", beyond)
    a, b, c = (house.vertices[house.triangles[:, k]] - UTM for k in range(3))
    assert volume == pytest.approx(np.einsum("ij,ij->", a, np.cross(b, c)) / 6, rel=1e-3)
    assert len(found) > len(poly.faces())  # concave walls became triangles


@pytest.mark.parametrize("version", ["2.0", "1.1"])
def test_cityjson_keeps_polygons_classes_and_place(tmp_path: Path, version: str) -> None:
    poly = made(UTM)
    path = tmp_path / "house.city.json"
    engine.write(path, poly, crs=25832, version=version)
    city = json.loads(path.read_text())
    same_rings(cityjson_rings(city), poly, within=1e-8)
    assert city["version"] == version
    assert city["metadata"]["referenceSystem"].endswith("EPSG/0/25832")
    (geometry,) = city["CityObjects"]["house"]["geometry"]
    kinds = [s["type"] for s in geometry["semantics"]["surfaces"]]
    values = geometry["semantics"]["values"]
    values = values[0] if geometry["type"] == "Solid" else values
    assert [kinds[v] for v in values] == surfaces_of(poly).kind
    assert all(isinstance(x, int) for vertex in city["vertices"] for x in vertex)


def test_cityjson_of_a_closed_box_is_a_solid(tmp_path: Path) -> None:
    for top, kind in ((True, "Solid"), (False, "MultiSurface")):
        engine.write(tmp_path / "box.city.json", box(top=top))
        (geometry,) = json.loads((tmp_path / "box.city.json").read_text())["CityObjects"]["box"]["geometry"]
        assert geometry["type"] == kind


def test_cjio_reads_cityjson(tmp_path: Path) -> None:
    cityjson = pytest.importorskip("cjio.cityjson", reason="cjio is not installed")
    path, poly = tmp_path / "box.city.json", box(10.0, UTM)
    engine.write(path, poly, crs=25832)
    with path.open() as file:
        city = cityjson.reader(file)
    city.check_version()  # raises for an unknown version
    assert city.get_version() == "2.0"
    assert city.get_epsg() == 25832
    assert city.number_city_objects_level1() == 1
    city.decompress()
    (building,) = city.j["CityObjects"].values()
    at = np.array(city.j["vertices"])
    same_rings([at[face[0]] for face in building["geometry"][0]["boundaries"][0]], poly, within=1e-8)


def test_ezdxf_reads_dxf(tmp_path: Path) -> None:
    ezdxf = pytest.importorskip("ezdxf", reason="ezdxf is not installed")
    path, poly = tmp_path / "house.dxf", made(UTM)
    engine.write(path, poly)
    drawing = ezdxf.readfile(path)
    assert not drawing.audit().has_errors
    kinds, found = surfaces_of(poly).kind, []
    for mesh in drawing.modelspace().query("MESH"):
        at = np.array(mesh.vertices)
        faces = [at[list(face)] for face in mesh.faces]
        assert len(faces) == kinds.count(mesh.dxf.layer)
        found += faces
    same_rings(found, poly, within=1e-9)


@pytest.mark.parametrize("crs", [None, 25832])
def test_ifcopenshell_reads_ifc(tmp_path: Path, crs: int | None) -> None:
    ifcopenshell = pytest.importorskip("ifcopenshell", reason="ifcopenshell is not installed")
    path, poly = tmp_path / "house.ifc", made(UTM)
    engine.write(path, poly, crs=crs)
    file = ifcopenshell.open(str(path))
    (site,) = file.by_type("IfcSite")
    shift = np.array(site.ObjectPlacement.RelativePlacement.Location.Coordinates)
    if crs is not None:
        (conversion,) = file.by_type("IfcMapConversion")
        assert conversion.TargetCRS.Name == "EPSG:25832"
        assert not shift.any()
        shift = np.array([conversion.Eastings, conversion.Northings, conversion.OrthogonalHeight])
    found, elements = [], file.by_type("IfcWall") + file.by_type("IfcRoof") + file.by_type("IfcSlab")
    (storey,) = file.by_type("IfcBuildingStorey")
    assert {element.ContainedInStructure[0].RelatingStructure for element in elements} == {storey}
    for element in elements:
        (shape,) = element.Representation.Representations[0].Items
        assert shape.is_a("IfcPolygonalFaceSet")
        at = np.array(shape.Coordinates.CoordList) + shift
        found += [at[np.array(face.CoordIndex) - 1] for face in shape.Faces]
    assert {e.is_a() for e in elements} >= {"IfcWall", "IfcRoof"}
    same_rings(found, poly, within=1e-8)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # it leaves its file of rules open
@pytest.mark.parametrize("crs", [None, 25832])
def test_ifc_keeps_the_rules_of_its_schema(tmp_path: Path, crs: int | None) -> None:
    validate = pytest.importorskip("ifcopenshell.validate", reason="ifcopenshell is not installed")
    engine.write(tmp_path / "a.ifc", box(10.0, UTM), crs=crs)
    log = validate.json_logger()
    validate.validate(str(tmp_path / "a.ifc"), log, express_rules=True)
    assert log.statements == []


@pytest.mark.parametrize("seed", range(2, 8))
def test_ifc_and_dxf_of_scans_have_no_error(tmp_path: Path, seed: int) -> None:
    validate = pytest.importorskip("ifcopenshell.validate", reason="ifcopenshell is not installed")
    recover = pytest.importorskip("ezdxf.recover", reason="ezdxf is not installed")
    house = houses.make(0.002 * (seed % 3), seed, at=UTM if seed % 2 else (0.0, 0.0, 0.0))
    scan = engine.clean(house.vertices, house.triangles)
    for detail in (0.02, 0.002):
        part = engine.partition(scan, engine.PartitionOptions(detail=detail))
        poly = engine.polygonize(scan, part, engine.MeshingOptions(planar=seed < 5))
        for name in ("a.ifc", "a.dxf"):
            engine.write(tmp_path / name, poly)
        log = validate.json_logger()
        validate.validate(str(tmp_path / "a.ifc"), log)
        assert log.statements == []
        drawing, audit = recover.readfile(tmp_path / "a.dxf")
        assert (drawing.units, drawing.dxfversion) == (6, "AC1015")
        assert (audit.errors, audit.fixes) == ([], [])


def test_names_and_areas_of_ifc_are_those_of_the_model(tmp_path: Path) -> None:
    ifcopenshell = pytest.importorskip("ifcopenshell", reason="ifcopenshell is not installed")
    geom = pytest.importorskip("ifcopenshell.geom")
    poly, name = made(), "H\u00e4u's \\ \u6f22 \U0001f3e0"
    path = tmp_path / f"{name}.ifc"
    engine.write(path, poly)
    file = ifcopenshell.open(str(path))
    assert [file.by_type(kind)[0].Name for kind in ("IfcProject", "IfcSite", "IfcBuilding")] == [name] * 3
    total = 0.0
    for element in file.by_type("IfcElement"):
        shape = geom.create_shape(geom.settings(), element).geometry
        total += faces_area(np.array(shape.verts).reshape(-1, 3), np.array(shape.faces).reshape(-1, 3))
    assert total == pytest.approx(area(poly), rel=1e-9)


@pytest.mark.parametrize("name", ["house.ifc", "house.dxf"])
def test_equal_models_are_equal_files(tmp_path: Path, name: str) -> None:
    def text(poly: engine.PolygonMesh) -> str:
        engine.write(tmp_path / name, poly)
        return (tmp_path / name).read_text()

    first, other = text(made()), text(made(UTM))
    assert text(made()) == first
    numbers, others = (set(re.findall(r"\('([\w$]{22})',\$", found)) for found in (first, other))
    assert len(numbers) == (12 if name == "house.ifc" else 0)
    assert not numbers & others


def test_a_row_is_all_that_a_format_needs(tmp_path: Path, monkeypatch) -> None:
    def count(draft: Path, of: formats.Content) -> dict:
        draft.write_text(f"{of.name} {len(of.polygons.loop_start)} {of.surfaces.solid}")
        return {"lines": 1}

    row = formats.Format(".count", count, "json", "json", "count")
    monkeypatch.setattr(formats, "FORMATS", (*formats.FORMATS, row))
    assert formats.kind_of("a.COUNT") == ".count"
    assert engine.exporting.write(tmp_path / "box.count", box()) == {"lines": 1}
    assert (tmp_path / "box.count").read_text() == "box 6 True"
    monkeypatch.setattr(formats, "FORMATS", (dataclasses.replace(row, package="no_such_package"),))
    with pytest.raises(engine.FileError, match=r"pip install 'isimp\[count\]'"):
        engine.exporting.write(tmp_path / "box.count", box())


def test_a_missing_package_is_named_before_the_work(tmp_path: Path, monkeypatch, capsys) -> None:
    scan = tmp_path / "scan.obj"
    scan.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    monkeypatch.setitem(sys.modules, "OCP", None)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(engine.FileError, match=r"cadquery-ocp-novtk is needed: pip install 'isimp\[step\]'"):
        require("a.step")
    assert main(["simplify", str(scan), str(tmp_path / "out.step"), "--quiet"]) == 2
    assert "cadquery-ocp-novtk" in capsys.readouterr().err
    assert not (tmp_path / "out.step").exists()


def test_nothing_is_left_where_the_place_is_missing(tmp_path: Path) -> None:
    with pytest.raises(engine.FileError, match="can't be written"):
        engine.write(tmp_path / "no" / "a.city.json", box())
    assert list(tmp_path.iterdir()) == []


def test_levels_of_detail_keep_the_kind_of_file() -> None:
    assert named(Path("a/house.city.json"), 1) == Path("a/house_LOD1.city.json")
    assert named(Path("a/house.v2.obj"), 0) == Path("a/house.v2_LOD0.obj")


def test_the_command_writes_cityjson_and_reports_whether_it_is_valid(tmp_path: Path, capsys) -> None:
    house = houses.make(0.002, 3)
    scan, out, report = tmp_path / "scan.obj", tmp_path / "out.city.json", tmp_path / "report.json"
    meshfiles.obj(scan, house.vertices, house.triangles)
    command = ["simplify", str(scan), str(out), "--proxies", "110", "--planar", "--crs", "25832"]
    assert main([*command, "--report", str(report)]) == 0
    assert "walls" in capsys.readouterr().out
    found = json.loads(report.read_text())["validity"]
    assert (found["non_planar"], found["planarity_limit"]) == (0, 0.01)
    city = json.loads(out.read_text())
    assert len(cityjson_rings(city)) == sum(found["surfaces"].values())
    assert list(city["CityObjects"]) == ["out"]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["out.city.json", "report.json", "scan.obj"]


@pytest.mark.parametrize("kind", engine.exporting.BUILDING_KINDS)
def test_files_of_buildings_are_in_metres(tmp_path: Path, kind: str) -> None:
    metres, millimetres = tmp_path / "m", tmp_path / "mm"
    for folder, poly, unit in ((metres, box(4.0), "m"), (millimetres, box(4000.0), "mm")):
        folder.mkdir()
        engine.write(folder / f"box{kind}", poly, unit=unit, surfaces=surfaces_of(poly))
    assert (millimetres / f"box{kind}").read_text() == (metres / f"box{kind}").read_text()


@pytest.mark.parametrize("flat", [False, True])
def test_the_command_converts_a_building_in_millimetres(tmp_path: Path, flat: bool, capsys) -> None:
    vertices, triangles = shapes.cube(4)
    scan, out, report = tmp_path / "scan.obj", tmp_path / "out.city.json", tmp_path / "report.json"
    meshfiles.obj(scan, 4000 * vertices, triangles)
    command = ["simplify", str(scan), str(out), "--unit", "mm", "--report", str(report)]
    assert main([*command, *(["--flat"] if flat else ["--proxies", "6"])]) == 0
    assert np.ptp(cityjson_rings(json.loads(out.read_text())), axis=(0, 1)) == pytest.approx([4, 4, 4])
    assert json.loads(report.read_text())["validity"]["planarity_limit"] == pytest.approx(10)
    capsys.readouterr()


def area(poly: engine.PolygonMesh) -> float:
    return faces_area(np.asarray(poly.vertices), poly.triangles())


def faces_area(vertices: np.ndarray, triangles: np.ndarray) -> float:
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


@pytest.mark.parametrize("at", [(0.0, 0.0, 0.0), UTM])
def test_stl_and_glb_are_read_again(tmp_path: Path, at: tuple[float, float, float]) -> None:
    poly = made(at)
    low, high = poly.vertices.min(axis=0), poly.vertices.max(axis=0)
    for name in ("house.stl", "house.glb"):
        engine.write(tmp_path / name, poly)
        soup = engine.read_textured(tmp_path / name) if name.endswith("glb") else None
        vertices, triangles = (soup.vertices, soup.triangles) if soup else engine.read(tmp_path / name)
        mesh = engine.clean(vertices, triangles)
        assert mesh.report["closed"] == poly.report["closed"], name
        assert faces_area(vertices, triangles) == pytest.approx(area(poly), rel=1e-6)
        np.testing.assert_allclose([vertices.min(axis=0), vertices.max(axis=0)], [low, high], atol=1e-5)
    assert (tmp_path / "house.stl").read_bytes().startswith(b"solid" if at == UTM else b"isimp")
    again = engine.read_textured(tmp_path / "house.glb")
    assert again.polygon.max() + 1 >= len(poly.loop_start)
    assert not again.images


def test_glb_without_a_texture_is_flat_shaded_polygons(tmp_path: Path) -> None:
    poly = box()
    engine.write(tmp_path / "box.glb", poly)
    document, _ = meshfiles.of_glb((tmp_path / "box.glb").read_bytes())
    assert document.keys().isdisjoint({"materials", "textures", "samplers", "images"})
    (primitive,) = document["meshes"][0]["primitives"]
    assert primitive.keys() == {"attributes", "indices", "extensions"}
    assert primitive["attributes"].keys() == {"POSITION", "NORMAL"}
    rows = {accessor["type"]: accessor["count"] for accessor in document["accessors"]}
    assert rows == {"VEC3": 24, "SCALAR": 36}
    soup = engine.read_textured(tmp_path / "box.glb")
    assert sorted(np.bincount(soup.polygon)) == [2] * 6


@pytest.mark.parametrize("top", [True, False])
def test_3mf_has_the_triangles_and_the_unit(tmp_path: Path, top: bool) -> None:
    poly = box(2.0, at=UTM, top=top)
    engine.write(tmp_path / "box.3mf", poly, unit="mm")
    first = (tmp_path / "box.3mf").read_bytes()
    with zipfile.ZipFile(tmp_path / "box.3mf") as file:
        assert file.testzip() is None
        assert sorted(file.namelist()) == ["3D/3dmodel.model", "[Content_Types].xml", "_rels/.rels"]
        for name in file.namelist():
            ET.fromstring(file.read(name))  # noqa: S314
        model = ET.fromstring(file.read("3D/3dmodel.model"))  # noqa: S314
    core = {"": "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"}
    assert model.get("unit") == "millimeter"
    assert [thing.get("type") for thing in model.findall(".//object", core)] == ["model" if top else "surface"]
    vertices = [[float(v.get(k, "")) for k in "xyz"] for v in model.findall(".//vertex", core)]
    assert vertices == poly.vertices.tolist()
    triangles = np.array([[int(t.get(f"v{k}", "")) for k in (1, 2, 3)] for t in model.findall(".//triangle", core)])
    assert faces_area(np.array(vertices), triangles) == pytest.approx(4 * (6 if top else 5))
    engine.write(tmp_path / "box.3mf", poly, unit="mm")
    assert (tmp_path / "box.3mf").read_bytes() == first


def test_trimesh_reads_stl_gltf_and_3mf(tmp_path: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("lxml")
    pytest.importorskip("networkx")
    poly = box()
    for name in ("box.stl", "box.glb", "box.gltf", "box.3mf"):
        engine.write(tmp_path / name, poly)
        assert trimesh.load(tmp_path / name, force="mesh").volume == pytest.approx(1)


@pytest.mark.parametrize("top", [True, False])
def test_3mf_is_read_again(tmp_path: Path, top: bool) -> None:
    poly = box(2.0, at=UTM, top=top)
    engine.write(tmp_path / "box.3mf", poly)
    vertices, triangles = engine.read(tmp_path / "box.3mf")
    assert np.array_equal(vertices, poly.vertices)
    assert np.array_equal(triangles, poly.triangles())
    result = engine.simplify(tmp_path / "box.3mf", proxies=6 if top else 5)
    assert len(result.polygons.loop_start) == (6 if top else 5)
    (tmp_path / "cut.3mf").write_bytes((tmp_path / "box.3mf").read_bytes()[:-40])
    with pytest.raises(engine.FileError, match=r"cut\.3mf: is damaged, or not 3MF"):
        engine.read(tmp_path / "cut.3mf")


MODEL = """<model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
 xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06"><resources>{}</resources>
 <build>{}</build></model>"""
RELATIONS = """<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship
 Target="/3D/a.model" Id="r" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>"""
TRIANGLE = """<object id="1"><mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/>
 <vertex x="0" y="1" z="0"/></vertices><triangles><triangle v1="0" v2="1" v3="{}"/></triangles></mesh></object>"""


def packed(path: Path, **models: str) -> Path:
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("_rels/.rels", RELATIONS)
        for name, text in models.items():
            file.writestr(f"3D/{name}.model", text)
    return path


def test_3mf_of_components_in_other_files_is_read_at_its_places(tmp_path: Path) -> None:
    a = MODEL.format(
        '<object id="2"><components><component p:path="/3D/b.model" objectid="1" transform="2 0 0 0 2 0 0 0 2 5 0 0"/>'
        '<component p:path="/3D/b.model" objectid="1" transform="-1 0 0 0 1 0 0 0 1 0 0 0"/></components></object>'
        '<object id="3" type="support"><components><component objectid="2"/></components></object>',
        '<item objectid="2" transform="1 0 0 0 1 0 0 0 1 0 0 7"/><item objectid="3"/>',
    )
    path = packed(tmp_path / "a.3mf", a=a, b=MODEL.format(TRIANGLE.format(2), ""))
    vertices, triangles = engine.read(path)
    assert vertices.tolist() == [[5, 0, 7], [7, 0, 7], [5, 2, 7], [0, 0, 7], [-1, 0, 7], [0, 1, 7]]
    corners = vertices[triangles]
    up = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]
    assert up.tolist() == [4, 1], "a mirrored part still faces up"


@pytest.mark.parametrize(
    ("resources", "build", "text"),
    [
        (TRIANGLE.format(3), '<item objectid="1"/>', "a triangle of object 1 uses a vertex that it does not have"),
        ("", '<item objectid="1"/>', "there is no object '1'"),
        (
            '<object id="1"><components><component objectid="1"/></components></object>',
            '<item objectid="1"/>',
            "object 1 is a part of itself",
        ),
    ],
)
def test_3mf_that_contradicts_itself_is_refused(tmp_path: Path, resources: str, build: str, text: str) -> None:
    with pytest.raises(engine.FileError, match=text):
        engine.read(packed(tmp_path / "a.3mf", a=MODEL.format(resources, build)))


@pytest.mark.parametrize("leaf", [TRIANGLE.format(2), '<object id="1"/>'])
def test_3mf_of_parts_without_number_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, leaf: str) -> None:
    monkeypatch.setattr(reading, "_ANY", 1 << 20)
    twice = [
        f'<object id="{n}"><components>{2 * f"""<component objectid="{n - 1}"/>"""}</components></object>'
        for n in range(2, 42)
    ]
    a = MODEL.format(leaf + "".join(twice), '<item objectid="41"/>')
    with pytest.raises(engine.FileError, match=r"a\.3mf: its parts become more than 4,194,304 bytes"):
        engine.read(packed(tmp_path / "a.3mf", a=a))
    few = MODEL.format(leaf + "".join(twice[:8]), '<item objectid="9"/>')
    assert len(engine.read(packed(tmp_path / "a.3mf", a=few))[1]) == 256 * leaf.count("<triangle ")


def test_points_are_no_scan(tmp_path: Path, capsys) -> None:
    (tmp_path / "a.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
        "0 0 0\n1 0 0\n"
    )
    wanted = {"a.ply": "has 2 points and no faces; make a mesh of them first"}
    wanted |= {f"a.{kind}": "has points, not faces; make a mesh" for kind in ("las", "laz", "e57", "xyz", "pts", "pcd")}
    for name, text in wanted.items():
        assert main(["info", str(tmp_path / name)]) == 3
        error = capsys.readouterr().err
        assert text in error
        assert error.endswith("(docs/points.md)\n")
        assert error.count("\n") == 1
    assert main(["info", str(tmp_path / "a.fbx")]) == 3
    assert 'the extension ".fbx" is not known; it can be .obj, .ply, .glb' in capsys.readouterr().err
