# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The camera's pose from a bag: a chain of TF, or a topic, and how well it is known."""

from diffcal_ros.errors import PoseError, RecordingError
from diffcal_ros.offline.calibrate_recordings import open_inputs
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.recording.topics.names import COLOR_FRAME, DEPTH_FRAME
from diffcal_ros.rigid_transform import angle_between, inverse, rotation_matrix, transform
from diffcal_ros.scene.load import load_scene
import numpy as np
import pytest
from support.posed_bags import copy_beam, pose_message, posed, send_tf, spoil, true_pose

_SECOND = 1_000_000_000  # [ns]
# Where the camera sits on the robot's hand, and the rig on the robot's base.
HAND_FROM_CAMERA = transform(rotation_matrix(np.array([0.3, -0.2, 1.1])), np.array([0.1, 0, 0.05]))
BASE_FROM_RIG = transform(rotation_matrix(np.array([-0.1, 0.4, 0.2])), np.array([0.5, 0.2, 0.3]))
RIG, BASE, HAND = 'rig_link', 'base_link', 'hand'
USUAL = np.diag([1e-3**2] * 3 + [np.deg2rad(0.3) ** 2] * 3)


@pytest.fixture
def truth(recorded_beam):
    return true_pose(recorded_beam)


@pytest.fixture
def opened(recorded_beam, tmp_path):
    """Open the beam's scene on a bag with more in it: `opened(extra, source, **pose)`."""

    def open_with(extra, source, **pose):
        bag = copy_beam(recorded_beam, tmp_path / 'posed', extra)
        scene = posed(load_scene(recorded_beam.scene), **{'source': source, **pose})
        inputs = open_inputs(scene, [bag])
        return inputs.observations[0], ' '.join(inputs.notes)

    return open_with


def robot(truth, move=lambda share: np.eye(4), *, late=0.0, hand_is_turned=True):
    """Write a robot that holds the camera: /tf for its hand, /tf_static for the rest."""

    def write(bag, stamps):
        send_tf(bag, '/tf_static', BASE_FROM_RIG, BASE, RIG, stamps[0])
        send_tf(
            bag,
            '/tf_static',
            HAND_FROM_CAMERA,
            HAND,
            DEPTH_FRAME,
            stamps[0],
            is_turned=hand_is_turned,
        )
        base_from_hand = BASE_FROM_RIG @ inverse(truth) @ inverse(HAND_FROM_CAMERA)
        first, span = stamps[0], stamps[-1] - stamps[0]
        # Never at a frame's own stamp.
        for share in np.linspace(-0.3, 1.3, 8) + late:
            stamp = first + round(share * span)
            send_tf(bag, '/tf', base_from_hand @ move(share), BASE, HAND, stamp)

    return write


def test_a_chain_through_moving_and_fixed_transforms_leads_to_the_camera(opened, truth):
    seen, notes = opened(robot(truth), 'tf', world_frame=RIG)
    np.testing.assert_allclose(seen.depth_from_world, truth, atol=1e-9)
    np.testing.assert_allclose(seen.pose_covariance, USUAL)
    np.testing.assert_array_equal(seen.pose_pivot, np.zeros(3))
    assert 'the pose from TF is taken to be known to 1 mm and 0.3 degrees: state' in notes


def test_bad_transforms_beside_the_chain_do_not_matter(opened, truth):
    def write(bag, stamps):
        robot(truth)(bag, stamps)
        for topic in ('/tf', '/tf_static'):
            send_tf(bag, topic, np.eye(4), BASE, 'gripper', stamps[0], is_turned=False)
            send_tf(bag, topic, np.eye(4), 'moon', 'mars', stamps[0])
            nowhere = np.eye(4)
            nowhere[0, 3] = np.nan
            send_tf(bag, topic, nowhere, HAND, 'tool', stamps[0])
        # One that is needed is sent once more, spoilt.
        send_tf(bag, '/tf_static', np.eye(4), BASE, RIG, stamps[1], is_turned=False)

    seen, _ = opened(write, 'tf', world_frame=f'/{RIG}')
    np.testing.assert_allclose(seen.depth_from_world, truth, atol=1e-9)


def test_garbled_transforms_are_left_out_and_counted(opened, truth):
    def write(bag, stamps):
        robot(truth)(bag, stamps)
        spoil(bag, ('/tf', '/tf_static', '/depth_from_color', '/tf'), stamps[0])

    seen, notes = opened(write, 'tf', world_frame=RIG)
    np.testing.assert_allclose(seen.depth_from_world, truth, atol=1e-9)
    assert '2 messages left out: /tf: the message is no tf2_msgs/msg/TFMessage' in notes
    assert '1 messages left out: /tf_static: the message is no tf2_msgs' in notes


