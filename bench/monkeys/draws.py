"""Draws the parts of a case of the monkey at random: scans, damage, options, edits.

Options come from the engine's tables of options, and edits from its stubs: every public function of a mesh and a
partition that returns a partition. So a new option or edit is tried without a change here, except that an argument with
a new name needs a row in ARGUMENTS.
"""

import ast
import math
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import isimp_engine as engine
from bench.files import DATA, around
from bench.generators import known_shapes, round_shapes
from isimp_engine.recipe import COUNTS
from tests.shared import shapes

KINDS = (".ply", ".obj", ".stl", ".off")
LARGEST_FILE = 60 << 20  # bytes
MOST_EDITS = 8

Arrays = tuple[np.ndarray, np.ndarray]


# Scans


def ball(n: int) -> Arrays:
    """A sphere as a cube whose vertices were moved outwards: 12 n^2 faces."""
    vertices, triangles = shapes.cube(n)
    vertices = vertices - 0.5
    return vertices / np.linalg.norm(vertices, axis=1)[:, None], triangles


def can(around: int, rings: int) -> Arrays:
    """A closed cylinder with fans as caps."""
    turn = 2 * np.pi * np.arange(around) / around
    ring = np.stack([np.cos(turn), np.sin(turn), 0 * turn], 1)
    heights = np.linspace(0, 2, rings + 1)
    vertices = np.concatenate([ring + [0, 0, z] for z in heights] + [[[0, 0, 0], [0, 0, 2]]])
    j, k = np.arange(around), (np.arange(around) + 1) % around
    faces = []
    for i in range(rings):
        a, b = i * around + j, i * around + k
        faces += [np.stack([a, b, b + around], 1), np.stack([a, b + around, a + around], 1)]
    low, high, top = len(vertices) - 2, len(vertices) - 1, rings * around
    faces += [np.stack([0 * j + low, k, j], 1), np.stack([0 * j + high, top + j, top + k], 1)]
    return vertices, np.concatenate(faces).astype(np.int32)


def soup(rng) -> Arrays:
    """Few vertices, and any faces on them: folded, doubled, crossing."""
    vertices = rng.random((rng.integers(3, 60), 3))
    if rng.random() < 0.5:
        vertices = np.round(3 * vertices) / 3
    return vertices, rng.integers(0, len(vertices), (rng.integers(1, 90), 3)).astype(np.int32)


def holed_plate(rng) -> Arrays:
    solid = rng.random((*rng.integers(4, 11, 2), 1)) < rng.uniform(0.5, 0.95)
    solid[0] = True
    return shapes.voxels(solid, noise=rng.choice([0, 0.03]))


@cache
def known() -> list[Arrays]:
    return [(shape.vertices, shape.faces) for _, shape in known_shapes.base_shapes().values()]


def round_one(rng) -> Arrays:
    every = round_shapes.shapes() | round_shapes.extruded()
    return round_shapes.made(every[rng.choice(sorted(every))], int(rng.integers(14, 24)))


MADE = {
    "cube": lambda rng: shapes.cube(int(rng.integers(1, 9))),
    "ball": lambda rng: ball(int(rng.integers(1, 10))),
    "can": lambda rng: can(int(rng.integers(3, 33)), int(rng.integers(1, 9))),
    "torus": lambda rng: shapes.torus(int(rng.integers(4, 31)), int(rng.integers(3, 17))),
    "sheet": lambda rng: shapes.bumpy(int(rng.integers(2, 31))),
    "cubes": lambda rng: shapes.two_cubes(int(rng.integers(1, 6))),
    "pipe": lambda rng: shapes.bent_pipe(int(rng.integers(5, 60)), int(rng.integers(4, 25))),
    "figure": lambda rng: shapes.figure(int(rng.integers(4, 13))),
    "facade": lambda rng: shapes.facade(2, 2, noise=rng.choice([0, 0.05])),
    "voxels": lambda rng: shapes.voxels(rng.random((6, 6, 6)) < rng.uniform(0.2, 0.7)),
    "plate": holed_plate,
    "soup": soup,
    "known": lambda rng: known()[rng.integers(len(known()))],
    "round": round_one,
}


