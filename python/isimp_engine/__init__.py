"""Dense scans into clean, editable n-gon meshes by Variational Shape Approximation: the engine."""

from ._core import (
    Cancelled,
    CleanOptions,
    FileError,
    InvalidInput,
    Job,
    Mesh,
    MeshingOptions,
    Partition,
    PartitionOptions,
    PolygonMesh,
    __version__,
    add_proxy,
    backends,
    clean,
    delete_proxy,
    partition,
    polygonize,
    read,
    read_polygons,
    triangulate,
    write,
)

__all__ = [
    "Cancelled",
    "CleanOptions",
    "FileError",
    "InvalidInput",
    "Job",
    "Mesh",
    "MeshingOptions",
    "Partition",
    "PartitionOptions",
    "PolygonMesh",
    "__version__",
    "add_proxy",
    "backends",
    "clean",
    "delete_proxy",
    "partition",
    "polygonize",
    "read",
    "read_polygons",
    "triangulate",
    "write",
]

for _name in __all__:
    if isinstance(_thing := globals()[_name], type):
        _thing.__module__ = __name__  # so that messages and pickles name the package, not its compiled part
