# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0

from diffcal_ros.pose.corner_fit import fit_corners, gather, perturbed, pose_equations
from diffcal_ros.pose.detection import Detection
from diffcal_ros.pose.marker_depth import MarkerPoints
from diffcal_ros.pose.marker_target import marker_grid
from diffcal_ros.rigid_transform import apply, rotation_vector
import numpy as np
import pytest

CORNER_ERROR = 0.2


@pytest.fixture
def board():
    return marker_grid('DICT_6X6_250', columns=2, rows=1, side=0.03, gap=0.01)


@pytest.fixture
def sightings(board, color_camera, marker_pose, random):
    pose = marker_pose(30.0)
    frames = [
        Detection(
            {
                marker: color_camera.project(apply(pose, corners)) + random.normal(0, 0.3, (4, 2))
                for marker, corners in board.corners.items()
            },
            {},
        )
        for _ in range(3)
    ]
    return gather(frames, board)


@pytest.fixture
def measured(marker_pose, random):
    count = 40
    flat = np.hstack([random.uniform(-0.02, 0.02, (count, 2)), random.normal(0, 5e-4, (count, 1))])
    return MarkerPoints(
        points=apply(marker_pose(31.0, distance=0.403), flat),
        normals=np.tile([0.0, 0.0, 1.0], (count, 1)),
        origins=np.tile([0.004, -0.003, 0.0], (count, 1)),
        depth_ratio=np.ones(count),
        parts=np.zeros(count, dtype=np.int64),
    )


def test_perturbation_shifts_and_turns_in_the_camera_frame(marker_pose):
    pose = marker_pose(25.0)
    step = np.array([1e-3, -2e-3, 3e-3, 0.02, -0.01, 0.03])
    moved = perturbed(pose, step)
    np.testing.assert_allclose(moved[:3, 3] - pose[:3, 3], step[:3])
    np.testing.assert_allclose(rotation_vector(moved[:3, :3] @ pose[:3, :3].T), step[3:])


def test_corner_gradient_matches_differences(sightings, color_camera, marker_pose, random):
    pose = marker_pose(34.0, distance=0.39)
    weights = random.uniform(0.2, 1.0, len(sightings.ids))
    said = pose_equations(
        pose, sightings, color_camera, weights, corner_error=CORNER_ERROR, depth=None
    )

    def half_sum(moved):
        # Two markers: the weighted mean over frames counts twice.
        share = 2.0 * weights / weights.sum() / CORNER_ERROR**2
        return 0.5 * 4.0 * share @ sightings.errors(moved, color_camera) ** 2

    np.testing.assert_allclose(-said.negative_gradient, differences(half_sum, pose), rtol=1e-5)
    assert said.cost == pytest.approx(half_sum(pose))


def test_depth_gradient_matches_differences(sightings, color_camera, marker_pose, measured):
    pose = marker_pose(34.0, distance=0.39)
    weights = np.ones(len(sightings.ids))
    options = {'corner_error': CORNER_ERROR}
    without = pose_equations(pose, sightings, color_camera, weights, depth=None, **options)
    both = pose_equations(pose, sightings, color_camera, weights, depth=measured, **options)
    assert np.linalg.eigvalsh(both.curvature).min() > 0.0
    # The pixels' weights follow from the heights at `pose`; they stay fixed here as they do there.
    heights = measured.heights(pose)
    spread = np.abs(heights - np.median(heights))
    scale = 1.4826 * np.median(spread) + 1e-4
    weight = 1.0 / (1.0 + (spread / (3.0 * scale)) ** 2)
    weight *= 10.0 / 1e-3**2 / weight.sum()

    def half_sum(moved):
        return 0.5 * weight @ measured.heights(moved) ** 2

    slope = without.negative_gradient - both.negative_gradient
    assert both.cost - without.cost == pytest.approx(half_sum(pose))
    np.testing.assert_allclose(slope, differences(half_sum, pose), rtol=1e-5)


def differences(function, pose):
    """Central differences along the six steps."""
    gradient = np.empty(6)
    for k in range(6):
        step = np.zeros(6)
        step[k] = 1e-6
        gradient[k] = (function(perturbed(pose, step)) - function(perturbed(pose, -step))) / 2e-6
    return gradient


def test_fit_is_stationary_and_down_weights_a_bad_frame(
    board, sightings, color_camera, marker_pose
):
    spoilt = sightings.pixels.copy()
    spoilt[sightings.frames == 1] += [9.0, -7.0]
    sightings.pixels[:] = spoilt
    fit = fit_corners(marker_pose(30.0), sightings, color_camera)
    assert fit.weights[sightings.frames == 1].max() < 0.05
    assert fit.weights[sightings.frames != 1].min() > 0.5
    at_end = pose_equations(
        fit.camera_from_marker,
        sightings,
        color_camera,
        fit.weights,
        corner_error=1.0,
        depth=None,
    )
    at_start = pose_equations(
        marker_pose(31.0), sightings, color_camera, fit.weights, corner_error=1.0, depth=None
    )
    assert np.linalg.norm(at_end.negative_gradient) < 1e-3 * np.linalg.norm(
        at_start.negative_gradient
    )


def test_averaged_sightings_are_weighted_means(sightings):
    weights = np.where(sightings.frames == 0, 3.0, 1.0)
    averaged = sightings.averaged(weights)
    first = sightings.ids == averaged.ids[0]
    expected = np.average(sightings.pixels[first], axis=0, weights=[3.0, 1.0, 1.0])
    np.testing.assert_allclose(averaged.pixels[0], expected)
    np.testing.assert_allclose(averaged.points[0], sightings.points[first][0])
