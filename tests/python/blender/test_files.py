"""Scans in and models out: exact import with map coordinates, buildings, reports."""

import csv
import json
import re
import sys
import types
import zipfile
from importlib import util

import bpy
import numpy as np
import pytest
import scans

from isimp import handover
from isimp.blender import menus
from isimp.blender.operators import files
from isimp.blender.scene import places, store, targets
from isimp.engine import engine

FAR = np.array([4_600_123.25, 530_456.5, 120.0])
OPS = bpy.ops.isimp


@pytest.fixture
def file(tmp_path):
    """A cube of 2 m in map coordinates, as OFF with all digits."""
    scan = scans.cube(cells=4)
    vertices = scans.coordinates(scan.data).astype(np.float64) + FAR
    faces = [list(polygon.vertices) for polygon in scan.data.polygons]
    lines = ["OFF", f"{len(vertices)} {len(faces)} 0"]
    lines += [" ".join(map(repr, v)) for v in vertices.tolist()]
    lines += [" ".join(map(str, [len(face), *face])) for face in faces]
    path = tmp_path / "tower.off"
    path.write_text("\n".join(lines) + "\n")
    bpy.data.objects.remove(scan)
    return path


def imported(file, **more):
    assert OPS.import_scan(filepath=str(file), **more) == {"FINISHED"}
    return bpy.context.object


def test_map_coordinates_are_kept_to_the_last_digit(file):
    scan = imported(file, epsg=25832)
    assert scan.name == "tower"
    assert scan.select_get()
    assert places.epsg(scan) == 25832
    wanted, _ = engine.read(file)
    found = scans.coordinates(scan.data).astype(np.float64) + places.origin(scan)
    assert np.array_equal(found, wanted)
    assert np.abs(scans.coordinates(scan.data)).max() < 10


