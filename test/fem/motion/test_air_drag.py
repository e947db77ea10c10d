# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Drag of the air and late stamps: absence bit for bit, physics, tangents and adjoint."""

from dataclasses import replace

from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.motion.air_drag import AIR_DENSITY, AirDrag
from diffcal_ros.fem.motion.inputs import MotionChange
from diffcal_ros.fem.terms.conditions import Conditions
import numpy as np
import pytest
from support.moving_bodies import Case, directions, released_beam

AREA = 0.03
# Solves of a step iterate what their matrix leaves out to 1e-8, in hundreds of nodes.
_ITERATED = 1e-6
STEPS = (2e-2, 1e-2, 5e-3)


def with_drag(case: Case, area: float) -> Case:
    return replace(case, conditions=Conditions(air_drag=area))


def test_a_body_that_moves_as_one_feels_coefficient_times_area(random) -> None:
    body = released_beam(Element.QUADRATIC, random).body.static_body
    drag = AirDrag(body.discretisation, body.solver.stiffness.pattern.free_nodes)
    drag.set_area(AREA)
    velocity = np.array([0.3, -1.2, 0.5])
    forces = drag.forces(np.tile(velocity, (body.discretisation.node_count, 1)))
    speed = np.linalg.norm(velocity)
    expected = 0.5 * AIR_DENSITY * AREA * speed * velocity
    np.testing.assert_allclose(forces.sum(axis=0), expected, rtol=1e-12)


@pytest.mark.parametrize(('counts', 'tolerance'), [((4, 1, 1), 0.02), ((16, 4, 4), 0.002)])
def test_drag_is_an_integral_over_the_surface(counts, tolerance, random) -> None:
    """The power of speeds that grow as x^2 from the clamp on, by hand: x^6 on sides and end."""
    body = released_beam(Element.QUADRATIC, random, counts=counts).body.static_body
    drag = AirDrag(body.discretisation, body.solver.stiffness.pattern.free_nodes)
    nodes = body.discretisation.rest_nodes
    length, width, height = np.ptp(nodes, axis=0)
    velocities = np.zeros_like(nodes)
    velocities[:, 1] = ((nodes[:, 0] - nodes[:, 0].min()) / length) ** 2
    around, end = 2.0 * (width + height), width * height
    whole = 0.5 * AIR_DENSITY * (around * length / 7.0 + end) / (around * length + end)
    power = float((drag.force_of_area(velocities) * velocities).sum())
    assert power == pytest.approx(whole, rel=tolerance)


def test_no_drag_is_the_model_without_bit_for_bit(random) -> None:
    case = released_beam(Element.LINEAR, random)
    plain = case.run().positions
    np.testing.assert_array_equal(with_drag(case, 0.0).run().positions, plain)


def test_drag_takes_more_of_a_larger_swing(random) -> None:
    """The share of the speed that is lost grows with the speed, unlike that of damping."""
    case = released_beam(Element.LINEAR, random)
    lost = []
    for scale in (0.5, 1.0):
        weaker = replace(case, gravity=scale * case.gravity)
        free, dragged = weaker.run(), with_drag(weaker, AREA).run()
        change = np.linalg.norm(dragged.velocities - free.velocities)
        lost.append(change / np.linalg.norm(free.velocities))
    assert 1.6 * lost[0] < lost[1] < 2.4 * lost[0]


@pytest.mark.parametrize('integrator', ['implicit', 'semi_implicit'])
def test_tangents_by_drag(integrator, random) -> None:
    case = with_drag(released_beam(Element.LINEAR, random, integrator=integrator), AREA)
    by_area = MotionChange(conditions=Conditions(air_drag=AREA))
    case.run()
    (tangent,) = case.body.tangents([by_area])
    errors = []
    for step in STEPS:
        ahead = with_drag(case, (1.0 + step) * AREA).run().positions
        behind = with_drag(case, (1.0 - step) * AREA).run().positions
        difference = (ahead - behind) / (2.0 * step)
        errors.append(np.linalg.norm(difference - tangent) / np.linalg.norm(tangent))
    # Central differences err by the square of the step.
    assert errors[-1] < 2e-5 + 0.3 * errors[0], errors
    assert errors[-1] < 1e-4, errors


def test_the_tangent_at_no_drag_is_that_of_a_little(random) -> None:
    case = released_beam(Element.LINEAR, random)
    plain = case.run().positions
    (tangent,) = case.body.tangents([MotionChange(conditions=Conditions(air_drag=1.0))])
    errors = []
    for area in (1e-3, 1e-4, 1e-5):
        slope = (with_drag(case, area).run().positions - plain) / area
        errors.append(np.linalg.norm(slope - tangent) / np.linalg.norm(tangent))
    # One-sided: the error falls with the area.
    assert errors[1] < 0.12 * errors[0], errors
    assert errors[2] < 1e-3, errors


def test_other_tangents_and_the_adjoint_hold_under_drag(random) -> None:
    case = with_drag(released_beam(Element.QUADRATIC, random), AREA)
    changes = directions(case, random)
    case.run()
    tangents = dict(zip(changes, case.body.tangents(list(changes.values())), strict=True))
    by_positions = random.normal(size=case.body.motion.positions.shape)
    gradient = case.body.gradient(by_positions)
    for name, tangent in tangents.items():
        forward = float((tangent * by_positions).sum())
        assert gradient.along(changes[name]) == pytest.approx(forward, rel=_ITERATED), name
    change = changes['damping']
    ahead, behind = case.moved(change, 0.01).run(), case.moved(change, -0.01).run()
    difference = (ahead.positions - behind.positions) / 0.02
    error = np.linalg.norm(difference - tangents['damping'])
    assert error < 1e-4 * np.linalg.norm(tangents['damping'])


def test_late_stamps_show_the_body_as_it_was(random) -> None:
    case, late = released_beam(Element.LINEAR, random), 0.004
    before = replace(case, stamps=case.stamps - late).run().positions
    np.testing.assert_allclose(case.run(time_offset=late).positions, before, atol=1e-9)
    np.testing.assert_array_equal(case.run(time_offset=0.0).positions, case.run().positions)
    case.run(time_offset=late)
    (tangent,) = case.body.tangents([MotionChange(time_offset=1.0)])
    by_positions = random.normal(size=tangent.shape)
    gradient = case.body.gradient(by_positions)
    assert gradient.time_offset == pytest.approx(float((tangent * by_positions).sum()))
    for step in (1e-4, 1e-5, 1e-6):
        ends = (case.run(time_offset=late + own).positions for own in (step, -step))
        difference = np.subtract(*ends) / (2.0 * step)
        error = np.linalg.norm(difference - tangent) / np.linalg.norm(tangent)
        assert error < 1e-4, step
