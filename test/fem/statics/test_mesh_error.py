# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
from diffcal_ros.fem.elements.element import discretise, Element
from diffcal_ros.fem.elements.prolongation import refine
from diffcal_ros.fem.statics.mesh_error import MeshError
from diffcal_ros.fem.statics.static_body import StaticBody
import numpy as np
import pytest
from support.beams import beam_mesh, held_end
from support.bodies import GRAVITY, uniform_material


def test_interpolation_keeps_quadratic_fields(random) -> None:
    mesh = beam_mesh((2, 1, 1), (0.05, 0.03, 0.02))
    coarse = discretise(mesh, Element.QUADRATIC)
    refinement = refine(mesh, coarse)
    form = random.normal(size=(3, 3))

    def field(points: np.ndarray) -> np.ndarray:
        return np.einsum('ni,ij,nj->n', points, form, points) + points @ [1.0, -2.0, 0.5]

    found = refinement.fine_from_coarse @ field(coarse.rest_nodes)
    np.testing.assert_allclose(found, field(refinement.fine.rest_nodes), atol=1e-15)


@pytest.mark.parametrize('nu', [0.3, 0.49])
def test_estimate_for_quadratic_elements_matches_a_refined_solve(nu) -> None:
    mesh = beam_mesh((4, 1, 1), (0.12, 0.03, 0.02))
    material = uniform_material(mesh, 60e3, nu)
    body = StaticBody(mesh, Element.QUADRATIC, held_end(mesh))
    body.solve_equilibrium(material, GRAVITY)
    estimate = MeshError(body).displacement(material, GRAVITY)

    finer_mesh, _ = mesh.refined()
    finer = StaticBody(finer_mesh, Element.QUADRATIC, held_end(finer_mesh))
    truth = finer.solve_equilibrium(uniform_material(finer_mesh, 60e3, nu), GRAVITY).positions
    # Nodes of the coarse quadratic elements are the finer mesh's vertices.
    difference = truth[: body.discretisation.node_count] - body.state.positions
    error = np.linalg.norm(estimate - difference) / np.linalg.norm(difference)
    assert error < 0.25
    assert np.abs(estimate[body.held_nodes]).max() == 0.0


def test_a_body_that_buckles_on_the_finer_mesh_moves_no_further_than_a_step_tells() -> None:
    mesh = beam_mesh((6, 1, 1), (0.12, 0.012, 0.01))
    upright = np.array([-9.81, 0.0, 0.0])
    moves = {}
    # Upright beams buckle at 280 kPa (Greenhill); this coarse mesh stands a little below.
    for modulus in (294e3, 274e3):
        material = uniform_material(mesh, modulus, 0.3)
        body = StaticBody(mesh, Element.QUADRATIC, held_end(mesh))
        body.solve_equilibrium(material, upright)
        assert np.abs(body.state.positions - body.discretisation.rest_nodes).max() < 0.001
        estimate = MeshError(body).displacement(material, upright)
        moves[modulus] = np.linalg.norm(estimate, axis=1).max()
    assert moves[294e3] < 0.0002
    size = np.linalg.norm(np.ptp(mesh.rest_positions, axis=0))
    assert 0.05 * size < moves[274e3] <= 0.101 * size


def test_estimate_for_linear_elements_is_the_way_to_quadratic_ones() -> None:
    mesh = beam_mesh((6, 2, 2))
    material = uniform_material(mesh, 60e3, 0.49)
    body = StaticBody(mesh, Element.LINEAR, held_end(mesh))
    body.solve_equilibrium(material, GRAVITY)
    estimate = MeshError(body).displacement(material, GRAVITY)
    better = StaticBody(mesh, Element.QUADRATIC, held_end(mesh)).solve_equilibrium(
        material, GRAVITY
    )
    np.testing.assert_allclose(
        body.state.positions + estimate, better.positions[: mesh.vertex_count], atol=1e-7
    )
