# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0

from diffcal_ros.errors import PoseError
from diffcal_ros.pose.detection import CornerRefinement, Detection, MarkerDetector, SHARED_ERROR
from diffcal_ros.pose.marker_depth import DepthEvidence, marker_distance_check
from diffcal_ros.pose.marker_target import marker_grid, single_marker
from diffcal_ros.pose.planar_pose import pose_candidates
from diffcal_ros.pose.rig_pose import estimate_rig_pose, pose_from_images
from diffcal_ros.rigid_transform import (
    angle_between,
    apply,
    rotation_matrix,
    rotation_vector,
    transform,
)
import numpy as np
import pytest

FLIPPED = np.deg2rad(15.0)


def seen(target, camera, pose, *, noise=0.0, random=None, ids=None):
    """Make a detection without an image."""
    corners = {}
    for marker in target.ids if ids is None else ids:
        corners[marker] = camera.project(apply(pose, target.corners[marker]))
        if noise:
            corners[marker] = corners[marker] + random.normal(0.0, noise, (4, 2))
    return Detection(corners, corners)


def pose_error(estimate, truth):
    """Shift of the origin and turn about it, both in the camera's frame, shape (6,)."""
    turn = rotation_vector(truth[:3, :3] @ estimate[:3, :3].T)
    return np.concatenate([truth[:3, 3] - estimate[:3, 3], turn])


def test_exact_corners_give_the_exact_pose(color_camera, target, marker_pose):
    pose = marker_pose(30.0)
    fused = estimate_rig_pose([seen(target, color_camera, pose)] * 2, target, color_camera)
    np.testing.assert_allclose(fused.camera_from_marker, pose, atol=1e-6)
    assert fused.frame_count == 2
    assert fused.outlier_count == 0
    assert fused.is_settled
    assert fused.reprojection_error < 1e-3


@pytest.mark.slow
def test_many_frames_settle_what_single_frames_mistake(color_camera, target, marker_pose, random):
    single_flips = fused_flips = 0
    for axis in range(0, 360, 30):
        pose = marker_pose(35.0, axis_deg=axis, distance=0.6)
        frames = [seen(target, color_camera, pose, noise=0.4, random=random) for _ in range(25)]
        for frame in frames:
            alone = estimate_rig_pose([frame], target, color_camera)
            single_flips += angle_between(alone.camera_from_marker, pose) > FLIPPED
        fused = estimate_rig_pose(frames, target, color_camera)
        fused_flips += angle_between(fused.camera_from_marker, pose) > FLIPPED
    assert single_flips > 20
    assert fused_flips == 0


@pytest.mark.slow
def test_the_solution_that_explains_all_frames_better_is_kept(
    color_camera, target, marker_pose, random
):
    # Few and noisy frames: the best single-frame pose is on the wrong side now and then.
    ratios = []
    for axis in range(0, 360, 6):
        pose = marker_pose(25.0, axis_deg=axis, distance=0.6)
        frames = [seen(target, color_camera, pose, noise=0.5, random=random) for _ in range(4)]
        ratios.append(estimate_rig_pose(frames, target, color_camera).error_ratio)
    # Outliers weigh differently in the two fits, so the means may differ a little.
    assert min(ratios) > 0.95


def test_frames_gone_wrong_do_not_count(color_camera, target, marker_pose, random):
    pose = marker_pose(30.0)
    frames = [seen(target, color_camera, pose, noise=0.05, random=random) for _ in range(7)]
    elsewhere = marker_pose(20.0, column=0.08, axis_deg=10.0)
    frames[1:1] = [seen(target, color_camera, elsewhere)] * 3
    frames.append(Detection({}, {}))
    fused = estimate_rig_pose(frames, target, color_camera)
    assert fused.supports == (True, *[False] * 3, *[True] * 6, False)
    assert fused.outlier_count == 3
    # The mean of all frames would be 9 mm off.
    assert np.linalg.norm(fused.camera_from_marker[:3, 3] - pose[:3, 3]) < 0.5e-3


