"""The look that a file of a scan describes: its images are named and not read."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

COLOR = "color"  #: the layer of the colour
Fault = Callable[[str], None]  #: takes what can't be used of a file


@dataclass(frozen=True)
class Material:
    """A material of a file. Its layers are "color" and the layers of `TexturedSoup`."""

    name: str
    color: tuple[float, float, float] | None = None  #: stored values, as in images; None: not stated
    numbers: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)  #: by layer
    #: by layer: the image, perhaps a pattern of UDIM tiles, and the place where it is named
    maps: Mapping[str, tuple[Path, str]] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Look:
    """Polygons of a file with UVs, materials and colours."""

    vertices: NDArray[np.float64]  #: (V, 3)
    loops: NDArray[np.int32]  #: (L,)
    loop_start: NDArray[np.int32]  #: (Q,)
    uv: NDArray[np.float64] | None = None  #: (L, 2) of each corner, zero where it has none
    #: (Q,) into `materials`, -1 for none; None: -1
    material: NDArray[np.int32] = None  # type: ignore[assignment]  # set below
    colors: NDArray[np.uint8] | None = None  #: RGBA: (V, 4), or (Q, 4) if they are of faces
    materials: list[Material] = field(default_factory=list)
    colors_of_faces: bool = False
    skipped: list[str] = field(default_factory=list)  #: words of the format for what is not read: "vn", "quality"
    faults: list[str] = field(default_factory=list)  #: what can't be used, with the place in the file

    def __post_init__(self) -> None:
        if self.material is None:
            object.__setattr__(self, "material", np.full(len(self.loop_start), -1, np.int32))
