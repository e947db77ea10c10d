# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Models whose noise was not measured are ranked by what most patches say."""

from diffcal_ros.diagnosis.model_comparison.guessed_floor import log_density
import numpy as np
import pytest
from scipy.stats import t


def test_the_size_is_that_which_makes_residuals_likeliest(random):
    residuals = 0.002 * random.standard_t(4.0, size=80)
    sizes = np.geomspace(1e-4, 1e-1, 4000)
    levels = t.logpdf(residuals[:, None], 4.0, scale=sizes).sum(axis=0)
    constant = len(residuals) * t.logpdf(0.0, 4.0)
    assert log_density(residuals) == pytest.approx(levels.max() - constant, abs=0.02)


def test_a_model_in_other_units_of_length_has_the_same_lead(random):
    one, other = 0.001 * random.standard_normal(50), 0.003 * random.standard_normal(50)
    lead = log_density(one) - log_density(other)
    assert lead > 20.0
    assert log_density(5.0 * one) - log_density(5.0 * other) == pytest.approx(lead, abs=0.05)


def test_few_patches_that_are_far_off_do_not_decide(random):
    """One model meets nine tenths to a millimetre and misses the rest by 40; one is 5 mm off."""
    mostly_right = 0.001 * random.standard_normal(50)
    mostly_right[:5] = 0.04
    off = 0.005 * random.standard_normal(50)
    assert np.sum(mostly_right**2) > 3.0 * np.sum(off**2)
    assert log_density(mostly_right) > log_density(off) + 5.0
