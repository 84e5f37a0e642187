"""A student with the zip and the manual: from nothing installed to polygons, by the words of the manual.

Each action is done only if its sentence is in the manual; the tab and the buttons are found by their names there. It
counts the actions.
"""

import os
import re
from pathlib import Path

import bpy

DOCS = Path(__file__).parents[4] / "docs"
MOST = 8  # actions


def words(name):
    return re.sub(r"\s+", " ", (DOCS / name).read_text(encoding="utf-8"))


class Student:
    def __init__(self):
        self.read = words("install.md") + words("manual.md").split("## The panel")[0]
        self.done = []

    def does(self, sentence, times=1):
        """Notes the clicks of an action."""
        assert sentence in self.read, f"the manual no longer says: {sentence}"
        self.done += [sentence] * times
        print(f"{len(self.done)}. {sentence}", flush=True)

    def button(self, name):
        """The action of a button of the panel, by its name in bold in the manual."""
        assert f"**{name}**" in self.read, name
        operators = (getattr(bpy.types, cls) for cls in dir(bpy.types) if cls.startswith("ISIMP_OT_"))
        found = [operator.bl_idname for operator in operators if operator.bl_label == name]
        assert len(found) == 1, f"{name}: {found}"
        return found[0]


def install(student, zip_file):
    """By the manual's steps for this Blender. The operator of a dropped zip opens a dialog for the repository."""
    if bpy.app.version >= (4, 2, 0):
        student.does("drag the zip into Blender's window")
        bpy.ops.extensions.package_install_files(filepath=zip_file, repo="user_default", enable_on_install=True)
        return
    student.does("*Edit > Preferences > Add-ons > Install...*")
    bpy.ops.preferences.addon_install(filepath=zip_file)
    student.does("tick *Mesh: iSimp*")
    bpy.ops.preferences.addon_enable(module="isimp")


def run(hand):
    student, zip_file = Student(), os.environ["ISIMP_ZIP"]
    install(student, zip_file)
    yield 0.5
    student.does("Delete the default cube.")
    yield from hand.into_view()
    yield from hand.key("X")
    yield 0.3
    yield from hand.key("RET")
    yield 0.3
    assert "Cube" not in bpy.context.scene.objects
    student.does("Import a scan (File > Import)")
    importer = bpy.ops.wm.obj_import if bpy.app.version >= (4, 0, 0) else bpy.ops.import_scene.obj
    importer(filepath=os.environ["ISIMP_SCAN"])
    student.does("click it, and press *Numpad .* in the 3D view")
    (scan,) = (obj for obj in bpy.context.scene.objects if obj.type == "MESH")
    bpy.context.view_layer.objects.active = scan
    scan.select_set(True)
    yield from hand.into_view()
    yield from hand.key("NUMPAD_PERIOD")
    yield 0.5
    yield from hand.shot("student-1-quick-start")
    student.does("Press N and choose the tab **iSimp**.")
    yield from hand.open_tab()
    for name in ("Partition", "Mesh"):
        student.does(f"Press **{name}**.")
        yield from hand.press(student.button(name))
    polygons = len(bpy.context.object.data.polygons)
    print(f"{len(scan.data.polygons)} triangles -> {polygons} polygons", flush=True)
    assert bpy.context.object.name.endswith(".simplified"), bpy.context.object.name
    assert 6 <= polygons < len(scan.data.polygons) / 10
    assert max(map(len, (polygon.vertices for polygon in bpy.context.object.data.polygons))) > 4, "n-gons"
    assert len(student.done) <= MOST, student.done
    yield from hand.shot("student-2-polygons")
