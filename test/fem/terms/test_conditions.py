# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects on a body at rest: tangents by finite differences, and absence bit for bit."""

from dataclasses import replace

from diffcal_ros.effects.contact_plane import Plane
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.statics.force_changes import Change, gravity_loads
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.fem.terms import strain_stiffening
from diffcal_ros.fem.terms.conditions import Conditions
from diffcal_ros.fem.terms.potential_terms import ShearRatio
from diffcal_ros.fem.terms.rest_shape import bent
from diffcal_ros.material import Material
import numpy as np
import pytest

GRAVITY = np.array([0.4, -9.7, 0.8])
# Tangents and adjoint by the same linear solver.
_SAME = 1e-7
STIFFENING = ShearRatio(0.4, strain_stiffening)
# An axis across, and along, of no special direction.
SLANTED = np.outer([0.3, 0.8, -0.4], [0.3, 0.8, -0.4])
PLANE = Plane(np.array([0.0, 0.96, 0.28]), -0.045)
# Twist and curvatures that are others in each third [1/m].
BENDS = np.array([[2.0, 0.5, -0.3], [-1.0, -0.8, 0.6], [3.0, 0.2, 1.0]])


@pytest.fixture
def body(beam_mesh) -> StaticBody:
    held = np.flatnonzero(beam_mesh.rest_positions[:, 0] > 0.07).astype(np.int32)
    return StaticBody(beam_mesh, Element.QUADRATIC, held)


def _weights(body: StaticBody) -> np.ndarray:
    """A derivative by positions, of held nodes too, that does not vanish for any change."""
    return 1.0 + np.random.default_rng(8).random(body.discretisation.rest_nodes.shape)


def material(body: StaticBody) -> Material:
    ones = np.ones(body.mesh.tet_count)
    share = body.mesh.rest_positions[body.mesh.tets].mean(axis=1)[:, 0]
    return Material(2.5e5 * (1.0 + 2.0 * share), 0.47 * ones, 1080.0 * ones)


def masses(body: StaticBody) -> np.ndarray:
    share = body.axes.fraction(body.discretisation.rest_nodes)
    weights = np.exp(-0.5 * ((share - 0.7) / 0.1) ** 2)
    return 0.004 * weights / weights.sum()


def giving_way() -> np.ndarray:
    """A clamp that gives way otherwise in each direction, and turns under forces, too."""
    root = np.diag([0.06, 0.05, 0.07, 0.6, 0.4, 0.5]) + 0.02 * np.tri(6, k=-2)
    compliance: np.ndarray = root @ root.T
    return compliance


def rises(body: StaticBody) -> np.ndarray:
    """What the body lies on is lower in the middle."""
    fraction = body.axes.fraction(body.discretisation.rest_nodes)
    height: np.ndarray = 0.003 * (2.0 * fraction - 1.0) ** 2
    return height


def everything(body: StaticBody) -> Conditions:
    """All effects at once, of sizes that matter."""
    return Conditions(
        clamp_motion=np.array([0.002, -0.001, 0.003, 0.02, -0.03, 0.05]),
        clamp_compliance=giving_way(),
        added_masses=masses(body),
        rest_curvature=np.array([0.6, -0.4]),
        rest_bends=BENDS,
        potentials=(STIFFENING, replace(PLANE, rises=rises(body))),
    )


DIRECTIONS = {
    **{f'clamp {axis}': Conditions(clamp_motion=np.eye(6)[axis]) for axis in (0, 1, 3, 4, 5)},
    'compliance': Conditions(clamp_compliance=np.diag([0.0, 0.0, 0.0, 1.0, 1.0, 1.0])),
    'shift compliance': Conditions(clamp_compliance=np.diag([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])),
    'compliance about one axis': Conditions(clamp_compliance=np.pad(SLANTED, ((3, 0), (3, 0)))),
    'curvature': Conditions(rest_curvature=np.array([0.8, 0.6])),
    'bend in the middle': Conditions(rest_bends=np.array([[0, 0, 0], [0, 0.8, 0.6], [0, 0, 0]])),
    'twist at the tip': Conditions(rest_bends=np.eye(3)[[1, 1, 0]] * [1.0, 0.0, 0.0]),
    'stiffening': Conditions(potentials=(ShearRatio(1.0, strain_stiffening),)),
    'plane': Conditions(potentials=(Plane(np.zeros(3), 1.0),)),
    'plane normal': Conditions(potentials=(Plane(np.array([0.3, -0.28, 0.96]), 0.0),)),
    'rises': Conditions(potentials=(Plane(np.zeros(3), 0.0, np.ones(1)),)),
}
STEPS = {
    'compliance': 0.01,
    'shift compliance': 1e-3,
    'compliance about one axis': 0.01,
    'curvature': 0.01,
    'bend in the middle': 0.01,
    'twist at the tip': 0.01,
    'stiffening': 0.01,
    'plane': 1e-4,
    'rises': 1e-4,
}


