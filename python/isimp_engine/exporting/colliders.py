"""Files of convex parts, with names that games and simulations know."""

import re
from collections.abc import Sequence
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

from .._core import FileError
from ..convex import NAMES, Convex
from ..surfaces import far_from_zero

Named = Sequence[tuple[str, Convex]]


def _obj(draft: Path, name: str, parts: Named) -> None:
    lines, first = [f"# {name}: convex parts by isimp"], 1
    for title, part in parts:
        lines.append(f"o {title}")
        lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in part.vertices.tolist()]
        lines += [f"f {a} {b} {c}" for a, b, c in (part.triangles + first).tolist()]
        first += len(part.vertices)
    draft.write_text("\n".join([*lines, ""]), encoding="utf-8")


def _glb(draft: Path, name: str, parts: Named) -> None:
    from ..texturing.glb import nodes  # reads the table of formats itself

    draft.write_bytes(nodes(draft, [(title, part.vertices, part.triangles) for title, part in parts]))


def _mjcf(draft: Path, name: str, parts: Named) -> None:
    """A model of MuJoCo: one body with a geom for each part."""
    meshes, geoms = [], []
    for title, part in parts:
        points = " ".join(repr(x) for x in part.vertices.ravel().tolist())
        corners = " ".join(str(i) for i in part.triangles.ravel().tolist())
        meshes.append(f'    <mesh name={quoteattr(title)} vertex="{points}" face="{corners}"/>')
        geoms.append(f'      <geom name={quoteattr(title)} type="mesh" mesh={quoteattr(title)}/>')
    lines = [
        f"<mujoco model={quoteattr(name)}>",
        "  <asset>",
        *meshes,
        "  </asset>",
        "  <worldbody>",
        f"    <body name={quoteattr(name)}>",
        *geoms,
        "    </body>",
        "  </worldbody>",
        "</mujoco>",
        "",
    ]
    draft.write_text("\n".join(lines), encoding="utf-8")


def _usda(draft: Path, name: str, parts: Named) -> None:
    """A scene of USD as text: a mesh for each part that collides as its convex hull."""
    shift = far_from_zero(np.concatenate([part.vertices for _, part in parts]))  # `translate` has double precision
    move = ["xformOp:translate"] if shift.any() else []
    lines = [
        "#usda 1.0",
        "(",
        f'    defaultPrim = "{_prim(name)}"',
        "    metersPerUnit = 1",
        '    upAxis = "Z"',
        ")",
        f'def Xform "{_prim(name)}" {{',
        *(f"    double3 {word} = {tuple(shift.tolist())}" for word in move),
        *(f'    uniform token[] xformOpOrder = ["{word}"]' for word in move),
    ]
    for title, part in parts:
        points = ", ".join(f"({x!r}, {y!r}, {z!r})" for x, y, z in (part.vertices - shift).tolist())
        lines += [
            f'    def Mesh "{_prim(title)}" (',
            '        prepend apiSchemas = ["PhysicsCollisionAPI", "PhysicsMeshCollisionAPI"]',
            "    ) {",
            '        uniform token physics:approximation = "convexHull"',
            '        uniform token subdivisionScheme = "none"',
            f"        point3f[] points = [{points}]",
            f"        int[] faceVertexCounts = {[3] * len(part.triangles)}",
            f"        int[] faceVertexIndices = {part.triangles.ravel().tolist()}",
            "    }",
        ]
    draft.write_text("\n".join([*lines, "}", ""]), encoding="utf-8")


def _prim(title: str) -> str:
    """A name that USD allows: ASCII letters, digits and underscores, no digit first."""
    return re.sub(r"^(?=\d)", "_", re.sub(r"[^A-Za-z0-9_]", "_", title))


_WRITERS = {".obj": _obj, ".glb": _glb, ".xml": _mjcf, ".usda": _usda}
KINDS = tuple(_WRITERS)  #: endings of such files


def write(draft: Path, name: str, parts: Sequence[Convex], names: str, like: Path) -> None:
    """Write parts. names: one of `convex.NAMES`. like: the file, whose ending is its kind; `draft` may have another.

    Raises FileError (another ending).
    """
    writer = _WRITERS.get(like.suffix.lower())
    if writer is None:
        raise FileError(f"{like}: must end in one of {', '.join(KINDS)}")
    writer(draft, name, [(NAMES[names](name, number), part) for number, part in enumerate(parts)])
