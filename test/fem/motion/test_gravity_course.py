# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Gravity and lateness in the course of a recording: motions, their derivatives, refusals."""

from dataclasses import replace
from itertools import pairwise

from diffcal_ros.effects.contact_plane import Plane
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.motion.inputs import in_course, MotionChange
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.fem.terms.conditions import Conditions
from diffcal_ros.time_knot import knots_between
import numpy as np
import pytest
from support.bodies import GRAVITY
from support.moving_bodies import RELEASE_TIME, released_beam

KNOTS = knots_between(0.0, 0.153, 4)
MORE = (
    np.array([0.4, -0.2, 0.3]),
    np.array([-1.5, 0.5, 0.8]),
    np.array([0.7, 2.0, -1.1]),
    np.array([0.2, 0.1, 3.0]),
)
COURSE = tuple(zip(KNOTS, MORE, strict=True))
STEPS = (2e-2, 1e-2, 5e-3)


@pytest.mark.parametrize('integrator', ['implicit', 'semi_implicit'])
def test_the_same_course_at_all_knots_is_another_gravity(integrator, random) -> None:
    case = released_beam(Element.LINEAR, random, counts=(3, 1, 1), integrator=integrator)
    same = tuple((knot, MORE[1]) for knot in KNOTS)
    found = case.run(gravity_course=same).positions
    expected = replace(case, gravity=case.gravity + MORE[1]).run().positions
    np.testing.assert_allclose(found, expected, atol=1e-9)
    assert np.abs(found - case.run().positions).max() > 1e-4


def test_steps_err_less_by_the_square_of_their_size(random) -> None:
    spread = []
    for step in (1 / 480, 1 / 960, 1 / 1920):
        random = np.random.default_rng(5)
        case = released_beam(Element.LINEAR, random, counts=(3, 1, 1), time_step=step)
        spread.append(case.run(gravity_course=COURSE).positions[-1])
    first, second = (np.abs(a - b).max() for a, b in pairwise(spread))
    assert first / second > 2.5


@pytest.mark.parametrize('integrator', ['implicit', 'semi_implicit'])
@pytest.mark.parametrize('number', range(4))
@pytest.mark.parametrize('course', [COURSE, ()])
@pytest.mark.slow_but_first
def test_tangents_by_each_knot(integrator, number, course, random) -> None:
    case = released_beam(Element.LINEAR, random, counts=(3, 1, 1), integrator=integrator)
    direction = np.array([2.0, 1.0, -4.0])
    case.run(gravity_course=course)
    change = in_course(Change(gravity=direction), KNOTS[number])
    (tangent,) = case.body.tangents([change])
    errors = []
    for step in STEPS:
        ends = []
        for sign in (step, -step):
            moved = (*course, (KNOTS[number], sign * direction))
            ends.append(case.run(gravity_course=moved).positions)
        difference = (ends[0] - ends[1]) / (2.0 * step)
        errors.append(np.linalg.norm(difference - tangent) / np.linalg.norm(tangent))
    assert min(errors) < 1e-4, errors


@pytest.mark.parametrize('name', ['release_time', 'density', 'youngs_modulus'])
@pytest.mark.slow
def test_other_tangents_in_the_course(name, random) -> None:
    case = released_beam(Element.LINEAR, random, counts=(3, 1, 1), time_step=1 / 1920)
    change = {
        'release_time': MotionChange(release_time=0.01),
        'density': MotionChange(density=500.0 * case.material.density / 1000.0),
        'youngs_modulus': MotionChange(youngs_modulus=10.0 * case.material.youngs_modulus / 40.0),
    }[name]
    case.run(gravity_course=COURSE)
    (tangent,) = case.body.tangents([change])
    errors = []
    for step in STEPS:
        ends = [
            case.moved(change, sign).run(gravity_course=COURSE).positions for sign in (step, -step)
        ]
        difference = (ends[0] - ends[1]) / (2.0 * step)
        errors.append(np.linalg.norm(difference - tangent) / np.linalg.norm(tangent))
    # Where a step goes over a knot its end does not follow the release quite as a slope says.
    assert min(errors) < (5e-3 if name == 'release_time' else 1e-4), errors


def test_stamps_that_are_each_late(random) -> None:
    case = released_beam(Element.LINEAR, random, counts=(3, 1, 1))
    late = np.array([0.0, 0.004, 0.012, -0.007])
    found = case.run(time_offset=late).positions
    sooner = replace(case, stamps=case.stamps - late).run().positions
    np.testing.assert_allclose(found, sooner, atol=1e-9)
    change = in_course(MotionChange(time_offset=1.0), KNOTS[2])
    motion = case.run(time_offset=late)
    (tangent,) = case.body.tangents([change])
    weights = KNOTS[2].weights(case.stamps)
    expected = -weights[:, None, None] * motion.velocities
    np.testing.assert_allclose(tangent, expected, atol=1e-12)
    assert 0.0 < weights.sum() < 4.0
    step = 1e-5
    ends = [case.run(time_offset=late + sign * weights).positions for sign in (step, -step)]
    difference = (ends[0] - ends[1]) / (2.0 * step)
    np.testing.assert_allclose(difference, tangent, atol=1e-3 * np.abs(tangent).max())


def test_what_has_no_course_is_refused(random) -> None:
    with pytest.raises(ValueError, match='conditions cannot be others in the course of time'):
        in_course(Change(conditions=Conditions(potentials=(Plane(GRAVITY, 0.1),))), KNOTS[0])
    case = released_beam(Element.LINEAR, random, counts=(3, 1, 1))
    motion = case.run()
    gradient = case.body.gradient(np.ones_like(motion.positions))
    with pytest.raises(NotImplementedError, match='in the course of time: use `tangents`'):
        gradient.along(in_course(Change(gravity=GRAVITY), KNOTS[1]))
    case.run(gravity_course=COURSE)
    with pytest.raises(NotImplementedError, match='no gradient goes through gravity'):
        case.body.gradient(np.ones_like(motion.positions))


def test_before_the_release_gravity_is_that_of_the_release(random) -> None:
    case = released_beam(Element.LINEAR, random, counts=(3, 1, 1))
    there = sum(float(knot.weights(RELEASE_TIME)) * own for knot, own in COURSE)
    found = case.run(gravity_course=COURSE).positions[0]
    expected = replace(case, gravity=case.gravity + there).run().positions[0]
    np.testing.assert_allclose(found, expected, atol=1e-9)
