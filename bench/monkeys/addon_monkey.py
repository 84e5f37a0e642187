"""Presses the operators of the add-on at random and checks the add-on after each.

    blender -b --factory-startup --python-exit-code 1 --python bench/monkeys/addon_monkey.py -- --actions 10000 --seed 1
    python -m bench.monkeys.addon_monkey --actions 1000        where bpy is installed from PyPI

The engine and the add-on are found on the path, or in the folders of ISIMP_SITE. An action is an operator with random
settings, a change of mode, selection, active object or of a setting of the panel, undo, redo, or saving and opening the
file. Each is written to the log before it is done, so that the last line names the one that ended Blender. After each:

- no Python exception, other than an operator's own report of an error;
- the geometry of each scan is unchanged, bit for bit;
- all panels can be drawn.

The exit status is 1 if a check failed, and the output names it. The same seed gives the same actions.
"""

from __future__ import annotations

import argparse
import faulthandler
import io
import json
import os
import random
import sys
import tempfile
import traceback
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [folder for folder in os.environ.get("ISIMP_SITE", "").split(os.pathsep) if folder]
sys.path += [str(ROOT / folder) for folder in ("addon", "tests/shared", "tests/python/blender")]

import bpy  # noqa: E402  (after the folders above)
import drawing  # noqa: E402
import numpy as np  # noqa: E402
import scans  # noqa: E402

import shapes  # noqa: E402

LEFT_OUT = {"preset_add", "compare", "workspace"}  # they write the user's files, or need a window
SLOW = 300  # seconds that no action takes
GARBAGE = ("", "no recipe", '{"isimp_recipe": 1, "steps": []}', '{"isimp_recipe": 1, "steps": [{"step": "mesh"}]}')


def squares(vertices, triangles) -> tuple:
    """The two halves of each square as one face."""
    half = len(triangles) // 2
    return vertices, np.c_[triangles[:half], triangles[half:, 2]]


def made_scans() -> dict:
    """Ten small meshes, by name: clean and noisy, open and closed, of one part and of many, and defective ones."""
    (sheet, halves), (ball, faces) = shapes.plane(12), shapes.figure(5, noise=0.0)
    roof = squares(np.c_[sheet[:, :2], np.maximum(0, 0.4 - np.abs(sheet[:, 0] - 0.5))], halves)
    rough = squares(*shapes.bumpy(16))
    small = 0.2 * shapes.figure(2)[0], shapes.figure(2)[1]
    return {
        "roof": roof,
        "rough": rough,
        "round": (ball, faces),
        "pieces": shapes.joined((ball, faces), *((small[0] + (2 + number, 0, 0), small[1]) for number in range(4))),
        "mixed": (np.concatenate([roof[0], ball + (0, 0, 3)]), [*roof[1].tolist(), *(faces + len(sheet)).tolist()]),
        "fins": ([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1)], [(0, 1, i) for i in (2, 3, 4)]),
        "far": (ball + (5e5, 5.4e6, 100), faces),
        "holed": (rough[0], np.delete(rough[1], np.random.default_rng(1).integers(0, len(rough[1]), 12), axis=0)),
        "one": (np.eye(3), [(0, 1, 2)]),
        "tiny": (1e-4 * ball, faces),
    }


class Broken(Exception):
    """A forbidden state has occurred."""


