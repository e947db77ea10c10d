# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a moving body does before, at and after its release, under which effects, and refusals."""

from dataclasses import replace

from diffcal_ros.damping import Damping
from diffcal_ros.effects.contact_plane import Plane
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.motion.inputs import MotionChange, MotionError, Release
from diffcal_ros.fem.motion.moving_body import MovingBody
from diffcal_ros.fem.terms import strain_stiffening
from diffcal_ros.fem.terms.conditions import Conditions
from diffcal_ros.fem.terms.potential_terms import ShearRatio
from diffcal_ros.rigid_transform import rotation_matrix
import numpy as np
import pytest
from support.beams import beam_mesh
from support.bodies import GRAVITY, hanging_beam, uniform_material
from support.moving_bodies import Case, directions, RELEASE_TIME, released_beam

STEPS = (2e-3, 1e-3)
# Newton leaves 1e-6 of the mean load in a step; differences divide what is left of it by theirs.
_RELATIVE = 2e-4


def test_the_body_rests_until_its_release(random) -> None:
    case = released_beam(Element.LINEAR, random)
    case = replace(case, stamps=np.array([-1.0, 0.0, RELEASE_TIME, RELEASE_TIME + 0.05]))
    motion = case.run()
    np.testing.assert_array_equal(motion.positions[0], motion.positions[2])
    assert not motion.velocities[:2].any()
    support = case.body.release.supported_vertices
    rest = case.body.static_body.mesh.rest_positions
    np.testing.assert_array_equal(motion.positions[0, support], rest[support])
    assert np.abs(motion.positions[3, support] - rest[support]).max() > 1e-3


def test_a_later_release_shifts_the_motion(random) -> None:
    case = released_beam(Element.LINEAR, random)
    first = case.run().positions
    later = replace(case, stamps=case.stamps + 0.21, release_time=RELEASE_TIME + 0.21).run()
    np.testing.assert_allclose(later.positions, first, atol=1e-9)


def test_without_a_release_nothing_moves(random) -> None:
    case = released_beam(Element.LINEAR, random)
    case = replace(case, body=MovingBody(case.body.static_body, None), release_time=0.0)
    motion = case.run()
    assert np.abs(motion.positions - motion.positions[0]).max() < 1e-7


def test_a_motion_long_after_its_release_is_the_equilibrium() -> None:
    mesh = beam_mesh((4, 1, 1))
    static = hanging_beam(Element.LINEAR, mesh)
    material = uniform_material(mesh)
    support = np.flatnonzero(mesh.rest_positions[:, 0] > 0.11).astype(np.int32)
    body = MovingBody(static, Release(support, 0.0))
    damping = Damping(np.full(mesh.tet_count, 400.0), 20.0)
    last = body.simulate(material, damping, GRAVITY, np.array([3.0])).positions[0]
    np.testing.assert_allclose(
        last, static.solve_equilibrium(material, GRAVITY).positions, atol=1e-6
    )


def _turning(case: Case) -> Case:
    """Turn and shift the clamp smoothly."""
    static = case.body.static_body
    held = static.mesh.rest_positions[static.held_vertices]

    def motion(time: float) -> np.ndarray:
        turn = rotation_matrix(np.array([0.5, 0.2, -0.3]) * np.sin(9.0 * time))
        return held @ turn.T + np.array([0.0, 0.01, 0.02]) * np.sin(14.0 * time) ** 2

    return replace(case, held_motion=motion)


def _check_tangent(case: Case, change: MotionChange, moved) -> None:
    motion = case.run()
    tangent = case.body.tangents([change])[0]
    assert np.abs(tangent).max() > 0.0
    errors = []
    for step in STEPS:
        ahead, behind = moved(step).run().positions, moved(-step).run().positions
        difference = (ahead - behind) / (2.0 * step)
        errors.append(np.linalg.norm(difference - tangent) / np.linalg.norm(tangent))
    assert min(errors) < _RELATIVE, errors
    assert np.isfinite(motion.positions).all()


