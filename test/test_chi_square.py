# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Chances of sums of squares, against their definition and the other way round."""

from diffcal_ros.chi_square import chance_beyond, exceeded_with
import numpy as np
import pytest
from scipy.stats import chi2


@pytest.mark.parametrize('freedom', [1, 2, 6, 40])
def test_chances_are_those_of_the_distribution(freedom: int) -> None:
    values = np.array([0.0, 1e-9, 0.3, 2.0, 7.0, 50.0, 400.0])
    np.testing.assert_allclose(
        chance_beyond(values, freedom), chi2.sf(values, freedom), rtol=1e-12
    )
    for chance in (0.003, 0.5, 0.999):
        assert float(chance_beyond(exceeded_with(chance, freedom), freedom)) == pytest.approx(
            chance
        )


def test_rounding_below_zero_is_zero() -> None:
    assert float(chance_beyond(-1e-17, 3)) == 1.0


def test_squares_of_normals_exceed_it_as_often(random) -> None:
    sums = (random.normal(size=(20_000, 3)) ** 2).sum(axis=1)
    assert float((sums > exceeded_with(0.1, 3)).mean()) == pytest.approx(0.1, abs=0.01)
