# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Cables: derivatives by finite differences, equilibrium by a second route, slack, routes."""

from dataclasses import replace

from diffcal_ros.fem.elements.element import discretise, Element
from diffcal_ros.fem.elements.sparse_pattern import make_pattern
from diffcal_ros.fem.laws import linear_elastic
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.fem.terms.cable import CableTerm
from diffcal_ros.fem.terms.cable_route import CableRoute, route_through, RouteError
from diffcal_ros.fem.terms.conditions import CableState, Conditions
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
import pytest
from support.beams import beam_mesh, held_end
from support.bodies import GRAVITY, uniform_material

# Along the upper side of the beam of 120 x 30 x 20 mm, and along one edge of it, not straight.
UPPER = np.array([[0.001, 0.025, 0.011], [0.041, 0.027, 0.008], [0.083, 0.023, 0.012]])
SIDE = np.array([[0.003, 0.008, 0.004], [0.05, 0.006, 0.006], [0.117, 0.009, 0.003]])
STIFFNESS = 800.0
STEPS = (1e-4, 1e-5, 1e-6)
# Central differences of smooth functions at the best of three steps.
EXACT = 1e-6


def routes(mesh: TetMesh) -> tuple[CableRoute, ...]:
    return route_through(mesh, UPPER), route_through(mesh, SIDE)


def bent(term: CableTerm, mesh: TetMesh, element: Element, random) -> np.ndarray:
    """Nodes at random places near a bent shape."""
    nodes = discretise(mesh, element).rest_nodes
    curled = nodes + np.outer(nodes[:, 0] ** 2, [0.3, 4.0, -2.0])
    return curled + random.normal(scale=5e-4, size=nodes.shape)


def make_term(element: Element, stretch: float, random) -> tuple[CableTerm, np.ndarray]:
    mesh = beam_mesh()
    term = CableTerm(route_through(mesh, UPPER), discretise(mesh, element))
    positions = bent(term, mesh, element, random)
    term.state = CableState(term.length(positions) - stretch, STIFFNESS)
    return term, positions


def best_error(function, derivative: np.ndarray, scale: float = 1.0) -> float:
    """Of a central difference along one direction at three steps."""
    errors = []
    for step in STEPS:
        ahead, behind = function(step * scale), function(-step * scale)
        difference = (ahead - behind) / (2.0 * step * scale)
        errors.append(np.linalg.norm(difference - derivative) / np.linalg.norm(derivative))
    return min(errors)


@pytest.mark.parametrize('element', Element)
@pytest.mark.parametrize('share', [0.2, -0.3, 3.0])
def test_forces_and_stiffness_are_derivatives_of_the_energy(element, share, random) -> None:
    """Within the smoothed onset (shares of its width) and beyond it."""
    term, positions = make_term(element, 0.0, random)
    width = term.smoothing
    term.state = replace(term.state, rest_length=term.state.rest_length - share * width)
    direction = random.normal(size=positions.shape)
    direction *= 0.02 * width / abs(float((term.length_gradient(positions) * direction).sum()))
    work = float((term.forces(positions) * direction).sum())
    assert best_error(lambda h: term.energy(positions + 1e3 * h * direction), 1e3 * work) < EXACT
    pushed = term.force_tangent(positions, direction)
    assert best_error(lambda h: term.forces(positions + 1e3 * h * direction), 1e3 * pushed) < EXACT


@pytest.mark.parametrize('element', Element)
def test_stiffness_in_the_pattern_is_the_tangent(element, random) -> None:
    mesh = beam_mesh()
    term, positions = make_term(element, 0.004, random)
    pattern = make_pattern(
        discretise(mesh, element),
        np.arange(0, 40, 3, dtype=np.int32),
        coupled_nodes=[term.nodes],
    )
    term.use_pattern(pattern)
    lower = np.zeros((pattern.size, pattern.size))
    columns = np.repeat(np.arange(pattern.size), np.diff(pattern.column_starts))
    lower[pattern.row_indices, columns] = term.stiffness(positions, is_guarded=False)
    whole = lower + np.tril(lower, -1).T
    direction = np.zeros_like(positions)
    direction[pattern.free_nodes] = random.normal(size=(len(pattern.free_nodes), 3))
    expected = term.force_tangent(positions, direction)[pattern.free_nodes].ravel()
    found = whole @ direction[pattern.free_nodes].ravel()
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-12 * np.abs(expected).max())
    # Newton's method relies on it.
    assert np.linalg.eigvalsh(whole).min() > -1e-9 * np.abs(whole).max()


