# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Equilibria of the public cases against the authors' end states."""

from pathlib import Path

from diffcal_ros.fem.elements.elastic_body import ElasticBody
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.material import LameConvention, LameParameters, Material
from diffcal_ros.scene.posing import held_targets, world_positions
from diffcal_ros.scene.sections.mesh_files import read_mesh
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
import pytest
from support import authors_law
from support.captures import load_case, reference

# The authors' run lets the body settle for tens of thousands of steps: what is left is theirs.
_MEAN_WITH_OUR_LAW = 0.2e-3
_MEAN_WITH_THEIR_LAW = 0.02e-3


def _body(data: Path, case: str) -> tuple[StaticBody, Material]:
    scene, _ = load_case(data, case, 'stored')
    setup = scene.observations[0]
    rest = world_positions(scene.mesh, setup)
    held = held_targets(setup, rest).vertices
    body = StaticBody(TetMesh(rest, scene.mesh.tets), Element.LINEAR, held)
    mu = reference(data, case, 'distribute_material_parameters')[:, 0]
    nu = np.full(len(mu), 0.49)
    material = Material(2.0 * mu * 1.49, nu, np.full(len(mu), 1080.0), LameConvention.PAPER)
    return body, material


def test_equilibrium_meets_the_authors_end_state(diffcal_data: Path) -> None:
    body, material = _body(diffcal_data, 'h_e_c')
    final = reference(diffcal_data, 'h_e_c', 'final_state')
    state = body.solve_equilibrium(material, np.array([0.0, -9.8, 0.0]))
    assert np.linalg.norm(state.positions - final, axis=1).mean() <= _MEAN_WITH_OUR_LAW


def test_what_is_left_is_their_invariant(diffcal_data: Path) -> None:
    body, material = _body(diffcal_data, 'h_e_c')
    final = reference(diffcal_data, 'h_e_c', 'final_state')
    gravity = np.array([0.0, -9.8, 0.0])
    positions = body.solve_equilibrium(material, gravity).positions.copy()
    loads = body.gravity_loads(material.density, gravity)
    theirs = ElasticBody(body.discretisation, law=authors_law)
    numbers = material.lame_parameters()
    theirs.set_lame_parameters(LameParameters(numbers.neo_hookean_mu, numbers.neo_hookean_lambda))
    free = np.setdiff1d(np.arange(len(positions)), body.held_nodes)
    for _ in range(200):
        unbalanced = loads - theirs.forces(positions)
        unbalanced[body.held_nodes] = 0.0
        if np.abs(unbalanced[free]).max() < 1e-9:
            break
        positions += body.solver.stiffness.apply_factor(unbalanced)
    assert np.abs(unbalanced[free]).max() < 1e-9
    assert np.linalg.norm(positions - final, axis=1).mean() <= _MEAN_WITH_THEIR_LAW


@pytest.mark.parametrize(
    ('shape', 'element', 'sag'),
    [
        ('cantilever_coarse', Element.LINEAR, 0.0569),
        ('cantilever_fine', Element.LINEAR, 0.0829),
    ],
)
def test_linear_elements_lock(diffcal_data: Path, shape, element, sag) -> None:
    assert _sag(diffcal_data, shape, element) == pytest.approx(sag, abs=5e-5)


@pytest.mark.slow
def test_quadratic_elements_agree_on_coarse_and_fine_meshes(diffcal_data: Path) -> None:
    coarse = _sag(diffcal_data, 'cantilever_coarse', Element.QUADRATIC)
    fine = _sag(diffcal_data, 'cantilever_fine', Element.QUADRATIC)
    assert abs(coarse / fine - 1.0) <= 0.03


def test_quadratic_elements_agree_on_coarse_and_middle_meshes(diffcal_data: Path) -> None:
    coarse = _sag(diffcal_data, 'cantilever_coarse', Element.QUADRATIC)
    middle = _sag(diffcal_data, 'cantilever', Element.QUADRATIC)
    assert abs(coarse / middle - 1.0) <= 0.03


def _sag(data: Path, shape: str, element: Element) -> float:
    """Largest sag [m] of the cantilever at mu = 69.27 kPa, lambda = 49 mu."""
    (path,) = (data / 'CAD_models' / shape).glob('*.tet')
    mesh = read_mesh(path, unit='cm').mesh
    held = np.flatnonzero(mesh.rest_positions[:, 0] >= 0.07 - 1e-9).astype(np.int32)
    body = StaticBody(mesh, element, held)
    ones = np.ones(mesh.tet_count)
    material = Material(
        2.0 * 69.27e3 * 1.49 * ones, 0.49 * ones, 1080.0 * ones, LameConvention.PAPER
    )
    state = body.solve_equilibrium(material, np.array([0.0, 9.8, 0.0]))
    moved = state.positions - body.discretisation.rest_nodes
    return float(moved[: mesh.vertex_count, 1].max())