def stepped(conditions: Conditions, change: Conditions, step: float) -> Conditions:
    stiffening, plane = conditions.potentials
    more = change.rest_bends
    for along in change.potentials:
        if isinstance(along, Plane):
            higher = 0.0 if along.rises is None else step * along.rises
            plane = Plane(
                plane.normal + step * along.normal,
                plane.height + step * along.height,
                plane.rises + higher,
            )
        else:
            stiffening = replace(stiffening, ratio=stiffening.ratio + step * along.ratio)
    return replace(
        conditions,
        clamp_motion=conditions.clamp_motion + step * change.clamp_motion,
        clamp_compliance=conditions.clamp_compliance + step * change.clamp_compliance,
        rest_curvature=conditions.rest_curvature + step * change.rest_curvature,
        rest_bends=conditions.rest_bends + (0.0 if more is None else step * more),
        potentials=(stiffening, plane),
    )


@pytest.mark.parametrize('name', DIRECTIONS)
def test_tangents_with_every_effect_there(body, name):
    change, here = DIRECTIONS[name], everything(body)
    if name == 'rises':
        change = Conditions(potentials=(Plane(np.zeros(3), 0.0, rises(body) / 0.003),))
    numbers = material(body)

    def settled(conditions: Conditions) -> np.ndarray:
        return body.solve_equilibrium(numbers, GRAVITY, conditions=conditions).positions

    settled(here)
    tangent = body.tangents([Change(conditions=change)])[0]
    assert np.abs(tangent).max() > 0.0
    weights = _weights(body)
    by_adjoint = body.gradient(weights).along(Change(conditions=change))
    assert by_adjoint == pytest.approx(float((weights * tangent).sum()), rel=_SAME)
    size = STEPS.get(name, 1e-3)
    errors, slopes = [], []
    for step in (size, size / 2.0, size / 4.0):
        ahead = settled(stepped(here, change, step))
        behind = settled(stepped(here, change, -step))
        difference = (ahead - behind) / (2.0 * step)
        errors.append(np.linalg.norm(difference - tangent) / np.linalg.norm(tangent))
        slopes.append(float((weights * difference).sum()))
    assert min(errors) < 2e-3, errors
    assert errors[-1] < 0.5 * errors[0] or max(errors) < 2e-3, errors
    assert slopes[-1] == pytest.approx(by_adjoint, rel=4e-3), slopes


@pytest.mark.parametrize('name', ['added mass', 'modulus', 'tilt'])
def test_other_tangents_with_every_effect_there(body, name):
    here, numbers = everything(body), material(body)
    added = masses(body)
    change = {
        'added mass': Change(conditions=Conditions(added_masses=added / 0.004)),
        'modulus': Change(youngs_modulus=numbers.youngs_modulus),
        'tilt': Change(gravity=np.cross([1.0, 0.0, 0.0], GRAVITY)),
    }[name]

    def settled(step: float) -> np.ndarray:
        if name == 'added mass':
            conditions = replace(here, added_masses=added * (1.0 + step / 0.004))
            return body.solve_equilibrium(numbers, GRAVITY, conditions=conditions).positions
        if name == 'modulus':
            stiffer = replace(numbers, youngs_modulus=numbers.youngs_modulus * (1.0 + step))
            return body.solve_equilibrium(stiffer, GRAVITY, conditions=here).positions
        tilted = GRAVITY + step * change.gravity
        return body.solve_equilibrium(numbers, tilted, conditions=here).positions

    settled(0.0)
    tangent = body.tangents([change])[0]
    weights = _weights(body)
    by_adjoint = body.gradient(weights).along(change)
    assert by_adjoint == pytest.approx(float((weights * tangent).sum()), rel=_SAME)
    size = 2e-4 if name == 'added mass' else 2e-3
    for step in (size, size / 2.0, size / 4.0):
        difference = (settled(step) - settled(-step)) / (2.0 * step)
        error = np.linalg.norm(difference - tangent) / np.linalg.norm(tangent)
        assert error < 2e-3, (step, error)
        assert float((weights * difference).sum()) == pytest.approx(by_adjoint, rel=4e-3)