@pytest.mark.slow
def test_covariance_tells_the_scatter(color_camera, target, marker_pose, random):
    pose = marker_pose(40.0)
    distances, turns = [], []
    for _ in range(150):
        # One error that the frames share, as large as is expected of edges, and one of each.
        shared = random.normal(0.0, 0.1, (4, 2))
        frames = [seen(target, color_camera, pose, noise=0.2, random=random) for _ in range(8)]
        for frame in frames:
            frame.corners[3][:] += shared
        fused = estimate_rig_pose(frames, target, color_camera)
        error = pose_error(fused.camera_from_marker, pose)
        distances.append(error @ np.linalg.solve(fused.covariance, error))
        turns.append(error[3:] @ np.linalg.solve(fused.covariance[3:, 3:], error[3:]))
    # Chi-square with 6 and 3 degrees of freedom; the corners' variance itself is estimated from
    # few residuals, so the band is wider than the scatter of 150 draws.
    assert 4.0 < np.mean(distances) < 9.0
    assert 2.0 < np.mean(turns) < 4.5


def test_unrefined_corners_carry_a_larger_covariance(color_camera, target, marker_pose):
    frame = seen(target, color_camera, marker_pose(30.0))
    rough = Detection(frame.corners, frame.corners, SHARED_ERROR[CornerRefinement.NONE])
    fine, coarse = (estimate_rig_pose([d], target, color_camera) for d in (frame, rough))
    assert coarse.covariance[2, 2] > 25.0 * fine.covariance[2, 2]


def test_depth_decides_where_corners_err(color_camera, target, marker_pose, plane_depth):
    pose = marker_pose(35.0, distance=0.6)
    points = target.corners[3]
    pixels = color_camera.project(apply(pose, points))
    mirrored = pose_candidates(points, pixels, color_camera)[1].camera_from_marker
    mixed = 0.3 * pixels + 0.7 * color_camera.project(apply(mirrored, points))
    frame = Detection({3: mixed}, {3: mixed})
    depth_from_color = transform(
        rotation_matrix(np.array([0.02, -0.03, 0.01])), np.array([0.015, -0.004, 0.002])
    )
    evidence = DepthEvidence(
        plane_depth(color_camera, depth_from_color @ pose), color_camera, depth_from_color
    )
    by_corners = estimate_rig_pose([frame], target, color_camera)
    assert angle_between(by_corners.camera_from_marker, pose) > FLIPPED
    by_depth = estimate_rig_pose([frame], target, color_camera, depth=evidence)
    assert angle_between(by_depth.camera_from_marker, pose) < FLIPPED
    assert by_depth.is_settled
    assert by_depth.depth_error_ratio > 10.0
    assert angle_between(by_depth.other_camera_from_marker, mirrored) < FLIPPED


def test_depth_corrects_the_distance(color_camera, target, marker_pose, plane_depth):
    pose = marker_pose(25.0)
    # Corners half a pixel inside the square, as an unrefined detector gives them.
    corners = color_camera.project(apply(pose, target.corners[3]))
    inside = corners + 0.02 * (corners.mean(axis=0) - corners)
    frame = Detection({3: inside}, {3: inside}, SHARED_ERROR[CornerRefinement.NONE])
    evidence = DepthEvidence(plane_depth(color_camera, pose), color_camera, np.eye(4))
    by_corners = estimate_rig_pose([frame], target, color_camera)
    by_depth = estimate_rig_pose([frame], target, color_camera, depth=evidence)
    assert by_corners.camera_from_marker[2, 3] - pose[2, 3] > 5e-3
    np.testing.assert_allclose(by_depth.camera_from_marker[:3, 3], pose[:3, 3], atol=1e-3)
    assert by_depth.covariance[2, 2] < by_corners.covariance[2, 2]


@pytest.mark.parametrize(('factor', 'is_wrong'), [(0.93, True), (1.02, False), (1.06, True)])
def test_depth_does_not_hide_a_wrong_side(
    color_camera, target, marker_pose, plane_depth, factor, is_wrong
):
    pose = marker_pose(25.0)
    believed = single_marker('DICT_6X6_250', 3, 0.03 * factor)
    evidence = DepthEvidence(plane_depth(color_camera, pose), color_camera, np.eye(4))
    frame = seen(target, color_camera, pose)
    fused = estimate_rig_pose([frame], believed, color_camera, depth=evidence)
    assert fused.distance_check.relative_error == pytest.approx(factor - 1.0, abs=2e-3)
    assert (fused.distance_check.problem is not None) == is_wrong
    distance = factor if is_wrong else 1.0
    # Corners keep a small say beside the depth.
    assert fused.camera_from_marker[2, 3] == pytest.approx(0.4 * distance, rel=5e-3)
    # Asked again of the result, a wrong side still shows.
    again = marker_distance_check(fused.camera_from_marker, believed, evidence)
    assert (again.problem is not None) == is_wrong