@pytest.mark.parametrize('integrator', ['implicit', 'semi_implicit'])
@pytest.mark.parametrize('name', ['youngs_modulus', 'release_time'])
def test_derivatives_while_the_clamp_turns(name, integrator, random) -> None:
    case = released_beam(Element.LINEAR, random, counts=(3, 1, 1), integrator=integrator)
    case = _turning(replace(case, stamps=np.array([0.004, 0.03, 0.071])))
    change = directions(case, random)[name]
    _check_tangent(case, change, lambda step: case.moved(change, step))
    case.run()
    tangent = case.body.tangents([change])[0]
    by_positions = random.normal(size=tangent.shape)
    gradient = case.body.gradient(by_positions)
    assert gradient.along(change) == pytest.approx(float((tangent * by_positions).sum()), rel=1e-6)


def _effects(case: Case) -> Conditions:
    nodes = case.body.static_body.discretisation.rest_nodes
    return Conditions(
        clamp_motion=np.array([0.002, -0.001, 0.003, 0.02, -0.03, 0.05]),
        added_masses=1e-3 * nodes[:, 0] / nodes[:, 0].sum(),
        potentials=(
            ShearRatio(0.4, strain_stiffening),
            Plane(np.array([0.0, 0.96, 0.28]), -0.001),
        ),
    )


EFFECTS = {
    'clamp': (Conditions(clamp_motion=np.array([0.1, 0.2, -0.1, 1.0, -2.0, 0.5])), 0.1),
    'stiffening': (Conditions(potentials=(ShearRatio(1.0, strain_stiffening),)), 1.0),
    'plane': (Conditions(potentials=(Plane(np.zeros(3), 1.0),)), 1e-4),
}


@pytest.mark.parametrize('name', EFFECTS)
def test_effects_in_motion(name, random) -> None:
    case = released_beam(Element.LINEAR, random, counts=(3, 1, 1))
    effects = _effects(case)
    if name != 'plane':
        # A step along the others moves many nodes on to the plane or off it: every one is a kink.
        effects = replace(effects, potentials=effects.potentials[:1])
    case = replace(case, stamps=np.array([0.004, 0.03, 0.05]), conditions=effects)
    effect, size = EFFECTS[name]

    def moved(step: float) -> Case:
        now = case.conditions
        stiffening, *planes = now.potentials
        by = step * size
        if name == 'clamp':
            now = replace(now, clamp_motion=now.clamp_motion + by * effect.clamp_motion)
        elif name == 'stiffening':
            stiffer = replace(stiffening, ratio=stiffening.ratio + by)
            now = replace(now, potentials=(stiffer, *planes))
        else:
            raised = [replace(plane, height=plane.height + by) for plane in planes]
            now = replace(now, potentials=(stiffening, *raised))
        return replace(case, conditions=now)

    case.run()
    tangent = case.body.tangents([MotionChange(conditions=effect)])[0] * size
    errors = []
    for step in STEPS:
        difference = (moved(step).run().positions - moved(-step).run().positions) / (2.0 * step)
        errors.append(np.linalg.norm(difference - tangent) / np.linalg.norm(tangent))
    # A node that touches the plane or leaves it in a step bends the path's dependence.
    assert min(errors) < 5e-3, errors


def test_added_mass_is_heavy_and_slow(random) -> None:
    case = released_beam(Element.LINEAR, random, counts=(3, 1, 1))
    nodes = case.body.static_body.discretisation.rest_nodes
    masses = 2e-3 * nodes[:, 0] / nodes[:, 0].sum()
    case = replace(case, conditions=Conditions(added_masses=masses))
    change = MotionChange(conditions=Conditions(added_masses=masses))
    _check_tangent(
        case,
        change,
        lambda step: replace(case, conditions=Conditions(added_masses=(1.0 + step) * masses)),
    )


