from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from os import PathLike
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

class InvalidInput(ValueError): ...
class FileError(InvalidInput): ...
class Cancelled(Exception): ...

class Job:
    def __init__(self) -> None: ...
    @property
    def progress(self) -> float: ...
    @property
    def stage(self) -> str: ...
    @property
    def cancelled(self) -> bool: ...
    def cancel(self) -> None: ...

class Mesh:
    def __init__(
        self,
        vertices: NDArray[np.floating],
        triangles: NDArray[np.integer],
        job: Job | None = None,
        *,
        threads: int = 0,
    ) -> None: ...
    @property
    def vertices(self) -> NDArray[np.float64]: ...
    @property
    def triangles(self) -> NDArray[np.int32]: ...
    @property
    def source_face(self) -> NDArray[np.int32]: ...
    @property
    def source_vertex(self) -> NDArray[np.int32]: ...
    @property
    def component(self) -> NDArray[np.int32]: ...
    @property
    def origin(self) -> tuple[float, float, float]: ...
    @property
    def report(self) -> dict[str, Any]: ...
    @property
    def openings(self) -> list[dict[str, Any]]: ...

class CleanOptions:
    weld: float
    fill_holes: float
    fill_flat_holes: float
    cut_handles: float
    stitch: float | None
    grid: float | None
    outside_only: bool
    threads: int
    def __init__(
        self,
        *,
        weld: float = ...,
        fill_holes: float = ...,
        fill_flat_holes: float = ...,
        cut_handles: float = ...,
        stitch: float | None = ...,
        grid: float | None = ...,
        outside_only: bool = ...,
        threads: int = ...,
    ) -> None: ...
    @staticmethod
    def fields() -> list[dict[str, Any]]: ...
    @staticmethod
    def gone() -> dict[str, Any]: ...
    def as_dict(self) -> dict[str, Any]: ...

def clean(
    vertices: NDArray[np.floating],
    triangles: NDArray[np.integer],
    options: CleanOptions = ...,
    *,
    job: Job | None = None,
    keep: NDArray[np.floating] | None = None,
) -> Mesh: ...
def close_openings(
    mesh: Mesh,
    options: CleanOptions,
    *,
    job: Job | None = None,
    keep: NDArray[np.floating] | None = None,
    left_out: int = 0,
) -> Mesh: ...

class PartitionOptions:
    proxies: int | None
    triangles: int | None
    detail: float | None
    tolerance: float | None
    bound: float | None
    noise: float | None
    snap: bool
    sharp_edges: float | None
    adaptivity: float
    smooth: float
    metric: Literal["mixed", "normals", "distance"]
    curved: bool
    leave_out: float
    seed: int
    iterations: int
    seeding: Literal["random", "farthest", "hierarchical"]
    method: Literal["hierarchy", "teleport", "lloyd", "queued", "naive", "hybrid"]
    threads: int
    backend: str
    nearest: int
    search: Literal["grid", "brute"]
    connect: Literal["repair", "flood"]
    fraction: float
    def __init__(
        self,
        *,
        proxies: int | None = ...,
        triangles: int | None = ...,
        detail: float | None = ...,
        tolerance: float | None = ...,
        bound: float | None = ...,
        noise: float | None = ...,
        snap: bool = ...,
        sharp_edges: float | None = ...,
        adaptivity: float = ...,
        smooth: float = ...,
        metric: Literal["mixed", "normals", "distance"] = ...,
        curved: bool = ...,
        leave_out: float = ...,
        seed: int = ...,
        iterations: int = ...,
        seeding: Literal["random", "farthest", "hierarchical"] = ...,
        method: Literal["hierarchy", "teleport", "lloyd", "queued", "naive", "hybrid"] = ...,
        threads: int = ...,
        backend: str = ...,
        nearest: int = ...,
        search: Literal["grid", "brute"] = ...,
        connect: Literal["repair", "flood"] = ...,
        fraction: float = ...,
    ) -> None: ...
    @staticmethod
    def fields() -> list[dict[str, Any]]: ...
    @staticmethod
    def gone() -> dict[str, Any]: ...
    def as_dict(self) -> dict[str, Any]: ...

class CurvedProxy:
    kind: Literal["cylinder", "cone", "sphere", "revolution", "extrusion"]
    axis: tuple[float, float, float]
    across: tuple[float, float, float]
    point: tuple[float, float, float]
    radius: float
    slope: float
    profile: list[tuple[float, float]]
    hollow: bool
    full: bool
    span: float
    segments: int
    rings: int
    faces: int
    regions: list[int]
    number: int
    def __getitem__(self, name: str, /) -> Any: ...
    def keys(self) -> Any: ...

