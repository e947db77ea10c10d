# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.statics.equilibrium import EquilibriumError
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.fem.statics.tangent_stiffness import TangentStiffness
from diffcal_ros.rigid_transform import rotation_matrix
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
import pytest
from support.beams import beam_mesh, held_end
from support.bodies import GRAVITY, hanging_beam, uniform_material

ELEMENTS = list(Element)


@pytest.mark.parametrize('element', ELEMENTS)
@pytest.mark.parametrize('modulus', [3e3, 30e3, 300e3])
def test_the_clamp_carries_the_weight(element, modulus) -> None:
    body = hanging_beam(element)
    material = uniform_material(body.mesh, modulus)
    state = body.solve_equilibrium(material, GRAVITY)
    weight = 1080.0 * body.mesh.volumes.sum() * GRAVITY
    np.testing.assert_allclose(state.reactions.sum(axis=0), -weight, rtol=1e-6)
    # And its moment: nothing else holds the body.
    masses = body.gravity_loads(material.density, GRAVITY)
    moment = np.cross(state.positions, state.reactions + masses).sum(axis=0)
    lever = np.abs(np.cross(state.positions, masses)).sum()
    np.testing.assert_allclose(moment, 0.0, atol=1e-6 * lever)


@pytest.mark.parametrize('modulus', [3e6, 30e6, 300e6])
def test_a_stiff_body_settles_where_its_forces_round(modulus) -> None:
    # Nearly incompressible and far stiffer than its load asks for: rounding alone leaves more than
    # the tolerance, which is a share of the load.
    mesh = beam_mesh((10, 3, 3), (0.1, 0.03, 0.02))
    body = hanging_beam(Element.QUADRATIC, mesh)
    state = body.solve_equilibrium(uniform_material(mesh, modulus, nu=0.4999), GRAVITY)
    weight = 1080.0 * mesh.volumes.sum() * GRAVITY
    left = np.linalg.norm(state.reactions.sum(axis=0) + weight)
    assert left < 1e-4 * np.linalg.norm(weight)
    moved = np.linalg.norm(state.positions - body.discretisation.rest_nodes, axis=1).max()
    softer = body.solve_equilibrium(uniform_material(mesh, 0.5 * modulus, nu=0.4999), GRAVITY)
    twice = np.linalg.norm(softer.positions - body.discretisation.rest_nodes, axis=1).max()
    # So small a sag is in proportion to the load.
    assert twice / moved == pytest.approx(2.0, rel=0.02)


def test_a_slender_beam_sags_as_beam_theory_says() -> None:
    length, height, width, modulus = 0.2, 0.02, 0.015, 5e6
    mesh = beam_mesh((16, 2, 2), (length, height, width))
    body = hanging_beam(Element.QUADRATIC, mesh)
    state = body.solve_equilibrium(
        uniform_material(mesh, modulus, nu=0.0), np.array([0.0, -9.81, 0.0])
    )
    sag = -(state.positions - body.discretisation.rest_nodes)[:, 1].min()
    load = 1080.0 * 9.81 * height * width
    inertia = width * height**3 / 12.0
    # Euler-Bernoulli plus Timoshenko's shear (5/6 of the section); the sag is 1.5 % of the length.
    theory = load * length**4 / (8 * modulus * inertia)
    theory += load * length**2 / (2 * (5 / 6) * (modulus / 2) * height * width)
    assert sag == pytest.approx(theory, rel=0.01)


def test_quadratic_elements_converge_with_their_order() -> None:
    # Held at one end: the corners of the clamp limit the slope, so only the sag's is asked for.
    sags = []
    for fineness in (1, 2, 3):
        mesh = beam_mesh((4 * fineness, fineness, fineness), (0.12, 0.03, 0.02))
        body = hanging_beam(Element.QUADRATIC, mesh)
        state = body.solve_equilibrium(
            uniform_material(mesh, 60e3, nu=0.3), np.array([0.0, -9.81, 0.0])
        )
        sags.append(-(state.positions - body.discretisation.rest_nodes)[:, 1].min())
    first, second = abs(sags[1] - sags[0]), abs(sags[2] - sags[1])
    assert first / sags[2] < 0.05
    # From h to h/2 to h/3 an error of order p shrinks its differences by
    # (1 - 2^-p) / (2^-p - 3^-p): 3.6 for p = 1.5, 5.4 for p = 2.
    assert first / second > 3.6


