"""The allowed dependencies: the order of the engine's modules, and the importers of the engine, numpy and bpy."""

import ast
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import isimp_engine

ROOT = Path(__file__).resolve().parents[3]
NATIVE = ROOT / "native"
ADDON = ROOT / "addon" / "isimp"
ORDER = [
    "core",
    "mesh",
    "convex",
    "partition",
    "interact",
    "curved",
    "meshing",
    "regular",
    "texture",
    "thesis",
    "simplify",
    "tiles",
]
#: each may use the modules before it
UNRELATED = {("interact", "meshing"), ("meshing", "interact")}
#: folders of a module, lowest first; a file may include files of its own and of lower folders
ROOMS = {
    "curved": ["fit", "find", "cells", ""],
    "mesh": ["surface", "files", "cleaning", ""],
    "meshing": ["discs", "complex", "judge", "place", "planar", "repair", "flat", ""],
    "texture": ["layout", "draw", "images", ""],
}
PRIVATE = {"CGAL": {"mesh", "meshing"}, "OpenMesh": {"thesis"}, "thrust": {"parallel"}}


def modules(inner=False):
    """The engine's modules and their declared dependencies in CMake; inner: dependencies on inner headers."""
    text = (NATIVE / "CMakeLists.txt").read_text()
    uses = {}
    for name, rest in re.findall(r"^\s*isimp_module\((\w+)([^)]*)\)", text, re.MULTILINE):  # once for each branch
        used, _, inside = rest.partition("USES")[2].partition("INSIDE")
        uses.setdefault(name, set()).update((inside if inner else used).split())
    return uses


def reachable(uses, name):
    return {name}.union(*(reachable(uses, other) for other in uses[name]))


def includes(path):
    return re.findall(r'^\s*#\s*include\s+[<"]([^>"]+)[>"]', path.read_text(), re.MULTILINE)


def sources(module):
    return [p for part in ("include/isimp", "src") for p in sorted((NATIVE / part / module).rglob("*")) if p.is_file()]


@pytest.mark.parametrize("module", sorted(modules()))
def test_a_module_includes_only_declared_and_earlier_modules(module):
    allowed = reachable(modules(), module)
    files = sources(module)
    assert files
    for path in files:
        for include in includes(path):
            if include.startswith("isimp/"):
                assert include.split("/")[1] in allowed, f"{path} includes {include}"


@pytest.mark.parametrize(("arrow", "inner"), [("-->", False), ("-. inner .->", True)])
def test_the_diagram_of_the_documentation_has_the_arrows_of_cmake(arrow, inner):
    text = (ROOT / "docs" / "architecture.md").read_text()
    (diagram,) = re.findall(r"```mermaid\n(.*?)```", text, re.DOTALL)
    drawn = re.findall(rf"^  (\w+) {re.escape(arrow)} (\w+)$", diagram, re.MULTILINE)
    assert sorted(drawn) == sorted((name, other) for name, used in modules(inner).items() for other in used)


def test_the_diagram_has_arrows_of_these_kinds_only():
    text = (ROOT / "docs" / "architecture.md").read_text()
    lines = text.partition("```mermaid\n")[2].partition("```")[0].splitlines()
    assert lines.pop(0) == "graph TD"
    assert [line for line in lines if not re.fullmatch(r"  \w+ (-->|-\. inner \.->) \w+", line)] == []


def test_modules_are_in_the_agreed_order():
    for module, uses in modules().items():
        for other in uses:
            assert (module, other) not in UNRELATED
            if module in ORDER and other in ORDER:
                assert ORDER.index(other) < ORDER.index(module), f"{module} uses {other}"
            else:
                assert other in ("core", "parallel"), f"{module} uses {other}"


@pytest.mark.parametrize("module", sorted(ROOMS))
def test_a_file_includes_only_files_of_its_folder_and_of_folders_before(module):
    rooms = ROOMS[module]
    folder = NATIVE / "src" / module
    assert {p.name for p in folder.iterdir() if p.is_dir()} == set(rooms) - {""}
    for path in sources(module):
        if not path.is_relative_to(folder):
            continue
        level = rooms.index(path.relative_to(folder).parent.as_posix().replace(".", ""))
        for include in includes(path):
            if (folder / include).is_file():
                room = Path(include).parent.as_posix().replace(".", "")
                assert rooms.index(room) <= level, f"{path} includes {include}"


