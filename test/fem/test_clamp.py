# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A clamp that gives way: what it follows, and Newton's step towards its load."""

from diffcal_ros.fem.clamp import Clamp, ClampResponse
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.fem.terms.conditions import Conditions
import numpy as np
import pytest
from support.beams import beam_mesh, held_end
from support.bodies import GRAVITY, uniform_material

REST = np.random.default_rng(4).random((9, 3))
MOTION = np.array([0.01, -0.02, 0.03, 0.1, -0.3, 0.2])


def test_what_a_rigid_motion_moved_to_is_followed():
    clamp, there = Clamp(REST), Clamp(REST)
    clamp.gave_way = np.array([0.002, 0.001, -0.003, 0.3, 0.1, -0.2])
    for size, left in ((1e-2, 1e-3), (1e-3, 1e-5), (1e-4, 1e-7)):
        there.gave_way = clamp.gave_way + size * np.array([1.0, -2.0, 0.5, 1.0, 2.0, -1.5])
        here = Clamp(REST)
        here.gave_way = clamp.gave_way
        here.follow(REST, MOTION, there.place(REST, MOTION), range(6))
        # Newton's error falls with the square of the motion.
        assert np.abs(here.gave_way - there.gave_way).max() < left


def test_what_follows_no_load_is_left_alone():
    clamp = Clamp(REST)
    clamp.gave_way = np.array([0.0, 0.0, 0.0, 0.3, 0.1, -0.2])
    before = clamp.gave_way
    clamp.follow(REST, MOTION, clamp.place(REST, MOTION) + 0.01, [4, 5])
    assert (before == [0.0, 0.0, 0.0, 0.3, 0.1, -0.2]).all(), 'a state that was kept stays'
    assert (clamp.gave_way[:4] == before[:4]).all()
    assert (clamp.gave_way[4:] != before[4:]).all()


def test_a_step_is_newtons_and_turns_no_farther_than_it_may():
    fields = np.random.default_rng(5).random((2, 4, 3))
    response = ClampResponse([1, 5], np.array([[2.0, 0.5], [0.0, 4.0]]), fields)
    missing = np.array([9.0, 0.1, 9.0, 9.0, 9.0, 0.4])
    step, displacement = response.step(missing)
    np.testing.assert_allclose(step, [0.0, 0.025, 0.0, 0.0, 0.0, 0.1])
    np.testing.assert_allclose(displacement, 0.025 * fields[0] + 0.1 * fields[1])
    far, _ = response.step(100.0 * missing)
    assert np.linalg.norm(far[3:]) == pytest.approx(0.3)
    np.testing.assert_allclose(far / far[5], step / step[5])


@pytest.mark.parametrize('compliance', [0.1, 1.0, 4.0])
def test_the_clamp_ends_where_its_load_holds_it(compliance):
    mesh = beam_mesh((8, 2, 2))
    body = StaticBody(mesh, Element.QUADRATIC, held_end(mesh).astype(np.int32))
    turn = compliance * np.array([[1.0, 0.2, 0.0], [0.2, 0.6, 0.1], [0.0, 0.1, 0.8]])
    conditions = Conditions(clamp_compliance=np.pad(turn, ((3, 0), (3, 0))))
    material = uniform_material(mesh, 2e5)
    first = body.solve_equilibrium(material, GRAVITY, conditions=conditions).positions
    assert np.linalg.norm(body.clamp.gave_way[3:]) > 1e-3 * compliance
    np.testing.assert_allclose(body.clamp.gave_way[3:], turn @ body.clamp_wrench()[3:], atol=2e-8)
    # From a wrong prediction it comes back.
    wrong = np.cross([0.0, 0.0, 0.05], first)
    again = body.solve_equilibrium(
        material, GRAVITY, conditions=conditions, prediction=wrong
    ).positions
    np.testing.assert_allclose(again, first, atol=2e-7)


def test_a_clamp_that_gives_way_in_fewer_ways_forgets_the_others():
    mesh = beam_mesh((8, 2, 2))
    held, material = held_end(mesh).astype(np.int32), uniform_material(mesh, 2e5)
    turns = np.diag([0.0, 0.0, 0.0, 1.0, 0.6, 0.8])
    slides = np.diag([2e-3, 1e-3, 3e-3, 0.0, 0.0, 0.0])
    body, fresh = (StaticBody(mesh, Element.QUADRATIC, held) for _ in range(2))
    body.solve_equilibrium(
        material, GRAVITY, conditions=Conditions(clamp_compliance=slides + turns)
    )
    assert np.abs(body.clamp.gave_way[:3]).max() > 1e-5
    conditions = Conditions(clamp_compliance=turns)
    again = body.solve_equilibrium(material, GRAVITY, conditions=conditions).positions
    first = fresh.solve_equilibrium(material, GRAVITY, conditions=conditions).positions
    assert (body.clamp.gave_way[:3] == 0.0).all()
    np.testing.assert_allclose(again, first, atol=2e-7)
