# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The twenty-seventh set's form of a rest curvature does what its labels say."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind.faults import Faults
from benchmarks.blind.rest_shape import stress_free_nodes
from benchmarks.blind.setups import Setup


def test_a_hammock_is_a_catenary(setup: Setup) -> None:
    shape, at, sag = setup.shape, 0.4, 0.25
    free = shape.length - shape.clamp
    radius, along = sag * free, np.linspace(0.0, 1.0, 401)
    unit = Faults(
        curvature_form='hammock', rest_curvature=(0.0, 1.0), curvature_at=at, curvature_sag=sag
    )
    line = np.outer(shape.clamp + along * free, [1.0, 0.0, 0.0])

    def lowest_turn(faults: Faults) -> float:
        """Return how much is turned by a short piece around the lowest place [rad]."""
        ends = np.array([at - 0.01, at - 0.005, at + 0.005, at + 0.01]) * free + shape.clamp
        bent = stress_free_nodes(np.outer(ends, [1.0, 0.0, 0.0]), shape, faults)
        one, other = bent[1] - bent[0], bent[3] - bent[2]
        return float(np.arctan2(np.cross(one, other)[2], one @ other)) / (0.015 * free)

    # By as much as a chain has whose lowest radius is told.
    faults = replace(unit, rest_curvature=(0.0, 1.0 / (radius * lowest_turn(unit))))
    bent = stress_free_nodes(line, shape, faults)
    lowest = int(np.argmin(np.abs(along - at)))
    ahead = bent[lowest + 2] - bent[lowest - 2]
    ahead /= np.linalg.norm(ahead)
    aside = np.cross([0.0, 0.0, 1.0], ahead)
    level, high = (bent - bent[lowest]) @ ahead, (bent - bent[lowest]) @ aside
    expected = radius * (np.cosh(level / radius) - 1.0)
    assert high == pytest.approx(expected, abs=0.03 * expected.max())
    assert expected.max() > 0.2 * free
    assert expected[0] < 0.7 * expected[-1]


@pytest.mark.parametrize(('at', 'sag'), [(0.36, 0.3), (0.6, 0.15)])
def test_a_hammocks_tip_is_as_far_off_as_that_of_an_arc(
    setup: Setup, at: float, sag: float
) -> None:
    curvature = np.array([0.03, -0.08])
    faults = Faults(
        curvature_form='hammock',
        rest_curvature=(float(curvature[0]), float(curvature[1])),
        curvature_at=at,
        curvature_sag=sag,
    )
    free = setup.shape.length - setup.shape.clamp
    tip = stress_free_nodes(np.array([[setup.shape.length, 0.0, 0.0]]), setup.shape, faults)[0]
    # About y it turns x towards -z, and about z towards y.
    expected = 0.5 * free**2 * np.array([curvature[1], -curvature[0]])
    assert tip[1:] == pytest.approx(expected, rel=0.03)
