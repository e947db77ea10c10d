# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The multifrontal solver against dense and other direct solutions, in both precisions."""

from concurrent.futures import ThreadPoolExecutor

from diffcal_ros.fem.elements.element import discretise, Element
from diffcal_ros.fem.elements.sparse_pattern import make_pattern, SparsePattern
from diffcal_ros.fem.laws import find_law, law_names
from diffcal_ros.fem.linear_solvers import make_solver, multifrontal, NotPositiveDefiniteError
from diffcal_ros.fem.linear_solvers.multifrontal import MultifrontalSolver
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.fem.terms.cable_route import route_through
from diffcal_ros.fem.terms.conditions import CableState, Conditions
from diffcal_ros.material import LameConvention, Material
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
import pytest
from support.beams import beam_mesh, held_end
from support.bodies import GRAVITY

# Newton leaves forces of 1e-7 of the mean load, which move this beam by far less [m].
_SAME = 1e-9


def _bent_mesh() -> TetMesh:
    """A tapered, twisted beam: no symmetry hides an entry in the wrong place."""
    mesh = beam_mesh((7, 3, 2), (0.1, 0.03, 0.02))
    along = mesh.rest_positions[:, :1] / 0.1
    x, y, z = mesh.rest_positions.T
    places = np.stack([x, y * (1.2 - 0.4 * along[:, 0]) + 0.4 * z * along[:, 0], z - y**2], axis=1)
    return TetMesh(places, mesh.tets)