class Partition:
    @property
    def face_region(self) -> NDArray[np.int32]: ...
    @property
    def region_seed(self) -> NDArray[np.int32]: ...
    @property
    def region_normal(self) -> NDArray[np.float64]: ...
    @property
    def region_locked(self) -> NDArray[np.bool_]: ...
    @property
    def region_left_out(self) -> NDArray[np.bool_]: ...
    @property
    def error(self) -> float: ...
    @property
    def history(self) -> NDArray[np.float64]: ...
    @property
    def region_count(self) -> int: ...
    @property
    def tolerance(self) -> float | None: ...
    @property
    def noise(self) -> float | None: ...
    @property
    def smooth(self) -> float: ...
    @property
    def metric(self) -> str: ...
    @property
    def snapped(self) -> bool: ...
    @property
    def region_offset(self) -> NDArray[np.float64]: ...
    @property
    def curved(self) -> list[CurvedProxy]: ...
    @property
    def regularity(self) -> dict[str, Any] | None: ...
    @property
    def region_held(self) -> NDArray[np.uint8]: ...
    @property
    def bound(self) -> float | None: ...
    @property
    def distance_max(self) -> float | None: ...
    @property
    def proxies_asked(self) -> int: ...
    @property
    def proxies_needed(self) -> int: ...
    @property
    def parts_left_out(self) -> int: ...
    @property
    def area_left_out(self) -> float: ...
    @property
    def report(self) -> dict[str, Any]: ...