def test_a_gradient_answers_for_its_own_state_wherever_the_body_is(body):
    here, numbers = everything(body), material(body)
    body.solve_equilibrium(numbers, GRAVITY, conditions=here)
    gradient = body.gradient(_weights(body))
    by_mass = Change(conditions=Conditions(added_masses=masses(body)))
    before = gradient.along(by_mass)
    bare = replace(here, rest_curvature=np.zeros(2), rest_bends=None)
    elsewhere = body.solve_equilibrium(numbers, 0.9 * GRAVITY, conditions=bare)
    there = body.gradient(_weights(body)).along(by_mass)
    assert gradient.along(by_mass) == pytest.approx(before, rel=1e-12)
    np.testing.assert_array_equal(body.state.positions, elsewhere.positions)
    assert body.gradient(_weights(body)).along(by_mass) == there != before


def test_forces_on_nodes_act_as_the_weight_that_they_are(body):
    here, numbers = everything(body), material(body)
    body.solve_equilibrium(numbers, GRAVITY, conditions=replace(here, added_masses=None))
    turned = np.array([3.0, 0.5, -1.0])
    weights = gravity_loads(body.discretisation, numbers.density, turned)
    by_gravity, by_forces = body.tangents(
        [Change(gravity=turned), Change(conditions=Conditions(forces=weights))]
    )
    np.testing.assert_allclose(by_forces, by_gravity, atol=1e-9 * np.abs(by_gravity).max())


def test_forces_that_stay_are_a_weight_of_their_own(body):
    numbers, turned = material(body), np.array([3.0, 0.5, -1.0])
    weights = gravity_loads(body.discretisation, numbers.density, turned)
    expected = body.solve_equilibrium(numbers, GRAVITY + turned).positions
    found = body.solve_equilibrium(
        numbers, GRAVITY, conditions=Conditions(forces=weights)
    ).positions
    np.testing.assert_allclose(found, expected, atol=1e-8)


def test_conditions_that_are_joined_act_together(body):
    one, other = (
        everything(body),
        Conditions(added_masses=masses(body), clamp_compliance=0.2 * np.eye(6)),
    )
    both = one.joined(other)
    np.testing.assert_array_equal(both.added_masses, 2.0 * masses(body))
    np.testing.assert_array_equal(both.clamp_compliance, giving_way() + 0.2 * np.eye(6))
    assert both.potentials == one.potentials
    assert other.joined(other).forces is None


def test_two_potentials_of_one_kind_are_refused(body):
    twice = Conditions(potentials=(PLANE, replace(PLANE, height=0.1)))
    with pytest.raises(ValueError, match='of one kind'):
        body.solve_equilibrium(material(body), GRAVITY, conditions=twice)


def test_absent_effects_change_nothing_at_all(beam_mesh):
    held = np.flatnonzero(beam_mesh.rest_positions[:, 0] > 0.07).astype(np.int32)
    plain, given = (StaticBody(beam_mesh, Element.QUADRATIC, held) for _ in range(2))
    without = plain.solve_equilibrium(material(plain), GRAVITY)
    with_zeros = given.solve_equilibrium(material(given), GRAVITY, conditions=Conditions())
    np.testing.assert_array_equal(without.positions, with_zeros.positions)


