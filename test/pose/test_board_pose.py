# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The pose of a ChArUco board, by OpenCV's detector on rendered pictures."""

from dataclasses import replace
from functools import cache

import cv2
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import PoseError
from diffcal_ros.marker import Board, Marker
from diffcal_ros.pose.detection import Detection
from diffcal_ros.pose.detectors import make_detector
from diffcal_ros.pose.marker_depth import DepthEvidence
from diffcal_ros.pose.marker_image import draw_print
from diffcal_ros.pose.marker_print import print_of
from diffcal_ros.pose.pose_drawing import draw_pose
from diffcal_ros.pose.rig_pose import estimate_rig_pose, pose_from_images
from diffcal_ros.pose.target import target_of
from diffcal_ros.rigid_transform import (
    angle_between,
    apply,
    rotation_matrix,
    rotation_vector,
    transform,
)
import numpy as np
import pytest

CAMERA = PinholeCamera(640, 480, 605.0, 590.0, 331.5, 226.3)
BOARD = Marker('DICT_4X4_50', 0, 0.022, board=Board(5, 7, 0.03))
LENS = (-0.3, 0.12, 0.001, -0.0007, 0.0)
FLIPPED = np.deg2rad(10.0)
# Corners of rendered squares of 35 pixels: measured 0.03 px, up to 0.06 px tilted by 45 degrees.
CORNER_ERROR = 0.06
# The mean over 24 corners scatters by 0.01 px; a detector that counts pixels from their corner
# is off by 0.5 px.
CORNER_BIAS = 0.03
# At 0.5 m, three frames; measured up to 0.25 mm and 0.08 degrees.
SHIFT, TURN = 0.5e-3, np.deg2rad(0.1)


def placed(tilt_deg, axis_deg=70.0, *, distance=0.5, shift=(0.02, -0.01), spin_deg=12.0):
    """Tilt a board that faces the camera about an axis in the image."""
    axis = np.deg2rad(axis_deg)
    tilt = rotation_matrix(np.deg2rad(tilt_deg) * np.array([np.cos(axis), np.sin(axis), 0.0]))
    spin = rotation_matrix(np.array([0.0, 0.0, np.deg2rad(spin_deg)]))
    return transform(tilt @ np.diag([1.0, -1.0, -1.0]) @ spin, np.array([*shift, distance]))


POSES = {
    'upright': placed(25.0),
    'turned': placed(35.0, 160.0, shift=(-0.03, 0.01), spin_deg=100.0),
    'flat': placed(8.0, 250.0, spin_deg=-50.0),
}


@cache
def picture(name, marker=BOARD.board, lens=()):
    """Render a board with a lens blur and without noise."""
    sheet = print_of(replace(BOARD, board=marker))
    camera = replace(CAMERA, distortion=lens)
    blank = np.full((camera.height, camera.width, 3), 110, np.uint8)
    drawn = draw_print(blank, sheet, camera=camera, camera_from_marker=POSES[name])
    return cv2.GaussianBlur(drawn, (0, 0), 0.7)


def exposed(image, random, count=3, noise=2.0):
    return [
        np.clip(image + random.normal(0.0, noise, image.shape), 0, 255).astype(np.uint8)
        for _ in range(count)
    ]


def covered(image, pose, low, high):
    """Paint over a rectangle of the board, between two places on it in squares."""
    low, high = np.array(low), np.array(high)
    across = [low, [high[0], low[1]], high, [low[0], high[1]]]
    points = (np.array(across) * 0.03 - BOARD.size / 2.0) * [1.0, -1.0]
    pixels = CAMERA.project(apply(pose, np.hstack([points, np.zeros((4, 1))])))
    return cv2.fillConvexPoly(image.copy(), np.rint(pixels).astype(np.int32), (150, 170, 200))


def pose_error(found, truth):
    """Shift of the origin and turn about it, both in the camera's frame, shape (6,)."""
    turn = rotation_vector(truth[:3, :3] @ found.camera_from_marker[:3, :3].T)
    return np.concatenate([truth[:3, 3] - found.camera_from_marker[:3, 3], turn])


def seen(target, pose, random, noise):
    corners = {
        number: CAMERA.project(apply(pose, point)) + random.normal(0.0, noise, (1, 2))
        for number, point in target.corners.items()
    }
    return Detection(corners, corners, 0.05)