def test_warm_and_cold_starts_agree() -> None:
    body = hanging_beam()
    body.solve_equilibrium(uniform_material(body.mesh, 30e3), GRAVITY)
    warm = body.solve_equilibrium(uniform_material(body.mesh, 27e3), GRAVITY)
    assert warm.held_steps > 0
    body.forget()
    cold = body.solve_equilibrium(uniform_material(body.mesh, 27e3), GRAVITY)
    assert cold.newton_steps > 0
    np.testing.assert_allclose(warm.positions, cold.positions, atol=1e-8)


def test_pressures_foreseen_save_factorisations(monkeypatch) -> None:
    tried: list[bool] = []

    def settled() -> np.ndarray:
        tried.clear()
        body = hanging_beam(mesh=beam_mesh((12, 2, 2), (0.2, 0.02, 0.03)))
        solver = body.solver.stiffness._solver
        factor = solver.factor
        monkeypatch.setattr(solver, 'factor', lambda values: (tried.append(True), factor(values)))
        state = body.solve_equilibrium(uniform_material(body.mesh, 60e3, 0.499), GRAVITY)
        return state.positions

    with_pressures = settled()
    count = len(tried)
    monkeypatch.setattr(TangentStiffness, 'foresee', lambda *_: None)
    without = settled()
    assert 2 * count <= len(tried)
    np.testing.assert_allclose(with_pressures, without, atol=1e-9)


def test_close_by_no_new_factorisation_is_made(monkeypatch) -> None:
    body = hanging_beam()
    body.solve_equilibrium(uniform_material(body.mesh, 30e3), GRAVITY)
    made: list[bool] = []
    stiffness = body.solver.stiffness
    make = stiffness.factor
    monkeypatch.setattr(
        stiffness, 'factor', lambda *given, **kinds: (made.append(True), make(*given, **kinds))[1]
    )
    state = body.solve_equilibrium(uniform_material(body.mesh, 27e3), GRAVITY)
    assert state.held_steps > 0
    assert state.newton_steps == 0
    assert not made
    # A clamp turned far round is not close: iterations with the old one would not end.
    turned = rotation_matrix(np.array([0.0, 0.0, 1.0]))
    rest = body.mesh.rest_positions[body.held_vertices]
    body.solve_equilibrium(
        uniform_material(body.mesh, 27e3), GRAVITY, held_path=lambda _: rest @ turned.T
    )
    assert made


def test_forces_whose_squares_vanish_are_solved_for() -> None:
    """A parameter may do next to nothing, as a relaxation time long before it shows."""
    body = hanging_beam()
    body.solve_equilibrium(uniform_material(body.mesh, 30e3), GRAVITY)
    state = body.solve_equilibrium(
        uniform_material(body.mesh, 27e3), GRAVITY
    )  # With an old factorisation.
    forces = np.zeros((1, *state.positions.shape))
    forces[:, :, 1] = -1e-3
    expected = body.solver.stiffness.linear_solve(state.positions, forces)
    # A single side is solved by iterations, which leave the factorisation as it is.
    tiny = body.solver.stiffness.linear_solve(state.positions, 1e-170 * forces)
    np.testing.assert_allclose(1e170 * tiny, expected, rtol=1e-11, atol=1e-15)
    assert not body.solver.stiffness.linear_solve(state.positions, 0.0 * forces).any()


@pytest.mark.parametrize('element', ELEMENTS)
def test_a_half_turn_of_the_far_end_is_followed(element) -> None:
    mesh = beam_mesh((8, 2, 2), (0.16, 0.03, 0.02))
    x = mesh.rest_positions[:, 0]
    held = np.flatnonzero((x <= 1e-9) | (x >= 0.16 - 1e-9)).astype(np.int32)
    far = x[held] > 0.1
    rest = mesh.rest_positions[held]
    middle = rest[far].mean(axis=0)

    def path(fraction: float) -> np.ndarray:
        rotation = rotation_matrix(np.array([np.pi * fraction, 0.0, 0.0]))
        moved = rest.copy()
        moved[far] = (rest[far] - middle) @ rotation.T + middle
        return moved

    body = StaticBody(mesh, element, held)
    state = body.solve_equilibrium(uniform_material(mesh, 40e3, 0.49), GRAVITY, held_path=path)
    np.testing.assert_allclose(state.positions[held], path(1.0), atol=1e-12)
    # Half of the turn is done half-way along, and in the direction of the path.
    half = np.flatnonzero(np.abs(x - 0.08) < 1e-9)
    offset = mesh.rest_positions[half] - middle
    turned = state.positions[half] - state.positions[half].mean(axis=0)
    angle = np.arctan2(
        (offset[:, 1] * turned[:, 2] - offset[:, 2] * turned[:, 1]).sum(),
        (offset[:, 1:] * turned[:, 1:]).sum(),
    )
    assert angle == pytest.approx(np.pi / 2, abs=0.15)


