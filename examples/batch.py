"""Simplifies a scan in the background of Blender.

    blender -b --python examples/batch.py -- IN OUT [OUT ...]
            [--detail X | --tolerance T | --bound T | --proxies N | --recipe R.json] [--picture P.png] [--table T.csv]

IN is any format that Blender reads, or .off. OUT are .obj, .ply, .glb, in the axes of IN, or .blend, which keeps the
scan and its coloured regions. Ends with 0; 2 for wrong usage; 3 for an unusable scan, and a line with the reason.
A table T.csv may collect many scans: each run adds a row with its result, or with the reason of its failure.
"""

import argparse
import csv
import os
import sys
import time
from pathlib import Path

import bpy
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

# By file name ending: operators to try in order, as they differ between Blender's versions. "engine" is iSimp's own.
READERS = {
    ".obj": ("wm.obj_import", "import_scene.obj"),
    ".ply": ("wm.ply_import", "engine"),  # the importer of Blender 3.4 takes a minute for a million triangles
    ".stl": ("wm.stl_import", "import_mesh.stl"),
    ".off": ("engine",),
    ".glb": ("import_scene.gltf",),
    ".gltf": ("import_scene.gltf",),
    ".fbx": ("import_scene.fbx", "wm.fbx_import"),
    ".dae": ("wm.collada_import",),
    ".x3d": ("import_scene.x3d",),
    ".wrl": ("import_scene.x3d",),
    ".abc": ("wm.alembic_import",),
    ".usd": ("wm.usd_import",),
    ".usdc": ("wm.usd_import",),
    ".usda": ("wm.usd_import",),
    ".usdz": ("wm.usd_import",),
}
COUNTS = ("proxies", "tolerance", "bound", "detail")
METHODS = ("hierarchy", "teleport", "lloyd")
WRITERS = (".blend", ".obj", ".ply", ".glb")
COLUMNS = ("scan", "faces", "regions", "polygons", "closed", "worst flatness", "farthest", "seconds", "problem")
Z_UP = {".ply", ".stl", ".off"}  # read as they are; all others are turned by Blender to have Z upwards


class Problem(Exception):
    """The scan can't be used, or a file not be written; the message gives the reason."""


def arguments(argv):
    parser = argparse.ArgumentParser(prog="blender -b --python batch.py --", description=__doc__.split("\n")[0])
    parser.add_argument("input", type=Path, metavar="IN", help="the scan, in any format that Blender reads")
    parser.add_argument("outputs", type=Path, nargs="+", metavar="OUT", help=f"files to write: {', '.join(WRITERS)}")
    parser.add_argument("--detail", type=float, metavar="X", help="show details larger than this share of the size")
    parser.add_argument("--tolerance", type=float, metavar="T", help="the same as a length in scan units")
    parser.add_argument("--bound", type=float, metavar="T", help="keep every vertex so near to its region's plane")
    parser.add_argument("--proxies", type=int, metavar="N", help="just so many regions")
    parser.add_argument("--recipe", type=Path, metavar="R.json", help="the steps to do, as the add-on exports them")
    parser.add_argument("--method", choices=METHODS, help="how regions are found (default hierarchy)")
    parser.add_argument("--seed", type=int, help="number that starts the random choice of teleport and lloyd")
    parser.add_argument("--iterations", type=int, help="the most rounds of flooding and fitting (default 20)")
    parser.add_argument(
        "--object", metavar="NAME", help="which object of a .blend (default: the active, or the only one)"
    )
    parser.add_argument("--table", type=Path, metavar="T.csv", help="add a row with the result of the scan")
    parser.add_argument("--picture", type=Path, metavar="P.png", help="regions and polygons side by side")
    parser.add_argument(
        "--up", choices=("X", "Y", "Z"), default="Z", help="the picture's upward axis, in Blender's space"
    )
    parser.add_argument(
        "--turn", type=float, default=30.0, metavar="DEGREES", help="from which side the picture is taken"
    )
    options = parser.parse_args(argv)
    for path in options.outputs:
        if path.suffix.lower() not in WRITERS:
            parser.error(f"can't write '{path}': its name must end in {', '.join(WRITERS)}")
    if options.input.suffix.lower() not in (*READERS, ".blend"):
        parser.error(f"can't read '{options.input}': known are .blend, {', '.join(READERS)}")
    return options


