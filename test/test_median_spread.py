# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A spread by the median is that of normal errors, whatever a few are."""

from diffcal_ros.median_spread import median_spread, SPREAD_OVER_MEDIAN
import numpy as np
import pytest
from scipy.stats import norm

# Of the median of so many errors, 0.6 % (1.17 / sqrt(n)), four times.
_SCATTER = 0.025


def test_the_factor_is_that_of_the_normal_distribution() -> None:
    assert pytest.approx(1.0 / norm.ppf(0.75), rel=1e-4) == SPREAD_OVER_MEDIAN


def test_gross_errors_hardly_change_it(random: np.random.Generator) -> None:
    errors = random.normal(scale=0.3, size=(400, 100))
    assert median_spread(errors) == pytest.approx(0.3, rel=_SCATTER)
    errors[::50] = 1e6  # A fiftieth of all.
    assert median_spread(errors) == pytest.approx(0.3, rel=_SCATTER + 0.03)
