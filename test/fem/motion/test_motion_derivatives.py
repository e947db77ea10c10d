# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Tangents and adjoint of a motion against differences, and against each other."""

from diffcal_ros.fem.elements.element import Element
import numpy as np
import pytest
from support.moving_bodies import directions, released_beam

NAMES = (
    'youngs_modulus',
    'poissons_ratio',
    'density',
    'gravity',
    'damping',
    'mass_damping',
    'release_time',
)
STEPS = (2e-2, 1e-2, 5e-3)
# Newton leaves 1e-7 of the mean load in every step; central differences divide that by the step.
_RELATIVE = 2e-5


@pytest.mark.parametrize(
    'element', [Element.LINEAR, pytest.param(Element.QUADRATIC, marks=pytest.mark.slow)]
)
def test_tangents(element, random) -> None:
    case = released_beam(element, random)
    changes = directions(case, random)
    case.run()
    tangents = case.body.tangents(list(changes.values()))
    for (name, change), tangent in zip(changes.items(), tangents, strict=True):
        errors = []
        for step in STEPS:
            ahead = case.moved(change, step).run().positions
            behind = case.moved(change, -step).run().positions
            difference = (ahead - behind) / (2.0 * step)
            errors.append(np.linalg.norm(difference - tangent) / np.linalg.norm(tangent))
        # Central differences err by the square of the step.
        assert errors[-1] < _RELATIVE + 0.3 * errors[0], (name, errors)
        assert errors[-1] < 1e-4, (name, errors)


@pytest.mark.parametrize('element', list(Element))
def test_adjoint_agrees_with_the_tangents(element, random) -> None:
    case = released_beam(element, random)
    changes = directions(case, random)
    motion = case.run()
    by_positions = random.normal(size=motion.positions.shape)
    gradient = case.body.gradient(by_positions)
    tangents = case.body.tangents(list(changes.values()))
    for name, tangent in zip(NAMES, tangents, strict=True):
        forward = float((tangent * by_positions).sum())
        assert gradient.along(changes[name]) == pytest.approx(forward, rel=1e-6), name