@cache
def files() -> list[Path]:
    """The scans of the data folder, in order; none where there is no such folder."""
    found = (path for path in sorted(DATA.rglob("*")) if path.suffix.lower() in KINDS)
    return [path for path in found if path.stat().st_size <= LARGEST_FILE]


def scan(rng, most: int, with_files: bool) -> tuple[str, np.ndarray, np.ndarray]:
    """A name, and vertices and triangles: of a file, or made."""
    name, arrays = "", None
    if with_files and files() and rng.random() < 0.5:
        path = files()[rng.integers(len(files()))]
        try:
            name, arrays = path.name, engine.read(path)
        except engine.InvalidInput:
            arrays = None
    if arrays is None:
        name = str(rng.choice([*sorted(MADE), "round", "round", "round"]))  # few options find round parts
        arrays = MADE[name](rng)
    vertices, triangles = np.array(arrays[0], float), np.array(arrays[1], np.int32)
    if len(triangles) > most:
        vertices, triangles = around(vertices, triangles, rng.integers(len(triangles)), most)
    for _ in range(rng.integers(0, 4)):
        damage = str(rng.choice(sorted(DAMAGE)))
        if len(triangles) and len(vertices):
            vertices, triangles = DAMAGE[damage](vertices, triangles, rng)
            name += f", {damage}"
    return name, vertices, triangles


def size_of(vertices: np.ndarray) -> float:
    known = vertices[np.isfinite(vertices).all(axis=1)]
    return float(np.linalg.norm(np.ptp(known, axis=0))) if len(known) else 0.0


def _turned(v, t, rng):
    some = rng.random(len(t)) < rng.choice([0.02, 0.5])
    return v, np.where(some[:, None], t[:, ::-1], t)


def _pinched(v, t, rng):
    """Two places share a vertex."""
    one, other = rng.integers(len(v), size=2)
    return v, np.where(t == one, other, t)


def _moved(v, t, rng):
    v = v.copy()
    v[rng.integers(len(v), size=2)] += rng.normal(size=(2, 3)) * size_of(v) * rng.choice([0.1, 100])
    return v, t


def _not_finite(v, t, rng):
    v = v.copy()
    v[rng.integers(len(v)), rng.integers(3)] = rng.choice([np.nan, np.inf])
    return v, t


def _rounded(v, t, rng):
    cell = size_of(v) / rng.choice([10, 40]) or 1.0
    return np.round(v / cell) * cell, t


FLAT = np.array([(1, 1, 0), (1, 0, 0), (0, 0, 0), (1, 1, 1e-9), (1, 1e-9, 1e-9), (1, 1, 0.01)])  # sheet, line, point
DAMAGE = {
    "without faces": lambda v, t, rng: (v, t[rng.random(len(t)) > rng.choice([0.01, 0.1, 0.5])]),
    "faces twice": lambda v, t, rng: (v, np.concatenate([t, t[rng.integers(len(t), size=3)]])),
    "faces turned": _turned,
    "pinched": _pinched,
    "vertices moved": _moved,
    "not finite": _not_finite,
    "crossed": lambda v, t, rng: (v, np.concatenate([t, rng.integers(0, len(v), (2, 3)).astype(np.int32)])),
    "noisy": lambda v, t, rng: (v + rng.normal(size=v.shape) * size_of(v) * rng.choice([1e-5, 1e-3, 1e-2]), t),
    "scaled": lambda v, t, rng: (v * 10.0 ** rng.integers(-6, 7), t),
    "far": lambda v, t, rng: (v + rng.normal(size=3) * size_of(v) * 10.0 ** rng.uniform(0, 6), t),
    "rotated": lambda v, t, rng: (v @ known_shapes.rotation(rng).T, t),
    "flattened": lambda v, t, rng: (v * FLAT[rng.integers(6)], t),
    "rounded": _rounded,
    "doubled": lambda v, t, rng: shapes.joined(
        (v, t), (v + rng.choice([0, 0.3, 2]) * size_of(v) * rng.normal(size=3), t)
    ),
    "apart": lambda v, t, rng: (v[t].reshape(-1, 3), np.arange(3 * len(t), dtype=np.int32).reshape(-1, 3)),
}


