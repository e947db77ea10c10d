# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Body, points, colours and clamp of a fit in one frame."""

from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.recording.color_on_depth import color_on_depth
from diffcal_ros.rigid_transform import apply, inverse
from diffcal_ros.web.fit_folder import read_fit
from diffcal_ros.web.fitted_view import seen_fit
from diffcal_ros.web.held_box import box_around
from diffcal_ros.web.point_cloud import distance_colors
import numpy as np
import pytest
from scipy.spatial import cKDTree

GREY = 150


@pytest.fixture(scope='module')
def seen(fitted_beam):
    fit = read_fit(fitted_beam.folder)
    inputs = fit.open()
    (body,) = seen_fit(fit, inputs)
    return body, inputs.observations[0], fit.scene


def test_points_on_the_body_lie_on_its_simulated_surface(seen):
    body, _, _ = seen
    corners = body.vertices[body.triangles]
    shares = np.random.default_rng(3).dirichlet((1.0, 1.0, 1.0), 60)
    surface = np.einsum('sc,fcx->fsx', shares, corners).reshape(-1, 3)
    is_on_body = ~(body.by_distance == GREY).all(axis=1)
    distance, _ = cKDTree(surface).query(body.points[is_on_body])
    assert is_on_body.sum() > 500
    # Samples of the surface are half a millimetre apart.
    assert np.median(distance) < 0.8e-3


def test_the_box_around_what_is_held_begins_where_the_clamp_does(seen):
    body, _, scene = seen
    ((world_from_object, box),) = body.held
    corner = -0.5 * box.sides
    low = apply(box.object_from_box, corner)
    assert low[0] == pytest.approx(0.105, abs=1e-6)
    # The beam was filmed where its scene places it, but for what the fit found.
    there = scene.observations[0].world_from_object
    assert np.abs(world_from_object - there).max() < 2e-3
    held = np.unique(body.held_triangles)
    inside = apply(inverse(world_from_object @ box.object_from_box), body.vertices[held])
    assert (np.abs(inside) <= 0.5 * box.sides + 1e-3).all()


def test_colours_are_those_of_the_marker(seen, fitted_beam):
    _, observation, scene = seen
    recording = open_recording(fitted_beam.bag)
    colors, is_known = color_on_depth(recording, observation.depth, observation.camera)
    points = apply(
        inverse(observation.depth_from_world),
        observation.camera.back_project(observation.depth.astype(np.float64)),
    )
    on_marker = is_known & (np.abs(points[..., 2]) < 2e-3)
    # The outermost ring of cells is black, and paper is left white around it.
    reach = np.abs(points[..., :2]).max(axis=-1) / (0.5 * scene.marker.side)
    black, white = on_marker & (np.abs(reach - 0.87) < 0.06), on_marker & (abs(reach - 1.1) < 0.04)
    assert black.sum() > 50
    assert white.sum() > 50
    assert np.median(colors[black]) < 80
    assert np.median(colors[white]) > 150


def test_a_recording_without_colour_lends_none(recorded_beam):
    recording = open_recording(recorded_beam.bags['observation'])
    frame = next(iter(recording.depth_frames(limit=1)))
    object.__setattr__(recording, 'color_camera', None)
    assert color_on_depth(recording, frame.depth, recording.depth_camera) is None


def test_distances_are_blue_before_and_orange_behind_the_surface():
    residual = np.array([[-1e-3, 1e-3, np.nan, 0.0]])
    colors, is_known, scale = distance_colors(residual, 0.25e-3)
    assert scale == pytest.approx(1e-3)
    assert is_known.tolist() == [[True, True, False, True]]
    nearer, farther = colors[0, 0].astype(int), colors[0, 1].astype(int)
    assert nearer[2] > nearer[0] + 50
    assert farther[0] > farther[2] + 50


def test_a_box_along_an_oblique_direction_holds_its_points():
    direction = np.array([0.6, 0.0, 0.8])
    points = np.random.default_rng(1).normal(size=(40, 3))
    box = box_around(points, direction, low=-0.5)
    assert np.linalg.det(box.object_from_box[:3, :3]) == pytest.approx(1.0)
    inside = apply(inverse(box.object_from_box), points)
    above = points @ direction >= -0.5
    assert (np.abs(inside[above]) <= 0.5 * box.sides + 1e-12).all()
    low = apply(box.object_from_box, np.array([-0.5 * box.sides[0], 0.0, 0.0]))
    assert low @ direction == pytest.approx(-0.5)
