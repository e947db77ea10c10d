# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Places are compared by what they explain of the images, not by how little they show."""

from diffcal_ros.calibration.residuals.measured_body import MeasuredShares
from diffcal_ros.calibration.residuals.residual_scales import Scale, Scales
from diffcal_ros.calibration.residuals.robust_residual import (
    Comparison,
    Reach,
    ResidualKind,
    Residuals,
)
from diffcal_ros.calibration.residuals.two_way_comparison import Misfit, TwoWayComparison
import numpy as np
import pytest

COARSE = Scales(Scale(0.0015, 0.0015), Scale(0.0015, 0.0015), Reach(0.025, 0.0375, 30))
FINE = Scales(Scale(0.0007, 0.0003, 5.0), Scale(0.0009, 0.0004, 12.0), COARSE.reach)


def _residuals(kind: ResidualKind, count: int, size: float, missing: float) -> Residuals:
    nowhere = np.zeros((count, 2), dtype=np.int32)
    values, places = np.full(count, size), np.arange(count, dtype=np.int32)
    return Residuals(kind, values, np.ones(count), nowhere, places, missing)


def _place(
    pixels: int,
    size: float,
    *,
    missing: float = 0.0,
    pieces: int = 0,
    lost: float = 0.0,
    unexplained: float = 0.0,
    hidden: float = 0.0,
) -> TwoWayComparison:
    """Compare one view: residuals of one size, and what has no counterpart."""
    depth = _residuals(ResidualKind.DEPTH, pixels, size, missing)
    edge = _residuals(ResidualKind.EDGE, pieces, size, lost)
    nothing = np.zeros((1, 1))
    compared = Comparison(depth, edge, np.ones(pieces), nothing, nothing > 0)
    shares = MeasuredShares(unexplained, hidden, nothing > 0, 1)
    return TwoWayComparison([compared], [shares])


@pytest.mark.parametrize('scales', [COARSE, FINE])
def test_a_body_that_turns_its_edge_to_the_camera_gains_less(scales) -> None:
    # As a plate that is met, beside a hand that passes for it, and the same plate seen edge-on.
    met = _place(4800, 0.0004, pieces=600, unexplained=3200.0)
    edge_on = _place(165, 0.014, missing=300.0, unexplained=800.0)
    assert met.misfit(scales) > edge_on.misfit(scales)
    assert met.gain(scales) > edge_on.gain(scales)
    assert edge_on.gain(scales) < 0.0


@pytest.mark.parametrize('scales', [COARSE, FINE])
def test_what_hides_a_part_says_nothing_and_what_shows_through_it_does(scales) -> None:
    whole = _place(2000, 0.0005).gain(scales)
    assert _place(2000, 0.0005, missing=700.0, hidden=700.0).gain(scales) == pytest.approx(whole)
    half = _place(2000, 0.0005, missing=700.0, hidden=350.0).gain(scales)
    assert _place(2000, 0.0005, missing=700.0).gain(scales) < half < whole


def test_outline_that_is_not_there_costs_what_the_worst_residual_does() -> None:
    found = _place(2000, 0.0005, pieces=300).gain(FINE)
    lost = _place(2000, 0.0005, pieces=300, lost=100.0).gain(FINE)
    far = _place(2000, 0.0005, pieces=300).misfit(FINE)
    assert found - lost == pytest.approx(
        _place(2000, 0.0005, pieces=300, lost=100.0).misfit(FINE) - far
    )


def test_more_that_is_met_as_well_gains_in_proportion() -> None:
    one, two = (_place(count, 0.0005).gain(FINE) for count in (1000, 3000))
    assert two == pytest.approx(3.0 * one)
    assert _place(1000, 0.002).gain(FINE) < one


@pytest.mark.parametrize(
    ('above', 'is_worse'), [(-100.0, False), (-95.6, False), (-95.4, True), (40.0, True)]
)
def test_worse_is_more_than_tells_nothing(above, is_worse) -> None:
    best = Misfit(-100.0, 9.0)
    assert Misfit(above, 9.0).is_worse(best, 0.1, 4.5) is is_worse
    # A tenth of a large cost that is left tells nothing, either.
    assert not Misfit(-95.4, 9.0).is_worse(Misfit(-100.0, 60.0), 0.1, 4.5)
