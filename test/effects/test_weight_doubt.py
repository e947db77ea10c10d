# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A push that is told as a tilt adds to the weight, and a modulus beside it is no surer."""

from diffcal_ros.effects.registry import EFFECTS
import numpy as np
import pytest

TILT = EFFECTS['gravity_tilt']


@pytest.mark.parametrize('across', [0.05, 0.15, 0.3])
def test_the_weight_beside_a_tilt_is_as_uncertain_as_by_pushes_of_any_direction(across):
    """Pushes, as shares of the weight: what turns it most, and how much more there is to carry.

    The tilt has the size of a typical push; a seventh is what its own spread is worth.
    """
    draws = np.random.default_rng(3).normal(0.0, across / np.sqrt(2.0), (200_000, 3))
    whole = np.linalg.norm(np.array([0.0, 0.0, 1.0]) + draws, axis=1)
    more = np.sqrt(np.mean((whole - 1.0) ** 2))
    angle = np.arctan(across)
    told = TILT.weight_doubt({'a': 0.8 * angle, 'b': -0.6 * angle})
    chance = 1.0 - TILT.most_confidence
    assert told == pytest.approx(np.sqrt(chance) * more, rel=1.0 / 7.0)


def test_what_has_no_such_twin_leaves_the_weight_as_it_is():
    others = [effect for name, effect in EFFECTS.items() if name != 'gravity_tilt']
    ones = [dict.fromkeys((part.name for part in own.components), 1.0) for own in others]
    doubts = [own.weight_doubt(values) for own, values in zip(others, ones, strict=True)]
    assert doubts == [0.0] * len(others)
    assert TILT.weight_doubt({'a': 0.0, 'b': 0.0}) == 0.0