def test_tension_is_continuous_and_hookean(random) -> None:
    term, positions = make_term(Element.LINEAR, 0.0, random)
    length, width = term.length(positions), term.smoothing

    def tension(stretch: float) -> float:
        term.state = CableState(length - stretch, STIFFNESS)
        return term.tension(positions)

    assert tension(-0.51 * width) == 0.0
    assert tension(0.004) == pytest.approx(STIFFNESS * 0.004, rel=1e-12)
    for seam in (-0.5 * width, 0.5 * width):
        gap = 1e-9 * width
        rise = tension(seam + gap) - tension(seam - gap)
        assert 0.0 <= rise <= 2.0 * STIFFNESS * 1.01 * gap
        slopes = [
            (tension(seam + sign * 1e-3 * width + gap) - tension(seam + sign * 1e-3 * width - gap))
            / (2.0 * gap)
            for sign in (1.0, -1.0)
        ]
        assert slopes[0] == pytest.approx(slopes[1], abs=5e-3 * STIFFNESS)


def body_with_cables(element: Element = Element.QUADRATIC) -> StaticBody:
    mesh = beam_mesh()
    return StaticBody(mesh, element, held_end(mesh), cables=routes(mesh))


def pulled(body: StaticBody, upper: float = 0.006, side: float = 0.009) -> Conditions:
    pulls = (upper, side)
    return Conditions(
        cables=tuple(
            CableState(cable.route_length - pull, STIFFNESS)
            for cable, pull in zip(body.cables, pulls, strict=True)
        )
    )


@pytest.mark.parametrize('element', Element)
@pytest.mark.parametrize('which', ['rest length', 'other rest length', 'stiffness'])
def test_equilibrium_follows_cables(element, which) -> None:
    body, number = body_with_cables(element), 1 if which.startswith('other') else 0
    material, here = uniform_material(body.mesh), pulled(body)

    def settled(step: float) -> np.ndarray:
        states = list(here.cables)
        state = states[number]
        if which == 'stiffness':
            states[number] = replace(state, stiffness=state.stiffness * np.exp(step))
        else:
            states[number] = replace(state, rest_length=state.rest_length + step)
        conditions = replace(here, cables=tuple(states))
        return body.solve_equilibrium(material, GRAVITY, conditions=conditions).positions

    settled(0.0)
    rates = [CableState(0.0, 0.0), CableState(0.0, 0.0)]
    rates[number] = CableState(0.0, STIFFNESS) if which == 'stiffness' else CableState(1.0, 0.0)
    change = Conditions(cables=tuple(rates))
    tangent = body.tangents([Change(conditions=change)])[0]
    weights = np.random.default_rng(3).normal(size=tangent.shape)
    by_adjoint = body.gradient(weights).along(Change(conditions=change))
    assert by_adjoint == pytest.approx(float((weights * tangent).sum()), rel=1e-8)
    errors = []
    for step in (4e-4, 2e-4, 1e-4):
        size = 10.0 * step if which == 'stiffness' else step
        difference = (settled(size) - settled(-size)) / (2.0 * size)
        errors.append(np.linalg.norm(difference - tangent) / np.linalg.norm(tangent))
    assert errors[-1] < 1e-3, errors
    assert errors[-1] < 0.5 * errors[0] or max(errors) < 1e-5, errors


def test_straight_bar_shortens_as_the_springs_in_parallel_say() -> None:
    """An axial cable squeezes a bar of linear elasticity: k (d - u) = (E A / l) u."""
    size, modulus, stiffness, pull = (0.12, 0.02, 0.02), 80e3, 40.0, 4e-3
    mesh = beam_mesh((12, 2, 2), size)
    middle = np.array([0.0, 0.01, 0.01])
    ends = middle + np.outer([0.0, size[0]], np.eye(3)[0])
    body = StaticBody(
        mesh,
        Element.QUADRATIC,
        held_end(mesh),
        law=linear_elastic,
        cables=[route_through(mesh, ends)],
    )
    (cable,) = body.cables
    material = replace(
        uniform_material(mesh, modulus, nu=0.0), conversion=linear_elastic.CONVERSION
    )
    state = CableState(size[0] - pull, stiffness)
    body.solve_equilibrium(material, np.zeros(3), conditions=Conditions(cables=(state,)))
    positions = body.state.positions
    shape = body.discretisation
    moved = (positions - shape.rest_nodes)[shape.nodes][..., 0]
    strain = np.einsum('tqa,ta->tq', shape.gradients[..., 0], moved)
    # The mean over the end's face, by the mean strain.
    shortened = -float((shape.weights * strain).sum()) / (size[1] * size[2])
    bar = modulus * size[1] * size[2] / size[0]
    # Wherever in its end the cable pulls: the work of a uniform stretch says so.
    assert shortened == pytest.approx(cable.tension(positions) / bar, rel=1e-6)
    sunk = size[0] - cable.length(positions)
    assert cable.tension(positions) == pytest.approx(stiffness * (pull - sunk), rel=1e-9)