def switch_on_addon():
    """The add-on as installed, else the one of this checkout."""
    if hasattr(bpy.types, "ISIMP_OT_partition"):
        return
    import addon_utils

    for module in addon_utils.modules():
        if module.__name__.split(".")[-1] == "isimp" and addon_utils.enable(module.__name__):
            return
    root = HERE.parent
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    for folder in (*root.glob("build*/python"), *root.glob(f".venv*/lib/{version}/site-packages")):
        if (folder / "isimp_engine").is_dir():
            sys.path.append(str(folder))  # behind all others, so that installed packages come first
            break
    sys.path.insert(0, str(root / "addon"))
    import isimp

    isimp.register()


def of_addon(name):
    """A module of the add-on, whether it was installed as an extension or not."""
    return next(module for known, module in sys.modules.items() if f".{known}".endswith(f".{name}"))


def call(name, **settings):
    """Calls an operator; an error that it reports becomes a Problem."""
    group, operator = name.split(".")
    try:
        return getattr(getattr(bpy.ops, group), operator)(**settings)
    except RuntimeError as error:
        raise Problem(said(str(error))) from None


def said(message):
    """The report of an operator as one line; for a fault in one written in Python only its last line."""
    lines = [line.strip() for line in message.splitlines() if line.strip()]
    if not any("Traceback (most recent" in line for line in lines):
        return " ".join(lines).removeprefix("Error: ")
    return next((line for line in reversed(lines) if not line.startswith(("Location:", "File "))), "")


def exists(name):
    group, operator = name.split(".")
    try:
        getattr(getattr(bpy.ops, group), operator).get_rna_type()
    except (KeyError, AttributeError):
        return False
    return True


def read(options):
    """Imports the scan, active and selected, and returns its object."""
    path = options.input.resolve()
    if not path.is_file():
        raise Problem(f"there is no file '{options.input}'")
    if path.suffix.lower() == ".blend":
        call("wm.open_mainfile", filepath=str(path), load_ui=False)
        scan = choose(options.object)
    else:
        bpy.data.batch_remove(list(bpy.data.objects))
        scan = imported(path)
    activate(scan)
    return scan


def imported(path):
    reader = next((name for name in READERS[path.suffix.lower()] if name == "engine" or exists(name)), None)
    if reader is None:
        raise Problem(f"this Blender can't read {path.suffix} files")
    if reader == "engine":
        return from_engine(path)
    if "bool" not in vars(np):
        np.bool = bool  # the glTF importer of Blender 3.4 uses it, Debian's numpy has it no longer
    call(reader, filepath=str(path))
    meshes = [obj for obj in bpy.context.scene.objects if obj.type == "MESH" and len(obj.data.polygons)]
    if not meshes:
        raise Problem(f"'{path.name}' holds no mesh with faces")
    if len(meshes) > 1:  # one file is one scan, so that N counts the whole
        activate(*meshes)
        bpy.ops.object.join()
    meshes[0].name = path.stem
    return meshes[0]


def from_engine(path):
    session = of_addon("isimp.session")  # which has the engine as it found it: installed, or packed with it
    try:
        vertices, triangles = session.engine.read(str(path))
    except session.engine.InvalidInput as error:
        raise Problem(str(error)) from None
    vertices = np.asarray(vertices, np.float64)
    place = place_of(vertices)
    mesh = bpy.data.meshes.new(path.stem)
    fill = of_addon("isimp.blender.scene.mesh_io").fill_polygons
    fill(mesh, vertices - place, np.ravel(triangles), np.arange(0, np.size(triangles), 3), {})
    scan = bpy.data.objects.new(path.stem, mesh)
    bpy.context.scene.collection.objects.link(scan)
    scan.location = place
    bpy.context.view_layer.update()
    return scan


def place_of(points):
    """(3,) where a scan's object is put, so that float32 loses nothing of its points: 0 unless they lie far from it."""
    finite = points[np.isfinite(points).all(axis=1)]
    if not len(finite) or of_addon("isimp.float_loss").loss(finite.min(axis=0), finite.max(axis=0)) is None:
        return np.zeros(3)
    return ((finite.min(axis=0) + finite.max(axis=0)) / 2).astype(np.float32).astype(np.float64)


