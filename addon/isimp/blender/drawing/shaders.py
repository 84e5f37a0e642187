"""Shaders of the add-on: lit triangles, hatching, and halves of a viewport."""

import gpu
import numpy as np
from mathutils import Vector

from ..scene import runtime

_PLACE = """
void main() {
  seen = (ModelViewMatrix * vec4(pos, 1.0)).xyz;
  tint = color;
  gl_Position = ModelViewProjectionMatrix * vec4(pos, 1.0);
}
"""
# Approximates Blender's studio light.
_TO_LIGHT = (-0.25, 0.45, 0.85)  # in the coordinates of the view
_AMBIENT, _DIFFUSE = 0.19, 0.36
_SHADE = """
  FragColor = vec4(BASE.rgb * (AMBIENT + DIFFUSE * lit) + 0.04 * lit, 1.0);
}
"""
_LIT = (
    f"""
void main() {{
  vec3 normal = normalize(cross(dFdx(seen), dFdy(seen)));
  float lit = max(dot(normal, normalize(vec3{_TO_LIGHT})), 0.0);
"""
    + _SHADE
)
_FLAT_PLACE = """
void main() {
  gl_Position = ModelViewProjectionMatrix * vec4(pos, 1.0);
}
"""
# A dark and a light stripe next to each other are visible on every colour.
_HATCH = """
void main() {
  float at = mod(gl_FragCoord.x + gl_FragCoord.y, 14.0);
  if (at > 4.0) {
    discard;
  }
  FragColor = at < 2.0 ? vec4(0.0, 0.0, 0.0, 0.7) : vec4(1.0, 1.0, 1.0, 0.45);
}
"""
# Draws only one half of a viewport. half_seen: x of the dividing line, and -1 for the left half, 1 for the right.
_HALF = """
  if ((gl_FragCoord.x - half_seen.x) * half_seen.y < 0.0) {
    discard;
  }
"""
_HALF_PLACE = """
void main() {
  seen = pos;
  tint = color;
  gl_Position = ModelViewProjectionMatrix * vec4(pos, 1.0);
}
"""
_HALF_LIGHT = (
    """
void main() {
"""
    + _HALF
    + """
  vec3 normal = light.w * normalize(cross(dFdx(seen), dFdy(seen)));
  float lit = max(dot(normal, light.xyz), 0.0);
"""
    + _SHADE
)
_HALF_FLAT = "void main() {" + _HALF + "FragColor = color; }"
#: Direction to the light, in the coordinates of the view.
LIGHT = Vector(_TO_LIGHT).normalized()


def draw(batch, shader) -> None:
    """Draws a batch, in a separate function so that a benchmark can time it."""
    batch.draw(shader)


def buffer(name, kind, count, fetch, values):
    layout = gpu.types.GPUVertFormat()
    layout.attr_add(id=name, comp_type=kind, len=count, fetch_mode=fetch)
    buffer = gpu.types.GPUVertBuf(layout, len(values))
    buffer.attr_fill(name, values)
    return buffer


class Corners:
    """Corners of triangles, uploaded to the graphics card at the first draw."""

    def __init__(self, points: np.ndarray):
        """points: (3 T, 3) float32."""
        self._points, self._buffer = points, None

    def buffer(self):
        if self._buffer is None:
            self._buffer, self._points = buffer("pos", "F32", 3, "FLOAT", self._points), None
        return self._buffer


class Lit:
    """Lit triangles with a colour for each corner."""

    def __init__(self, corners: Corners, color: np.ndarray):
        """color: (3 T,) from view.PACKED."""
        self.corners, self.color = corners, color  #: color: None after the upload to the graphics card
        self._batch = None

    def draw(self) -> None:
        if self._batch is None:
            self._batch = gpu.types.GPUBatch(type="TRIS", buf=self.corners.buffer())
            values, self.color = self.color.view(np.uint8).reshape(-1, 4), None
            self._batch.vertbuf_add(buffer("color", "U8", 4, "INT_TO_FLOAT_UNIT", values))
        shader = lit()
        shader.bind()
        gpu.state.depth_mask_set(True)  # hides the far side of the triangles
        draw(self._batch, shader)
        gpu.state.depth_mask_set(False)