@pytest.fixture
def target():
    return target_of(BOARD)


@pytest.fixture
def detector(target):
    return make_detector(target, CAMERA)


@pytest.mark.parametrize('name', POSES)
@pytest.mark.slow_but_first
def test_corners_are_found_without_bias(detector, random, name):
    (image,) = exposed(picture(name), random, 1)
    found = detector.detect(image)
    assert len(found.corners) == 24
    truth = {
        number: CAMERA.project(apply(POSES[name], point))
        for number, point in detector.target.corners.items()
    }
    misses = np.concatenate([corner - truth[number] for number, corner in found.corners.items()])
    assert np.sqrt((misses**2).mean()) < CORNER_ERROR
    assert np.abs(misses.mean(axis=0)).max() < CORNER_BIAS


@pytest.mark.parametrize('name', POSES)
def test_pose_and_its_covariance(detector, random, name):
    """Three frames of a whole board, then of one that something stands before."""
    parts = {'whole': picture(name), 'part': covered(picture(name), POSES[name], (0, 3), (5, 7))}
    for part, image in parts.items():
        found = pose_from_images(exposed(image, random), detector)
        error = pose_error(found, POSES[name])
        factor = 1.0 if part == 'whole' else 2.0
        assert np.linalg.norm(error[:3]) < factor * SHIFT
        assert np.linalg.norm(error[3:]) < factor * TURN
        assert (np.abs(error) < 3.0 * np.sqrt(np.diag(found.covariance))).all()
        assert found.is_settled
        assert found.frame_count == 3
        assert (len(found.seen_ids) == 24) == (part == 'whole')


def test_a_part_is_known_less_well_than_the_whole(detector, random):
    image = picture('upright')
    part = covered(image, POSES['upright'], (0, 3), (5, 7))
    spreads = [
        np.sqrt(np.diag(pose_from_images(exposed(shown, random), detector).covariance))
        for shown in (image, part)
    ]
    assert (spreads[1] > 1.2 * spreads[0])[2:5].all()


@pytest.mark.slow
def test_covariance_tells_the_scatter(target, random):
    pose = POSES['upright']
    distances = []
    for _ in range(60):
        shared = seen(target, np.array(pose), random, 0.04)
        frames = []
        for _ in range(3):
            own = {n: c + random.normal(0.0, 0.02, (1, 2)) for n, c in shared.corners.items()}
            frames.append(Detection(own, own, 0.05))
        found = estimate_rig_pose(frames, target, CAMERA)
        error = pose_error(found, pose)
        distances.append(error @ np.linalg.solve(found.covariance, error))
    # Chi-square with 6 degrees of freedom: the mean of 60 scatters by 0.45.
    assert 4.0 < np.mean(distances) < 8.0
    assert max(distances) < 30.0


def test_many_frames_settle_what_single_frames_mistake(target, random):
    single_flips = fused_flips = 0
    for axis in range(0, 360, 60):
        pose = placed(20.0, axis, distance=3.5)
        frames = [seen(target, pose, random, 0.5) for _ in range(20)]
        for frame in frames[:8]:
            alone = estimate_rig_pose([frame], target, CAMERA)
            single_flips += angle_between(alone.camera_from_marker, pose) > FLIPPED
        fused = estimate_rig_pose(frames, target, CAMERA)
        fused_flips += angle_between(fused.camera_from_marker, pose) > FLIPPED
    assert single_flips >= 3
    assert fused_flips == 0


def test_frames_gone_wrong_and_corners_gone_wrong_do_not_count(target, random):
    pose = POSES['upright']
    frames = [seen(target, pose, random, 0.03) for _ in range(5)]
    elsewhere = placed(20.0, 10.0, shift=(0.05, 0.02))
    frames.insert(1, seen(target, elsewhere, random, 0.03))
    for frame in frames:
        # A corner that something half covers, in every frame alike.
        frame.corners[7][:] += [3.0, -2.0]
    found = estimate_rig_pose(frames, target, CAMERA)
    assert found.supports == (True, False, True, True, True, True)
    assert 7 not in found.seen_ids
    error = pose_error(found, pose)
    assert np.linalg.norm(error[:3]) < SHIFT
    assert np.linalg.norm(error[3:]) < TURN


