"""Dense scans into clean, editable n-gon meshes by Variational Shape Approximation: the engine."""

from ._core import (
    Cancelled,
    FileError,
    InvalidInput,
    Job,
    Mesh,
    Partition,
    PartitionOptions,
    __version__,
    add_proxy,
    backends,
    delete_proxy,
    partition,
)

__all__ = [
    "Cancelled",
    "FileError",
    "InvalidInput",
    "Job",
    "Mesh",
    "Partition",
    "PartitionOptions",
    "__version__",
    "add_proxy",
    "backends",
    "delete_proxy",
    "partition",
]

for _name in __all__:
    if isinstance(_thing := globals()[_name], type):
        _thing.__module__ = __name__  # so that messages and pickles name the package, not its compiled part
