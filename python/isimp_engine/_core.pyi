from os import PathLike
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

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
        self, vertices: NDArray[np.floating], triangles: NDArray[np.signedinteger], job: Job | None = None
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
    def report(self) -> dict[str, Any]: ...

class CleanOptions:
    weld: float
    fill_holes: float
    cut_handles: float
    def __init__(self, *, weld: float = ..., fill_holes: float = ..., cut_handles: float = ...) -> None: ...
    def as_dict(self) -> dict[str, Any]: ...

def clean(
    vertices: NDArray[np.floating],
    triangles: NDArray[np.signedinteger],
    options: CleanOptions = ...,
    job: Job | None = None,
) -> Mesh: ...

class PartitionOptions:
    proxies: int | None
    detail: float | None
    tolerance: float | None
    noise: float | None
    snap: bool
    leave_out: float
    seed: int
    iterations: int
    seeding: Literal["random", "farthest", "hierarchical"]
    method: Literal["hierarchy", "lloyd", "teleport", "naive", "queued", "hybrid"]
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
        detail: float | None = ...,
        tolerance: float | None = ...,
        noise: float | None = ...,
        snap: bool = ...,
        leave_out: float = ...,
        seed: int = ...,
        iterations: int = ...,
        seeding: Literal["random", "farthest", "hierarchical"] = ...,
        method: Literal["hierarchy", "lloyd", "teleport", "naive", "queued", "hybrid"] = ...,
        threads: int = ...,
        backend: str = ...,
        nearest: int = ...,
        search: Literal["grid", "brute"] = ...,
        connect: Literal["repair", "flood"] = ...,
        fraction: float = ...,
    ) -> None: ...
    def as_dict(self) -> dict[str, Any]: ...

class Partition:
    @property
    def face_region(self) -> NDArray[np.int32]: ...
    @property
    def region_seed(self) -> NDArray[np.int32]: ...
    @property
    def region_normal(self) -> NDArray[np.float64]: ...
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
    def snapped(self) -> bool: ...
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
    job: Job | None = None,
    weights: NDArray[np.floating] | None = None,
    barriers: NDArray[np.signedinteger] | None = None,
) -> Partition: ...
def add_proxy(mesh: Mesh, partition: Partition, face: int, job: Job | None = None) -> Partition: ...
def delete_proxy(mesh: Mesh, partition: Partition, face: int, job: Job | None = None) -> Partition: ...
def backends() -> list[str]: ...

class MeshingOptions:
    chord_tolerance: float
    chord_area: float
    reach: float
    flatten: int
    flatness_from: int
    flatness: float
    repair_budget: float
    def __init__(
        self,
        *,
        chord_tolerance: float = ...,
        chord_area: float = ...,
        reach: float = ...,
        flatten: int = ...,
        flatness_from: int = ...,
        flatness: float = ...,
        repair_budget: float = ...,
    ) -> None: ...
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
    def source_vertex(self) -> NDArray[np.int32]: ...
    @property
    def report(self) -> dict[str, Any]: ...

def polygonize(
    mesh: Mesh, partition: Partition, options: MeshingOptions = ..., job: Job | None = None
) -> PolygonMesh: ...
def read(path: str | PathLike[str], job: Job | None = None) -> tuple[NDArray[np.float64], NDArray[np.int32]]: ...
def read_polygons(
    path: str | PathLike[str], job: Job | None = None
) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.int32]]: ...
def triangulate(
    vertices: NDArray[np.floating],
    loops: NDArray[np.signedinteger],
    loop_start: NDArray[np.signedinteger],
    job: Job | None = None,
) -> tuple[NDArray[np.int32], NDArray[np.int32]]: ...
def write(path: str | PathLike[str], polygons: PolygonMesh, job: Job | None = None) -> None: ...
