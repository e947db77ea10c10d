# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A clamp that gives way while the body swings: where that leads, and how all follows changes."""

from dataclasses import replace

from diffcal_ros.damping import Damping
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.giving_clamp import GivingClamp
from diffcal_ros.fem.motion.inputs import MotionChange, MotionError, Release
from diffcal_ros.fem.motion.lumped_mass import lumped_fractions, lumped_masses
from diffcal_ros.fem.motion.moving_body import MovingBody
from diffcal_ros.fem.terms.conditions import Conditions
import numpy as np
import pytest
from support.beams import beam_mesh
from support.bodies import GRAVITY, hanging_beam, uniform_material
from support.moving_bodies import Case, directions, released_beam

# Shifts [m/N] and turns [rad/(N m)] that differ along all axes, and one between two.
COMPLIANCE = np.diag([1e-3, 2e-3, 1.5e-3, 3.0, 2.0, 4.0])
COMPLIANCE[4, 5] = COMPLIANCE[5, 4] = 0.7
# Largest error of a tangent against differences at the best of three step sizes, relative.
_RELATIVE = 1e-5
_STEPS = (1e-2, 1e-3, 1e-4)


def _giving(element: Element, random, compliance: np.ndarray = COMPLIANCE) -> Case:
    case = released_beam(element, random, counts=(4, 1, 1))
    conditions = Conditions(clamp_compliance=compliance)
    return replace(case, stamps=np.array([0.004, 0.03, 0.09]), conditions=conditions)


def _changes(case: Case, random) -> dict[str, MotionChange]:
    """Return changes, each of a size at which a step of one would be large."""
    motion = np.array([0.001, -0.002, 0.001, 0.05, -0.1, 0.08])
    return {
        'compliance': MotionChange(conditions=Conditions(clamp_compliance=0.5 * COMPLIANCE)),
        'clamp_motion': MotionChange(conditions=Conditions(clamp_motion=motion)),
        **{
            name: own
            for name, own in directions(case, random).items()
            if name in {'youngs_modulus', 'damping', 'gravity', 'density', 'release_time'}
        },
    }


def _moved(case: Case, change: MotionChange, step: float) -> Case:
    own, now = change.conditions, case.conditions
    if own is None:
        return case.moved(change, step)
    there = replace(
        now,
        clamp_compliance=now.clamp_compliance + step * own.clamp_compliance,
        clamp_motion=now.clamp_motion + step * own.clamp_motion,
    )
    return replace(case, conditions=there)


@pytest.mark.parametrize('element', list(Element))
@pytest.mark.slow
def test_tangents_are_those_of_differences(element, random) -> None:
    case = _giving(element, random)
    case.run()
    changes = _changes(case, random)
    tangents = case.body.tangents(list(changes.values()))
    for (name, change), tangent in zip(changes.items(), tangents, strict=True):
        errors = []
        for step in _STEPS:
            ahead, behind = (_moved(case, change, s).run().positions for s in (step, -step))
            off = np.linalg.norm((ahead - behind) / (2.0 * step) - tangent)
            errors.append(off / np.linalg.norm(tangent))
        assert errors[0] > 10.0 * errors[1] or errors[0] < _RELATIVE, (name, errors)
        assert min(errors) < _RELATIVE, (name, errors)


def test_a_rigid_clamp_has_a_tangent_of_giving_way(random) -> None:
    """Only one way from there is a body's: differences are of second order ahead."""
    case = _giving(Element.LINEAR, random, np.zeros((6, 6)))
    here = case.run().positions
    change = MotionChange(conditions=Conditions(clamp_compliance=COMPLIANCE))
    others = directions(case, random)['gravity']
    tangent, beside = case.body.tangents([change, others])
    errors = []
    for step in _STEPS:
        once, twice = (_moved(case, change, s).run().positions for s in (step, 2.0 * step))
        difference = (4.0 * once - twice - 3.0 * here) / (2.0 * step)
        errors.append(np.linalg.norm(difference - tangent) / np.linalg.norm(tangent))
    assert min(errors) < _RELATIVE, errors
    # What is asked for beside it is what it is alone.
    case.run()
    np.testing.assert_allclose(beside, case.body.tangents([others])[0], atol=1e-7)


