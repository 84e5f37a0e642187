"""Operators for recipes as JSON: export, import, copy, paste and replay."""

from contextlib import suppress
from pathlib import Path

import bpy
from bpy.props import BoolProperty, StringProperty

from ... import messages
from ...engine import engine
from ...language import said
from ...recipe import Recipe
from ...session import placed, with_places
from .. import reading
from ..scene import mesh_io, store, targets
from ..work.modal import RecipeOperator
from .files import Writes

_FILTER = {"default": "*.json", "options": {"HIDDEN"}}


class ISIMP_OT_replay(RecipeOperator, bpy.types.Operator):
    """Apply a recipe to the active scan. It replaces the present steps"""

    bl_idname = "isimp.replay"
    bl_label = "Replay Recipe"
    adjusted = ("strict",)

    recipe: StringProperty(name="Recipe", description="The steps as JSON text, as written by Copy or Export")
    strict: BoolProperty(
        name="All or Nothing", description="If a step fails, change nothing. If off, the failed step is marked"
    )

    names_steps = True

    @property
    def keeps_failed(self):
        return not self.strict

    @classmethod
    def problem(cls, context, scan):
        return ""

    def wanted(self, context, target):
        recipe = Recipe.from_json(self.recipe)
        if not recipe.active():
            raise ValueError(said("The recipe has no active step."))
        self._lost, self._gone = 0, recipe.gone
        if recipe.places is not None:
            recipe, self._lost = placed(reading.read(context, target.scan), recipe)
        return recipe

    def warnings(self, context, scan, before):
        return [*self._gone, *([messages.lost(self._lost)] if self._lost else [])]

    def told(self, before, numbers):
        return messages.partitioned(numbers)


class _HasRecipe:
    """Mixin of operators that read the active scan's recipe."""

    @classmethod
    def poll(cls, context):
        return targets.allows(cls, context, targets.needs_steps)

    @staticmethod
    def text(context):
        scan = targets.find(context)[0]
        recipe = store.load(scan)
        with suppress(mesh_io.Unusable):  # the faces then have their numbers alone
            if recipe.faces():
                recipe = with_places(reading.read(context, scan), recipe)
        return recipe.to_json(indent=2) + "\n"


def _without_kind(told: str) -> str:
    """Return an operator's report without the prefix "Error", which Blender adds in the language of the interface."""
    words = bpy.app.translations
    for kind in {"Error", words.pgettext_iface("Error"), words.pgettext_tip("Error")}:
        told = told.removeprefix(f"{kind}: ")
    return told


class _TakesRecipe:
    """Mixin of operators that pass a recipe to Replay."""

    @classmethod
    def poll(cls, context):
        return targets.allows(cls, context)

    def replay(self, recipe):
        try:
            done = bpy.ops.isimp.replay("INVOKE_DEFAULT", True, recipe=recipe)
        except RuntimeError as error:
            self.report({"ERROR"}, _without_kind(str(error).strip()))
            return {"CANCELLED"}
        except (TypeError, ValueError):  # Blender can't pass it as a property
            self.report({"ERROR"}, said("Not a recipe: it is not text."))
            return {"CANCELLED"}
        return {"CANCELLED"} if done == {"RUNNING_MODAL"} else done


class ISIMP_OT_recipe_copy(_HasRecipe, bpy.types.Operator):
    """Copy the recipe to the clipboard as JSON text, for another scan or a message"""

    bl_idname = "isimp.recipe_copy"
    bl_label = "Copy Recipe"

    def execute(self, context):
        context.window_manager.clipboard = self.text(context)
        self.report({"INFO"}, said("Recipe copied."))
        return {"FINISHED"}


class ISIMP_OT_recipe_paste(_TakesRecipe, bpy.types.Operator):
    """Apply the recipe in the clipboard to the active scan. It replaces the present steps"""

    bl_idname = "isimp.recipe_paste"
    bl_label = "Paste Recipe"

    def execute(self, context):
        text = context.window_manager.clipboard
        if not text.lstrip().startswith("{"):
            self.report({"ERROR"}, said("The clipboard holds no recipe: press Copy on another scan first."))
            return {"CANCELLED"}
        return self.replay(text)


class ISIMP_OT_recipe_export(_HasRecipe, Writes, bpy.types.Operator):
    """Write the recipe to a JSON file, for other scans or for examples/batch.py"""

    bl_idname = "isimp.recipe_export"
    bl_label = "Export Recipe"

    filepath: StringProperty(subtype="FILE_PATH")
    filter_glob: StringProperty(**_FILTER)

    def invoke(self, context, event):
        self.filepath = f"{targets.find(context)[0].name}.json"
        return super().invoke(context, event)

    def check(self, context):
        """Adds the ending to the name in the dialog, so that Blender warns if that file exists."""
        named = self.filepath
        if bpy.path.basename(named):
            self.filepath = bpy.path.ensure_ext(named, ".json")
        return self.filepath != named

    def written(self, context):
        path = Path(bpy.path.abspath(self.filepath))
        if not path.name:
            raise ValueError(said("No file is named: enter a name."))
        if path.suffix.lower() != ".json":
            path = path.with_name(f"{path.name}.json")
        try:
            with engine.drafts.whole(path) as draft:
                draft.write_text(self.text(context), encoding="utf-8")
        except OSError as error:
            raise ValueError(said("'{path}' can't be written: {why}.", path=path, why=error.strerror)) from None
        return said("Recipe written to '{path}'.", path=path)


class ISIMP_OT_recipe_import(_TakesRecipe, bpy.types.Operator):
    """Apply a recipe from a JSON file to the active scan. It replaces the present steps"""

    bl_idname = "isimp.recipe_import"
    bl_label = "Import Recipe"

    filepath: StringProperty(subtype="FILE_PATH")
    filter_glob: StringProperty(**_FILTER)

    def invoke(self, context, event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        path = Path(bpy.path.abspath(self.filepath))
        try:
            recipe = path.read_text(encoding="utf-8-sig")
        except (OSError, UnicodeDecodeError) as error:
            why = getattr(error, "strerror", None) or said("it is not text")
            self.report({"ERROR"}, said("'{path}' can't be read: {why}.", path=path, why=why))
            return {"CANCELLED"}
        return self.replay(recipe)


CLASSES = (
    ISIMP_OT_replay,
    ISIMP_OT_recipe_copy,
    ISIMP_OT_recipe_paste,
    ISIMP_OT_recipe_export,
    ISIMP_OT_recipe_import,
)
