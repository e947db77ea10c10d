# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Steps with an old factorisation: as exact as Newton's, whatever they begin from."""

from dataclasses import replace

from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.elements.prolongation import refine
from diffcal_ros.fem.motion.implicit_step import ImplicitStep
from diffcal_ros.fem.motion.moving_body import MovingBody
from diffcal_ros.fem.motion.step_system import StepSystem
from diffcal_ros.fem.statics.static_body import StaticBody
import numpy as np
import pytest
from support.moving_bodies import released_beam

# What is left of the forces moves no node by more [m].
_SAME = 1e-9


@pytest.fixture
def factored(monkeypatch) -> list[float]:
    """The steps of all factorisations [s]."""
    made: list[float] = []
    factor = StepSystem.factor

    def counted(self, rule, positions) -> None:
        made.append(rule.step)
        factor(self, rule, positions)

    monkeypatch.setattr(StepSystem, 'factor', counted)
    return made


@pytest.mark.parametrize('element', list(Element))
def test_old_factorisations_find_what_newtons_method_finds(element, random, monkeypatch) -> None:
    case = released_beam(element, random, counts=(4, 1, 2))
    held = case.run()
    monkeypatch.setattr(ImplicitStep, '_by_held_factor', lambda *_: None)
    by_newton = case.run()
    assert np.abs(by_newton.positions - by_newton.positions[0]).max() > 1e-3
    np.testing.assert_allclose(held.positions, by_newton.positions, rtol=0.0, atol=_SAME)


def test_old_factorisations_save_most_new_ones(factored, random) -> None:
    motion = released_beam(Element.QUADRATIC, random, counts=(4, 1, 1)).run()
    assert 0 < len(factored) < 0.4 * motion.step_count


def test_the_motion_before_is_a_beginning_and_no_more(random) -> None:
    case = released_beam(Element.LINEAR, random, counts=(4, 1, 2))
    other = released_beam(Element.LINEAR, np.random.default_rng(4), counts=(4, 1, 2))
    alone = case.run()
    other.run()
    beside = case.run(near=other.body.path)
    np.testing.assert_allclose(beside.positions, alone.positions, rtol=0.0, atol=_SAME)


def test_a_motion_of_other_steps_serves_as_far_as_it_goes(random) -> None:
    case = released_beam(Element.LINEAR, random, counts=(4, 1, 2))
    shorter = released_beam(Element.LINEAR, random, counts=(4, 1, 2), time_step=1 / 500)
    alone = case.run()
    shorter.body.simulate(
        case.material, case.damping, case.gravity, case.stamps[:2], release_time=0.0
    )
    beside = case.run(near=shorter.body.path)
    np.testing.assert_allclose(beside.positions, alone.positions, rtol=0.0, atol=_SAME)


def test_a_coarse_motion_is_one_of_a_finer_mesh(random) -> None:
    coarse = released_beam(Element.QUADRATIC, random, counts=(3, 1, 1))
    coarse.run()
    discretisation = coarse.body.static_body.discretisation
    mesh = coarse.body.static_body.mesh
    leading = coarse.body.path.mapped(refine(mesh, discretisation).fine_from_coarse)
    assert leading.positions[0].shape[0] > discretisation.node_count
    ends = leading.positions[-1][: mesh.vertex_count], coarse.body.path.positions[-1]
    np.testing.assert_allclose(ends[0], ends[1][: mesh.vertex_count], atol=1e-12)


def test_a_motion_without_derivatives_is_found_with_a_rough_factorisation(random) -> None:
    exact = released_beam(Element.QUADRATIC, random, counts=(4, 1, 1))
    static = exact.body.static_body
    rough = StaticBody(static.mesh, Element.QUADRATIC, static.held_vertices, solver='multifrontal')
    body = MovingBody(rough, exact.body.release, has_derivatives=False)
    expected = exact.run()
    found = replace(exact, body=body).run()
    assert not np.array_equal(found.positions, expected.positions)
    np.testing.assert_allclose(found.positions, expected.positions, rtol=0.0, atol=1e-8)
