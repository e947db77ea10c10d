# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The camera's pose from the fixture in a bag's depth images, with no marker in it."""

from dataclasses import replace

from diffcal_ros.errors import PoseError
from diffcal_ros.live.inputs import LiveInputs
from diffcal_ros.offline.calibrate_recordings import open_inputs
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.rigid_transform import apply
import numpy as np
import pytest
from support.held_beam import film_in_bracket


@pytest.fixture
def held(recorded_beam, tmp_path):
    return film_in_bracket(recorded_beam, tmp_path / 'bag')


@pytest.mark.slow
def test_a_bag_without_a_marker_is_posed_by_its_fixture(held):
    inputs = open_inputs(held.scene, [held.bag])
    (seen,) = inputs.observations
    body = held.scene.observations[0].world_from_object
    points = apply(body, held.scene.mesh.rest_positions)
    apart = apply(seen.depth_from_world, points) - apply(held.truth, points)
    assert np.linalg.norm(apart, axis=1).max() < 2e-3
    assert seen.pose_covariance.shape == (6, 6)
    assert np.linalg.eigvalsh(seen.pose_covariance).min() > 0.0
    middle = apply(held.truth @ body, held.scene.fixture.positions).mean(axis=0)
    np.testing.assert_allclose(seen.pose_pivot, middle, atol=0.02)
    assert 'pose of the fixture from' in ' '.join(inputs.notes)


def test_a_scene_without_a_fixture_says_so(held):
    bare = replace(held.scene, fixture=None)
    with pytest.raises(PoseError, match="the scene has no 'fixture'"):
        open_inputs(bare, [held.bag])
    with pytest.raises(PoseError, match="the scene has no 'fixture'"):
        LiveInputs(bare, 'scene', '')


def test_live_a_fixture_needs_depth_alone(held):
    inputs = LiveInputs(held.scene, 'fixture', '')
    frame = next(iter(open_recording(held.bag).depth_frames(limit=1)))
    assert inputs.missing(frame) == ['depth/camera_info']
