"""The engine's options as settings of steps. Written by scripts/generate.py; do not edit."""

from __future__ import annotations

from dataclasses import dataclass

from .step import Step


@dataclass(frozen=True)
class CleanFields(Step):
    stitch: float = -1.0
    grid: float = -1.0
    outside_only: bool = False


@dataclass(frozen=True)
class MeshingFields(Step):
    chord_tolerance: float = 0.35
    chord_area: float = 0.53
    join_junctions: float = 0.8
    reach: float = 0.02
    straight_rims: float = -1.0
    flatten: int = 15
    flatness_from: int = 100
    flatness: float = 0.005
    repair_budget: float = 4.0
    planar: bool = False
    planar_reach: float = 0.005
    planar_most: float = 1.0
    convex: bool = False


@dataclass(frozen=True)
class PartitionFields(Step):
    noise: float = -1.0
    snap: bool = True
    sharp_edges: float = -1.0
    adaptivity: float = 0.0
    smooth: float = 0.5
    metric: str = "mixed"
    curved: bool = False
    leave_out: float = 0.001
    seed: int = 1
    iterations: int = 20
    seeding: str = "random"
    method: str = "hierarchy"
    nearest: int = 8
    search: str = "grid"
    connect: str = "repair"
    fraction: float = 0.125


@dataclass(frozen=True)
class RegulariseFields(Step):
    angle: float = 8.0
    length: float = 0.0
    up: str = "z"


@dataclass(frozen=True)
class TextureFields(Step):
    size: int = 0
    tiles: int = 0
    materials: bool = False
    unfold: float = 40.0
    gutter: int = 0
    band: int = 2
    normals: bool = True
    occlusion: bool = False
    occlusion_distance: float = 0.0
    occlusion_rays: int = 144
