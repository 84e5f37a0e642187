"""The engine's options of partition and meshing. Written by scripts/generate.py; do not edit."""

from .options import Option

MESHING: dict[str, Option] = {
    "chord_tolerance": Option(
        kind="float",
        default=0.35,
        words="in [0, 100]",
        least=0.0,
        most=100.0,
    ),
    "chord_area": Option(
        kind="float",
        default=0.53,
        words="in [0, 100]",
        least=0.0,
        most=100.0,
    ),
    "join_junctions": Option(
        kind="float",
        default=0.8,
        words="in [0, 100]",
        least=0.0,
        most=100.0,
    ),
    "reach": Option(
        kind="float",
        default=0.01,
        words="in [0, 1]",
        least=0.0,
        most=1.0,
    ),
    "straight_rims": Option(
        kind="float",
        default=None,
        words="a finite length, at least 0",
        least=0.0,
    ),
    "flatten": Option(
        kind="int",
        default=30,
        words="in [0, 10000]",
        least=0.0,
        most=10000.0,
    ),
    "flatness_from": Option(
        kind="int",
        default=100,
    ),
    "flatness": Option(
        kind="float",
        default=0.005,
        words="in [0, 100]",
        least=0.0,
        most=100.0,
    ),
    "repair_budget": Option(
        kind="float",
        default=4.0,
        words="in [0, 1000]",
        least=0.0,
        most=1000.0,
    ),
    "planar": Option(
        kind="bool",
        default=False,
    ),
    "planar_reach": Option(
        kind="float",
        default=0.005,
        words="in [0, 1]",
        least=0.0,
        most=1.0,
    ),
    "planar_most": Option(
        kind="float",
        default=1.0,
        words="in [0, 1]",
        least=0.0,
        most=1.0,
    ),
    "threads": Option(
        kind="int",
        default=0,
        words="at least 0",
        least=0.0,
    ),
}

PARTITION: dict[str, Option] = {
    "proxies": Option(
        kind="int",
        default=None,
        words="at least 1",
        least=1.0,
    ),
    "triangles": Option(
        kind="int",
        default=None,
        words="at least 2",
        least=2.0,
    ),
    "detail": Option(
        kind="float",
        default=None,
        words="in (0, 1]",
        least=0.0,
        above_least=True,
        most=1.0,
    ),
    "tolerance": Option(
        kind="float",
        default=None,
        words="a finite length above 0",
        least=0.0,
        above_least=True,
    ),
    "bound": Option(
        kind="float",
        default=None,
        words="a finite length above 0",
        least=0.0,
        above_least=True,
    ),
    "noise": Option(
        kind="float",
        default=None,
        words="a finite length, at least 0",
        least=0.0,
    ),
    "snap": Option(
        kind="bool",
        default=True,
    ),
    "sharp_edges": Option(
        kind="float",
        default=None,
        words="a finite length, at least 0",
        least=0.0,
    ),
    "adaptivity": Option(
        kind="float",
        default=0.0,
        words="in [0, 1]",
        least=0.0,
        most=1.0,
    ),
    "smooth": Option(
        kind="float",
        default=0.5,
        words="in [0, 1]",
        least=0.0,
        most=1.0,
    ),
    "symmetry": Option(
        kind="str",
        default="none",
        choices=("none", "x", "y", "z", "found"),
    ),
    "curved": Option(
        kind="bool",
        default=False,
    ),
    "leave_out": Option(
        kind="float",
        default=0.001,
        words="in [0, 1)",
        least=0.0,
        most=1.0,
        below_most=True,
    ),
    "seed": Option(
        kind="int",
        default=1,
        words="at least 0",
        least=0.0,
    ),
    "iterations": Option(
        kind="int",
        default=20,
        words="at least 1",
        least=1.0,
    ),
    "seeding": Option(
        kind="str",
        default="random",
        choices=("random", "farthest", "hierarchical"),
    ),
    "method": Option(
        kind="str",
        default="hierarchy",
        choices=("lloyd", "hierarchy", "teleport", "naive", "queued", "hybrid"),
    ),
    "threads": Option(
        kind="int",
        default=0,
        words="at least 0",
        least=0.0,
    ),
    "backend": Option(
        kind="str",
        default="cpu",
    ),
    "nearest": Option(
        kind="int",
        default=8,
        words="in [1, 32]",
        least=1.0,
        most=32.0,
    ),
    "search": Option(
        kind="str",
        default="grid",
        choices=("grid", "brute"),
    ),
    "connect": Option(
        kind="str",
        default="repair",
        choices=("repair", "flood"),
    ),
    "fraction": Option(
        kind="float",
        default=0.125,
        words="in (0, 1]",
        least=0.0,
        above_least=True,
        most=1.0,
    ),
}

REGULARISE: dict[str, Option] = {
    "angle": Option(
        kind="float",
        default=8.0,
        words="in [0, 45]",
        least=0.0,
        most=45.0,
    ),
    "length": Option(
        kind="float",
        default=None,
        words="a finite length above 0",
        least=0.0,
        above_least=True,
    ),
    "up": Option(
        kind="str",
        default="z",
        choices=("x", "y", "z", "none"),
    ),
    "even_spacing": Option(
        kind="bool",
        default=False,
    ),
    "merge_islands": Option(
        kind="float",
        default=0.0,
        words="a finite length, at least 0",
        least=0.0,
    ),
}

TEXTURE: dict[str, Option] = {
    "size": Option(
        kind="int",
        default=None,
        words="in [16, 16384]",
        least=16.0,
        most=16384.0,
    ),
    "tiles": Option(
        kind="int",
        default=None,
        words="in [1, 100]",
        least=1.0,
        most=100.0,
    ),
    "materials": Option(
        kind="bool",
        default=False,
    ),
    "unfold": Option(
        kind="float",
        default=40.0,
        words="in [0, 90]",
        least=0.0,
        most=90.0,
    ),
    "gutter": Option(
        kind="int",
        default=None,
        words="in [2, 64]",
        least=2.0,
        most=64.0,
    ),
    "band": Option(
        kind="int",
        default=2,
        words="in [0, 64]",
        least=0.0,
        most=64.0,
    ),
    "normals": Option(
        kind="bool",
        default=True,
    ),
    "height": Option(
        kind="bool",
        default=False,
    ),
    "occlusion": Option(
        kind="bool",
        default=False,
    ),
    "occlusion_distance": Option(
        kind="float",
        default=None,
        words="a finite length above 0",
        least=0.0,
        above_least=True,
    ),
    "occlusion_rays": Option(
        kind="int",
        default=144,
        words="in [9, 9216]",
        least=9.0,
        most=9216.0,
    ),
    "threads": Option(
        kind="int",
        default=0,
        words="at least 0",
        least=0.0,
    ),
}