def test_the_folders_of_meshing_are_in_the_documentation():
    text = (ROOT / "docs" / "architecture.md").read_text().partition("The sources of `meshing` are in ")[2]
    assert text.startswith("seven folders")
    assert re.findall(r"^\| `(\w+)/` \|", text.partition("\n\nOnly")[0], re.MULTILINE) == ROOMS["meshing"][:-1]


@pytest.mark.parametrize("library", sorted(PRIVATE))
def test_a_foreign_library_stays_private_to_the_sources_of_its_modules(library):
    for path in sorted(NATIVE.rglob("*")):
        if path.suffix in {".h", ".cpp"} and any(i.split("/")[0] == library for i in includes(path)):
            inside = path.relative_to(NATIVE).parts
            assert inside[0] == "src", f"{path} includes {library}"
            assert inside[1] in PRIVATE[library], f"{path} includes {library}"


def imports(path):
    """The top-level names a Python file imports, with dots for relative ones."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            names = [node.module or ""] if node.module else [alias.name for alias in node.names]
            yield from ("." * node.level + name.split(".")[0] for name in names)


OPTIONAL = {"on_dask.py": {"distributed"}, "images.py": {"PIL"}}
OPTIONAL |= {name: {"OCP"} for name in ("faces.py", "kernel.py", "solid.py", "step_file.py")}


def test_the_package_imports_itself_relatively_and_else_only_numpy_and_pillow_for_images():
    for path in sorted((ROOT / "python" / "isimp_engine").rglob("*.py")):
        allowed = {"numpy"} | OPTIONAL.get(path.name, set())
        for name in imports(path):
            assert name.startswith(".") or name in allowed or name in sys.stdlib_module_names, f"{path} imports {name}"


def test_optional_packages_are_not_imported_before_their_use():
    code = (
        "import sys, isimp_engine.cli, isimp_engine.batch.work\nprint({'distributed', 'PIL', 'OCP'} & set(sys.modules))"
    )
    outer = str(Path(isimp_engine.__file__).parents[1])
    done = subprocess.run([sys.executable, "-c", code], env={"PYTHONPATH": outer}, capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("set()\n", "")


COMPILED = {"_core", "isimp_engine"}  # no Python files of these names: the engine, and the engine inside the add-on


def imported_files(path):
    """The files of a package that one of them imports, in functions too."""
    for node in ast.walk(ast.parse(path.read_text())):
        if not isinstance(node, ast.ImportFrom) or not node.level:
            continue
        folder = path.parents[node.level - 1]
        for part in (node.module or "").split("."):
            folder = folder / part
        names = [alias.name for alias in node.names if folder.is_dir()] or [""]
        for name in names:
            inner = folder / name if name else folder
            if inner.name not in COMPILED:
                file = inner.with_suffix(".py")
                yield file if file.is_file() else (inner if inner.is_dir() else folder) / "__init__.py"


@pytest.mark.parametrize("package", [ROOT / "python" / "isimp_engine", ADDON], ids=lambda path: path.name)
def test_no_file_imports_itself_by_way_of_others(package):
    if not package.is_dir():
        pytest.skip("the add-on is not here")
    left = {path: set(imported_files(path)) - {path} for path in package.rglob("*.py")}
    assert sum(map(len, left.values())) > 50
    while free := [path for path, needed in left.items() if not needed & left.keys()]:
        for path in free:
            del left[path]
    assert sorted(str(path.relative_to(package)) for path in left) == []


#: rooms and files of addon/isimp/blender by floors, lowest first; a file may import its own room and lower floors
FLOORS = [
    {"scene", "translations", "command", "widths"},
    {"texts", "without_numpy"},
    {"preferences", "texturing", "controls"},
    {"drawing"},
    {"reading"},
    {"view"},
    {"work"},
    {"operators", "panel"},
    {"tools", "menus"},
    {"everything"},
    {"__init__"},
]


@pytest.mark.skipif(not ADDON.is_dir(), reason="the add-on is not here")
def test_each_room_of_the_add_on_in_blender_stands_on_lower_floors():
    folder = ADDON / "blender"
    floor = {name: number for number, names in enumerate(FLOORS) for name in names}
    rooms = {path.relative_to(folder).parts[0].removesuffix(".py") for path in folder.rglob("*.py")}
    assert rooms == set(floor)
    for path in sorted(folder.rglob("*.py")):
        room = path.relative_to(folder).parts[0].removesuffix(".py")
        for other in imported_files(path):
            if other.is_relative_to(folder):
                its = other.relative_to(folder).parts[0].removesuffix(".py")
                assert its == room or floor[its] < floor[room], f"{path} imports {other}"


@pytest.mark.skipif(not ADDON.is_dir(), reason="the add-on is not here")
def test_only_engine_imports_the_engine_and_only_blender_bpy():
    for path in sorted(ADDON.rglob("*.py")):
        inside = path.relative_to(ADDON).parts
        if inside[0] == "isimp_engine":  # the engine itself, when put inside the add-on
            continue
        for name in imports(path):
            if name.lstrip(".") == "isimp_engine":
                assert inside in {("engine.py",), ("recipe.py",)}, f"{path} imports the engine"
            if name in {"bpy", "bmesh", "gpu", "gpu_extras", "blf", "bpy_extras", "mathutils"}:
                assert inside[0] in ("blender", "__init__.py"), f"{path} imports {name}"


@pytest.mark.skipif(not ADDON.is_dir(), reason="the add-on is not here")
def test_view_stands_on_little():
    for name in imports(ADDON / "view.py"):
        assert name.startswith(".") or name == "numpy" or name in sys.stdlib_module_names, f"view.py imports {name}"


def test_recipes_stand_on_their_folder_and_the_standard_library_so_that_the_add_on_can_copy_them():
    files = sorted((ROOT / "python" / "isimp_engine" / "recipe").rglob("*.py"))
    assert len(files) > 5
    for path in files:
        for name in imports(path):
            is_own = name.startswith(".") and not name.startswith("..")
            assert is_own or name in sys.stdlib_module_names, f"{path} imports {name}"


def test_the_package_also_works_inside_another_one_with_the_installed_copy(tmp_path):
    inner = tmp_path / "isimp" / "isimp_engine"
    shutil.copytree(Path(isimp_engine.__file__).parent, inner)
    (tmp_path / "isimp" / "__init__.py").touch()
    code = (
        "import isimp_engine as outer\n"
        "from isimp import isimp_engine as inner\n"
        "assert inner.Mesh is not outer.Mesh\n"
        "for engine in (inner, outer):\n"
        "    try: engine.Mesh([[0., 0., 0.]], [[0, 0, 0]])\n"
        "    except engine.InvalidInput as error: print(type(error).__module__, error)\n"
    )
    outer = str(Path(isimp_engine.__file__).parents[1])
    done = subprocess.run(
        [sys.executable, "-c", code], env={"PYTHONPATH": f"{tmp_path}:{outer}"}, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == [
        "isimp.isimp_engine face 0 uses vertex 0 twice; clean(...) repairs this",
        "isimp_engine face 0 uses vertex 0 twice; clean(...) repairs this",
    ]


TYPE = re.compile(r"(?:enum )?(?:struct|class) (\w+)(?: final)?(?: :[^:].*)? \{")


def types_of(text: str) -> list[str]:
    """The types that a C++ file defines outside functions, classes and namespaces without a name."""
    spaces: list[str] = []
    found = []
    for line in text.splitlines():
        if opened := re.match(r"(?:inline )?namespace ?([\w:]*) ?\{", line):
            spaces.append(opened[1])
        elif line.startswith("}  // namespace"):
            spaces.pop()
        elif "" not in spaces and (named := TYPE.match(line)):
            found.append("::".join([*spaces, named[1]]))
    return found


def test_a_type_has_one_definition():
    """The linker keeps one of the functions of two types of a name, and the other type gets it too."""
    text = "namespace isimp::a {\nnamespace {\nstruct B {\n}  // namespace\nclass C : D {\nstruct E;\nenum class F {\n"
    assert types_of(text) == ["isimp::a::C", "isimp::a::F"]
    where: dict[str, set[str]] = {}
    for path in [*ROOT.glob("native/**/*.h"), *ROOT.glob("native/**/*.cpp")]:
        for name in types_of(path.read_text()):
            where.setdefault(name, set()).add(str(path.relative_to(ROOT)))
    assert len(where) > 300
    assert {name: sorted(paths) for name, paths in where.items() if len(paths) > 1} == {}