def test_garbled_poses_are_left_out_and_counted(opened, truth):
    def write(bag, stamps):
        poses(inverse(truth), RIG)(bag, stamps)
        spoil(bag, ('/camera_pose',), stamps[0])

    seen, notes = opened(write, 'topic', world_frame=RIG)
    np.testing.assert_allclose(seen.depth_from_world, truth, atol=1e-9)
    assert '1 messages left out: /camera_pose: the message is no' in notes


@pytest.mark.parametrize(
    ('pose', 'arrange', 'error', 'words'),
    [
        ({}, {}, PoseError, "which frame of TF its world is: add 'world_frame' under 'pose'"),
        (
            {'world_frame': 'table'},
            {},
            PoseError,
            f"TF does not lead from 'table', the scene's world_frame, to '{DEPTH_FRAME}'",
        ),
        (
            {'world_frame': RIG},
            {'hand_is_turned': False},
            RecordingError,
            f'transform from {DEPTH_FRAME} to {HAND} is unusable, quaternion is .* record it ag',
        ),
        (
            {'world_frame': RIG},
            {'late': -20.0},
            RecordingError,
            r'from hand to base_link is needed \d.\d\d s after it is last known \(0.2 s are tol',
        ),
        (
            {'world_frame': RIG},
            {
                'move': lambda share: transform(
                    rotation_matrix(np.array([0.02 * share, 0, 0])), np.array([0, 0.01 * share, 0])
                )
            },
            PoseError,
            'changes by .* mm and .* degrees, and is known to 1 mm and 0.3 degrees: hold camera',
        ),
    ],
    ids=('no world', 'no way', 'unusable', 'too old', 'moving'),
)
def test_a_chain_that_cannot_be_used_is_refused(opened, truth, pose, arrange, error, words):
    with pytest.raises(error, match=words):
        opened(robot(truth, **arrange), 'tf', **pose)


def test_a_little_movement_is_told_and_one_within_what_is_stated_is_not(opened, truth):
    def drift(share):
        return transform(np.eye(3), np.array([0.003 * share, 0, 0]))

    _, notes = opened(robot(truth, drift), 'tf', world_frame=RIG)
    assert 'the pose of the camera changes by 2 mm' in notes
    assert 'the one in the middle is taken' in notes


def test_what_the_scene_states_is_what_counts(opened, truth):
    def drift(share):
        return transform(np.eye(3), np.array([0.003 * share, 0, 0]))

    seen, notes = opened(
        robot(truth, drift), 'tf', world_frame=RIG, position_std=0.005, rotation_std=0.01
    )
    assert np.diag(seen.pose_covariance)[[0, 5]] == pytest.approx([0.005**2, 0.01**2])
    assert 'changes' not in notes
    assert 'is taken to be known' not in notes


def poses(matrix, frame, topic='/camera_pose', covariance=None, offsets=(0,)):
    def write(bag, stamps):
        for stamp in stamps:
            for offset in offsets:
                found = pose_message(matrix, frame, stamp + offset, covariance)
                bag.write(topic, found, stamp + offset)

    return write


def some_covariance(random):
    root = random.normal(size=(6, 6)) * np.repeat([1e-3, 4e-3], 3)[:, None]
    return root @ root.T


def test_a_pose_in_the_world_frame_is_the_cameras_own(opened, truth):
    seen, notes = opened(poses(inverse(truth), RIG), 'topic', world_frame=RIG)
    np.testing.assert_allclose(seen.depth_from_world, truth, atol=1e-9)
    np.testing.assert_allclose(seen.pose_covariance, USUAL)
    assert 'the pose on /camera_pose is taken to be known to 1 mm and 0.3 degrees' in notes


@pytest.mark.parametrize('frame', [DEPTH_FRAME, COLOR_FRAME])
def test_a_pose_in_a_cameras_frame_is_the_worlds(opened, recorded_beam, truth, frame, random):
    depth_from_color = open_recording(recorded_beam.bags['observation']).depth_from_color
    depth_from_frame = np.eye(4) if frame == DEPTH_FRAME else depth_from_color
    covariance = some_covariance(random)
    seen, notes = opened(
        poses(inverse(depth_from_frame) @ truth, frame, covariance=covariance), 'topic'
    )
    np.testing.assert_allclose(seen.depth_from_world, truth, atol=1e-9)
    np.testing.assert_allclose(seen.pose_pivot, truth[:3, 3], atol=1e-9)
    turn = np.kron(np.eye(2), depth_from_frame[:3, :3])
    np.testing.assert_allclose(seen.pose_covariance, turn @ covariance @ turn.T, atol=1e-15)
    assert 'known' not in notes