def test_a_scan_near_zero_has_no_place(tmp_path):
    (tmp_path / "tri.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    scan = imported(tmp_path / "tri.off", up="Y")
    assert places.ORIGIN not in scan
    assert not places.origin(scan).any()
    assert np.array(scan.matrix_world)[:3, :3] @ (0, 1, 0) == pytest.approx((0, 0, 1), abs=1e-6)


def test_several_files_come_at_once_and_a_bad_one_is_named(tmp_path, file):
    (tmp_path / "bad.off").write_text("OFF\n3 1 0\n0 0 0\n")
    names = [{"name": file.name}, {"name": "bad.off"}]
    with pytest.raises(RuntimeError, match=r"bad\.off"):
        OPS.import_scan(directory=str(tmp_path), files=names)
    assert "tower" in bpy.data.objects
    assert "bad" not in bpy.data.objects


def test_a_damaged_place_counts_as_none():
    scan = scans.cube()
    for value in ("here", [1.0, 2.0], [float("nan")] * 3, 7):
        scan[places.ORIGIN] = value
        assert not places.origin(scan).any()
    scan[places.EPSG] = "EPSG"
    assert places.epsg(scan) == 0


def meshed(file):
    scan = imported(file, epsg=25832)
    OPS.partition(proxies=6)
    OPS.mesh()
    return scan


def test_3mf_is_imported(file, tmp_path):
    scan = meshed(file)
    result = bpy.context.object
    vertices = scans.coordinates(result.data)
    path = tmp_path / "tower.3mf"
    part = engine.simplify((vertices, [tuple(p.vertices) for p in result.data.polygons]), proxies=6)
    part.write(path)
    bpy.data.objects.remove(scan)
    again = imported(path)
    assert len(again.data.polygons) == 12
    np.testing.assert_allclose(np.ptp(scans.coordinates(again.data), axis=0), [2, 2, 2], atol=1e-5)


def test_a_building_is_written_where_it_stands(file, tmp_path):
    meshed(file)
    path = tmp_path / "tower.city.json"
    assert OPS.export_building(filepath=str(path), epsg=25832) == {"FINISHED"}
    city = json.loads(path.read_text())
    assert city["metadata"]["referenceSystem"].endswith("/25832")
    extent = np.array(city["metadata"]["geographicalExtent"])
    assert extent == pytest.approx(np.concatenate([FAR - 1, FAR + 1]), abs=1e-6)
    (building,) = city["CityObjects"].values()
    assert building["geometry"][0]["type"] == "Solid"
    kinds = building["geometry"][0]["semantics"]["surfaces"]
    assert {kind["type"] for kind in kinds} == {"WallSurface", "RoofSurface", "GroundSurface"}


def test_a_moved_and_mirrored_result_is_written_as_it_is_seen(file, tmp_path):
    scan = meshed(file)
    result = targets.result_of(bpy.context.scene, scan)
    result.scale, result.location = (-1, 1, 2), (5, 0, 0)
    bpy.context.view_layer.update()
    path = tmp_path / "tower.city.json"
    OPS.export_building(filepath=str(path))
    city = json.loads(path.read_text())
    assert np.ptp(np.array(city["metadata"]["geographicalExtent"]).reshape(2, 3), axis=0) == pytest.approx((2, 2, 4))
    assert next(iter(city["CityObjects"].values()))["geometry"][0]["type"] == "Solid", "it faces outwards"


def test_a_script_gets_the_scan_s_epsg_and_the_chosen_format(file, tmp_path):
    scan = meshed(file)
    scan["isimp_epsg"] = 25832
    for more, wanted in (({}, True), ({"epsg": 0}, False)):
        assert OPS.export_building(filepath=str(tmp_path / "tower"), kind=".ifc", **more) == {"FINISHED"}
        assert ("EPSG:25832" in (tmp_path / "tower.ifc").read_text()) == wanted
    assert OPS.export_building(filepath=str(tmp_path / "tower.idf")) == {"FINISHED"}
    assert "BuildingSurface:Detailed" in (tmp_path / "tower.idf").read_text()
    assert {kind for kind, _, _ in files._BUILDINGS + files._ENERGY} == set(engine.exporting.BUILDING_KINDS)
    assert {kind for kind, _, _ in files._LEVELS} == set(engine.exporting.LODS)


@pytest.mark.parametrize(
    ("name", "kind", "wanted"),
    [("a.ifc", ".city.json", "a.city.json"), ("a.city.json", ".dxf", "a.dxf"), ("a.v2", ".ifc", "a.v2.ifc")],
)
def test_the_menu_of_formats_gives_the_name_its_ending(name, kind, wanted):
    dialog = types.SimpleNamespace(filepath=f"//{name}", kind=kind)
    assert files._Formats.check(dialog, None)
    assert dialog.filepath == f"//{wanted}"
    assert not files._Formats.check(dialog, None)


@pytest.mark.parametrize(
    ("name", "place", "words"),
    [
        ("export_building", {"filepath": "tower.txt"}, "must end in"),
        ("export_lods", {"filepath": "tower.txt"}, r"must end in \.glb, \.obj"),
        ("write_report", {}, "No folder is named"),
    ],
)
def test_other_names_are_refused_and_nothing_is_written(file, tmp_path, monkeypatch, name, place, words):
    meshed(file)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(RuntimeError, match=words):
        getattr(OPS, name)(**place)
    assert [path.name for path in tmp_path.iterdir()] == [file.name]


def test_ifc_and_dxf_need_no_package(file, tmp_path):
    meshed(file)
    for name in ("tower.ifc", "tower.dxf"):
        assert OPS.export_building(filepath=str(tmp_path / name), epsg=25832) == {"FINISHED"}
    ifc, dxf = ((tmp_path / name).read_text() for name in ("tower.ifc", "tower.dxf"))
    assert ifc.count("IFCINDEXEDPOLYGONALFACE((") == 6
    assert "IFCPROJECTEDCRS('EPSG:25832'" in ifc
    sizes = [int(number) for number in re.findall(r"\n93\n(\d+)\n", dxf)]
    assert sum(sizes) == 6 * 5, "each face has its number of corners and four corners"


def test_a_report_of_steps_that_fail_says_why(file, tmp_path):
    meshed(file)
    OPS.step_switch("EXEC_DEFAULT", True, step=0)
    with pytest.raises(RuntimeError, match=r"^Error: Step 2, Mesh: there are no regions yet"):
        OPS.write_report(directory=str(tmp_path / "report"))


def test_a_report_that_can_not_be_written_leaves_the_old_one(tmp_path, monkeypatch):
    folder = tmp_path / "report"
    handover.write_report(folder, {"planes.csv": "old", "sizes.csv": "old"})
    write_text = type(folder).write_text

    def full(self, text, **more):
        if "report" in self.name:
            raise OSError(28, "No space left on device")
        return write_text(self, text, **more)

    monkeypatch.setattr(type(folder), "write_text", full)
    with pytest.raises(OSError, match=r"No space left on device: '.*/report/report\.html'"):
        handover.write_report(folder, {"planes.csv": "new", "report.html": "new"})
    assert {path.name: path.read_text() for path in folder.iterdir()} == {"planes.csv": "old", "sizes.csv": "old"}
    monkeypatch.undo()
    handover.write_report(folder, {"planes.csv": "new", "report.html": "new"})
    assert {path.name: path.read_text() for path in folder.iterdir()} == {"planes.csv": "new", "report.html": "new"}


def test_a_report_has_map_coordinates_and_the_scene_up(file, tmp_path):
    scan = meshed(file)
    scan.rotation_euler = (0, 0, np.pi / 2)
    bpy.context.view_layer.update()
    old = tmp_path / "report" / "round_parts.csv"
    old.parent.mkdir()
    old.touch()
    assert OPS.write_report(directory=str(tmp_path / "report")) == {"FINISHED"}
    assert not old.exists(), "there are no round parts"
    rows = list(csv.DictReader((tmp_path / "report" / "planes.csv").read_text().splitlines()))
    assert len(rows) == 6
    assert sorted(round(float(row["tilt"])) for row in rows) == [0, 90, 90, 90, 90, 180]
    assert {row["area"][:4] for row in rows} <= {"4.0", "3.99", "4.00"}
    places_ = np.array([[float(row[f"centre_{axis}"]) for axis in "xyz"] for row in rows])
    assert np.abs(places_ - places.origin(scan)).max() < 3
    found = json.loads((tmp_path / "report" / "planes.geojson").read_text())
    assert found["crs"]["properties"]["name"].endswith("25832")
    assert "<svg" in (tmp_path / "report" / "report.html").read_text()
    assert store.load(scan) is not None


def test_a_round_part_is_a_true_surface_in_step_and_a_row_of_the_report(tmp_path):
    pytest.importorskip("OCP", reason="cadquery-ocp-novtk is not installed")
    scan = scans.column(96, 60)
    scan.location, scan.rotation_euler, scan.scale = (10, 20, 30), (np.pi / 2, 0, 0), (2, 2, 2)
    bpy.context.view_layer.update()
    OPS.partition(count_by="detail", curved=True)
    OPS.mesh()
    path = tmp_path / "column.step"
    assert OPS.export_step(filepath=str(path), unit="mm") == {"FINISHED"}
    text = path.read_text()
    assert "SI_UNIT(.MILLI.,.METRE.)" in text
    assert text.count("MANIFOLD_SOLID_BREP(") == 1
    (radius,) = re.findall(r"CYLINDRICAL_SURFACE\('',#\d+,([\d.]+)\)", text)
    assert float(radius) == pytest.approx(2, rel=0.01)
    assert OPS.write_report(directory=str(tmp_path / "report")) == {"FINISHED"}
    (row,) = csv.DictReader((tmp_path / "report" / "round_parts.csv").read_text().splitlines())
    assert abs(float(row["axis_y"])) == pytest.approx(1, abs=1e-3)
    assert (float(row["point_x"]), float(row["point_z"])) == pytest.approx((10, 30), abs=0.02)
    assert float(row["radius"]) == pytest.approx(2, rel=0.01)


def test_step_without_its_package_is_grey_with_the_command_that_installs_it(file, tmp_path, monkeypatch):
    meshed(file)
    if OPS.export_step.poll():
        with pytest.raises(RuntimeError, match=r"must end in \.step or \.stp"):
            OPS.export_step(filepath=str(tmp_path / "tower.dxf"))
    monkeypatch.setattr(engine.exporting.formats.importlib.util, "find_spec", lambda name: None)
    assert not OPS.export_step.poll()
    with pytest.raises(RuntimeError, match="Blender needs the package cadquery-ocp-novtk"):
        OPS.export_step(filepath=str(tmp_path / "tower.step"))
    # Blender cuts the text of this error, so where its folders are deep the command is whole in the tooltip only.
    tooltip = handover.missing(tmp_path / "tower.step", places.modules())
    assert re.search(r"-m pip install --target \S+ cadquery-ocp-novtk$", tooltip)
    assert OPS.install_step.poll()
    assert [path.name for path in tmp_path.iterdir()] == [file.name]


def test_a_button_installs_the_package_with_blender_s_own_python(tmp_path, monkeypatch, capfd):
    """A package of the same name, from a folder in place of the network."""
    name = "cadquery_ocp_novtk-1.0"
    with zipfile.ZipFile(tmp_path / f"{name}-py3-none-any.whl", "w") as wheel:
        wheel.writestr("OCP_stand_in/__init__.py", "")
        info = "Metadata-Version: 2.1\nName: cadquery-ocp-novtk\nVersion: 1.0\n"
        wheel.writestr(f"{name}.dist-info/METADATA", info)
        wheel.writestr(f"{name}.dist-info/WHEEL", "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n")
        wheel.writestr(f"{name}.dist-info/RECORD", "")
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PIP_FIND_LINKS", str(tmp_path))
    monkeypatch.setattr(engine.exporting, "missing", lambda path: "cadquery-ocp-novtk")
    monkeypatch.setattr(places, "modules", lambda: tmp_path / "modules")
    monkeypatch.setattr(sys, "path", list(sys.path))
    assert OPS.install_step() == {"FINISHED"}
    assert (tmp_path / "modules" / "OCP_stand_in").is_dir()
    assert util.find_spec("OCP_stand_in")
    monkeypatch.setenv("PIP_FIND_LINKS", str(tmp_path / "modules"))
    with pytest.raises(RuntimeError, match="Nothing was installed: ERROR"):
        OPS.install_step()


def test_the_reason_of_pip_is_reported_in_any_encoding(tmp_path, monkeypatch):
    """A stand-in for Blender's Python without pip, which notes its arguments."""
    python, called = tmp_path / "python", tmp_path / "called"
    python.write_bytes(b'#!/bin/sh\necho "$2" >> %s\necho "ERROR: no f\xfcr \xc3\xbcber"\nexit 1\n' % bytes(called))
    python.chmod(0o755)
    monkeypatch.setattr(engine.exporting, "missing", lambda path: "cadquery-ocp-novtk")
    monkeypatch.setattr(handover, "pip", lambda *given: [str(python), "-m", "pip"])
    monkeypatch.setattr(util, "find_spec", lambda name: None)
    with pytest.raises(RuntimeError, match="Nothing was installed: ERROR: no f\ufffdr \u00fcber"):
        OPS.install_step()
    assert called.read_text().split() == ["ensurepip", "pip"]


def test_a_level_has_its_colliders_in_its_file(file, tmp_path):
    scan = meshed(file)
    OPS.make_lods(counts=(6, 4, 0))
    OPS.export_lods(filepath=str(tmp_path / "tower.obj"))
    assert f"o UCX_{scan.name}_LOD0_00" in (tmp_path / "tower_LOD0.obj").read_text()
    assert "UCX" not in (tmp_path / "tower_LOD1.obj").read_text()


@pytest.mark.parametrize("child", [False, True])
def test_levels_and_colliders_of_an_excluded_collection_are_left_out(file, tmp_path, child):
    scan = meshed(file)
    OPS.make_lods(counts=(6, 4, 0))
    kept = bpy.data.objects[f"{scan.name}_LOD0"]
    moved, apart = kept.children[0] if child else kept, bpy.data.collections.new("Apart")
    bpy.context.scene.collection.children.link(apart)
    for collection in moved.users_collection:
        collection.objects.unlink(moved)
    apart.objects.link(moved)
    bpy.context.view_layer.layer_collection.children["Apart"].exclude = True
    coarse = bpy.data.objects[f"{scan.name}_LOD1"]
    coarse.hide_set(True)
    scans.activate(scan)
    assert OPS.export_lods(filepath=str(tmp_path / "tower.obj")) == {"FINISHED"}
    assert coarse.hide_get()
    written = sorted(path.name for path in tmp_path.glob("tower_LOD*.obj"))
    assert written == [f"tower_LOD{number}.obj" for number in range(2 if child else 1)]


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # by Blender's own exporter
@pytest.mark.parametrize("kind", [".glb", ".obj", ".city.json"])
def test_levels_of_detail_are_written_each_to_its_file(file, tmp_path, kind):
    scan = meshed(file)
    OPS.keep_lod()
    OPS.partition(proxies=4)
    OPS.mesh()
    kept = bpy.data.objects[f"{scan.name}_LOD0"]
    before = [(obj.name, obj.hide_get(), obj.select_get()) for obj in bpy.context.view_layer.objects]
    folder = tmp_path / "out"
    folder.mkdir()
    assert OPS.export_lods(filepath=str(folder / f"tower{kind}")) == {"FINISHED"}
    names = sorted(path.name for path in folder.iterdir() if path.suffix != ".mtl")
    assert names == [f"tower_LOD0{kind}", f"tower_LOD1{kind}"]
    assert [(obj.name, obj.hide_get(), obj.select_get()) for obj in bpy.context.view_layer.objects] == before
    assert kept.hide_get()
    if kind == ".obj":
        counts = [(folder / name).read_text().count("\nf ") for name in names]
        result = targets.result_of(bpy.context.scene, scan)
        assert counts == [len(kept.data.polygons), len(result.data.polygons)]


def test_an_object_of_the_user_is_no_level(file, tmp_path):
    scan = meshed(file)
    OPS.keep_lod()
    scans.cube(f"{scan.name}_LOD1", cells=1)
    scans.activate(scan)
    OPS.export_lods(filepath=str(tmp_path / "tower.obj"))
    assert [path.name for path in tmp_path.glob("*.obj")] == ["tower_LOD0.obj"]
    OPS.mesh()
    OPS.keep_lod()
    assert [obj.name for _, obj in targets.levels(scan)] == [f"{scan.name}_LOD0", f"{scan.name}_LOD2"]


def test_the_export_menu_has_all_three():
    drawn = []
    layout = type("Layout", (), {"operator": lambda _, name, **__: drawn.append(name)})()
    menus._draw_export(type("Menu", (), {"layout": layout})(), bpy.context)
    assert drawn == ["isimp.export_building", "isimp.export_step", "isimp.export_lods"]
