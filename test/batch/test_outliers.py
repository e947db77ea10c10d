# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bodies that are not of the material of the others are named, and no others."""

from diffcal_ros.batch.outliers import find_outliers
import numpy as np
import pytest

_ERRORS = (0.02, 0.06)
_SPREAD = 0.05
_DRAWS = 60
# One in a hundred is the level; five of sixty would be a chance of one in three thousand.
_MOST_FALSE = 4


def _material(random, count):
    errors = random.uniform(*_ERRORS, count)
    return random.normal(scale=np.hypot(errors, _SPREAD)), errors


@pytest.mark.parametrize('count', [6, 30])
def test_bodies_of_one_material_are_left_alone(random, count) -> None:
    named = [find_outliers(*_material(random, count)).any() for _ in range(_DRAWS)]
    assert sum(named) <= _MOST_FALSE


def test_several_outliers_do_not_hide_behind_one_another(random) -> None:
    values, errors = _material(random, 30)
    values[[3, 11, 20]] += 0.6
    assert np.flatnonzero(find_outliers(values, errors)).tolist() == [3, 11, 20]


def test_a_body_that_is_unsure_of_itself_is_no_outlier(random) -> None:
    values, errors = _material(random, 20)
    values[5] += 0.8
    assert find_outliers(values, errors)[5]
    errors[5] = 0.5
    assert not find_outliers(values, errors).any()


def test_of_few_bodies_nobody_can_tell() -> None:
    assert not find_outliers(np.array([0.0, 0.0, 0.01, 9.0]), np.full(4, 0.01)).any()