def test_a_bent_lens_is_taken_out(target, random):
    lens = replace(CAMERA, distortion=LENS)
    found = pose_from_images(
        exposed(picture('upright', lens=LENS), random), make_detector(target, lens)
    )
    error = pose_error(found, POSES['upright'])
    assert np.linalg.norm(error[:3]) < SHIFT
    assert np.linalg.norm(error[3:]) < TURN


def test_depth_is_taken_where_the_board_is_uncovered(target, random):
    """A thing before most of the board must not count as the board's own depth."""
    pose = POSES['upright']
    normal = pose[:3, 2]
    depth = (normal @ pose[:3, 3]) / (CAMERA.rays() @ normal)
    mask = covered(np.zeros((CAMERA.height, CAMERA.width, 3), np.uint8), pose, (0, 2.5), (5, 7))
    # 8 % nearer: enough to be told from noise, too little to be dropped as something else.
    evidence = DepthEvidence(np.where(mask[..., 0] > 0, 0.92 * depth, depth), CAMERA, np.eye(4))
    frame = seen(target, pose, random, 0.02)
    shown = {number: frame.corners[number] for number in range(8)}
    found = estimate_rig_pose([Detection(shown, shown, 0.05)], target, CAMERA, depth=evidence)
    assert found.distance_check.problem is None
    assert found.distance_check.relative_error == pytest.approx(0.0, abs=5e-3)


@pytest.mark.parametrize('is_legacy', [False, True])
def test_boards_with_even_rows_are_found_in_both_patterns(random, is_legacy):
    board = Board(4, 6, 0.03, is_legacy)
    images = exposed(picture('upright', board), random, 1)
    own = target_of(replace(BOARD, board=board))
    found = pose_from_images(images, make_detector(own, CAMERA))
    assert np.linalg.norm(pose_error(found, POSES['upright'])[:3]) < 2.0 * SHIFT
    other = target_of(replace(BOARD, board=replace(board, is_legacy=not is_legacy)))
    made = 'before' if is_legacy else 'after'
    said = rf'OpenCV {made} version 4.6: set `legacy: {str(is_legacy).lower()}` under `board`'
    with pytest.raises(PoseError, match=said):
        pose_from_images(images, make_detector(other, CAMERA))


def test_too_few_corners_are_counted(detector, random):
    left = covered(picture('upright'), POSES['upright'], (-0.5, 2.5), (5.5, 7.5))
    left = covered(left, POSES['upright'], (2.5, -0.5), (5.5, 7.5))
    images = exposed(left, random, 2)
    said = r'5x7 board of DICT_4X4_50 was seen in 2 colour frames, but at most [1-5] of its 24 in'
    with pytest.raises(PoseError, match=said):
        pose_from_images(images, detector)


def test_another_board_is_told(random):
    images = exposed(picture('upright'), random, 1)
    wider = make_detector(target_of(replace(BOARD, board=Board(7, 5, 0.03))), CAMERA)
    with pytest.raises(PoseError, match=r'17 of its 17 markers were, .* check columns, rows'):
        pose_from_images(images, wider)
    later = make_detector(target_of(replace(BOARD, id=20)), CAMERA)
    with pytest.raises(PoseError, match=r'never seen in 1 colour frame, but markers 0, 1, 2'):
        pose_from_images(images, later)


def test_an_empty_picture_and_one_of_another_size(detector):
    with pytest.raises(PoseError, match='5x7 board of DICT_4X4_50 was never seen in 1 colour fr'):
        pose_from_images([np.full((480, 640, 3), 110, np.uint8)], detector)
    with pytest.raises(PoseError, match='colour image is 320x240, its camera is 640x480'):
        detector.detect(np.zeros((240, 320), np.uint8))


def test_found_corners_are_drawn(detector, random):
    (image,) = exposed(picture('upright'), random, 1)
    detection = detector.detect(image)
    drawn = draw_pose(image, CAMERA, detection, POSES['upright'], length=0.05)
    changed = (drawn != image).any(axis=-1)
    for corner in detection.image_corners.values():
        column, row = np.rint(corner[0]).astype(int)
        assert changed[row - 4 : row + 5, column - 4 : column + 5].sum() >= 8