class Monkey:
    def __init__(self, seed: int, log: Path, files=()):
        import isimp

        self.addon, self.random, self.log = isimp, random.Random(seed), log
        self.folder = Path(tempfile.mkdtemp(prefix="isimp-monkey-"))
        self.errors, self.done, self.refused = io.StringIO(), {}, 0
        self._files = list(files)
        self._known = {}  # scan's mesh -> its geometry
        classes = [cls for cls in isimp.blender._CLASSES if issubclass(cls, bpy.types.Operator)]
        names = [cls.bl_idname.split(".")[1] for cls in classes if hasattr(cls, "execute")]
        self.operators = sorted(set(names) - LEFT_OUT)
        self.panels = [cls for cls in isimp.blender._CLASSES if issubclass(cls, (bpy.types.Panel, bpy.types.Menu))]
        self._last = ""

    # State of the file

    def begin(self) -> None:
        """An empty file with one scan, at times with two."""
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        bpy.context.preferences.edit.use_global_undo = True
        self._known.clear()
        made = made_scans()
        for name in self.random.sample(sorted(made), self.random.choice((1, 1, 1, 2))):
            self.add(name, *made[name])
        if self._files and self.random.random() < 0.5:
            self.read(self.random.choice(self._files))
        bpy.ops.ed.undo_push(message="begin")

    def add(self, name: str, vertices, faces):
        obj = scans.add(name, vertices, faces)
        if self.random.random() < 0.3:
            obj.scale = self.random.choice([(-1, 1, 1), (1, 2, 0.5), (0.01, 0.01, 0.01)])
            obj.rotation_euler = (0.3, 0.2, 0.1)
        if self.random.random() < 0.4:
            self.texture(obj)
        if self.random.random() < 0.2:
            obj.vertex_groups.new(name="Density").add(range(0, len(vertices), 2), 0.7, "REPLACE")
        bpy.context.view_layer.update()
        self._known[obj.data.name] = scans.geometry(obj.data)

    def read(self, path: Path) -> None:
        engine = self.addon.engine.engine
        mesh = engine.clean(*engine.read(str(path)))  # Blender takes no invalid faces
        self.add(path.stem[:40], np.asarray(mesh.vertices) - np.mean(mesh.vertices, axis=0), mesh.triangles)

    def texture(self, obj) -> None:
        layer = obj.data.uv_layers.new(name="UV")
        values = np.random.default_rng(self.random.randrange(99)).random(2 * len(obj.data.loops))
        layer.data.foreach_set("uv", values.astype(np.float32))
        image = bpy.data.images.new("Paint", 8, 8)
        image.pack()
        obj.data.materials.append(scans.material_of("Paint", image))

    @staticmethod
    def activate(obj) -> None:
        for other in bpy.context.selected_objects:
            other.select_set(False)
        bpy.context.view_layer.objects.active = obj
        if obj is not None and obj.name in bpy.context.view_layer.objects:
            obj.select_set(True)

    def check(self) -> None:
        """Raises Broken where a scan has changed, or a panel can't be drawn."""
        for obj in bpy.data.objects:
            if obj.type == "MESH" and obj.data.name in self._known:
                obj.update_from_editmode()
                if scans.geometry(obj.data) != self._known[obj.data.name]:
                    raise Broken(f"the scan '{obj.name}' has changed")
        context = bpy.context
        for cls in self.panels:
            if hasattr(cls, "poll") and not cls.poll(context):
                continue
            drawn = type("Drawn", (), {"layout": drawing.Recorder([]), "prepare": getattr(cls, "prepare", None)})()
            cls.draw(drawn, context)
        written = self.errors.getvalue()
        if "Traceback" in written:
            raise Broken(written)

    # Actions

    def face(self) -> int:
        obj = bpy.context.view_layer.objects.active
        count = len(obj.data.polygons) if obj is not None and obj.type == "MESH" else 10
        return self.random.choice(
            (-1, -1, 0, max(0, count - 1), count + 3, *(self.random.randrange(max(1, count)),) * 6)
        )

    def value(self, prop, name: str):
        """A random value of a setting; None to leave it out."""
        pick = self.random
        if name in ("face", "other"):
            return self.face()
        if name == "painted":
            own = (
                f"{self.face()}:{','.join(str(max(0, self.face())) for _ in range(pick.randint(1, 9)))}"
                for _ in range(2)
            )
            return pick.choice(("", "x", ";".join(own)))
        if name == "filepath":
            return str(self.folder / pick.choice(("a.json", "b.json", "none/c.json")))
        if name == "directory":
            return str(self.folder / pick.choice(("", "reports", "none", "a.json")))
        if name == "recipe":
            return pick.choice((*GARBAGE, self.recipe()))
        if prop.type == "BOOLEAN":
            return pick.random() < 0.5
        if prop.type == "ENUM":
            return pick.choice([item.identifier for item in prop.enum_items])
        if prop.type in ("INT", "FLOAT"):
            low, high = max(prop.soft_min, -5), min(prop.soft_max, 64 if prop.type == "INT" else 10.0)
            draw = pick.randint if prop.type == "INT" else pick.uniform
            ends = (prop.default, low, high)
            one = lambda: pick.choice((*ends, *(draw(low, max(low, high)) for _ in range(4))))  # noqa: E731
            if getattr(prop, "is_array", False):
                return [
                    draw(low, high) if prop.type == "INT" else pick.uniform(-1, 1) for _ in range(prop.array_length)
                ]
            return (int if prop.type == "INT" else float)(one())
        if prop.type == "STRING":
            return pick.choice(("", "Density", "UV", "none"))
        return None

    def recipe(self) -> str:
        store = sys.modules["isimp.blender.scene.store"]
        obj = bpy.context.view_layer.objects.active
        found = store.load(obj) if obj is not None and obj.type == "MESH" else None
        return found.to_json() if found else GARBAGE[-1]

    def press(self) -> None:
        """Runs any operator with any settings; common operators are more frequent."""
        usual = (
            "partition",
            "mesh",
            "partition",
            "add_proxy",
            "delete_proxy",
            "split",
            "merge",
            "swap",
            "grow",
            "texture",
        )
        name = self.random.choice((*usual, *self.operators))
        if self.random.random() < 0.8:
            self.come_back()
        call = getattr(bpy.ops.isimp, name)
        settings = {}
        for prop in call.get_rna_type().properties:
            if prop.identifier != "rna_type" and self.random.random() < (
                0.8 if name not in ("partition", "mesh") else 0.2
            ):
                value = self.value(prop, prop.identifier)
                if value is not None and not prop.is_readonly:
                    settings[prop.identifier] = value
        if name == "partition" and "proxies" not in settings and self.random.random() < 0.7:
            settings |= {"proxies": self.random.choice((1, 4, 9, 30)), "count_by": "proxies"}
        if name == "texture":
            settings |= {"size": self.random.choice((16, 32)), "tiles": 0}
        self.note(f"isimp.{name}", settings)
        if call("EXEC_DEFAULT", True, **settings) == {"FINISHED"}:
            bpy.ops.ed.undo_push(message=name)

    def come_back(self) -> None:
        """Selects a mesh, and a mode that the add-on works in."""
        active, there = bpy.context.view_layer.objects.active, bpy.context.view_layer.objects
        if bpy.context.mode not in ("OBJECT", "EDIT_MESH"):
            bpy.ops.object.mode_set(mode="OBJECT")
        meshes = [obj for obj in there if obj.type == "MESH"]
        if (active is None or active.type != "MESH") and meshes:
            self.activate(self.random.choice(meshes))

    def mode(self) -> None:
        wanted = self.random.choice(("OBJECT", "OBJECT", "EDIT", "EDIT", "SCULPT", "WEIGHT_PAINT", "VERTEX_PAINT"))
        self.note("mode", wanted)
        active = bpy.context.view_layer.objects.active
        if active is None or active.type != "MESH" or not active.visible_get():
            return
        bpy.ops.object.mode_set(mode=wanted)
        bpy.ops.ed.undo_push(message="mode")

    def select(self) -> None:
        """No face, one, some or all."""
        obj, how = bpy.context.view_layer.objects.active, self.random.choice(("none", "one", "some", "all"))
        self.note("select", how)
        if obj is None or obj.type != "MESH":
            return
        count, share = len(obj.data.polygons), {"none": 0.0, "one": 0.0, "some": 0.1, "all": 1.0}[how]
        chosen = np.array([self.random.random() < share for _ in range(count)], bool)
        if how == "one" and count:
            chosen[self.random.randrange(count)] = True
        if obj.mode in ("OBJECT", "EDIT"):
            sys.modules["isimp.blender.scene.selection"].select_polygons(obj, chosen)
        bpy.ops.ed.undo_push(message="select")

    def turn_to(self) -> None:
        """Makes another object active, or none."""
        there = [obj.name for obj in bpy.context.view_layer.objects]
        name = self.random.choice([*there, *there, ""])
        self.note("activate", name)
        if bpy.context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        self.activate(bpy.data.objects.get(name))
        bpy.ops.ed.undo_push(message="activate")

    def objects(self) -> None:
        """A user's handling of objects: copies, new names, hiding, deleting results, empties."""
        how = self.random.choice(("duplicate", "link", "rename", "hide", "show", "delete", "empty", "move", "edit"))
        obj = bpy.context.view_layer.objects.active
        self.note("object", [how, obj.name if obj else None])
        if bpy.context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        is_scan = obj is not None and obj.type == "MESH" and obj.data.name in self._known
        if how == "empty":
            bpy.context.scene.collection.objects.link(bpy.data.objects.new("Empty", None))
        elif obj is None:
            return
        elif how in ("duplicate", "link"):
            if len(bpy.data.objects) < 8:
                bpy.ops.object.duplicate(linked=how == "link")
        elif how == "rename":
            obj.name = self.random.choice(("Ä" * 40, "other", "roof", "a.simplified"))
        elif how in ("hide", "show"):
            obj.hide_set(how == "hide")
        elif how == "delete" and not is_scan:
            bpy.data.objects.remove(obj)
        elif how == "move":
            obj.location.x += 1
        elif how == "edit" and obj.type == "MESH" and not is_scan and len(obj.data.vertices):
            obj.data.vertices[0].co.x += 0.1
        bpy.context.view_layer.update()
        bpy.ops.ed.undo_push(message="object")

    def set(self) -> None:
        """A setting of the panel; then the work of the timer."""
        panel = bpy.context.window_manager.isimp
        groups = [panel] + [
            getattr(panel, p.identifier)
            for p in panel.bl_rna.properties
            if p.type == "POINTER" and p.identifier != "rna_type"
        ]
        group = self.random.choice(groups)
        kinds = [p for p in group.bl_rna.properties if not p.is_readonly and p.identifier not in ("rna_type", "name")]
        if not kinds:
            return
        prop = self.random.choice(kinds)
        value = self.value(prop, prop.identifier)
        self.note("set", [type(group).__name__, prop.identifier, value])
        if value is not None:
            setattr(group, prop.identifier, value)
        if self.random.random() < 0.5:
            self.settle()

    def settle(self) -> None:
        live = sys.modules["isimp.blender.scene.runtime"].get().live
        live.pending = True
        if sys.modules["isimp.blender.work.live"]._find(bpy.context) is None:
            live.pending = False
            return
        self.note("settle", None)
        if bpy.ops.isimp.settle("EXEC_DEFAULT", True) == {"FINISHED"}:
            bpy.ops.ed.undo_push(message="settle")

    def undo(self) -> None:
        self.note("undo", None)
        bpy.ops.ed.undo()

    def redo(self) -> None:
        self.note("redo", None)
        bpy.ops.ed.redo()

    def reopen(self) -> None:
        self.note("reopen", None)
        if bpy.context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        path = str(self.folder / "file.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path)
        bpy.ops.wm.open_mainfile(filepath=path)
        bpy.ops.ed.undo_push(message="reopened")

    def restart(self) -> None:
        self.note("begin", None)
        self.begin()

    def note(self, name: str, more) -> None:
        self._last = f"{name} {json.dumps(more, default=str)}"
        self.done[name] = self.done.get(name, 0) + 1
        with self.log.open("a") as log:
            log.write(f"{self._last}\n")

    def run(self, actions: int, limit: int = 5) -> list:
        """[(number, action, failure)]; stops after `limit` of them."""
        broken = []
        verbs = {self.press: 60, self.mode: 6, self.select: 8, self.turn_to: 5, self.objects: 5, self.set: 8}
        verbs |= {self.undo: 6, self.redo: 3, self.reopen: 0.5, self.restart: 1.5}
        self.begin()
        kept, sys.stderr = sys.stderr, self.errors
        try:
            for number in range(actions):
                faulthandler.dump_traceback_later(SLOW, exit=True, file=kept)
                (verb,) = self.random.choices(list(verbs), list(verbs.values()))
                why = self._tried(verb)
                if why:
                    broken.append((number, self._last, why))
                    self.errors.truncate(0)
                    if len(broken) >= limit:
                        break
                    self.begin()
        finally:
            faulthandler.cancel_dump_traceback_later()
            sys.stderr = kept
        return broken

    def _tried(self, verb) -> str:
        """The failure; empty if there is none."""
        try:
            try:
                verb()
            except RuntimeError as error:
                if "Traceback" in str(error) or "Internal error" in str(error):
                    return str(error)
                self.refused += 1
            self.check()
        except Broken as error:
            return str(error)
        except Exception:  # noqa: BLE001  (all that is no refusal is a failure)
            return traceback.format_exc()
        return ""


def main(words=None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("files", nargs="*", type=Path, help="scans to take too, besides the ten that are made here")
    parser.add_argument("--actions", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--log", type=Path, default=Path(tempfile.gettempdir()) / "isimp-monkey.log")
    options = parser.parse_args(words)
    import isimp

    isimp.register()
    options.log.unlink(missing_ok=True)
    monkey = Monkey(options.seed, options.log, options.files)
    broken = monkey.run(options.actions)
    for number, action, why in broken:
        print(f"\n{number}: {action}\n{why}")
    counts = ", ".join(f"{name} {count}" for name, count in sorted(monkey.done.items()))
    print(f"\n{sum(monkey.done.values())} actions, {monkey.refused} refused, {len(broken)} broke something\n{counts}")
    return 1 if broken else 0


if __name__ == "__main__":
    code = main(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else None)
    sys.stdout.flush()
    os._exit(code)
