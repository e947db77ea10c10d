# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which bodies share a material is told from gaps between their values."""

from diffcal_ros.batch.shared_materials import find_shared_materials
import numpy as np
import pytest

_DRAWS = 20
# Of twenty draws at one in a hundred; three more would be a chance below one in a thousand.
_MOST_WRONG = 2


def _bodies(random, count, distance):
    errors = random.uniform(0.02, 0.05, count)
    places = np.arange(count) % 3
    return random.normal(scale=np.hypot(errors, 0.04)) + distance * places, errors, places


@pytest.mark.parametrize('count', [6, 60])
def test_one_material_is_not_parted(random, count) -> None:
    found = [find_shared_materials(*_bodies(random, count, 0.0)[:2]) for _ in range(_DRAWS)]
    assert sum(len(own.means) > 1 for own in found) <= _MOST_WRONG


def test_three_materials_are_told_apart(random) -> None:
    wrong = 0
    for _ in range(_DRAWS):
        values, errors, places = _bodies(random, 60, 0.4)
        found = find_shared_materials(values, errors)
        wrong += found.places != places.tolist()
    assert wrong <= _MOST_WRONG


def test_means_and_spreads_are_those_of_the_materials(random) -> None:
    values, errors, _ = _bodies(random, 240, 0.5)
    found = find_shared_materials(values, errors)
    # Three deviations of a mean of eighty bodies.
    np.testing.assert_allclose(found.means, [0.0, 0.5, 1.0], atol=3.0 * 0.06 / np.sqrt(80.0))
    np.testing.assert_allclose(found.spreads, 0.04, rtol=0.5)


def test_a_body_between_two_materials_is_unsure() -> None:
    values = np.array([*np.linspace(-0.02, 0.02, 10), *np.linspace(0.98, 1.02, 10), 0.5])
    errors = np.array([*np.full(20, 0.02), 0.6])
    places = find_shared_materials(values, errors).places
    assert places[:20] == [0] * 10 + [1] * 10
    assert places[20] is None
