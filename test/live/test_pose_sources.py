# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Live, frames and poses are made into observations as those of a bag are."""

from dataclasses import replace

from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.errors import InputError, PoseError, RecordingError
from diffcal_ros.live.inputs import LiveInputs
from diffcal_ros.recording.topics.frame_tree import FrameTree
from diffcal_ros.rigid_transform import inverse, transform
from diffcal_ros.scene.model import MotionSetup, PoseSetup, Quantity, QUASI_STATIC
from diffcal_ros.stamped_pose import StampedPose
import numpy as np
import pytest
from support.scenes import beam_scene, CAMERA, DEPTH_FROM_WORLD

FRAME, RIG, HAND = 'depth_camera', 'rig_link', 'hand'
START, PERIOD = 1_700_000_000_000_000_000, 33_333_333  # [ns]
HAND_FROM_CAMERA = transform(np.eye(3), np.array([0.1, 0.0, 0.02]))
USUAL = np.diag([1e-3**2] * 3 + [np.deg2rad(0.3) ** 2] * 3)


def frames(count=4, distance=0.4, period=PERIOD):
    """A wall that comes a little nearer with every frame."""
    depth = np.full((CAMERA.height, CAMERA.width), distance, dtype=np.float32)
    return tuple(
        DepthFrame(depth - np.float32(1e-4 * k), START + k * period, FRAME) for k in range(count)
    )


def inputs_with(asked='scene', **pose):
    scene = beam_scene()
    (setup,) = scene.observations
    scene = replace(scene, observations=(replace(setup, pose=PoseSetup(**pose)),))
    inputs = LiveInputs(scene, asked, '')
    inputs.set_camera(CAMERA)
    return inputs


def robot(move=lambda number: np.eye(4)):
    """A camera in a hand that moves before the rig."""
    tree = FrameTree()
    tree.add(HAND, FRAME, HAND_FROM_CAMERA)
    rig_from_hand = inverse(DEPTH_FROM_WORLD) @ inverse(HAND_FROM_CAMERA)
    for number in range(4):
        stamp = START + number * PERIOD
        tree.add(RIG, HAND, rig_from_hand @ move(number), stamp_ns=stamp)
    return tree


def observed(inputs, film=None):
    ((seen,), notes) = inputs.snapshot(film or frames()).take(inputs.scene)
    return seen, ' '.join(notes)


def test_tf_gives_the_pose_at_the_frames():
    inputs = inputs_with('tf', world_frame=RIG)
    waited_for = ["TF from 'rig_link' to 'depth_camera', the frame of the depth images"]
    assert inputs.missing(frames()[-1]) == waited_for
    inputs.lookup = robot().find
    assert inputs.missing(frames()[-1]) == []
    seen, notes = observed(inputs)
    np.testing.assert_allclose(seen.depth_from_world, DEPTH_FROM_WORLD, atol=1e-12)
    np.testing.assert_allclose(seen.pose_covariance, USUAL)
    assert 'the pose from TF is taken to be known to 1 mm and 0.3 degrees' in notes


def test_tf_is_asked_when_frames_are_frozen_and_not_when_they_are_fitted():
    inputs = inputs_with(source='tf', world_frame=RIG)
    inputs.lookup = robot().find
    frozen = inputs.snapshot(frames())
    inputs.lookup = FrameTree().find
    (seen,) = frozen.observe(inputs.scene)
    np.testing.assert_allclose(seen.depth_from_world, DEPTH_FROM_WORLD, atol=1e-12)


def test_a_hand_that_moves_is_refused():
    inputs = inputs_with(source='tf', world_frame=RIG)
    inputs.lookup = robot(lambda k: transform(np.eye(3), np.array([0.004 * k, 0, 0]))).find
    with pytest.raises(PoseError, match=r'changes by 8 mm .*: hold camera and rig still'):
        observed(inputs)


