"""Models that the add-on passes to the exporters."""

import numpy as np
import pytest

from isimp import handover


@pytest.mark.parametrize(
    ("faces", "closed", "manifold"),
    [
        ([(0, 1, 2)], False, True),
        ([(0, 1, 2), (1, 0, 3)], False, True),
        ([(0, 1, 2), (0, 1, 3)], False, False),
        ([(0, 1, 2), (1, 0, 3), (0, 1, 4)], False, False),
        ([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)], True, True),
        ([(0, 1, 2), (0, 1, 3), (1, 2, 3), (2, 0, 3)], True, False),
    ],
)
def test_a_model_knows_whether_it_is_closed_and_manifold(faces, closed, manifold):
    loops = np.array(faces, np.int32)
    model = handover.Model(np.eye(5, 3), loops.ravel(), 3 * np.arange(len(loops), dtype=np.int32))
    assert (model.report["closed"], model.report["manifold"]) == (closed, manifold)
