# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where on its triangle a pixel sees a body."""

from dataclasses import replace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.residuals.robust_residual import make_comparers
from diffcal_ros.depth.corner_weights import corner_pairs, corner_weights
import numpy as np
import pytest
from support.scenes import beam_scene, observation, true_depth


def test_weights_lead_to_the_point_of_the_ray_in_its_triangle(random):
    points = np.array(
        [[0.1, -0.05, 0.5], [-0.08, 0.02, 0.61], [0.03, 0.09, 0.44], [0.2, 0.1, 0.7]]
    )
    triangles = np.array([[0, 1, 2], [3, 0, 2]], dtype=np.int32)
    weights = random.dirichlet(np.ones(3), size=7)
    faces = np.array([0, 1, 1, 0, 0, 1, 0])
    seen = np.einsum('nc,nci->ni', weights, points[triangles][faces])
    found = corner_weights(corner_pairs(points, triangles)[faces], seen[:, :2] / seen[:, 2:])
    np.testing.assert_allclose(found, weights, rtol=0.0, atol=1e-12)
    # What is not a triangle's corner first by order does not matter: turned they turn with it.
    turned = corner_pairs(points, np.roll(triangles, 1, axis=1))[faces]
    again = corner_weights(turned, seen[:, :2] / seen[:, 2:])
    np.testing.assert_allclose(again, np.roll(weights, 1, axis=1), rtol=0.0, atol=1e-12)


@pytest.fixture(scope='module')
def traced():
    """A hanging beam that states a border, its comparer and its view."""
    scene = replace(beam_scene((5, 2, 2)), effects={'depth_bias_by_region': {'at': 0.43}})
    model = ForwardModel(
        scene, [observation(true_depth())], make_parameters(scene, ('youngs_modulus',))
    )
    return model, make_comparers(model)[0], model.views(model.parameters.start())[0]


def test_pixels_of_a_bent_body_lie_where_its_nodes_say(traced):
    """Points of the surface are rays times the traced depth, and by the weights those of nodes."""
    model, comparer, view = traced
    trace = view.trace
    pixels = np.flatnonzero(trace.faces.ravel() >= 0).astype(np.int32)
    faces = trace.faces.ravel()[pixels]
    rays = view.tracer.camera.rays()[trace.rows, trace.columns].reshape(-1, 3)[pixels]
    weights = trace.corner_weights(faces, rays[:, :2])
    points = np.einsum('nc,nci->ni', weights, view.points[view.tracer.triangles[faces]])
    np.testing.assert_allclose(points, rays * trace.depth.ravel()[pixels, None], atol=1e-6)
    assert weights.min() > -1e-4
    shares = comparer.shares(trace, pixels)
    rest = model.body(model.observations[0]).discretisation.rest_nodes
    at_rest = np.einsum('nc,nci->ni', weights, rest[view.tracer.triangles[faces]])
    axes = model.effects.axes(0)
    np.testing.assert_allclose(shares, axes.fraction(at_rest), atol=1e-9)


def test_errors_know_where_on_the_body_each_pixel_is_and_which_way_it_faces(traced):
    """Of a box a face is flat across one axis, and whoever is on it faces along that one."""
    model, comparer, view = traced
    trace = view.trace
    shown = trace.faces >= 0
    pixels = np.flatnonzero(shown).astype(np.int32)
    some, whole = comparer.seen(view, pixels), comparer.seen(view, np.arange(shown.size))
    np.testing.assert_array_equal(whole.places[pixels], some.places)
    assert not whole.places[~shown.ravel()].any()
    faces = trace.faces.ravel()[pixels]
    weights = trace.corner_weights(faces, some.directions)
    rest = model.body(model.observations[0]).discretisation.rest_nodes
    at_rest = np.einsum('nc,nci->ni', weights, rest[view.tracer.triangles[faces]])
    axes = model.effects.axes(0)
    np.testing.assert_allclose(some.places, axes.places(at_rest, rest), atol=1e-9)
    for way in (0, 1):
        on = np.abs(some.sides[:, way]) > 0.5
        np.testing.assert_allclose(some.sides[on, way], some.places[on, 1 + way], atol=1e-9)
    # The end faces along the body, and not across.
    ends = ~np.isclose(np.abs(some.sides), 1.0).any(axis=1)
    np.testing.assert_allclose(some.sides[ends], 0.0, atol=1e-9)
    np.testing.assert_allclose(some.places[ends, 0], 1.0)
    assert (np.abs(some.sides) > 0.5).any(axis=0).sum() > 0


def test_a_border_goes_through_elements(traced):
    """Of five layers the second ends at 0.4, and none at 0.43."""
    _, comparer, view = traced
    trace = view.trace
    pixels = np.flatnonzero(trace.faces.ravel() >= 0).astype(np.int32)
    second = comparer.is_second(trace).ravel()[pixels]
    shares = comparer.shares(trace, pixels)
    np.testing.assert_array_equal(second, shares > 0.43)
    whole = comparer.surface.is_second[trace.faces.ravel()[pixels]]
    between = (shares > 0.4) & (shares < 0.43)
    assert between.sum() > 20
    assert (second[between] != whole[between]).all()