def partition(
    mesh: Mesh,
    options: PartitionOptions = ...,
    *,
    job: Job | None = None,
    weights: NDArray[np.floating] | None = None,
    barriers: NDArray[np.integer] | None = None,
) -> Partition: ...
def barrier_faces(mesh: Mesh, part: Partition) -> NDArray[np.int32]: ...
def partition_from(
    mesh: Mesh,
    face_region: NDArray[np.integer],
    *,
    job: Job | None = None,
    weights: NDArray[np.floating] | None = None,
    barriers: NDArray[np.integer] | None = None,
    before: Partition | None = None,
) -> Partition: ...
def add_proxy(mesh: Mesh, partition: Partition, face: int, *, job: Job | None = None) -> Partition: ...
def delete_proxy(mesh: Mesh, partition: Partition, face: int, *, job: Job | None = None) -> Partition: ...
def merge_regions(mesh: Mesh, partition: Partition, face: int, other: int, *, job: Job | None = None) -> Partition: ...
def split_region(mesh: Mesh, partition: Partition, face: int, *, job: Job | None = None) -> Partition: ...
def split_along(
    mesh: Mesh,
    partition: Partition,
    face: int,
    line: NDArray[np.floating],
    direction: NDArray[np.floating] | None = None,
    *,
    job: Job | None = None,
) -> Partition: ...
def paint_faces(
    mesh: Mesh,
    partition: Partition,
    faces: NDArray[np.integer],
    onto: int | None = None,
    *,
    job: Job | None = None,
) -> Partition: ...
def erase_faces(
    mesh: Mesh, partition: Partition, faces: NDArray[np.integer], *, job: Job | None = None
) -> Partition: ...
def grow_region(
    mesh: Mesh, partition: Partition, face: int, rings: int = 1, *, job: Job | None = None
) -> Partition: ...
def shrink_region(
    mesh: Mesh, partition: Partition, face: int, rings: int = 1, *, job: Job | None = None
) -> Partition: ...
def lock_regions(mesh: Mesh, partition: Partition, faces: NDArray[np.integer]) -> Partition: ...
def unlock_regions(mesh: Mesh, partition: Partition, faces: NDArray[np.integer]) -> Partition: ...
def leave_out_regions(mesh: Mesh, partition: Partition, faces: NDArray[np.integer], box: bool = False) -> Partition: ...
def add_worst(mesh: Mesh, partition: Partition, times: int = 1, *, job: Job | None = None) -> Partition: ...
def delete_least(mesh: Mesh, partition: Partition, times: int = 1, *, job: Job | None = None) -> Partition: ...
def merge_cheapest(mesh: Mesh, partition: Partition, times: int = 1, *, job: Job | None = None) -> Partition: ...
def even_borders(mesh: Mesh, partition: Partition, strength: float = 1.0, *, job: Job | None = None) -> Partition: ...
def make_round(
    mesh: Mesh,
    part: Partition,
    faces: NDArray[np.integer] | list[int],
    kind: str | None = None,
    *,
    job: Job | None = None,
) -> Partition: ...
def set_segments(
    mesh: Mesh, part: Partition, face: int, segments: int, rings: int = 0, *, job: Job | None = None
) -> Partition: ...
def release_round(mesh: Mesh, part: Partition, face: int, *, job: Job | None = None) -> Partition: ...
def round_part_at(mesh: Mesh, part: Partition, face: int) -> int | None: ...
def improve(mesh: Mesh, partition: Partition, *, job: Job | None = None) -> Partition: ...
def region_statistics(mesh: Mesh, partition: Partition, face: int, *, job: Job | None = None) -> dict[str, Any]: ...
def all_statistics(mesh: Mesh, partition: Partition, *, job: Job | None = None) -> list[dict[str, Any]]: ...
def region_sides(
    vertices: NDArray[np.floating], triangles: NDArray[np.integer], region: NDArray[np.integer], regions: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
def backends() -> list[str]: ...

class RegulariseOptions:
    angle: float
    length: float | None
    up: Literal["x", "y", "z", "none"]
    def __init__(
        self,
        *,
        angle: float = ...,
        length: float | None = ...,
        up: Literal["x", "y", "z", "none"] = ...,
    ) -> None: ...
    @staticmethod
    def fields() -> list[dict[str, Any]]: ...
    @staticmethod
    def gone() -> dict[str, Any]: ...
    def as_dict(self) -> dict[str, Any]: ...

class MeshingOptions:
    chord_tolerance: float
    chord_area: float
    join_junctions: float
    reach: float
    straight_rims: float | None
    flatten: int
    flatness_from: int
    flatness: float
    repair_budget: float
    planar: bool
    planar_reach: float
    planar_most: float
    convex: bool
    threads: int
    def __init__(
        self,
        *,
        chord_tolerance: float = ...,
        chord_area: float = ...,
        join_junctions: float = ...,
        reach: float = ...,
        straight_rims: float | None = ...,
        flatten: int = ...,
        flatness_from: int = ...,
        flatness: float = ...,
        repair_budget: float = ...,
        planar: bool = ...,
        planar_reach: float = ...,
        planar_most: float = ...,
        convex: bool = ...,
        threads: int = ...,
    ) -> None: ...
    @staticmethod
    def fields() -> list[dict[str, Any]]: ...
    @staticmethod
    def gone() -> dict[str, Any]: ...
    def as_dict(self) -> dict[str, Any]: ...

class PolygonMesh:
    @property
    def vertices(self) -> NDArray[np.float64]: ...
    @property
    def loops(self) -> NDArray[np.int32]: ...
    @property
    def loop_start(self) -> NDArray[np.int32]: ...
    @property
    def polygon_region(self) -> NDArray[np.int32]: ...
    @property
    def planarity(self) -> NDArray[np.float64]: ...
    @property
    def planes_let_go(self) -> NDArray[np.int32]: ...
    @property
    def source_vertex(self) -> NDArray[np.int32]: ...
    @property
    def report(self) -> dict[str, Any]: ...
    def faces(self) -> list[NDArray[np.int32]]: ...
    def triangles(self, *, job: Job | None = None) -> NDArray[np.int32]: ...

def regularise(
    mesh: Mesh,
    partition: Partition,
    options: RegulariseOptions = ...,
    *,
    job: Job | None = None,
    up_direction: ArrayLike | None = None,
) -> Partition: ...
def _convex_parts(
    vertices: ArrayLike,
    loops: ArrayLike,
    loop_start: ArrayLike,
    region: ArrayLike,
    enclosed: ArrayLike,
    tolerance: float,
    parts: int,
    most_vertices: int,
    thickness: float,
    job: Job | None = None,
) -> list[tuple[NDArray[np.float64], NDArray[np.int32], float]]: ...
def merge_flat(
    mesh: Mesh, angle: float = ..., group: ArrayLike | None = None, *, job: Job | None = None
) -> tuple[PolygonMesh, NDArray[np.int32]]: ...
def align_planes(
    mesh: Mesh,
    partition: Partition,
    faces: ArrayLike,
    to: Literal["level", "upright", "parallel", "perpendicular", "coplanar", "free"],
    up_direction: ArrayLike = ...,
    length: float | None = None,
    *,
    job: Job | None = None,
) -> Partition: ...
def _hold_planes(
    mesh: Mesh,
    partition: Partition,
    planes: Sequence[tuple[int, Sequence[float], float]],
    parts: Sequence[tuple[int, Sequence[float], Sequence[float], float]] = ...,
    *,
    job: Job | None = None,
) -> Partition: ...
def region_fits(
    mesh: Mesh, partition: Partition
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]: ...
def expected_polygons(
    mesh: Mesh, partition: Partition, options: MeshingOptions = ..., *, job: Job | None = None
) -> dict[str, int]: ...
def polygonize(
    mesh: Mesh, partition: Partition, options: MeshingOptions = ..., *, job: Job | None = None
) -> PolygonMesh: ...
def read(
    path: str | PathLike[str], *, job: Job | None = None, threads: int = 0
) -> tuple[NDArray[np.float64], NDArray[np.int32]]: ...
def read_polygons(
    path: str | PathLike[str], *, job: Job | None = None, threads: int = 0
) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.int32]]: ...
def triangulate(
    vertices: NDArray[np.floating],
    loops: NDArray[np.integer],
    loop_start: NDArray[np.integer],
    *,
    job: Job | None = None,
) -> tuple[NDArray[np.int32], NDArray[np.int32]]: ...
def write(path: str | PathLike[str], polygons: PolygonMesh, *, job: Job | None = None) -> None: ...
def opening_length(mesh: Mesh, regions: int, *, job: Job | None = None) -> float: ...
def opening_lengths(mesh: Mesh, regions: int, *, job: Job | None = None) -> tuple[float, float]: ...