def test_depth_that_misses_the_marker_changes_nothing(color_camera, target, marker_pose):
    frame = seen(target, color_camera, marker_pose(25.0))
    empty = DepthEvidence(np.full((480, 640), np.nan), color_camera, np.eye(4))
    without = estimate_rig_pose([frame], target, color_camera)
    given = estimate_rig_pose([frame], target, color_camera, depth=empty)
    np.testing.assert_array_equal(given.camera_from_marker, without.camera_from_marker)
    assert given.depth_error_ratio is None


def test_board_seen_in_parts(color_camera, marker_pose, random):
    board = marker_grid('DICT_6X6_250', columns=2, rows=2, side=0.02, gap=0.02)
    pose = marker_pose(30.0)
    frames = [
        seen(board, color_camera, pose, noise=0.05, random=random, ids=ids)
        for ids in ([0, 1], [2], [1, 3], [0, 3])
    ]
    fused = estimate_rig_pose(frames, board, color_camera)
    assert fused.frame_count == 4
    np.testing.assert_allclose(fused.camera_from_marker, pose, atol=3e-3)
    one = estimate_rig_pose(frames[1:2], board, color_camera)
    # A larger target is better known.
    assert np.trace(fused.covariance) < 0.5 * np.trace(one.covariance)


def test_view_along_the_normal_is_not_settled(color_camera, target, marker_pose, random):
    frames = [
        seen(target, color_camera, marker_pose(6.0), noise=0.4, random=random) for _ in range(3)
    ]
    fused = estimate_rig_pose(frames, target, color_camera)
    assert fused.error_ratio < 1.5
    assert not fused.is_settled


def test_images_to_pose(color_camera, target, marker_pose, photograph):
    pose = marker_pose(35.0)
    images = [photograph(pose) for _ in range(3)]
    fused = pose_from_images(images, MarkerDetector(target, color_camera))
    error = pose_error(fused.camera_from_marker, pose)
    # Measured 0.1 to 0.5 mm and 0.1 degrees.
    assert np.linalg.norm(error[:3]) < 1e-3
    assert np.linalg.norm(error[3:]) < np.deg2rad(0.5)
    unrefined = pose_from_images(images, MarkerDetector(target, color_camera, 'none'))
    assert np.linalg.norm(pose_error(unrefined.camera_from_marker, pose)[:3]) > 4e-3


def test_marker_never_seen(color_camera, target):
    blank = Detection({}, {})
    with pytest.raises(PoseError, match=r'marker 3 of DICT_6X6_250 was never seen in 2 colour'):
        estimate_rig_pose([blank, blank], target, color_camera)


def test_wrong_id_names_what_was_seen(color_camera, marker_pose, photograph):
    detector = MarkerDetector(single_marker('DICT_6X6_250', 0, 0.03), color_camera)
    with pytest.raises(PoseError, match=r'marker 0 .*1 colour frame, but marker 3 .*set the mar'):
        pose_from_images([photograph(marker_pose(20.0))], detector)


def test_blurred_marker_is_told_apart(color_camera, target):
    found = {3: np.zeros((4, 2))}
    with pytest.raises(PoseError, match='too blurred'):
        estimate_rig_pose([Detection({}, found)], target, color_camera)


def test_covariance_follows_the_camera_frame(color_camera, target, marker_pose):
    pose = marker_pose(0.0, column=0.0, row=0.0)
    fused = estimate_rig_pose([seen(target, color_camera, pose)], target, color_camera)
    spread = np.sqrt(np.diag(fused.covariance))
    # Along the line of sight a marker is worst known, and best turned about it.
    assert spread[2] > 5.0 * max(spread[:2])
    assert spread[5] < 0.2 * min(spread[3:5])
