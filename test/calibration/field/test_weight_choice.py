# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which weight is taken: the noise where it is reached, else the L-curve."""

from diffcal_ros.calibration.field.weight_choice import by_l_curve, corner
import numpy as np
import pytest


def test_the_corner_of_a_bent_curve_is_found() -> None:
    # Misfit falls hundredfold at little roughness; then roughness grows and nothing falls.
    misfits = [1000.0, 300.0, 60.0, 10.0, 9.8, 9.7, 9.6]
    roughnesses = [0.01, 0.012, 0.015, 0.02, 0.2, 2.0, 20.0]
    assert corner(misfits, roughnesses) == 3


def test_the_corner_is_near_the_best_weight(random) -> None:
    # Patterns of a signal that the data see ever less, and noise.
    seen = 10.0 ** -np.arange(0.0, 4.0, 0.25)
    signal = 0.8 ** np.arange(len(seen))
    shares = 10.0 ** -np.arange(0.5, 5.0, 0.5)
    for _ in range(10):
        data = seen * signal + 1e-3 * random.normal(size=len(seen))
        fits = [seen * data / (seen**2 + share) for share in shares]
        misfits = [float(((data - seen * fit) ** 2).sum()) for fit in fits]
        errors = [float(((fit - signal) ** 2).sum()) for fit in fits]
        chosen = corner(misfits, [float((fit**2).sum()) for fit in fits])
        # Twice the least error is what a weight costs that is half a decade off.
        assert errors[chosen] < 2.0 * min(errors)
        assert errors[chosen] < 0.1 * max(errors)


@pytest.mark.parametrize('misfits', [[100.0, 99.0, 98.0], [100.0, 102.0, 101.0]])
def test_the_smoothest_is_taken_where_rougher_ones_gain_nothing(misfits) -> None:
    chosen, reason = by_l_curve(misfits, [0.1, 1.0, 10.0])
    assert chosen == 0
    assert 'hardly fit better' in reason