# Options


def value(option: dict[str, Any], rng, size: float, faces: int) -> Any:
    """A value of an option, by its row in the engine's table. size: of the scan, for lengths."""
    kind, default = option["type"].removesuffix(" | None"), option["default"]
    if option["type"].endswith("None") and rng.random() < 0.2:
        return None
    if "choices" in option:
        return str(rng.choice(option["choices"]))
    if kind == "bool":
        return bool(rng.random() < 0.5)
    if option["name"] == "backend":
        return str(rng.choice(engine.backends()))
    low, high = option.get("least", -math.inf), option.get("most", math.inf)
    if option["name"] == "proxies":
        return int(min(faces, 1 + 300 ** rng.random()))
    if kind == "int":
        drawn = round((default or 10) * 2.0 ** rng.uniform(-3, 2)) if rng.random() < 0.8 else max(low, 0)
        return int(min(max(drawn, low), high))
    if option.get("unit") == "length":
        drawn = size * 10.0 ** rng.uniform(-4, -0.5) if rng.random() < 0.9 else low
    elif rng.random() < 0.2:
        drawn = rng.choice([low, high if high <= 1 else low])
    else:
        drawn = (default or 0.1) * 2.0 ** rng.uniform(-3, 3)
    drawn = float(min(max(drawn, low), high))
    edge = (option.get("above_least") and drawn <= low) or (option.get("below_most") and drawn >= high)
    return default if edge else drawn


def options(kind: type, rng, size: float, faces: int, share: float = 0.25) -> Any:
    """Options of a class, a share of them drawn; at most one of the options that set the number of regions."""
    rows = kind.fields()
    counts = [row for row in rows if row["name"] in COUNTS]
    often = {row["name"]: 2 if row["type"] == "bool" else 1 for row in rows}  # a switch is turned half of the times
    drawn = [
        row for row in rows if row["name"] not in (*COUNTS, "threads") and rng.random() < share * often[row["name"]]
    ]
    if counts and rng.random() < 0.8:
        drawn.append(counts[rng.integers(len(counts))])
    values = {row["name"]: value(row, rng, size, faces) for row in drawn}
    return kind(**values | {row["name"]: 1 for row in rows if row["name"] == "threads"})


def scaled(given: Any, factor: float) -> Any:
    """The same options for a scan that is `factor` times as large."""
    values = given.as_dict()
    for row in type(given).fields():
        if row.get("unit") == "length" and values[row["name"]] is not None:
            values[row["name"]] *= factor
    return type(given)(**values)


# Edits

PARTITION = "partition_guided"  #: an edit that makes other regions of some faces, or of all that are not locked
ROUND_EDITS = ("set_segments", "release_round")  #: refused elsewhere, so drawn often where there are round parts


@dataclass(frozen=True)
class Edit:
    """A call of a function of a mesh and a partition."""

    name: str
    arguments: dict[str, Any] = field(default_factory=dict)

    def run(self, mesh: engine.Mesh, part: engine.Partition, factor: float = 1.0, job: Any = None) -> engine.Partition:
        """The new partition. factor: how many times as large the mesh is as the one that the edit was drawn for."""
        own = {name: self._scaled(name, each, factor) for name, each in self.arguments.items()}
        if self.name == PARTITION:
            guides = engine.guided.Guides(faces=own["faces"], before=part)
            return engine.guided.partition_guided(mesh, own["options"], job, guides)
        if job is not None and "job" in functions()[self.name]:
            own["job"] = job
        return getattr(engine, self.name)(mesh, part, **own)

    @staticmethod
    def _scaled(name: str, given: Any, factor: float) -> Any:
        if isinstance(given, (engine.RegulariseOptions, engine.PartitionOptions)):
            return scaled(given, factor)
        return given * factor if name in ("line", "length") and given is not None else given


