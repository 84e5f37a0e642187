"""Long chains of edits: every promise holds after any order of edits, and memory does not grow.

ISIMP_SOAK_EDITS is the number of edits of each of three real scans (25).
"""

import os
from pathlib import Path

import numpy as np
import pytest

import isimp_engine as engine
import shapes

pytestmark = pytest.mark.slow

EDITS = int(os.environ.get("ISIMP_SOAK_EDITS", "25"))
SCANS = ["scan/rockerarm_20k.ply", "scan/bunny_69k.ply", "scan/armadillo_86k.ply"]


class Surface:
    """A mesh, and the data for the checks."""

    def __init__(self, mesh):
        self.mesh = mesh
        self.corners = mesh.vertices[mesh.triangles]
        cross = np.cross(self.corners[:, 1] - self.corners[:, 0], self.corners[:, 2] - self.corners[:, 0])
        doubled = np.linalg.norm(cross, axis=1)
        self.area = doubled / 2
        self.normal = cross / np.where(doubled > 0, doubled, 1)[:, None]
        self.middle = self.corners.mean(axis=1)
        self.pairs = self._pairs()

    def _pairs(self):
        """The faces on both sides of each inner edge."""
        t = self.mesh.triangles
        edges = np.sort(np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]]), axis=1).astype(np.int64)
        key = edges[:, 0] * (t.max() + 1) + edges[:, 1]
        order = np.argsort(key, kind="stable")
        same = np.flatnonzero(key[order][1:] == key[order][:-1])
        return order[same] % len(t), order[same + 1] % len(t)

    def pieces(self, label):
        """The number of connected pieces of faces of equal labels, without the faces that have no label."""
        a, b = self.pairs
        inside = (label[a] == label[b]) & (label[a] >= 0)
        a, b = a[inside], b[inside]
        name = np.arange(len(label))
        while len(a):
            low = np.minimum(name[a], name[b])
            np.minimum.at(name, name[a], low)
            np.minimum.at(name, name[b], low)
            while (name != name[name]).any():
                name = name[name]
            apart = name[a] != name[b]
            a, b = a[apart], b[apart]
        return len(np.unique(name[label >= 0]))

    def check(self, part):
        label, regions = part.face_region, part.region_count
        assert label.min() >= -1
        assert label.max() == regions - 1
        assert (np.bincount(label[label >= 0], minlength=regions) > 0).all()
        assert self.pieces(label) == regions
        np.testing.assert_array_equal(label[part.region_seed], np.arange(regions))
        assert part.region_normal.shape == (regions, 3)
        kept = label >= 0
        off = ((self.normal[kept] - part.region_normal[label[kept]]) ** 2).sum(axis=1)
        assert part.error == pytest.approx((self.area[kept] * off).sum(), rel=1e-4, abs=1e-6 * self.area.sum())
        assert len(part.region_locked) in (0, regions)


def near(surface, face, part, random):
    """A connected disc of faces around one."""
    size = np.sqrt(surface.area.sum()) * random.uniform(0.01, 0.06)
    disc = np.flatnonzero(np.linalg.norm(surface.middle - surface.middle[face], axis=1) < size)
    label = np.where(np.isin(np.arange(len(surface.middle)), disc) & (part.face_region >= 0), 0, -1)
    return disc if len(disc) and (label[disc] == 0).all() and surface.pieces(label) == 1 else np.array([face])


def line(surface, face, random):
    """A straight line over the surface near a face, and the viewing direction."""
    along = random.normal(size=3) * np.sqrt(surface.area.sum()) * 0.1
    return np.array([surface.middle[face] - along, surface.middle[face] + along]), surface.normal[face]


EDIT = {
    "add": lambda s, p, f, r: engine.add_proxy(s.mesh, p, f),
    "delete": lambda s, p, f, r: engine.delete_proxy(s.mesh, p, f),
    "paint": lambda s, p, f, r: engine.paint_faces(s.mesh, p, near(s, f, p, r)),
    "paint onto": lambda s, p, f, r: engine.paint_faces(s.mesh, p, near(s, f, p, r), f),
    "erase": lambda s, p, f, r: engine.erase_faces(s.mesh, p, near(s, f, p, r)),
    "lock": lambda s, p, f, r: engine.lock_regions(s.mesh, p, np.array([f])),
    "unlock": lambda s, p, f, r: engine.unlock_regions(s.mesh, p, np.flatnonzero(p.face_region >= 0)[::97]),
    "merge": lambda s, p, f, r: engine.merge_regions(s.mesh, p, f, neighbour(s, p, f)),
    "split": lambda s, p, f, r: engine.split_region(s.mesh, p, f),
    "cut": lambda s, p, f, r: engine.split_along(s.mesh, p, f, *line(s, f, r)),
    "grow": lambda s, p, f, r: engine.grow_region(s.mesh, p, f, int(r.integers(1, 4))),
    "shrink": lambda s, p, f, r: engine.shrink_region(s.mesh, p, f, int(r.integers(1, 4))),
    "worst": lambda s, p, f, r: engine.add_worst(s.mesh, p, 2),
    "least": lambda s, p, f, r: engine.delete_least(s.mesh, p, 2),
}
CHANGE_OF_COUNT = {"add": 1, "split": 1, "cut": 1, "worst": 2, "delete": -1, "merge": -1, "least": -2}


