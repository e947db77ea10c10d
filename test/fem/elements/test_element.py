# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
from diffcal_ros.fem.elements.element import discretise, Element, reshaped
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
import pytest
from support.beams import beam_mesh

ELEMENTS = list(Element)
# Rest gradients of these meshes are of order 1e2 per metre; the rest is rounding.
_ROUNDING = 1e-9


def _gradients(discretisation, values: np.ndarray) -> np.ndarray:
    return np.einsum('tai,tqaj->tqij', values[discretisation.nodes], discretisation.gradients)


def _points(discretisation) -> np.ndarray:
    """Positions of the quadrature points, from the field x itself."""
    nodes = discretisation.rest_nodes[discretisation.nodes]
    far, near = (5 - np.sqrt(5)) / 20, (5 + 3 * np.sqrt(5)) / 20
    shares = np.full((4, 4), far) + np.eye(4) * (near - far)
    return np.einsum('qa,tai->tqi', shares, nodes[:, :4])


@pytest.mark.parametrize('element', ELEMENTS)
def test_linear_fields_have_their_gradient_everywhere(element, random) -> None:
    body = discretise(beam_mesh(), element)
    matrix = random.normal(size=(3, 3))
    gradients = _gradients(body, body.rest_nodes @ matrix.T + [1.0, 2.0, 3.0])
    np.testing.assert_allclose(gradients, np.broadcast_to(matrix, gradients.shape), atol=_ROUNDING)


def test_quadratic_fields_are_exact_on_quadratic_elements(random) -> None:
    body = discretise(beam_mesh(), Element.QUADRATIC)
    form = random.normal(size=(3, 3))
    symmetric = form + form.T
    values = np.einsum('ni,ij,nj->n', body.rest_nodes, form, body.rest_nodes)
    found = _gradients(body, np.repeat(values[:, None], 3, axis=1))[:, :, 0]
    np.testing.assert_allclose(found, _points(body) @ symmetric, atol=_ROUNDING)


@pytest.mark.parametrize('element', ELEMENTS)
def test_weights_and_load_fractions_sum_to_the_volume(element) -> None:
    mesh = beam_mesh()
    body = discretise(mesh, element)
    np.testing.assert_allclose(body.weights.sum(axis=1), mesh.volumes)
    np.testing.assert_allclose(body.load_fractions.sum(axis=1), mesh.volumes)


@pytest.mark.parametrize('element', ELEMENTS)
def test_a_uniform_load_works_through_the_centroid(element) -> None:
    mesh = beam_mesh()
    body = discretise(mesh, element)
    moment = np.einsum('ta,tai->ti', body.load_fractions, body.rest_nodes[body.nodes])
    np.testing.assert_allclose(moment, mesh.volumes[:, None] * mesh.centroids, atol=1e-15)


@pytest.mark.parametrize('element', ELEMENTS)
def test_surface_is_closed_and_keeps_its_area(element) -> None:
    mesh = beam_mesh((3, 2, 1), (0.09, 0.04, 0.02))
    body = discretise(mesh, element)
    corners = body.rest_nodes[body.surface_triangles]
    normals = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    np.testing.assert_allclose(normals.sum(axis=0), 0.0, atol=1e-15)
    area = 2 * (0.09 * 0.04 + 0.09 * 0.02 + 0.04 * 0.02)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1).sum(), area)
    np.testing.assert_allclose(np.linalg.det(corners).sum() / 6.0, mesh.volumes.sum())


@pytest.mark.parametrize('element', ELEMENTS)
def test_moved_vertices_are_discretised_as_a_new_mesh_is(element, random) -> None:
    mesh = beam_mesh()
    shift = random.normal(scale=5e-4, size=mesh.rest_positions.shape)
    moved = TetMesh(mesh.rest_positions + shift, mesh.tets)
    fresh, again = discretise(moved, element), reshaped(discretise(mesh, element), moved)
    for name in ('rest_nodes', 'gradients', 'weights', 'load_fractions'):
        np.testing.assert_allclose(getattr(again, name), getattr(fresh, name), rtol=1e-12)
    for name in ('nodes', 'node_parents', 'surface_triangles'):
        np.testing.assert_array_equal(getattr(again, name), getattr(fresh, name))