def test_the_covariance_of_the_cameras_pose_is_turned_into_its_own_frame(opened, truth, random):
    covariance = some_covariance(random)
    seen, _ = opened(poses(inverse(truth), RIG, covariance=covariance), 'topic', world_frame=RIG)
    turn = np.kron(np.eye(2), truth[:3, :3])
    np.testing.assert_allclose(seen.pose_covariance, turn @ covariance @ turn.T, atol=1e-15)


def test_a_pose_that_was_sent_once_holds_for_all_frames(opened, truth):
    def write(bag, stamps):
        bag.write('/camera_pose', pose_message(inverse(truth), RIG, 0), stamps[0])

    seen, notes = opened(write, 'topic', world_frame=RIG)
    np.testing.assert_allclose(seen.depth_from_world, truth, atol=1e-9)
    assert 'away from' not in notes


def test_poses_of_another_time_are_told(opened, truth):
    late = poses(inverse(truth), RIG, offsets=(5 * _SECOND,))
    _, notes = opened(late, 'topic', world_frame=RIG)
    assert 'poses on /camera_pose are up to 5.0 s away from the depth images' in notes


def test_zero_covariance_means_that_nobody_knows(opened, truth):
    write = poses(inverse(truth), RIG, covariance=np.zeros((6, 6)))
    seen, _ = opened(write, 'topic', world_frame=RIG)
    np.testing.assert_allclose(seen.pose_covariance, USUAL)


def test_bad_poses_are_left_out(opened, truth):
    def write(bag, stamps):
        broken = pose_message(inverse(truth), RIG, stamps[0])
        broken.pose.orientation.x = float('nan')
        bag.write('/camera_pose', broken, stamps[0])
        poses(inverse(truth), RIG)(bag, stamps)

    seen, _ = opened(write, 'topic', world_frame=RIG)
    np.testing.assert_allclose(seen.depth_from_world, truth, atol=1e-9)


def both(truth):
    def write(bag, stamps):
        poses(inverse(truth), RIG)(bag, stamps)
        poses(inverse(truth), RIG, '/other_pose')(bag, stamps)

    return write


def flat(truth):
    return poses(inverse(truth), RIG, covariance=np.ones((6, 6)))


@pytest.mark.parametrize(
    ('write', 'pose', 'words'),
    [
        (both, {}, "the recording has /camera_pose, /other_pose: give 'topic' under 'pose'"),
        (lambda _: lambda *__: None, {}, "recording has none: give 'topic' under 'pose'"),
        (both, {'topic': 'hand_pose'}, 'topic /hand_pose is not in the recording: poses come as'),
        (both, {'topic': '/tf_static'}, 'topic /tf_static carries tf2_msgs/msg/TFMessage: poses'),
        (
            lambda truth: poses(inverse(truth), 'table'),
            {'world_frame': RIG},
            r"/camera_pose is in the frame 'table': a pose of the camera must .*\('rig_link'; un",
        ),
        (
            lambda truth: poses(inverse(truth), ''),
            {},
            r"in the frame '': .* world_frame \(which the scene does not name; under 'pose'\)",
        ),
        (flat, {}, 'no usable pose .the covariance is not positive definite: .* record it again'),
        (
            lambda truth: poses(np.diag([np.nan, 1, 1, 1.0]), RIG),
            {},
            '/camera_pose holds no usable pose .*: record it again',
        ),
    ],
    ids=('two', 'none', 'missing', 'type', 'frame', 'no frame', 'flat', 'nan'),
)
def test_poses_that_cannot_be_used_are_refused(opened, truth, write, pose, words):
    with pytest.raises(PoseError, match=words):
        opened(write(truth), 'topic', **pose)


def test_what_is_asked_for_goes_before_what_the_scene_says(recorded_beam, tmp_path, truth):
    bag = copy_beam(recorded_beam, tmp_path / 'posed', robot(truth))
    scene = posed(load_scene(recorded_beam.scene), source='topic', world_frame=RIG)
    (seen,) = open_inputs(scene, [bag], pose_source='tf').observations
    assert angle_between(seen.depth_from_world, truth) < 1e-9
    with pytest.raises(PoseError, match='the recording has none'):
        open_inputs(scene, [bag])
    with pytest.raises(PoseError, match='has no colour images'):
        open_inputs(scene, [bag], pose_source='estimated')