# Private functions that the modules guides, guided, within and tiles publish under their own names.
_inner_edges: Callable[[Mesh], tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]]
_sharp_edges: Callable[[Mesh, float], NDArray[np.int32]]
_marked_edges: Callable[[Mesh, NDArray[Any]], NDArray[np.int32]]
_shared_edges: Callable[[NDArray[Any]], tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]]
_all_opening_lengths: Callable[[Mesh, int, PartitionOptions, Job | None], tuple[float, float, float]]
_guess_opening_lengths: Callable[[Mesh, PartitionOptions, Job | None], tuple[float, float, float, int, bool]]
_left_out_count: Callable[[Mesh, PartitionOptions, Job | None], int]
_partition: Callable[..., Partition]
_read_columns: Callable[..., tuple[Any, Any, Any, dict[str, Any], dict[str, Any], Any, list[str], list[Any], list[str]]]
_inside_regions: Callable[[Mesh, Partition, NDArray[Any]], int]
_scan_distances: Callable[[Mesh, Partition, PolygonMesh, float, int, int, Job | None], NDArray[np.float64]]
_distances_to_triangles: Callable[[NDArray[Any], NDArray[Any]], NDArray[np.float64]]
_tightened: Callable[[Mesh, Partition, float, MeshingOptions], MeshingOptions]
_noise: Callable[[Mesh], float]
_has_noise: Callable[[Mesh], bool]
_tile_border: Callable[[Mesh], NDArray[np.int32]]
_tile_thin: Callable[[Mesh, int], tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.int32]]]
_tile_weld: Callable[..., NDArray[np.int32]]
_tile_points_on_edges: Callable[..., NDArray[np.int32]]
_BoundSearch: Callable[[float, bool], Any]
_Stretch: Callable[[Job, float, float], AbstractContextManager[None]]

class TextureOptions:
    size: int | None
    tiles: int | None
    materials: bool
    unfold: float
    gutter: int | None
    band: int
    normals: bool
    occlusion: bool
    occlusion_distance: float | None
    occlusion_rays: int
    threads: int
    def __init__(
        self,
        *,
        size: int | None = ...,
        tiles: int | None = ...,
        materials: bool = ...,
        unfold: float = ...,
        gutter: int | None = ...,
        band: int = ...,
        normals: bool = ...,
        occlusion: bool = ...,
        occlusion_distance: float | None = ...,
        occlusion_rays: int = ...,
        threads: int = ...,
    ) -> None: ...
    @staticmethod
    def fields() -> list[dict[str, Any]]: ...
    @staticmethod
    def gone() -> dict[str, Any]: ...
    def as_dict(self) -> dict[str, Any]: ...

_Atlas = Any  # side, tiles, scale, fill, gutter, chart_count, chart, tile, tile_group, tangent, normal

_unwrap: Callable[..., _Atlas]
_uv: Callable[[PolygonMesh, _Atlas], NDArray[np.float64]]
_bake: Callable[
    ...,
    tuple[NDArray[np.uint8], NDArray[np.uint8] | None, list[NDArray[np.uint8]], NDArray[np.int64]],
]
_occlusion: Callable[..., NDArray[np.uint8]]
_closest_places: Callable[..., tuple[NDArray[np.int32], NDArray[np.float32]]]
_bake_map: Callable[..., tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.float32]]]
_source_corners: Callable[
    [Mesh, NDArray[Any], NDArray[Any], Job | None], tuple[NDArray[np.int32], NDArray[np.float32], int, int]
]
