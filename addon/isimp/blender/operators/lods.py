"""Operator that makes all levels of detail of a scan, from coarse to fine, with their images and colliders."""

import dataclasses
from contextlib import contextmanager

import bpy
from bpy.props import BoolProperty, IntVectorProperty

from ... import recipe as rcp
from ...language import own, said
from ..controls import settings, up_direction
from ..scene import mesh_io, result, targets
from ..texturing import materials, texture
from ..work import scene_outcome
from ..work.modal import Aside
from ..work.target import Target
from .finish import COLLIDER, add_colliders, convex_parts, remove, remove_collider
from .mesh import Meshing

_DIGEST = "isimp_level"  # on a level: its digest after Mesh
_SMALLEST = 64  # pixels of an image


class ISIMP_OT_make_lods(Meshing, bpy.types.Operator):
    """Make all levels of detail as NAME_LOD0, NAME_LOD1 ..., each with images of half the size, and colliders"""

    bl_idname = "isimp.make_lods"
    bl_label = "Make LODs"
    adjusted = ("counts", "colliders")

    counts: IntVectorProperty(
        name="Polygons",
        description="Number of regions of each level, or of triangles if the panel counts these; 0: no such level",
        size=3,
        default=(300, 100, 33),
        min=0,
    )
    colliders: BoolProperty(
        name="Colliders",
        description="Convex parts of the coarsest level, named for Unreal after the finest one",
        default=True,
    )

    @classmethod
    def problem(cls, context, scan):
        return ""

    def _gather(self, context, first):
        super()._gather(context, first)
        wanted = sorted({count for count in self.counts if count}, reverse=True)
        self._levels = list(enumerate(wanted))  # the coarsest is made first, so that the finest is seen at the end
        self._made, self._size, self._ended, self._cuts = [], 0, 0, False
        if first.scan is not None and wanted:
            self._size = self._finest_image(context, first.scan)
        return first

    def _finest_image(self, context, scan) -> int:
        """Return the width of the finest level's image; 0 without a texture."""
        if not (self.keep_texture and texture.is_textured(scan)):
            return 0
        shown = targets.result_of(context.scene, scan)
        step = None if shown in dict(targets.levels(scan)).values() else texture.last_step(shown)
        images = [bpy.data.images.get(materials.image_name(slot.material)) for slot in scan.material_slots]
        widest = max((image.size[0] for image in images if image is not None), default=0)
        return step.size if step is not None and step.size else widest

    def wanted(self, context, target):
        if not self._levels:
            raise mesh_io.Unusable(said("Each level has 0 polygons: write at least one number."))
        level, count = self._levels[-1]
        names = [targets.named(target.scan.name, f"_LOD{number}") for number, _ in self._levels]
        for taken in filter(None, map(bpy.data.objects.get, names)):
            if targets.scan_of(taken) != target.scan:
                raise mesh_io.Unusable(said("{name} has the name of a level: rename it.", name=taken.name))
        step = settings.to_step(rcp.Partition, settings.group(context, rcp.Partition))
        by = "triangles" if step.count_by == "triangles" else "proxies"
        step = dataclasses.replace(step, count_by=by, **{by: count})
        before = rcp.Recipe() if targets.needs_regions(target.scan) else target.recipe
        if (last := before.whole()[1]) is not None:
            step = dataclasses.replace(step, keep_openings=last.keep_openings, more=last.more)
        recipe = before.then(step)
        if self.regularise:
            recipe = recipe.regularised(up_direction.first(context, target.scan))
        recipe = recipe.then(settings.to_step(rcp.Mesh, self))
        if self._size:
            recipe = recipe.then(rcp.Texture(size=max(_SMALLEST, self._size >> level)))
        return recipe

    def show(self, context, scan, work, outcome):
        former = self._former(scan)
        with _set_aside(former):
            kept = super().show(context, scan, work, outcome)
        level, _ = self._levels.pop()
        made = context.view_layer.objects.active
        for number, obj in former:
            scene_outcome.hide(context, obj)
            if number == level and not _removed(context, scan, number, obj):
                kept.append((obj.name, own("edited by hand")))
        made.name = made.data.name = targets.named(scan.name, f"_LOD{level}")
        self._made.append(made.name)
        made[_DIGEST] = made.isimp.made
        if level:  # the finest one stays the result
            made.isimp.made = targets.KEPT
        return kept

    def _former(self, scan) -> list:
        """Return [(number, object)] of the levels that an earlier press has made."""
        return [(number, obj) for number, obj in targets.levels(scan) if obj.name not in self._made]

    def _next_target(self, context):
        made = [bpy.data.objects.get(name) for name in self._made]
        scan = targets.scan_of(made[-1]) if made and made[-1] is not None else None
        if scan is None or len(self._made) == self._ended:  # the last level failed
            return None
        if not self._levels:
            self._cuts = self.colliders and not self._cuts and made[0] is not None
            return Target(context) if self._cuts else None
        self._ended = len(self._made)
        scene_outcome.bring_to_front(context, scan, made[-1])
        return Target(context)

    def _begin(self, context, target):
        """Begins a level, or the colliders after the last one."""
        if not self._cuts:
            return super()._begin(context, target)
        return Aside(target.scan, convex_parts(bpy.data.objects[self._made[0]]), self._show_colliders)

    def _show_colliders(self, context, parts):
        finest = bpy.data.objects.get(self._made[-1])
        if finest is not None:
            add_colliders(context, parts, finest, "unreal")
            for part in finest.children:  # their wires would cover the model
                part.hide_set(True)
        return {"FINISHED"}

    def _refuse(self, context, work, error):
        if work.end is None or not isinstance(error, ValueError):
            return super()._refuse(context, work, error)
        self.report({"WARNING"}, str(error))
        return {"FINISHED"}

    def _conclude(self, context, state):
        made = [bpy.data.objects[name] for name in self._made if name in bpy.data.objects]
        scan = targets.scan_of(made[-1]) if made and not self._levels else None
        if scan is not None:
            for number, obj in self._former(scan):
                _removed(context, scan, number, obj)
        self._done = []
        if made and not self._levels:
            counts = ", ".join(f"{len(obj.data.polygons):,}" for obj in reversed(made))
            self.report({"INFO"}, said(own("Levels of {counts} polygons"), counts=counts))
        return super()._conclude(context, state)


@contextmanager
def _set_aside(levels: list):
    """Mesh neither fills nor hides these levels meanwhile."""
    made = [(obj, obj.isimp.made) for _, obj in levels]
    for obj, _ in made:
        obj.isimp.made = targets.KEPT
    try:
        yield
    finally:
        for obj, before in made:
            obj.isimp.made = before


def _removed(context, scan, number: int, level) -> bool:
    """Removes a level of an earlier press with its colliders; returns False if an edited one got another name."""
    if level.get(_DIGEST) != result.digest(level):
        level.name, level.isimp.made = targets.named(scan.name, f"_LOD{number}.old"), targets.KEPT
        return False
    context.view_layer.update()  # for the places of its children
    for part in level.children:
        if part.get(COLLIDER):
            remove_collider(part)
        else:  # an object of the user
            place = part.matrix_world.copy()
            part.parent = None
            part.matrix_world = place
    remove(level)
    return True


CLASSES = (ISIMP_OT_make_lods,)