@pytest.mark.parametrize('element', list(Element))
@pytest.mark.slow
def test_long_after_its_release_it_is_where_it_is_at_rest(element) -> None:
    mesh = beam_mesh((4, 1, 1))
    static, material = hanging_beam(element, mesh), uniform_material(mesh)
    support = np.flatnonzero(mesh.rest_positions[:, 0] > 0.11).astype(np.int32)
    body = MovingBody(static, Release(support, 0.0))
    damping = Damping(np.full(mesh.tet_count, 400.0), 20.0)
    conditions = Conditions(clamp_compliance=COMPLIANCE)
    last = body.simulate(
        material, damping, GRAVITY, np.array([4.0]), conditions=conditions
    ).positions[0]
    rests = static.solve_equilibrium(material, GRAVITY, conditions=conditions).positions
    stiff = static.solve_equilibrium(material, GRAVITY).positions
    assert np.abs(rests - stiff).max() > 3e-3
    np.testing.assert_allclose(last, rests, atol=1e-6)


@pytest.mark.slow
def test_a_stiff_body_swings_as_a_rigid_one_on_a_spring() -> None:
    """Its period is that of its moment of inertia on the clamp's stiffness."""
    mesh = beam_mesh((4, 1, 1))
    static, material = hanging_beam(Element.LINEAR, mesh), uniform_material(mesh, 2e9)
    support = np.flatnonzero(mesh.rest_positions[:, 0] > 0.11).astype(np.int32)
    per_moment = 0.4
    compliance = np.zeros((6, 6))
    compliance[5, 5] = per_moment  # About the axis across, around which it sags.
    body = MovingBody(static, Release(support, 0.0), time_step=1e-3)
    times = np.arange(0.0, 0.6, 2e-3)
    motion = body.simulate(
        material,
        Damping(np.zeros(mesh.tet_count)),
        np.array([0.0, -1.0, 0.0]),
        times,
        conditions=Conditions(clamp_compliance=compliance),
    )
    height = motion.positions[:, support, 1].mean(axis=1)
    nodes = static.discretisation.rest_nodes - static.clamp.center - static.origin
    fractions = lumped_fractions(static.discretisation)
    masses = lumped_masses(static.discretisation, fractions, material.density)
    masses[static.held_nodes] = 0.0
    inertia = float(masses @ (nodes[:, 0] ** 2 + nodes[:, 1] ** 2))
    period = 2.0 * np.pi * np.sqrt(inertia * per_moment)
    middle = 0.5 * (height.min() + height.max())
    crossings = times[1:][(height[1:] < middle) & (height[:-1] >= middle)]
    assert len(crossings) >= 3
    assert np.diff(crossings).mean() == pytest.approx(period, rel=0.02)


def test_what_it_gives_way_by_is_told_from_where_points_are(random) -> None:
    static = hanging_beam(Element.LINEAR, beam_mesh((4, 1, 1)))
    conditions = Conditions(clamp_compliance=COMPLIANCE)
    clamp = GivingClamp.of(static.clamp, static.held_nodes, conditions)
    points = static.discretisation.rest_nodes[static.held_nodes]
    gave_way = np.array([0.001, -0.002, 0.003, 0.1, -0.2, 0.15])
    there = clamp.place(points, gave_way)
    np.testing.assert_allclose(clamp.followed(points, there), gave_way, atol=1e-9)
    np.testing.assert_allclose(clamp.unplaced(there, gave_way), points, atol=1e-12)


def test_steps_and_gradients_that_do_not_follow_it_refuse_it(random) -> None:
    case = _giving(Element.LINEAR, random)
    motion = case.run()
    with pytest.raises(NotImplementedError, match='use `tangents`'):
        case.body.gradient(np.ones_like(motion.positions))
    explicit = released_beam(Element.LINEAR, random, integrator='semi_implicit', counts=(3, 1, 1))
    with pytest.raises(MotionError, match='clamp_compliance'):
        replace(explicit, conditions=case.conditions).run()
    explicit.run()
    with pytest.raises(MotionError, match='implicit integrator'):
        explicit.body.tangents([MotionChange(conditions=case.conditions)])