def test_the_scenes_source_holds_where_no_other_is_asked_for():
    for source in ('tf', 'stored', 'topic'):
        pose = {'source': source, 'world_frame': RIG, 'topic': '/hand_eye'}
        asked = {'stored': 'tf'}.get(source, 'scene')
        assert inputs_with(asked, **pose).source == ('tf' if source == 'stored' else source)
    assert inputs_with('scene', source='topic', topic='/hand_eye').pose_topic == '/hand_eye'
    assert inputs_with('tf', world_frame=RIG, topic='/hand_eye').pose_topic == 'marker_pose/pose'
    with pytest.raises(PoseError, match=r"no 'marker': add .* or set pose_source to 'topic'"):
        inputs_with('scene')
    with pytest.raises(PoseError, match="its world is: add 'world_frame' under 'pose'"):
        inputs_with('tf')
    with pytest.raises(PoseError, match="has no 'stored_depth_from_world'"):
        inputs_with('stored')


def test_a_pose_on_a_topic_is_taken_at_the_frames_and_with_its_covariance(random):
    inputs = inputs_with('topic', world_frame=RIG)
    known = np.diag(random.uniform(1e-7, 1e-6, 6))
    world_from_depth = inverse(DEPTH_FROM_WORLD)
    for k in range(4):
        stamp = START + k * PERIOD
        inputs.pose = StampedPose(world_from_depth, known, RIG, stamp)
    # It went on after the frames.
    inputs.pose = StampedPose(np.eye(4), known, RIG, START + 100 * PERIOD)
    assert inputs.missing(frames()[-1]) == []
    seen, notes = observed(inputs)
    np.testing.assert_allclose(seen.depth_from_world, DEPTH_FROM_WORLD, atol=1e-12)
    turn = np.kron(np.eye(2), DEPTH_FROM_WORLD[:3, :3])
    np.testing.assert_allclose(seen.pose_covariance, turn @ known @ turn.T)
    assert notes == ''


def test_a_topic_in_another_frame_needs_a_way_from_there():
    inputs = inputs_with('topic')
    inputs.pose = StampedPose(HAND_FROM_CAMERA @ DEPTH_FROM_WORLD, None, HAND, START)
    (missing,) = inputs.missing(frames()[-1])
    assert missing.startswith(f'depth_from_color: where the frame {HAND!r} is in')
    inputs.lookup = robot().find
    seen, notes = observed(inputs)
    np.testing.assert_allclose(seen.depth_from_world, DEPTH_FROM_WORLD, atol=1e-12)
    assert 'the pose on marker_pose/pose is taken to be known to 1 mm' in notes


def test_poses_go_on_with_other_settings_of_the_same_topic():
    old = inputs_with('topic', world_frame=RIG)
    old.pose = StampedPose(np.eye(4), None, RIG)
    same, other = inputs_with('topic'), inputs_with('topic', topic='/hand_eye')
    for fresh in (same, other):
        fresh.take_over(old)
    assert same.pose is old.pose
    assert other.pose is None


def test_millimetres_that_are_published_as_metres_are_refused():
    inputs = inputs_with('topic')
    inputs.pose = StampedPose(DEPTH_FROM_WORLD, None, FRAME)
    with pytest.raises(RecordingError, match='depth/image_rect_raw holds depths of 400 m in the'):
        observed(inputs, frames(distance=400.0))
    with pytest.raises(InputError, match='nothing has arrived yet on depth/image_rect_raw'):
        inputs.snapshot(())


def test_a_load_that_is_held_may_be_filmed_with_pauses():
    """Seconds between frames end a swing, and are nothing to a body that creeps."""
    inputs = inputs_with('topic')
    inputs.pose = StampedPose(DEPTH_FROM_WORLD, None, FRAME)
    (setup,) = inputs.scene.observations
    film = frames(12, period=3_000_000_000)
    for number, frame in enumerate(film[2:]):
        frame.depth[60:180, 80:240] -= 0.03 + 0.002 * number
    motion = MotionSetup(('clamp',), Quantity(4.0, 3.5, 5.0), QUASI_STATIC)
    creeps, swings = (
        replace(inputs.scene, observations=(replace(setup, motion=own),))
        for own in (motion, replace(motion, integrator='implicit'))
    )
    assert len(inputs.snapshot(film).observe(creeps)) == 12
    with pytest.raises(RecordingError, match='the release is expected at 4 s: it is ne'):
        inputs.snapshot(film).observe(swings)