@cache
def functions() -> dict[str, dict[str, str]]:
    """The functions of a mesh and a partition that return a partition: the types of their other arguments."""
    tree = ast.parse((Path(engine.__file__).parent / "_core.pyi").read_text())
    found = {}
    for node in tree.body:
        if not isinstance(node, ast.FunctionDef) or node.name.startswith("_") or len(node.args.args) < 2:
            continue
        types = [ast.unparse(each.annotation) for each in node.args.args if each.annotation]
        if types[:2] == ["Mesh", "Partition"] and ast.unparse(node.returns) == "Partition":
            found[node.name] = {each.arg: ast.unparse(each.annotation) for each in node.args.args[2:]}
    return found


class Place:
    """A face of a partition, and its surroundings."""

    def __init__(self, mesh: engine.Mesh, part: engine.Partition, rng) -> None:
        self.mesh, self.part, self.rng = mesh, part, rng
        self.label = np.asarray(part.face_region)
        self.face = self._any()
        self.size = mesh.report["diagonal"]

    def _any(self) -> int:
        """Any face, or as often one of any region: so small regions are met too. Often one of a round part."""
        regions, parts = self.part.region_count, self.part.curved
        if parts and self.rng.random() < 0.5:
            cells = parts[self.rng.integers(len(parts))]["regions"]
            return int(self.rng.choice(np.flatnonzero(np.isin(self.label, cells))))
        if self.rng.random() < 0.5 and regions:
            own = np.flatnonzero(self.label == self.rng.integers(regions))
            if len(own):
                return int(self.rng.choice(own))
        return int(self.rng.integers(len(self.label)))

    @property
    def across(self) -> np.ndarray:
        """The faces across an edge of the face's region, or of the face itself where it has no region."""
        pairs = neighbours(self.mesh)
        own = self.label == self.label[self.face]
        one, other = pairs[:, 0], pairs[:, 1]
        beside = np.concatenate([other[own[one] & ~own[other]], one[own[other] & ~own[one]]])
        return beside[self.label[beside] >= 0]

    def beside(self) -> int:
        found = self.across
        return int(self.rng.choice(found)) if len(found) and self.rng.random() < 0.95 else self._any()

    def blot(self) -> np.ndarray:
        """The face and others near it, or the faces of several regions."""
        if self.rng.random() < 0.3:
            return np.array([self.face, *(self.beside() for _ in range(self.rng.integers(0, 4)))])
        middle = np.asarray(self.mesh.vertices)[np.asarray(self.mesh.triangles)].mean(axis=1)
        near = np.argsort(np.linalg.norm(middle - middle[self.face], axis=1), kind="stable")
        return near[: self.rng.integers(1, 14)]

    def half(self) -> np.ndarray:
        """The faces on one side of the face."""
        middle = np.asarray(self.mesh.vertices)[np.asarray(self.mesh.triangles)].mean(axis=1) @ self.direction()
        return np.flatnonzero(middle <= middle[self.face])

    def line(self) -> np.ndarray:
        """Three points across the face."""
        at = np.asarray(self.mesh.vertices)[np.asarray(self.mesh.triangles)[self.face]].mean(axis=0)
        by = 0.05 * self.size * self.rng.normal(size=3)
        return np.stack([at - by, at + 0.1 * np.linalg.norm(by) * self.rng.normal(size=3), at + by])

    def direction(self) -> np.ndarray:
        return np.eye(3)[self.rng.integers(3)] if self.rng.random() < 0.5 else self.rng.normal(size=3)


