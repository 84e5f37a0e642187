"""Compares a scan with its result: the viewports show the scan left of a line and the result right of it.

Both objects are hidden during the comparison. Their triangles are copied to the graphics card once; after that, a move
of the line or of the view costs one redraw. Images are drawn too, so textures can be compared.
"""

from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property

import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader
from mathutils import Matrix

from ... import messages
from ..drawing import shaders, sketches
from ..drawing.space import ON, Over
from ..scene import mesh_io, runtime
from ..texts import viewport_text
from ..texturing import materials, texture
from . import overlay

LOOKS = ("PLAIN", "REGIONS", "TEXTURE")
_GREY = 0.8
_WHITE, _DARK = (1.0, 1.0, 1.0, 0.9), (0.02, 0.02, 0.02, 0.9)
_HANDLE = 9  # half the size of the grip in the middle of the line, pixels


@dataclass
class Side:
    """One of the two objects: arrays, and batches made at the first draw. Points are relative to `origin`."""

    label: str
    place: np.ndarray  #: (4, 4) from the points' space to the world
    origin: np.ndarray  #: (3,)
    points: np.ndarray  #: (3 T, 3) float32
    color: np.ndarray  #: (3 T, 4) uint8, linear
    uv: np.ndarray | None = None  #: (3 T, 2) float32, if it is drawn with images
    slots: np.ndarray | None = None  #: (T,) the material of each triangle
    images: list = field(default_factory=list)  #: names of the images of the materials; "" for none
    lines: np.ndarray = field(default_factory=lambda: np.empty((0, 3), np.float32))
    batches: dict = field(default_factory=dict)


class _Before:
    """The hidden, selected and active objects of a view layer before a comparison."""

    def __init__(self, context, objects):
        self._layer, there = context.view_layer, context.view_layer.objects
        self._hidden = [(obj, obj.hide_get()) for obj in objects if obj.name in there]
        self._selected, self._active = list(context.selected_objects), there.active

    def hide(self) -> None:
        for obj, _ in self._hidden:
            obj.hide_set(True, view_layer=self._layer)

    def give_back(self) -> None:
        with suppress(ReferenceError, RuntimeError):  # another file was opened, or an object was deleted
            for obj, hidden in self._hidden:
                obj.hide_set(hidden, view_layer=self._layer)
            for obj in self._selected:
                obj.select_set(True, view_layer=self._layer)
            self._layer.objects.active = self._active


class Comparison:
    """The compared objects, their look, and the place of the line as a share of the viewport's width."""

    def __init__(self, context, scan, result):
        self.names = scan.name, result.name
        self.looks = looks_of(scan, result)
        self.look = self.looks[-1] if self.looks[-1] == "TEXTURE" else "PLAIN"
        self.share = 0.5
        self.handles = ()
        self._before = _Before(context, (scan, result))
        self._arrays = [mesh_io.read(context, obj) for obj in (scan, result)]
        self._sides = {}

    def begin(self) -> None:
        add = bpy.types.SpaceView3D.draw_handler_add
        self.handles = (add(_draw, (), "WINDOW", "POST_VIEW"), add(_draw_line, (), "WINDOW", "POST_PIXEL"))
        self._before.hide()

    def end(self) -> None:
        for handle in self.handles:
            bpy.types.SpaceView3D.draw_handler_remove(handle, "WINDOW")
        self._before.give_back()

    @cached_property
    def _color(self) -> np.ndarray:
        return _region_colors(bpy.data.objects[self.names[0]])

    def stands(self) -> bool:
        """Return whether both objects exist."""
        return all(name in bpy.data.objects for name in self.names)

    def sides(self) -> list:
        if self.look not in self._sides:
            self._sides[self.look] = [self._side(number) for number in (0, 1)]
        return self._sides[self.look]

    def _side(self, number: int) -> Side:
        obj, arrays = bpy.data.objects[self.names[number]], self._arrays[number]
        corners = arrays.triangles.ravel()
        origin = arrays.vertices[0].astype(np.float64).round()
        made = Side(
            messages.compared(number == 1, arrays.face_count),
            mesh_io.place_matrix(obj),
            origin,
            (arrays.vertices - origin).astype(np.float32)[corners],
            self._colors(obj, arrays),
        )
        if self.look == "TEXTURE" and texture.is_textured(obj):
            layer = next(layer for layer in obj.data.uv_layers if layer.active_render)
            _take_texture(made, obj, layer, arrays)
        if number == 1:
            made.lines = _edges(obj.data, arrays, origin)
        return made

    def _colors(self, obj, arrays) -> np.ndarray:
        """Return (3 T, 4) uint8 the colours of the corners."""
        grey = np.array([int(255 * _GREY)] * 3 + [255], np.uint8)
        if self.look != "REGIONS" or not len(self._color):
            return np.broadcast_to(grey, (3 * len(arrays.triangles), 4)).copy()
        region = mesh_io.read_layer(obj.data, mesh_io.REGION)
        known = (region >= 0) & (region < len(self._color))
        face = np.where(known[:, None], self._color[np.clip(region, 0, len(self._color) - 1)], grey)
        return np.repeat(face[arrays.triangle_face], 3, axis=0).astype(np.uint8)


