"""Dense scans into clean, editable n-gon meshes by Variational Shape Approximation: the engine."""

from ._core import Cancelled, FileError, InvalidInput, Job, Mesh, __version__

__all__ = ["Cancelled", "FileError", "InvalidInput", "Job", "Mesh", "__version__"]

for _public in (Cancelled, FileError, InvalidInput, Job, Mesh):
    _public.__module__ = __name__
