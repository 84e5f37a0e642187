"""The values of `Partition.region_held`, as in `isimp/partition/partition.h`."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

SNAPPED = 1  #: by `regularise`
BY_HAND = 2  #: by `align_planes`
FREE = 3  #: released by `align_planes`
OF_CELL = 4  #: of a cell of a round part


def is_held(values: NDArray[Any]) -> NDArray[np.bool_]:
    """Whether polygons keep to the plane of each region. values: region_held."""
    found: NDArray[np.bool_] = (values != 0) & (values != FREE)
    return found


def is_fixed(values: NDArray[Any]) -> NDArray[np.bool_]:
    """Whether the plane of each region was snapped or set by hand. values: region_held."""
    found: NDArray[np.bool_] = (values == SNAPPED) | (values == BY_HAND)
    return found