def test_clamp_carries_the_weight_and_nothing_of_the_cables() -> None:
    """Cables pull a body against itself: no force and no moment on the clamp is left of them."""
    body = body_with_cables()
    material = uniform_material(body.mesh)
    body.solve_equilibrium(material, GRAVITY, conditions=pulled(body))
    assert max(cable.tension(body.state.positions) for cable in body.cables) > 0.2
    weight = 1080.0 * body.mesh.volumes.sum() * GRAVITY
    np.testing.assert_allclose(body.state.reactions.sum(axis=0), -weight, rtol=1e-5)
    loads = body.gravity_loads(material.density, GRAVITY)
    arms = np.cross(body.state.positions, body.state.reactions + loads).sum(axis=0)
    assert np.abs(arms).max() < 1e-6 * np.linalg.norm(weight)


@pytest.mark.parametrize('element', Element)
def test_cable_pulled_far_is_tightened_in_steps(element) -> None:
    """A quarter of its length taken up at once: the end points up afterwards, and stays taut."""
    body = body_with_cables(element)
    state = CableState(0.75 * body.cables[0].route_length, 5000.0)
    slack = CableState(1.0, 5000.0)
    conditions = Conditions(cables=(state, slack))
    found = body.solve_equilibrium(uniform_material(body.mesh), GRAVITY, conditions=conditions)
    cable = body.cables[0]
    assert cable.state == state
    stretch = cable.length(found.positions) - state.rest_length
    assert 0.0 < stretch < 0.02 * cable.route_length
    gradients = np.einsum(
        'tqai,taj->tqji', body.discretisation.gradients, found.positions[body.discretisation.nodes]
    )
    assert np.linalg.det(gradients).min() > 0.1
    # The same place from another start: the steps do not choose the answer.
    again = body_with_cables(element)
    half = replace(state, rest_length=0.88 * cable.route_length)
    again.solve_equilibrium(
        uniform_material(body.mesh), GRAVITY, conditions=Conditions(cables=(half, slack))
    )
    other = again.solve_equilibrium(uniform_material(body.mesh), GRAVITY, conditions=conditions)
    np.testing.assert_allclose(other.positions, found.positions, atol=1e-6)


def test_cables_without_stiffness_leave_the_body_alone() -> None:
    body, plain = (
        body_with_cables(),
        StaticBody(beam_mesh(), Element.QUADRATIC, held_end(beam_mesh())),
    )
    material = uniform_material(body.mesh)
    without = plain.solve_equilibrium(material, GRAVITY).positions
    absent = body.solve_equilibrium(material, GRAVITY).positions
    np.testing.assert_allclose(absent, without, atol=1e-12)
    assert body.solver.stiffness.terms == ()
    slack = Conditions(cables=(CableState(1.0, STIFFNESS), CableState(1.0, STIFFNESS)))
    body.forget()
    loose = body.solve_equilibrium(material, GRAVITY, conditions=slack).positions
    np.testing.assert_array_equal(loose, absent)


@pytest.mark.parametrize(
    ('points', 'words'),
    [
        ([[0.01, 0.01, 0.01]], 'has 1 via points: give at least two'),
        ([[0.01, 0.01, 0.01], [0.01, 0.01, 0.01]], 'via points 0 and 1 at the same place'),
        ([[0.01, 0.01, 0.01], [0.05, 0.01, 0.021]], r'via point 1 at .* outside of the body'),
    ],
)
def test_impossible_routes_are_refused(points, words) -> None:
    with pytest.raises(RouteError, match=words):
        route_through(beam_mesh(), np.array(points))


def test_cable_through_the_air_is_refused() -> None:
    """Two fingers on one palm: from tip to tip the cable would leave the body."""
    mesh = beam_mesh((8, 4, 2), (0.16, 0.08, 0.03))
    middle = mesh.centroids
    gap = (middle[:, 0] > 0.05) & (np.abs(middle[:, 1] - 0.04) < 0.019)
    forked = TetMesh(mesh.rest_positions, mesh.tets[~gap])
    tips = np.array([[0.15, 0.01, 0.015], [0.15, 0.07, 0.015]])
    with pytest.raises(RouteError, match='leaves the body between via points 0 and 1'):
        route_through(forked, tips)
    assert route_through(forked, tips, may_cross_gaps=True).length == pytest.approx(0.06)
    around = np.array([tips[0], [0.03, 0.01, 0.015], [0.03, 0.07, 0.015], tips[1]])
    assert route_through(forked, around).length == pytest.approx(0.30)


def test_a_state_for_each_cable_is_needed() -> None:
    body = body_with_cables()
    with pytest.raises(ValueError, match='1 cables are given for a body with 2'):
        body.solve_equilibrium(
            uniform_material(body.mesh),
            GRAVITY,
            conditions=Conditions(cables=(CableState(0.1, 1.0),)),
        )
