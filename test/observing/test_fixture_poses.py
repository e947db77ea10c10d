# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The camera's pose from the fixture in a bag's depth images, with no marker in it."""

from dataclasses import replace

from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.errors import PoseError
from diffcal_ros.live.inputs import LiveInputs
from diffcal_ros.offline.calibrate_recordings import open_inputs
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.recording.bag_writer import BagWriter
from diffcal_ros.recording.topics.names import DEPTH_FRAME
from diffcal_ros.rigid_transform import apply
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.model import Fixture
import numpy as np
import pytest
from support.posed_bags import posed, true_pose

from benchmarks import rigid_parts


def bracket(scene) -> Fixture:
    """Return an L that holds the beam's end, from where its clamp begins."""
    part = rigid_parts.bracket(np.array([0.024, 0.022]), 0.035)
    # It runs to -x from its front, and the beam is held towards +x.
    positions = part.positions * [-1.0, 1.0, 1.0]
    beam = scene.mesh.rest_positions
    middle = 0.5 * (beam.min(axis=0) + beam.max(axis=0))
    return Fixture(positions + np.array([0.1, *middle[1:]]), part.triangles[:, ::-1])


@pytest.fixture
def filmed(recorded_beam, tmp_path):
    """Bag of depth alone with the bracket in it, its scene, and the camera's true pose."""
    scene = load_scene(recorded_beam.scene)
    scene = replace(posed(scene, source='fixture'), fixture=bracket(scene), marker=None)
    (setup,) = scene.observations
    truth = true_pose(recorded_beam)
    source = open_recording(recorded_beam.bags['observation'])
    camera = source.depth_camera
    part = scene.fixture
    tracer = DepthTracer(part.triangles, len(part.positions), camera)
    placed = truth @ setup.world_from_object
    shown = tracer.trace(apply(placed, part.positions)).full_depth()
    path = tmp_path / 'bag'
    random = np.random.default_rng(3)
    with BagWriter(path) as bag:
        for frame in source.depth_frames():
            noisy = shown + random.normal(0.0, 1.5e-4, shown.shape)
            depth = np.fmin(frame.depth, noisy).astype(np.float32)
            bag.write_depth_camera(camera, stamp_ns=frame.stamp_ns, frame_id=DEPTH_FRAME)
            bag.write_depth(replace(frame, depth=depth))
    return path, scene, truth


@pytest.mark.slow
def test_a_bag_without_a_marker_is_posed_by_its_fixture(filmed):
    path, scene, truth = filmed
    inputs = open_inputs(scene, [path])
    (seen,) = inputs.observations
    body = scene.observations[0].world_from_object
    points = apply(body, scene.mesh.rest_positions)
    apart = apply(seen.depth_from_world, points) - apply(truth, points)
    assert np.linalg.norm(apart, axis=1).max() < 2e-3
    assert seen.pose_covariance.shape == (6, 6)
    assert np.linalg.eigvalsh(seen.pose_covariance).min() > 0.0
    middle = apply(truth @ body, scene.fixture.positions).mean(axis=0)
    np.testing.assert_allclose(seen.pose_pivot, middle, atol=0.02)
    assert 'pose of the fixture from' in ' '.join(inputs.notes)


def test_a_scene_without_a_fixture_says_so(filmed):
    path, scene, _ = filmed
    bare = replace(scene, fixture=None)
    with pytest.raises(PoseError, match="the scene has no 'fixture'"):
        open_inputs(bare, [path])
    with pytest.raises(PoseError, match="the scene has no 'fixture'"):
        LiveInputs(bare, 'scene', '')


def test_live_a_fixture_needs_depth_alone(filmed):
    path, scene, _ = filmed
    inputs = LiveInputs(scene, 'fixture', '')
    frame = next(iter(open_recording(path).depth_frames(limit=1)))
    assert inputs.missing(frame) == ['depth/camera_info']