def choose(name):
    """The scan of a .blend: the one named, else the active one, else the only one."""
    scene = bpy.context.scene
    meshes = [obj for obj in scene.objects if obj.type == "MESH" and len(obj.data.polygons)]
    names = ", ".join(obj.name for obj in meshes)
    if name is not None:
        if name not in scene.objects:
            raise Problem(f"there is no object '{name}'; there are: {names}")
        return scene.objects[name]
    active = bpy.context.view_layer.objects.active
    if active in meshes:
        return active
    if len(meshes) != 1:
        raise Problem(f"say which one by --object NAME: {names}" if meshes else "the file holds no mesh with faces")
    return meshes[0]


def activate(*objects):
    for other in bpy.context.selected_objects:
        other.select_set(False)
    for obj in objects:
        obj.hide_set(False)
        obj.select_set(True)
    bpy.context.view_layer.objects.active = objects[0]


def simplify(options):
    names = (*COUNTS, "method", "seed", "iterations")
    settings = {name: getattr(options, name) for name in names if getattr(options, name) is not None}
    ways = [name for name in COUNTS if name in settings]
    if len(ways) > 1:
        raise Problem(f"--{' and --'.join(ways)} each set the number of regions: give one")
    settings |= {"count_by": ways[0]} if ways else {}
    for name, least in (("proxies", 1), ("iterations", 1), ("seed", 0)):
        if settings.get(name, least) < least:
            raise Problem(f"--{name} must be at least {least}, got {settings[name]}")
    if options.recipe is None:
        call("isimp.partition", **settings)
        call("isimp.mesh")
        return bpy.context.object
    if settings:
        raise Problem("--recipe says how it is done: leave out --proxies, --detail, --method and the like")
    scan = bpy.context.object
    call("isimp.replay", recipe=recipe_text(options.recipe), strict=True)
    if bpy.context.object == scan:
        call("isimp.mesh")
    return bpy.context.object


def recipe_text(path):
    """The text of a recipe that can be used."""
    try:
        text = path.read_text(encoding="utf-8")
        of_addon("isimp.recipe").Recipe.from_json(text)
    except UnicodeDecodeError:
        raise Problem(f"the recipe '{path}' can't be read: it is not UTF-8 text") from None
    except OSError as error:
        raise Problem(f"the recipe '{path}' can't be read: {error.strerror}") from None
    except ValueError as error:
        raise Problem(f"the recipe '{path}' can't be used: {error}") from None
    return text


def write(path, options):
    """As `write_as`; every failure becomes a Problem that names the file."""
    make_room(path)
    try:
        write_as(path, options)
    except OSError as error:
        raise Problem(f"'{path}' can't be written: {error.strerror or error}") from None
    except Problem as problem:
        raise Problem(f"'{path}' can't be written: {problem}") from None


def make_room(path):
    """Makes the folder of an output, and checks that it can be written. Some writers of Blender report no error."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        existed = path.exists()
        if existed and not (path.is_file() or path.is_dir()):
            return  # a pipe, of which opening would not return
        path.open("ab").close()
        if not existed:
            path.unlink()
    except OSError as error:
        raise Problem(f"'{path}' can't be written: {error.strerror}") from None


def write_as(path, options):
    """Writes the result, or for a .blend everything, in the axes of the input."""
    path = path.resolve()
    kind, y_up = path.suffix.lower(), options.input.suffix.lower() not in Z_UP
    if kind == ".blend":
        call("wm.save_as_mainfile", filepath=str(path), copy=True)
    elif kind in EXACT and is_afar(bpy.context.object):
        EXACT[kind](path, *in_the_world(bpy.context.object, y_up))
    elif kind == ".glb":
        call("export_scene.gltf", filepath=str(path), export_format="GLB", use_selection=True)
    elif kind == ".ply" and not exists("wm.ply_export"):
        plain = {"use_normals": False, "use_uv_coords": False, "use_colors": False, "use_selection": True}
        axes = {"axis_forward": "-Z", "axis_up": "Y"} if y_up else {"axis_forward": "Y", "axis_up": "Z"}
        call("export_mesh.ply", filepath=str(path), **plain, **axes)
    else:
        plain = {"export_normals": False, "export_uv": False, "export_selected_objects": True}
        plain |= {"export_colors": "NONE"} if kind == ".ply" else {"export_materials": False}
        axes = {"forward_axis": "NEGATIVE_Z", "up_axis": "Y"} if y_up else {"forward_axis": "Y", "up_axis": "Z"}
        call(f"wm.{kind[1:]}_export", filepath=str(path), **plain, **axes)
    if not path.is_file():
        raise Problem("Blender made no file")


def is_afar(obj):
    """Whether float32, which Blender's own writers put out, is too coarse for where an object is in the world."""
    points, _ = in_the_world(obj, y_up=False)
    return of_addon("isimp.float_loss").loss(points.min(axis=0), points.max(axis=0)) is not None