def test_nothing_held_is_refused() -> None:
    mesh = beam_mesh()
    with pytest.raises(ValueError, match='0 nodes are held'):
        StaticBody(mesh, Element.LINEAR, np.zeros(0, dtype=np.int32))


def test_a_hopelessly_soft_body_says_so() -> None:
    mesh = beam_mesh((12, 1, 1), (0.5, 0.01, 0.01))
    body = StaticBody(mesh, Element.LINEAR, held_end(mesh))
    with pytest.raises(EquilibriumError, match='soft'):
        body.solve_equilibrium(uniform_material(mesh, 0.02), GRAVITY * 100.0)


# Far too soft for their weight: with pressures foreseen Newton's method stalls on the way.
@pytest.mark.parametrize(
    ('cells', 'size', 'modulus', 'nu', 'gravity'),
    [
        ((6, 1, 1), (0.2, 0.015, 0.02), 5e3, 0.3, (0.0, -9.8, 0.0)),
        ((8, 2, 1), (0.2, 0.06, 0.02), 2e3, 0.4, (4.0, -8.0, 3.0)),
    ],
)
def test_very_soft_bodies_settle_from_rest(cells, size, modulus, nu, gravity, make_beam) -> None:
    body = hanging_beam(Element.QUADRATIC, make_beam(cells, size))
    state = body.solve_equilibrium(uniform_material(body.mesh, modulus, nu), np.array(gravity))
    weight = 1080.0 * body.mesh.volumes.sum() * np.array(gravity)
    np.testing.assert_allclose(
        state.reactions.sum(axis=0), -weight, atol=1e-6 * np.linalg.norm(weight)
    )
    sag = np.linalg.norm(state.positions - body.discretisation.rest_nodes, axis=1).max()
    assert sag > 0.75 * size[0]


def test_a_way_from_rest_that_fails_is_gone_without_foreseen_pressures(monkeypatch) -> None:
    body, material = hanging_beam(), uniform_material(beam_mesh(), 30e3, 0.49)
    expected = body.solve_equilibrium(material, GRAVITY).positions
    solve, ways = body.solver.solve, []

    def failing_first(*args, is_foreseen=True, **kwargs):
        ways.append(is_foreseen)
        if is_foreseen:
            raise EquilibriumError('it stalled')
        return solve(*args, is_foreseen=is_foreseen, **kwargs)

    monkeypatch.setattr(body.solver, 'solve', failing_first)
    factor, foreseen = body.solver.stiffness.factor, []
    monkeypatch.setattr(
        body.solver.stiffness,
        'factor',
        lambda at, is_foreseen: (
            foreseen.append(is_foreseen) or factor(at, is_foreseen=is_foreseen)
        ),
    )
    body.forget()
    found = body.solve_equilibrium(material, GRAVITY).positions
    assert ways == [True, False]
    assert len(foreseen) > 3
    assert not any(foreseen)
    np.testing.assert_allclose(found, expected, atol=1e-9)


@pytest.mark.parametrize('modulus', [1e6, 5e6, 50e6])
def test_stiff_bodies_of_uneven_meshes_settle(modulus, random) -> None:
    # Nearly incompressible: where the rounding of one mesh stays below the tolerance, that of
    # another exceeds it.
    even = beam_mesh((5, 2, 2))
    for _ in range(6):
        shaken = random.uniform(-0.0015, 0.0015, even.rest_positions.shape)
        mesh = TetMesh(even.rest_positions + shaken, even.tets)
        body = StaticBody(mesh, Element.LINEAR, held_end(even))
        state = body.solve_equilibrium(uniform_material(mesh, modulus, nu=0.4999), GRAVITY)
        weight = 1080.0 * mesh.volumes.sum() * GRAVITY
        np.testing.assert_allclose(state.reactions.sum(axis=0), -weight, rtol=1e-4)