def test_a_bend_is_about_the_axes_that_are_given(body):
    numbers, conditions = material(body), Conditions(rest_curvature=np.array([3.0, -2.0]))
    along, wide, narrow = body.axes.axes
    axes = replace(body.axes, axes=np.stack([along, narrow, -wide]))
    other = StaticBody(body.mesh, Element.QUADRATIC, body.held_vertices, axes=axes)
    turned = other.solve_equilibrium(numbers, GRAVITY, conditions=conditions).positions
    tangents = other.tangents([Change(conditions=DIRECTIONS['curvature'])] * 2)
    np.testing.assert_array_equal(tangents[0], tangents[1])
    again = other.solve_equilibrium(numbers, GRAVITY, conditions=conditions).positions
    np.testing.assert_allclose(again, turned, atol=1e-9)
    same = Conditions(rest_curvature=np.array([2.0, 3.0]))
    np.testing.assert_allclose(
        body.solve_equilibrium(numbers, GRAVITY, conditions=same).positions, turned, atol=1e-7
    )


def test_effects_that_go_leave_the_body_as_it_was(body):
    numbers = material(body)
    before = body.solve_equilibrium(numbers, GRAVITY).positions
    body.solve_equilibrium(numbers, GRAVITY, conditions=everything(body))
    after = body.solve_equilibrium(numbers, GRAVITY).positions
    np.testing.assert_allclose(after, before, atol=1e-8)


def test_a_shape_bent_without_stress_stays_so_without_weight(body):
    curvature = np.array([3.0, -2.0])
    state = body.solve_equilibrium(
        material(body), np.zeros(3), conditions=Conditions(rest_curvature=curvature)
    )
    vertices = body.mesh.vertex_count
    expected = bent(body.mesh.rest_positions, body.axes, np.array([[0.0, *curvature]]))
    np.testing.assert_allclose(state.positions[:vertices], expected, atol=2e-7)


def test_a_plane_carries_what_the_clamp_does_not(body):
    down, numbers = np.array([0.0, -9.8, 0.0]), material(body)
    free = body.solve_equilibrium(numbers, down)
    lowest = free.positions[:, 1].min()
    plane = Plane(np.array([0.0, 1.0, 0.0]), lowest + 0.004)
    resting = body.solve_equilibrium(numbers, down, conditions=Conditions(potentials=(plane,)))
    assert resting.positions[:, 1].min() > plane.height - 2e-4
    weight = 9.8 * 1080.0 * body.mesh.volumes.sum()
    # The clamp's share is what the plane leaves.
    assert 0.0 < resting.reactions[:, 1].sum() < 0.999 * weight
    below = replace(plane, height=lowest - 0.01)
    untouched = body.solve_equilibrium(numbers, down, conditions=Conditions(potentials=(below,)))
    np.testing.assert_allclose(untouched.positions, free.positions, atol=1e-8)


def test_a_clamp_that_gives_way_shifts_with_the_weight(body):
    gravity, compliance = np.array([3.0, -9.0, 2.0]), 0.02
    firm = body.solve_equilibrium(material(body), gravity).positions
    conditions = Conditions(clamp_compliance=np.diag(np.repeat([compliance, 0.0], 3)))
    given = body.solve_equilibrium(material(body), gravity, conditions=conditions).positions
    weight = body.gravity_loads(material(body).density, gravity).sum(axis=0)
    assert np.linalg.norm(weight) > 0.1
    # The body hangs as it did, elsewhere.
    np.testing.assert_allclose(
        given - firm, np.tile(compliance * weight, (len(firm), 1)), atol=2e-7
    )


def test_a_clamp_that_gives_way_turns_with_its_moment(body):
    down, compliance = np.array([0.0, -9.8, 0.0]), np.diag([0.2, 0.3, 0.5])
    conditions = Conditions(clamp_compliance=np.pad(compliance, ((3, 0), (3, 0))))
    body.solve_equilibrium(material(body), down, conditions=conditions)
    held, rest = body.held_nodes, body.discretisation.rest_nodes
    moved, still = body.state.positions[held], rest[held]
    center = body.axes.center
    turn, *_ = np.linalg.lstsq(
        np.concatenate([np.cross(np.eye(3)[axis], still - center) for axis in range(3)], axis=1)
        .reshape(len(held), 3, 3)
        .transpose(0, 2, 1)
        .reshape(-1, 3),
        (moved - still).ravel(),
        rcond=None,
    )
    expected = compliance @ body.clamp_wrench()[3:]
    np.testing.assert_allclose(turn, expected, rtol=0.02, atol=1e-4)
    assert np.linalg.norm(expected) > 0.01
