# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0

from dataclasses import replace

from diffcal_ros.errors import PoseError
from diffcal_ros.pose.corner_refinement import refine_corners
from diffcal_ros.pose.detection import MarkerDetector
from diffcal_ros.pose.marker_image import draw_marker
from diffcal_ros.pose.marker_target import single_marker
from diffcal_ros.rigid_transform import apply
import numpy as np
import pytest

# Corners of rendered markers of 30 to 45 px, blurred by 0.7 px, noise of 2 grey levels. Measured
# means over poses: edges 0.01, OpenCV's refinement 0.3, unrefined 0.5 px.
EDGES_WITHIN = 0.03
UNREFINED_BEYOND = 0.3
POSES = [(10.0, 20.0), (25.0, 200.0), (40.0, 110.0), (50.0, 290.0)]


def corner_errors(detector, camera, pose, image):
    truth = camera.project(apply(pose, detector.target.corners[3]))
    return np.linalg.norm(detector.detect(image).corners[3] - truth, axis=1)


@pytest.mark.parametrize('distortion', [(), (-0.3, 0.12, 0.001, -0.0007, 0.0)])
def test_edges_locate_corners_and_unrefined_ones_are_inside(
    color_camera, target, marker_pose, photograph, distortion
):
    lens = replace(color_camera, distortion=distortion)
    errors = {'edges': [], 'subpixel': [], 'none': []}
    for tilt, axis in POSES:
        pose = marker_pose(tilt, axis_deg=axis, column=0.1)
        image = photograph(pose, camera=lens)
        for name, found in errors.items():
            detector = MarkerDetector(target, lens, name)
            # Corners come in the ideal pinhole image, so the truth needs no distortion.
            found.append(corner_errors(detector, color_camera, pose, image).mean())
    assert np.mean(errors['edges']) < EDGES_WITHIN
    assert np.mean(errors['none']) > UNREFINED_BEYOND
    assert np.mean(errors['edges']) < 0.1 * np.mean(errors['subpixel'])


def test_grey_and_colour_images_give_the_same(color_camera, target, marker_pose, photograph):
    image = photograph(marker_pose(30.0))
    image[:] = image[..., :1]
    detector = MarkerDetector(target, color_camera)
    colour, grey = detector.detect(image), detector.detect(image[..., 0].copy())
    np.testing.assert_allclose(colour.corners[3], grey.corners[3])


def test_other_markers_are_named(color_camera, marker_pose, photograph):
    detector = MarkerDetector(single_marker('DICT_6X6_250', 0, 0.03), color_camera)
    seen = detector.detect(photograph(marker_pose(20.0)))
    assert seen.corners == {}
    assert seen.other_ids == (3,)


def test_the_larger_of_two_equal_markers_counts(color_camera, target, marker_pose, photograph):
    near = photograph(marker_pose(10.0, column=-0.06))
    both = draw_marker(
        near,
        camera=color_camera,
        camera_from_marker=marker_pose(10.0, column=0.15, distance=0.6),
        dictionary='DICT_6X6_250',
        marker_id=3,
        side=0.03,
    )
    detector = MarkerDetector(target, color_camera)
    assert detector.detect(both).corners[3].mean(axis=0)[0] < 320.0


def test_corners_without_an_edge_are_refused(color_camera):
    flat = np.full((480, 640), 90, np.uint8)
    square = np.array([[100.0, 100.0], [140.0, 100.0], [140.0, 140.0], [100.0, 140.0]])
    assert refine_corners(flat, square, camera=color_camera, cells=8) is None


def test_corners_that_run_away_are_refused(color_camera, target, marker_pose, photograph):
    pose = marker_pose(0.0)
    image = photograph(pose)[..., 0]
    truth = color_camera.project(apply(pose, target.corners[3]))
    assert refine_corners(image, truth + 0.5, camera=color_camera, cells=8) is not None
    # Sides at a slant to the true ones meet them in a point only.
    turn = np.deg2rad(18.0)
    slant = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    wrong = (truth - truth.mean(axis=0)) @ slant.T + truth.mean(axis=0)
    assert refine_corners(image, wrong, camera=color_camera, cells=8) is None


def test_image_of_another_size_is_refused(color_camera, target):
    detector = MarkerDetector(target, color_camera)
    with pytest.raises(PoseError, match='image is 1280x720, its camera is 640x480'):
        detector.detect(np.zeros((720, 1280, 3), np.uint8))


def test_unknown_refinement_is_refused(color_camera, target):
    with pytest.raises(ValueError, match='exact'):
        MarkerDetector(target, color_camera, 'exact')