def _pattern(mesh: TetMesh) -> SparsePattern:
    body = discretise(mesh, Element.QUADRATIC)
    far = np.concatenate([body.nodes[0], body.nodes[-1], body.nodes[len(body.nodes) // 2]])
    return make_pattern(body, held_end(mesh, 0.012), coupled_nodes=[far])


def _random_values(pattern: SparsePattern, random: np.random.Generator) -> np.ndarray:
    values = random.normal(size=pattern.entry_count)
    values[pattern.diagonal_slots] += 100.0
    return values


def _dense(values: np.ndarray, rows: np.ndarray, starts: np.ndarray) -> np.ndarray:
    count = len(starts) - 1
    lower = np.zeros((count, count))
    lower[rows, np.repeat(np.arange(count), np.diff(starts))] = values
    return lower + np.tril(lower, -1).T


@pytest.mark.parametrize(('is_exact', 'bound'), [(True, 1e-12), (False, 1e-5)])
def test_any_matrix_of_the_pattern_is_solved(is_exact, bound, random) -> None:
    pattern = _pattern(_bent_mesh())
    assert len(pattern.dissection.groups) > 10
    values = _random_values(pattern, random)
    dense = _dense(values, pattern.row_indices, pattern.column_starts)
    solver = MultifrontalSolver(pattern, is_exact=is_exact)
    for scale in (3.0, 1.0):  # The second factorisation takes the place of the first.
        solver.factor(scale * values)
    sides = random.normal(size=(pattern.size, 3))
    expected = np.linalg.solve(dense, sides)
    largest = np.abs(expected).max()
    np.testing.assert_allclose(solver.solve(sides), expected, atol=bound * largest)
    np.testing.assert_allclose(solver.solve(sides[:, 1]), expected[:, 1], atol=bound * largest)
    assert solver.solve(sides[:, :0]).shape == (pattern.size, 0)


def test_a_matrix_with_one_unknown_a_node_is_solved(random) -> None:
    pattern = _pattern(_bent_mesh())
    values = random.normal(size=len(pattern.neighbours))
    values[pattern.block_starts[:-1]] += 60.0
    dense = _dense(values, pattern.neighbours, pattern.block_starts)
    solver = MultifrontalSolver(pattern, is_exact=True, per_node=1)
    solver.factor(values)
    solver.finish()
    sides = random.normal(size=(len(pattern.free_nodes), 3))
    np.testing.assert_allclose(solver.solve(sides), np.linalg.solve(dense, sides), atol=1e-12)


def test_a_large_matrix_is_factored_a_few_fronts_at_a_time(monkeypatch, random) -> None:
    pattern = _pattern(_bent_mesh())
    values, sides = _random_values(pattern, random), random.normal(size=(pattern.size, 2))
    whole = MultifrontalSolver(pattern)
    whole.factor(values)
    monkeypatch.setattr(multifrontal, '_AT_A_TIME', 1e5)
    parted = MultifrontalSolver(pattern)
    parted.factor(values)
    assert len(whole._spans) == 1
    assert len(parted._spans) > 5
    np.testing.assert_array_equal(parted.solve(sides), whole.solve(sides))


def test_two_bodies_are_factored_at_once_on_two_threads(random) -> None:
    pattern = _pattern(_bent_mesh())
    values = [_random_values(pattern, random) for _ in range(2)]
    sides = random.normal(size=(pattern.size, 4))
    solvers = [MultifrontalSolver(pattern) for _ in values]

    def work(number: int) -> list[np.ndarray]:
        found = []
        for _ in range(20):
            solvers[number].factor(values[number])
            found += [solvers[number].solve(sides), solvers[number].solve(sides[:, 0])]
        return found

    with ThreadPoolExecutor(2) as pool:
        for number, found in enumerate(pool.map(work, range(2))):
            dense = _dense(values[number], pattern.row_indices, pattern.column_starts)
            expected = np.linalg.solve(dense, sides)
            for both, one in zip(found[::2], found[1::2], strict=True):
                np.testing.assert_allclose(both, expected, atol=1e-12)
                np.testing.assert_allclose(one, expected[:, 0], atol=1e-12)


@pytest.mark.parametrize('is_exact', [True, False])
@pytest.mark.parametrize('share', [0.0, 0.4, 1.0])
def test_an_indefinite_matrix_is_refused_wherever_its_pivot_is(is_exact, share, random) -> None:
    pattern = _pattern(_bent_mesh())
    values = _random_values(pattern, random)
    values[pattern.diagonal_slots[int(share * (pattern.size - 1))]] = -1.0
    with pytest.raises(NotPositiveDefiniteError, match='pivot'):
        MultifrontalSolver(pattern, is_exact=is_exact).factor(values)


def _body(solver: str, law: str = 'stable_neo_hookean') -> StaticBody:
    mesh = _bent_mesh()
    cable = route_through(mesh, np.array([[0.09, 0.012, 0.01], [0.02, 0.02, 0.008]]))
    return StaticBody(
        mesh,
        Element.QUADRATIC,
        held_end(mesh, 0.012),
        law=find_law(law),
        solver=solver,
        cables=[cable],
    )


def _material(body: StaticBody, random: np.random.Generator, nu: float) -> Material:
    count = body.mesh.tet_count
    modulus = 40e3 * random.uniform(0.7, 1.4, count)
    shares = body.elastic.law.CONVERSION
    ones = np.ones(count)
    return Material(modulus, nu * ones, 1080.0 * ones, LameConvention.CONSISTENT, shares)


def _conditions(body: StaticBody, random: np.random.Generator) -> Conditions:
    """A taut cable, weights and forces."""
    nodes = body.discretisation.node_count
    return Conditions(
        cables=tuple(CableState(0.97 * c.route_length, 0.8) for c in body.cables),
        added_masses=random.uniform(0.0, 2e-6, nodes),
        forces=random.normal(scale=1e-5, size=(nodes, 3)),
    )


@pytest.fixture
def in_single(monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep all factors in single precision, as those of large bodies are."""
    monkeypatch.setattr(multifrontal, '_DOUBLE_LIMIT', 0)


@pytest.mark.usefixtures('in_single')
@pytest.mark.parametrize('law', law_names())
@pytest.mark.parametrize('nu', [0.3, 0.495])
def test_single_precision_finds_the_equilibrium_and_tangents_of_a_direct_solver(
    law, nu, random
) -> None:
    bodies = [_body(name, law) for name in ('superlu', 'multifrontal')]
    material = _material(bodies[0], random, nu)
    conditions = _conditions(bodies[0], random)
    states = [body.solve_equilibrium(material, GRAVITY, conditions=conditions) for body in bodies]
    moved = np.abs(states[0].positions - bodies[0].discretisation.rest_nodes).max()
    assert moved > 1e-3
    np.testing.assert_allclose(states[1].positions, states[0].positions, rtol=0, atol=_SAME)
    np.testing.assert_allclose(states[1].reactions, states[0].reactions, rtol=0, atol=1e-7)
    change = [Change(youngs_modulus=material.youngs_modulus), Change(gravity=GRAVITY)]
    first, second = (body.tangents(change) for body in bodies)
    np.testing.assert_allclose(second, first, rtol=0, atol=1e-6 * np.abs(first).max())
    by_positions = random.normal(size=states[0].positions.shape)
    first, second = (body.gradient(by_positions).youngs_modulus for body in bodies)
    np.testing.assert_allclose(second, first, rtol=0, atol=1e-6 * np.abs(first).max())


@pytest.mark.usefixtures('in_single')
@pytest.mark.parametrize('step', [1e-2, 3e-3, 1e-3])
def test_gradient_in_single_precision_is_the_slope(step, random) -> None:
    body = _body('multifrontal')
    material = _material(body, random, 0.49)
    conditions = _conditions(body, random)
    weights = random.normal(size=body.discretisation.rest_nodes.shape)
    direction = material.youngs_modulus * random.uniform(-1.0, 1.0, body.mesh.tet_count)

    def value(share: float) -> float:
        moved = Material(
            material.youngs_modulus + share * direction,
            material.poissons_ratio,
            material.density,
            material.convention,
            material.conversion,
        )
        return float(
            (
                weights * body.solve_equilibrium(moved, GRAVITY, conditions=conditions).positions
            ).sum()
        )

    slope = (value(step) - value(-step)) / (2.0 * step)
    value(0.0)
    expected = float(body.gradient(weights).youngs_modulus @ direction)
    # Central differences err by the square of the step, and equilibria are found to 1e-7 of the
    # load, which a step of 1e-3 makes 1e-4.
    assert abs(slope - expected) < (1e-4 + 2.0 * step**2) * abs(expected)


@pytest.mark.usefixtures('in_single')
def test_who_needs_exact_solutions_gets_them_from_a_large_body_too() -> None:
    pattern = _pattern(_bent_mesh())
    assert not make_solver(pattern, 'multifrontal').is_exact
    assert make_solver(pattern, 'multifrontal', needs_exact=True).is_exact


def test_whom_single_precision_will_do_gets_it_of_a_small_body_too() -> None:
    pattern = _pattern(_bent_mesh())
    assert make_solver(pattern, 'multifrontal').is_exact
    assert not make_solver(pattern, 'multifrontal', needs_exact=None).is_exact


def test_close_to_its_factorisation_one_side_is_solved_by_iterations(monkeypatch, random) -> None:
    body = StaticBody(_bent_mesh(), Element.QUADRATIC, held_end(_bent_mesh(), 0.012))
    stiffness = body.solver.stiffness
    stiffness._solver = MultifrontalSolver(stiffness.pattern, is_exact=True)
    ones = np.ones(body.mesh.tet_count)
    body.solve_equilibrium(Material(30e3 * ones, 0.49 * ones, 1e3 * ones), GRAVITY)
    weights = random.normal(size=(1, *body.own_state.positions.shape))
    made: list[bool] = []
    factor = stiffness.factor
    monkeypatch.setattr(stiffness, 'factor', lambda *given: (made.append(True), factor(*given))[1])
    close = stiffness.linear_solve(body.own_state.positions, weights)
    assert not made
    body.factor()
    assert made
    exact = stiffness.linear_solve(body.own_state.positions, weights)
    np.testing.assert_allclose(close, exact, atol=1e-8 * np.abs(exact).max())
