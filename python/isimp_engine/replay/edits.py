"""How each step of a recipe after its partition changes the regions."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .. import recipe as rcp
from .._core import Cancelled, Job, Partition, RegulariseOptions
from ..snapping import snap_sizes
from . import smoothing
from .faces import Faces

Edit = Callable[[Any, Faces, Partition, Job | None], Partition]


def edited(kind: str, step: Any, faces: Faces, part: Partition, job: Job | None = None) -> Partition:
    """The partition after a step. kind: its name in EDITS, since the add-on has its own classes of steps.

    Raises InvalidInput, whose message may name faces of the mesh (see `Faces.named`), ValueError or Cancelled.
    """
    return EDITS[kind](step, faces, part, job)


def _upward(step: rcp.Regularise | rcp.AlignPlanes, faces: Faces, part: Partition) -> NDArray[np.float64] | None:
    """(3,) the up direction of a step; None if it has none."""
    if step.up == "none":
        return None
    if step.up == "region":
        if step.face < 0:
            raise ValueError("no region is chosen for the up direction: select a face and press Regularise")
        region = int(part.face_region[faces.triangle_at(step.face)])
        if region < 0:
            raise ValueError("the region for the up direction was left out: select another face")
        return np.asarray(_core.region_fits(faces.mesh, part)[0][region])
    if step.up == "scene":
        return np.array(step.direction or (0.0, 0.0, 1.0))
    return np.asarray(np.eye(3)["xyz".index(step.up)])


def _regularise(step: rcp.Regularise, faces: Faces, part: Partition, job: Job | None) -> Partition:
    up = _upward(step, faces, part)
    own = rcp.engine_options(step, rcp.REGULARISE) | {"up": "none" if up is None else "z"}
    part = _core.regularise(faces.mesh, part, RegulariseOptions(**own), job=job, up_direction=up)
    return snap_sizes(faces.mesh, part, step.snap_sizes, job=job) if step.snap_sizes else part


def _align(step: Any, faces: Faces, part: Partition, job: Job | None) -> Partition:
    up = _upward(step, faces, part)
    if up is None:
        if step.to in ("level", "upright"):
            raise ValueError("level and upright need an up direction: choose an axis for Up")
        up = np.array([0.0, 0.0, 1.0])
    chosen = np.array([faces.triangle_at(face) for face in step.faces])
    return _core.align_planes(faces.mesh, part, chosen, step.to, up, step.length or None, job=job)


def _paint(step: rcp.PaintFaces, faces: Faces, part: Partition, job: Job | None) -> Partition:
    onto = None if step.onto < 0 else faces.triangle_at(step.onto)
    part = _core.paint_faces(faces.mesh, part, faces.triangles_at(step.faces), onto, job=job)
    if not step.lock:
        return part
    return _core.lock_regions(faces.mesh, part, np.array([part.region_seed[-1] if onto is None else onto]))


def _erase(step: rcp.EraseFaces, faces: Faces, part: Partition, job: Job | None) -> Partition:
    """Erases faces, also from a locked region: the user chose them."""
    mesh, chosen, count = faces.mesh, faces.triangles_at(step.faces), part.region_count
    region = int(part.face_region[chosen[0]])
    locked = region >= 0 and bool(part.region_locked[region])
    if locked:
        part = _core.unlock_regions(mesh, part, chosen[:1])
    part = _core.erase_faces(mesh, part, chosen, job=job)
    if locked and part.region_count == count:  # the region still exists
        part = _core.lock_regions(mesh, part, np.flatnonzero(part.face_region == region)[:1])
    return part


def _smooth(step: rcp.SmoothFaces, faces: Faces, part: Partition, job: Job | None) -> Partition:
    """Smooths borders on the faces of the scan, then paints changed faces onto their new regions, one at a time.

    A stroke that begins in a locked region smooths that region too. Other locked regions stay unchanged.
    """
    mesh, count, label = faces.mesh, faces.count, faces.regions(part)
    faces.triangles_at(step.faces)  # raises if a face does not exist
    inside = np.zeros(count, bool)
    inside[list(step.faces)] = True
    inside &= faces.face_triangle >= 0
    joined = faces.joined(_core.barrier_faces(mesh, part))
    pairs = faces.pairs[joined]
    fixed, first = np.array(part.region_locked, bool), int(label[step.faces[0]])
    locked = first >= 0 and bool(fixed[first])
    if locked:
        part = _core.unlock_regions(mesh, part, faces.triangles_at(step.faces[:1]))
        fixed[first] = False
    wanted = smoothing.smoothed(label, pairs, inside, fixed, step.rounds, partial(_poll, job))
    wanted = smoothing.shortened(wanted, pairs, faces.pair_lengths()[joined], inside, fixed)
    for region in np.unique(label[wanted != label]):
        if not (wanted[label == region] == region).any():
            wanted[label == region] = region  # a brush that covers a whole region must not remove it
    for region in np.unique(wanted[wanted != label]):
        stays = int(np.flatnonzero((label == region) & (wanted == region))[0])
        now = faces.regions(part)
        moved = smoothing.reachable((wanted == region) & (now != now[stays]) & inside, now == now[stays], pairs)
        if moved.any():
            whole = faces.with_split(part, moved, now == now[stays], pairs)
            chosen = faces.triangles_at(np.flatnonzero(whole).tolist())
            part = _core.paint_faces(mesh, part, chosen, faces.triangle_at(stays), job=job)
    if locked:
        stays = int(np.flatnonzero((label == first) & (wanted == first))[0])
        part = _core.lock_regions(mesh, part, np.array([faces.triangle_at(stays)]))
    return part


def _poll(job: Job | None) -> None:
    if job is not None and job.cancelled:
        raise Cancelled("cancelled")


def _cut(step: rcp.CutRegion, faces: Faces, part: Partition, job: Job | None) -> Partition:
    direction = np.array(step.direction, float) if step.direction else None
    line = np.array(step.line, float)
    return _core.split_along(faces.mesh, part, faces.triangle_at(step.face), line, direction, job=job)


def _locks(change: Callable[..., Partition], *names: str) -> Edit:
    def edit(step: rcp.LockRegions, faces: Faces, part: Partition, job: Job | None) -> Partition:
        chosen = np.array([faces.triangle_at(face) for face in step.faces])
        return change(faces.mesh, part, chosen, *(getattr(step, name) for name in names))

    return edit


def _at_face(change: Callable[..., Partition], *names: str) -> Edit:
    """An edit at the face of a step, with more of its settings."""

    def edit(step: Any, faces: Faces, part: Partition, job: Job | None) -> Partition:
        more = (getattr(step, name) for name in names)
        return change(faces.mesh, part, faces.triangle_at(step.face), *more, job=job)

    return edit


def _everywhere(change: Callable[..., Partition], *names: str) -> Edit:
    """An edit of all regions, with settings of a step."""

    def edit(step: Any, faces: Faces, part: Partition, job: Job | None) -> Partition:
        return change(faces.mesh, part, *(getattr(step, name) for name in names), job=job)

    return edit


def _merge(step: rcp.MergeRegions, faces: Faces, part: Partition, job: Job | None) -> Partition:
    other = faces.triangle_at(step.other)
    return _core.merge_regions(faces.mesh, part, faces.triangle_at(step.face), other, job=job)


def _round(step: rcp.RoundRegions, faces: Faces, part: Partition, job: Job | None) -> Partition:
    return _core.make_round(faces.mesh, part, faces.triangles_at(step.faces), step.kind or None, job=job)


#: the steps that change regions, by their names in recipes
EDITS: dict[str, Edit] = {
    "add_proxy": _at_face(_core.add_proxy),
    "delete_proxy": _at_face(_core.delete_proxy),
    "merge_regions": _merge,
    "split_region": _at_face(_core.split_region),
    "cut_region": _cut,
    "paint": _paint,
    "erase": _erase,
    "smooth": _smooth,
    "grow": _at_face(_core.grow_region, "rings"),
    "shrink": _at_face(_core.shrink_region, "rings"),
    "lock": _locks(_core.lock_regions),
    "unlock": _locks(_core.unlock_regions),
    "leave_out": _locks(_core.leave_out_regions, "box"),
    "add_worst": _everywhere(_core.add_worst, "times"),
    "delete_least": _everywhere(_core.delete_least, "times"),
    "merge_cheapest": _everywhere(_core.merge_cheapest, "times"),
    "improve": _everywhere(_core.improve),
    "even_borders": _everywhere(_core.even_borders, "strength"),
    "round": _round,
    "segments": _at_face(_core.set_segments, "segments", "rings"),
    "explode": _at_face(_core.release_round),
    "regularise": _regularise,
    "align": _align,
}