def in_the_world(obj, y_up):
    """(V, 3) float64 points of an object in the world, and the corners of each of its faces."""
    points, place = np.empty(3 * len(obj.data.vertices), np.float32), np.array(obj.matrix_world, np.float64)
    obj.data.vertices.foreach_get("co", points)
    points = points.reshape(-1, 3) @ place[:3, :3].T + place[:3, 3]
    points = points[:, [0, 2, 1]] * (1, 1, -1) if y_up else points
    turn = -1 if np.linalg.det(place[:3, :3]) < 0 else 1  # a mirrored face is seen from its other side
    return points, [tuple(face.vertices)[::turn] for face in obj.data.polygons]


def write_obj(path, points, faces):
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
    lines += [f"f {' '.join(str(corner + 1) for corner in face)}" for face in faces]
    path.write_text("\n".join(lines) + "\n")


def write_ply(path, points, faces):
    head = ["ply", "format ascii 1.0", f"element vertex {len(points)}", *(f"property double {axis}" for axis in "xyz")]
    head += [f"element face {len(faces)}", "property list int int vertex_indices", "end_header"]
    lines = [f"{x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
    lines += [" ".join(map(str, (len(face), *face))) for face in faces]
    path.write_text("\n".join([*head, *lines]) + "\n")


#: kinds of files with coordinates as float64
EXACT = {".obj": write_obj, ".ply": write_ply}


def add_row(path, row):
    """Adds a scan's row to a table, which is begun if there is none."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, COLUMNS)
        if file.tell() == 0:
            table.writeheader()
        table.writerow(row)


def what_came(scan, result):
    """The row of a scan with polygons."""
    numbers = of_addon("isimp.blender.scene.store").numbers(scan)
    return {
        "regions": numbers["regions"],
        "polygons": len(result.data.polygons),
        "closed": "yes" if numbers["closed"] else "no",
        "worst flatness": f"{numbers['planarity_max']:.6g}",
        "farthest": f"{numbers['scan_distance']:.6g}" if "scan_distance" in numbers else "",
    }


def main(argv):
    options = arguments(argv)
    row, started = {"scan": str(options.input)}, time.perf_counter()
    code = run(options, row, started)
    row["seconds"] = f"{time.perf_counter() - started:.1f}"
    try:
        if options.table is not None:
            add_row(options.table, row)
    except OSError as problem:
        print(f"{options.table}: {problem}", file=sys.stderr)
        return 3
    return code


def run(options, row, started):
    """Does all steps, and fills in the row of the table; returns the exit code."""
    try:
        switch_on_addon()
        scan = read(options)
        name, faces = scan.name, len(scan.data.polygons)
        row["faces"] = faces
        result = simplify(options)
        row |= what_came(scan, result)
        for path in options.outputs:
            write(path, options)
        seconds = time.perf_counter() - started
        print(f"{name}: {faces:,} faces -> {len(result.data.polygons):,} polygons in {seconds:.1f} s")
        if options.picture is not None:
            import picture

            make_room(options.picture)
            picture.render(scan, result, options.picture.resolve(), up=options.up, turn=options.turn)
            print(options.picture)
    except (Problem, OSError, ValueError) as problem:
        row["problem"] = str(problem)
        print(f"{options.input}: {problem}", file=sys.stderr)
        return 3
    return 0


if __name__ == "__main__":
    code = main(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else [])
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)  # bpy 4.5 from PyPI waits for ever in a destructor when Python ends
