"""The loss of scans far from zero in float32."""

import numpy as np
import pytest

from isimp import float_loss

UTM = np.array([5e5, 4.6e6, 100.0])


def loss(size, at, scale=(1, 1, 1)):
    """The loss of a scan with a diagonal at a place."""
    half = size / np.sqrt(12)
    return float_loss.loss(np.asarray(at) - half, np.asarray(at) + half, scale)


@pytest.mark.parametrize("size", [1e-6, 5, 50, 5000, 1e9])
def test_nothing_is_lost_at_zero(size):
    assert loss(size, (0, 0, 0)) is None
    assert loss(size, (size, -size, 10 * size)) is None


@pytest.mark.parametrize("size", [5, 50, 5000])
def test_map_coordinates_have_steps_of_half_a_metre(size):
    """4.6e6 lies between 2**22 and 2**23, where float32 has 23 bits below the first: steps of 2**-1."""
    lost = loss(size, UTM)
    assert lost.step == 0.5
    assert lost.away == pytest.approx(4.6e6, abs=size)


def test_a_step_is_measured_by_the_scans_size():
    assert loss(49_000, UTM).step == 0.5  # more than a hundred thousandth
    assert loss(51_000, UTM) is None


def test_lengths_include_the_scale_of_the_object():
    """A scan in millimetres, scaled to metres; one that is stretched along the axis that is far from zero."""
    lost = loss(5000, 1000 * UTM, scale=(0.001, -0.001, 0.001))
    assert (lost.step, lost.away) == (0.512, pytest.approx(4.6e6, rel=1e-5))
    assert loss(51_000, UTM, scale=(1, 3, 1)).step == 1.5


@pytest.mark.parametrize("box", [((0, 0, np.nan), (1, 1, 1)), ((0, 0, 0), (np.inf, 1, 1)), ((7, 7, 7), (7, 7, 7))])
def test_an_object_without_size_has_no_loss(box):
    assert float_loss.loss(*box) is None


@pytest.mark.parametrize(
    ("lost", "system", "scale", "away", "step"),
    [
        (float_loss.Loss(4.6e6, 0.5), "METRIC", 1.0, "4,600,000 m", "0.5 m"),
        (float_loss.Loss(4.6e9, 512.0), "METRIC", 0.001, "4,600,000 m", "0.51 m"),
        (float_loss.Loss(4.6e6, 0.5), "IMPERIAL", 1.0, "15,000,000 ft", "1.6 ft"),
        (float_loss.Loss(4.6e9, 512.0), "NONE", 0.001, "4,600,000,000 units", "510 units"),
        (float_loss.Loss(1.25, 2.0**-23), "METRIC", 1.0, "1.2 m", "0.00000012 m"),
    ],
)
def test_the_line_is_in_the_scenes_units(lost, system, scale, away, step):
    line = float_loss.warning(lost, system, scale)
    assert line.startswith(
        f"This scan lies {away} from its origin, where Blender's coordinates have steps of {step}. To keep"
    )