def neighbour(surface, part, face):
    """A face of a region adjacent to that of a face."""
    a, b = surface.pairs
    label = part.face_region
    beside = np.concatenate([b[label[a] == label[face]], a[label[b] == label[face]]])
    beside = beside[(label[beside] != label[face]) & (label[beside] >= 0)]
    return int(beside[0]) if len(beside) else face


def check_locks(kind, face, before, after):
    """Locked regions remain locked and unchanged, except that painting onto one may add faces."""
    if kind == "unlock":
        return
    target = before.face_region[face] if kind == "paint onto" else -1
    for region in np.flatnonzero(before.region_locked):
        faces = before.face_region == region
        now = after.face_region[faces]
        assert now.min() == now.max(), "a locked region was taken apart"
        assert after.region_locked[now[0]], "a locked region is not locked any more"
        gained = np.count_nonzero(after.face_region == now[0]) - np.count_nonzero(faces)
        assert gained == 0 or region == target, "a locked region has gained faces"


def resident_mb():
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def soak(surface, part, edits, seed):
    """Applies `edits` edits and checks after each. Returns memory at a tenth, the middle and the end, and counts."""
    random = np.random.default_rng(seed)
    names = sorted(EDIT)
    earlier = [part]  # partitions that undo can return to
    memory, done, refused = [], dict.fromkeys([*names, "undo"], 0), 0
    for number in range(edits):
        if number in (edits // 10, edits // 2):  # the first edits set up the kept data
            memory.append(resident_mb())
        kind, face = names[random.integers(len(names))], int(random.integers(len(surface.mesh.triangles)))
        if random.random() < 0.1:
            part = earlier[random.integers(len(earlier))]
            done["undo"] += 1
            continue
        try:
            after = EDIT[kind](surface, part, face, random)
        except engine.InvalidInput:
            refused += 1
            continue
        where = f"edit {number} of seed {seed}: {kind} at face {face}"
        try:
            surface.check(after)
            check_locks(kind, face, part, after)
            if kind in CHANGE_OF_COUNT:
                assert after.region_count == part.region_count + CHANGE_OF_COUNT[kind]
        except AssertionError as e:
            raise AssertionError(f"{where}: {e}") from e
        part = after
        done[kind] += 1
        earlier = [*earlier[-20:], part]
    memory.append(resident_mb())
    return memory, done, refused


def test_a_long_chain_of_edits_keeps_every_promise():
    mesh = engine.Mesh(*shapes.bumpy(40))
    part = engine.partition(mesh, engine.PartitionOptions(proxies=30))
    _, done, _ = soak(Surface(mesh), part, 400, seed=1)
    assert all(done.values()), f"some kind of edit was never done: {done}"


def test_edits_next_to_parts_that_were_left_out():
    vertices, triangles = shapes.joined(
        shapes.cube(8), shapes.torus(), (shapes.plane(1)[0] * 0.01 + 3, shapes.plane(1)[1])
    )
    mesh = engine.Mesh(vertices, triangles)
    part = engine.partition(mesh, engine.PartitionOptions(proxies=20))
    assert (part.face_region == -1).any()
    soak(Surface(mesh), part, 200, seed=2)


@pytest.mark.parametrize("scan", SCANS)
def test_real_scans(data, scan):
    mesh = engine.clean(*engine.read(data / scan))
    part = engine.partition(mesh, engine.PartitionOptions(proxies=200))
    memory, done, refused = soak(Surface(mesh), part, EDITS, seed=3)
    print(f"{scan}: {memory} MB at a tenth, the middle and the end; done {done}, refused {refused}")
    assert memory[2] < memory[1] * 1.05 + 10, f"memory grows: {memory} MB"