#: how an argument is drawn, by its name
ARGUMENTS: dict[str, Any] = {
    "face": lambda at: at.face,
    "other": lambda at: at.beside(),
    "faces": lambda at: at.blot(),
    "onto": lambda at: at.beside() if at.rng.random() < 0.5 else None,
    "line": lambda at: at.line(),
    "direction": lambda at: at.direction() if at.rng.random() < 0.5 else None,
    "up_direction": lambda at: at.direction(),
    "rings": lambda at: int(at.rng.integers(1, 4)),
    "segments": lambda at: int(at.rng.integers(1, 25)),
    "times": lambda at: int(at.rng.integers(1, 4)),
    "strength": lambda at: float(at.rng.random()),
    "length": lambda at: at.size * 10.0 ** at.rng.uniform(-3, 1) if at.rng.random() < 0.7 else None,
    "box": lambda at: bool(at.rng.random() < 0.3),
    "kind": lambda at: [None, "cylinder", "cone", "sphere", "revolution", "extrusion"][at.rng.integers(6)],
    "options": lambda at: options(engine.RegulariseOptions, at.rng, at.size, len(at.label), 0.5),
}


def edit(mesh: engine.Mesh, part: engine.Partition, rng, name: str = "") -> Edit:
    """An edit at a face of a partition. name: which; empty: any."""
    if not name:
        name = str(rng.choice([*sorted(functions()), PARTITION]))
        if part.curved and rng.random() < 0.2:
            name = str(rng.choice(ROUND_EDITS))
    at, own = Place(mesh, part, rng), dict[str, Any]()
    if name == PARTITION:
        own["options"] = options(engine.PartitionOptions, rng, at.size, len(at.label))
        own["faces"] = at.half() if rng.random() < 0.7 else None
        return Edit(name, own)
    for argument, kind in functions()[name].items():
        if argument == "job":
            continue
        if kind.startswith("Literal["):
            own[argument] = str(rng.choice(ast.literal_eval(kind.removeprefix("Literal"))))
        else:
            own[argument] = ARGUMENTS[argument](at)
    return Edit(name, own)


def neighbours(mesh: engine.Mesh) -> np.ndarray:
    """(E, 2) the faces at each inner edge."""
    triangles = np.asarray(mesh.triangles)
    ends = np.sort(np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    face = np.tile(np.arange(len(triangles)), 3)
    order = np.lexsort(ends.T[::-1])
    same = (ends[order][1:] == ends[order][:-1]).all(axis=1)
    return np.stack([face[order][:-1][same], face[order][1:][same]], axis=1)


# Guides


def guides(mesh: engine.Mesh, rng) -> engine.guided.Guides:
    """Weights of the faces, and edges that no region crosses; often none."""
    count, found = len(mesh.triangles), dict[str, Any]()
    if rng.random() < 0.15:
        found["weights"] = np.where(rng.random(count) < 0.3, 0.0, rng.uniform(1, 100, count))
    for name in ("barriers", "cuts"):
        if rng.random() < 0.15:
            found[name] = edges(mesh, rng)
    return engine.guided.Guides(**found)


def edges(mesh: engine.Mesh, rng) -> np.ndarray:
    """(K, 2) a walk along edges, or edges anywhere."""
    triangles = np.asarray(mesh.triangles)
    if rng.random() < 0.5:
        some = triangles[rng.integers(len(triangles), size=max(1, int(len(triangles) * rng.choice([0.01, 0.3]))))]
        return some[:, :2]
    of = dict[int, list[int]]()
    for face in triangles.tolist():
        for k in range(3):
            of.setdefault(face[k], []).append(face[k - 1])
    path = [int(triangles[rng.integers(len(triangles)), 0])]
    for _ in range(40):
        path.append(int(rng.choice(of[path[-1]])))
    return np.array([path[:-1], path[1:]], np.int32).T
