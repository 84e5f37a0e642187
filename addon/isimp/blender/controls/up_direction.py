"""Computes the up direction of a scan: the scene's Z axis in the scan's space."""

import dataclasses

import numpy as np

from ... import recipe as rcp
from ..scene import mesh_io
from . import settings


def direction(scan) -> tuple:
    """Return the scene's Z in the space of a scan's arrays; empty if that is z."""
    up = np.array((0.0, 0.0, 1.0)) @ mesh_io.place_matrix(scan)[:3, :3]  # orthogonal, possibly mirrored
    up = (up / np.linalg.norm(up)).round(6) + 0.0  # removes float32 noise from quarter turns
    return () if up[2] == 1 else tuple(up.tolist())


def of_scan(step, scan):
    """Return the step with the up direction of a scan."""
    return dataclasses.replace(step, direction=direction(scan) if step.up == "scene" else ())


def as_last(step: rcp.AlignPlanes, shown: rcp.Regularise, recipe: rcp.Recipe) -> rcp.AlignPlanes:
    """Return the step with the panel's up direction. "Region" means the region of the last Regularise."""
    found = [old for _, old in recipe.active() if isinstance(old, rcp.Regularise) and old.up == "region"]
    if shown.up == "region" and found:
        return dataclasses.replace(step, up="region", face=found[-1].face)
    return dataclasses.replace(step, up="scene" if shown.up in ("region", "none") else shown.up)


def first(context, scan) -> rcp.Regularise:
    """Return the panel's Regularise step to run before Mesh."""
    step = settings.to_step(rcp.Regularise, settings.group(context, rcp.Regularise))
    return of_scan(dataclasses.replace(step, up="scene") if step.up == "region" else step, scan)