def looks_of(scan, result) -> tuple:
    """Return the available looks: TEXTURE only if both objects have one."""
    textured = texture.is_textured(scan) and not mesh_io.has_modifiers(scan) and texture.is_textured(result)
    return LOOKS if textured else LOOKS[:2]


def _region_colors(scan) -> np.ndarray:
    """Return (R, 4) uint8 the colour of each region of a scan."""
    mesh = scan.data
    layer = mesh.color_attributes.get(mesh_io.COLOR)
    if layer is None or layer.domain != "CORNER" or layer.data_type != "FLOAT_COLOR":
        return np.empty((0, 4), np.uint8)
    region = mesh_io.read_regions(scan)
    color, start = np.empty(4 * len(mesh.loops), np.float32), np.empty(len(mesh.polygons), np.int32)
    layer.data.foreach_get("color", color)
    mesh.polygons.foreach_get("loop_start", start)
    made = np.zeros((int(region.max(initial=0)) + 1, 4), np.uint8)
    inside = np.flatnonzero(region >= 0)
    made[region[inside]] = (255 * color.reshape(-1, 4)[start[inside]]).round()
    return made


def _take_texture(side: Side, obj, layer, arrays) -> None:
    mesh = obj.data
    uv, slots = np.empty(2 * len(mesh.loops), np.float32), np.empty(len(mesh.polygons), np.int32)
    layer.data.foreach_get("uv", uv)
    mesh.polygons.foreach_get("material_index", slots)
    corners = np.arange(len(mesh.loops))
    if len(mesh.loops) != 3 * len(mesh.polygons):
        corners, _ = mesh_io.loop_triangles(mesh, "loops")
    side.uv = uv.reshape(-1, 2)[np.asarray(corners).ravel()]
    side.images = [materials.image_name(slot.material) for slot in obj.material_slots]
    side.slots = np.clip(slots, 0, len(side.images) - 1)[arrays.triangle_face]


def _edges(mesh, arrays, origin) -> np.ndarray:
    """Return (2 E, 3) the edges of a mesh, in the space of its arrays; empty if modifiers change its vertices."""
    if len(mesh.vertices) != len(arrays.vertices):
        return np.empty((0, 3), np.float32)
    ends = np.empty(2 * len(mesh.edges), np.int32)
    mesh.edges.foreach_get("vertices", ends)
    return (arrays.vertices[ends] - origin).astype(np.float32)


def start(context, scan, result) -> Comparison:
    made = runtime.get().comparison = Comparison(context, scan, result)
    made.begin()
    overlay.redraw()
    return made


def stop() -> None:
    """Ends the comparison, if there is one, and restores visibility and selection."""
    made, runtime.get().comparison = runtime.get().comparison, None
    if made is not None:
        made.end()
        overlay.redraw()


def _shown():
    made = runtime.get().comparison if runtime.get() is not None else None
    return made if made is not None and made.stands() else None