def test_adjoint_with_effects_agrees_with_the_tangents(random) -> None:
    case = released_beam(Element.LINEAR, random, counts=(3, 1, 1))
    case = replace(case, stamps=np.array([0.004, 0.03, 0.05]), conditions=_effects(case))
    motion = case.run()
    by_positions = random.normal(size=motion.positions.shape)
    gradient = case.body.gradient(by_positions)
    changes = directions(case, random)
    tangents = case.body.tangents(list(changes.values()))
    for (name, change), tangent in zip(changes.items(), tangents, strict=True):
        forward = float((tangent * by_positions).sum())
        assert gradient.along(change) == pytest.approx(forward, rel=1e-6), name


def test_a_gradient_of_a_motion_refuses_effects(random) -> None:
    case = released_beam(Element.LINEAR, random, counts=(3, 1, 1))
    motion = case.run()
    gradient = case.body.gradient(np.ones_like(motion.positions))
    with pytest.raises(NotImplementedError, match='does not know effects: use `tangents`'):
        gradient.along(MotionChange(conditions=Conditions(air_drag=1.0)))


def test_a_step_that_does_not_converge_is_halved_and_said_so() -> None:
    mesh = beam_mesh((4, 1, 1))
    support = np.flatnonzero(mesh.rest_positions[:, 0] > 0.11).astype(np.int32)
    lifted = mesh.rest_positions[support] + np.array([-0.03, 0.0, 0.05])
    body = MovingBody(
        hanging_beam(Element.LINEAR, mesh), Release(support, 0.0, lifted), time_step=0.05
    )
    damping = Damping(np.full(mesh.tet_count, 5.0))
    motion = body.simulate(uniform_material(mesh), damping, GRAVITY, np.array([0.2]))
    assert motion.halvings > 0
    assert motion.step_count > 4


@pytest.mark.parametrize(
    ('integrator', 'time_step', 'message'),
    [
        ('implicit', 1 / 240, r"does not go on 17\.7 ms .*4\.1e-06 s: .*raise Young's modulus"),
        ('semi_implicit', 5e-5, r'diverges even with .*3\.1e-06 s: .*use the implicit integrator'),
    ],
)
def test_a_motion_that_no_step_can_follow_is_given_up(
    integrator, time_step, message, random
) -> None:
    counts = (4, 1, 1)
    case = released_beam(
        Element.LINEAR, random, integrator=integrator, time_step=time_step, counts=counts
    )
    rest = case.body.static_body.discretisation.rest_nodes[case.body.static_body.held_nodes]

    def torn_away(time: float) -> np.ndarray:
        return rest + (10.0 if time > 0.03 else 0.0)

    with pytest.raises(MotionError, match=message):
        replace(case, held_motion=torn_away, stamps=np.array([0.05])).run()


def test_refusals(random) -> None:
    case = released_beam(Element.LINEAR, random, counts=(2, 1, 1))
    static, release = case.body.static_body, case.body.release
    with pytest.raises(ValueError, match="'leapfrog' is unknown: use one of implicit"):
        MovingBody(static, release, integrator='leapfrog')
    with pytest.raises(ValueError, match='must be positive'):
        MovingBody(static, release, time_step=0.0)
    with pytest.raises(ValueError, match='1 support positions are given for'):
        MovingBody(static, replace(release, support_positions=np.zeros((1, 3))))
    with pytest.raises(RuntimeError, match='call simulate first'):
        case.body.tangents([MotionChange()])
    with pytest.raises(ValueError, match='finite times'):
        replace(case, stamps=np.array([0.0, np.nan])).run()
    light = np.full(static.discretisation.node_count, -1.0)
    with pytest.raises(MotionError, match='positive mass'):
        replace(case, conditions=Conditions(added_masses=light)).run()
    motion = case.run()
    with pytest.raises(ValueError, match='must be like the positions'):
        case.body.gradient(motion.positions[:1])