def lit():
    """Return the shader of lit triangles: (pos, color) for each corner."""
    known = runtime.get().shaders
    if "lit" not in known:
        info, between = gpu.types.GPUShaderCreateInfo(), gpu.types.GPUStageInterfaceInfo("isimp_lit")
        between.smooth("VEC3", "seen")
        between.flat("VEC4", "tint")
        info.push_constant("MAT4", "ModelViewProjectionMatrix")
        info.push_constant("MAT4", "ModelViewMatrix")
        info.vertex_in(0, "VEC3", "pos")
        info.vertex_in(1, "VEC4", "color")
        info.vertex_out(between)
        known["lit"] = _made(info, _PLACE, _shaded(_LIT, "tint", _AMBIENT, _DIFFUSE))
    return known["lit"]


def hatched():
    """Return the shader of hatched triangles (pos), with stripes of constant width on the screen."""
    known = runtime.get().shaders
    if "hatched" not in known:
        info = gpu.types.GPUShaderCreateInfo()
        info.push_constant("MAT4", "ModelViewProjectionMatrix")
        info.vertex_in(0, "VEC3", "pos")
        known["hatched"] = _made(info, _FLAT_PLACE, _HATCH)
    return known["hatched"]


def half_lit():
    """Return the shader like `lit` for one half of the viewport.

    half_seen: x of the dividing line, and -1 for the left half, 1 for the right. light: direction to the light in the
    space of the points, and -1 if that space is mirrored, else 1.
    """
    return _half("half_lit", "color", "VEC4", _HALF_PLACE, _shaded(_HALF_LIGHT, "tint", _AMBIENT, _DIFFUSE))


def half_textured():
    """Return the shader like `half_lit` with an image (pos, uv) in place of colours."""
    base = "texture(image, tint)"
    light = _shaded(_HALF_LIGHT, base, 0.35, 0.65)  # brighter: photographs are darker than the palette
    return _half("half_textured", "uv", "VEC2", _HALF_PLACE.replace("color", "uv"), light)


def _shaded(source: str, base: str, ambient: float, diffuse: float) -> str:
    return source.replace("BASE", base).replace("AMBIENT", f"{ambient}").replace("DIFFUSE", f"{diffuse}")


def _half(name: str, attribute: str, kind: str, place: str, color: str):
    known = runtime.get().shaders
    if name not in known:
        info, between = gpu.types.GPUShaderCreateInfo(), gpu.types.GPUStageInterfaceInfo(f"isimp_{name}")
        between.smooth("VEC3", "seen")
        between.smooth(kind, "tint")
        info.push_constant("MAT4", "ModelViewProjectionMatrix")
        info.push_constant("VEC4", "light")
        info.push_constant("VEC2", "half_seen")
        if attribute == "uv":
            info.sampler(0, "FLOAT_2D", "image")
        info.vertex_in(0, "VEC3", "pos")
        info.vertex_in(1, kind, attribute)
        info.vertex_out(between)
        known[name] = _made(info, place, color)
    return known[name]


def half_flat():
    """Return the shader of lines (pos) of one colour in one half of the viewport."""
    known = runtime.get().shaders
    if "half_flat" not in known:
        info = gpu.types.GPUShaderCreateInfo()
        info.push_constant("MAT4", "ModelViewProjectionMatrix")
        info.push_constant("VEC4", "color")
        info.push_constant("VEC2", "half_seen")
        info.vertex_in(0, "VEC3", "pos")
        known["half_flat"] = _made(info, _FLAT_PLACE, _HALF_FLAT)
    return known["half_flat"]


def _made(info, place, color):
    info.fragment_out(0, "VEC4", "FragColor")
    info.vertex_source(place)
    info.fragment_source(color)
    return gpu.shader.create_from_info(info)