def _draw() -> None:
    context, made = bpy.context, _shown()
    if made is None:
        return
    edge = made.share * context.region.width
    for number, side in enumerate(made.sides()):
        obj = bpy.data.objects[made.names[number]]
        with Over(context.region_data, obj) as space, space.at(side.origin):
            space.nearer(0.0)
            gpu.state.depth_mask_set(True)
            light = _light(context.region_data, side.place)
            for name, shader in _surfaces(side):
                shader.bind()
                shader.uniform_float("light", light)
                shader.uniform_float("half_seen", (edge, 1.0 if number else -1.0))
                shaders.draw(side.batches[name], shader)
            gpu.state.depth_mask_set(False)
            if len(side.lines):
                space.nearer(ON)
                _draw_lines(side, edge, 1.0 if number else -1.0)


def _light(region_view, place) -> tuple:
    """Return the direction to the light in the space of the points, and -1 if that space is mirrored, else 1."""
    turn = Matrix(place[:3, :3].tolist())
    inwards = (region_view.view_matrix.to_3x3() @ turn).transposed()
    return (*(inwards @ shaders.LIGHT), -1.0 if turn.determinant() < 0 else 1.0)


def _surfaces(side: Side):
    """Yields names and shaders of the batches of a side; makes the batches at the first draw."""
    if side.uv is None:
        if "plain" not in side.batches:
            side.batches["plain"] = batch = gpu.types.GPUBatch(
                type="TRIS", buf=shaders.buffer("pos", "F32", 3, "FLOAT", side.points)
            )
            batch.vertbuf_add(shaders.buffer("color", "U8", 4, "INT_TO_FLOAT_UNIT", side.color))
        yield "plain", shaders.half_lit()
        return
    for slot, name in enumerate(side.images):
        if f"{slot}" not in side.batches:
            chosen = np.repeat(side.slots == slot, 3)
            if not chosen.any():
                continue
            side.batches[f"{slot}"] = batch = gpu.types.GPUBatch(
                type="TRIS", buf=shaders.buffer("pos", "F32", 3, "FLOAT", side.points[chosen])
            )
            batch.vertbuf_add(shaders.buffer("uv", "F32", 2, "FLOAT", side.uv[chosen]))
        shader, image = shaders.half_textured(), bpy.data.images.get(name)
        shader.bind()
        shader.uniform_sampler("image", gpu.texture.from_image(image) if image is not None else _no_image())
        yield f"{slot}", shader


def _no_image():
    """Return a texture of one grey pixel, for materials without an image."""
    known = runtime.get().shaders
    if "no_image" not in known:
        pixel = gpu.types.Buffer("FLOAT", 4, [_GREY] * 3 + [1.0])
        known["no_image"] = gpu.types.GPUTexture((1, 1), format="RGBA8", data=pixel)
    return known["no_image"]


def _draw_lines(side: Side, edge: float, which: float) -> None:
    shader = shaders.half_flat()
    if "lines" not in side.batches:
        side.batches["lines"] = batch_for_shader(shader, "LINES", {"pos": side.lines})
    shader.bind()
    shader.uniform_float("color", _DARK)
    shader.uniform_float("half_seen", (edge, which))
    shaders.draw(side.batches["lines"], shader)


def _draw_line() -> None:
    """Draws the line, its grip, and the names of both sides."""
    context, made = bpy.context, _shown()
    if made is None:
        return
    high, x = context.region.height, made.share * context.region.width
    scale = context.preferences.system.ui_scale
    grip, middle = _HANDLE * scale, high / 2
    corners = [(x - grip, middle), (x, middle + grip), (x + grip, middle), (x, middle - grip)]
    ring = [(*at, 0.0) for pair in zip(corners, corners[1:] + corners[:1], strict=True) for at in pair]
    gpu.state.blend_set("ALPHA")
    sketches.lines(np.array([(x, 0, 0), (x, high, 0)], np.float32), _DARK, 5.0 * scale)
    sketches.lines(np.array([(x, 0, 0), (x, high, 0)], np.float32), _WHITE, 2.0 * scale)
    sketches.lines(np.array(ring, np.float32), _WHITE, 2.5 * scale)
    gpu.state.blend_set("NONE")
    viewport_text.draw_beside(context, [side.label for side in made.sides()], x)
