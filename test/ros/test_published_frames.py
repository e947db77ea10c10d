# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""TF, over DDS: a recording's own frames, the marker, the scene's world and the body."""

from importlib.util import find_spec
import json
from pathlib import Path
import shutil
import tempfile

from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.rigid_transform import inverse, rotation_matrix, transform
from diffcal_ros.ros.calibration import CalibrationNode
from diffcal_ros.ros.conversion import (
    header_message,
    image_message,
    stamp_ns,
    transform_matrix,
    transform_message,
)
from diffcal_ros.ros.depth_source import DepthSourceNode
from diffcal_ros.ros.frame_sender import FrameSender
from diffcal_ros.ros.marker_pose import MarkerPoseNode
from diffcal_ros.scene.load import load_scene
from geometry_msgs.msg import TransformStamped
import numpy as np
import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger
from support.posed_bags import copy_beam, send_tf, spoil, true_pose
from support.ros_images import depth_image
from support.tf2_messages import provide_tf2_messages, withdraw_tf2_messages
import yaml

DEPTH, COLOR = 'camera_depth_optical_frame', 'camera_color_optical_frame'
BASE_FROM_DEPTH = transform(rotation_matrix(np.array([0.1, -0.7, 0.2])), np.array([0.5, 0.1, 2.0]))
REPLAY, OK = 'depth_source: replay', b'\x00'
LATCHED = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_CACHE = Path(tempfile.gettempdir()) / 'diffcal_ros_test_messages'


@pytest.fixture
def messages():
    """The type of TF's messages."""
    problem = provide_tf2_messages(_CACHE)
    if problem:
        pytest.skip(problem)
    from tf2_msgs.msg import TFMessage

    yield TFMessage
    withdraw_tf2_messages(_CACHE)


@pytest.fixture
def bag(recorded_beam, tmp_path):
    """The filmed beam on a robot: its base is above the depth camera in TF."""

    def extra(writer, stamps):
        base = ('robot_base', DEPTH)
        send_tf(writer, '/tf_static', BASE_FROM_DEPTH, *base, stamps[0])
        broken = ('robot_base', 'broken')
        send_tf(writer, '/tf_static', np.eye(4), *broken, stamps[0], is_turned=False)

    return copy_beam(recorded_beam, tmp_path / 'bag', extra)


@pytest.fixture
def turning_bag(recorded_beam, tmp_path):
    """The filmed beam before a camera that a robot turns; /tf goes on when the film is over."""

    def extra(writer, stamps):
        period = stamps[1] - stamps[0]
        for number in range(-1, 3 * len(stamps)):
            stamp = stamps[0] + number * period
            send_tf(writer, '/tf', turned(number), 'robot_base', 'flange', stamp)
            send_tf(writer, '/tf', np.eye(4), 'robot_base', 'wheel', stamp)
            send_tf(writer, '/tf', np.eye(4), 'base', 'broken', stamp, is_turned=False)
        spoil(writer, ('/tf',), stamps[1])

    return copy_beam(recorded_beam, tmp_path / 'turning', extra)


def turned(number):
    """Return robot_base_from_flange when so many frames have passed, shape (4, 4)."""
    return transform(rotation_matrix(np.array([0.1, 0.02 * number, 0.3])), np.array([0.5, 0.1, 2]))


class Listener:
    """What came on /tf and /tf_static, by child frame."""

    def __init__(self, bench, kind):
        self.still, self.moving = {}, {}
        bench.probe.create_subscription(kind, '/tf', self._into(self.moving), 100)
        bench.probe.create_subscription(kind, '/tf_static', self._into(self.still), LATCHED)

    def _into(self, found):
        def take(message):
            for stamped in message.transforms:
                matrix = transform_matrix(stamped.transform)
                found[stamped.child_frame_id] = (stamped.header.frame_id, matrix)

        return take


def said_by_another(bench, kind, topic, parent, child, qos=LATCHED):
    """Let the probe tell of a frame; return the publisher."""
    stamped = TransformStamped(header=header_message(1, parent), child_frame_id=child)
    stamped.transform = transform_message(np.eye(4))
    sender = bench.probe.create_publisher(kind, topic, qos)
    sender.publish(kind(transforms=[stamped]))
    return sender


def test_a_recordings_still_frames_are_passed_on(make_bench, bag, recorded_beam, messages):
    bench = make_bench({'bag': bag, 'wait_for_subscriber': 0.0, 'rate': 100.0})
    heard = Listener(bench, messages)
    bench.add(DepthSourceNode)
    bench.until(lambda: len(heard.still) == 2, 'both frames')
    parent, matrix = heard.still[DEPTH]
    assert parent == 'robot_base'
    np.testing.assert_allclose(matrix, BASE_FROM_DEPTH, atol=1e-12)
    truth = json.loads(recorded_beam.truth.read_text())
    assert heard.still[COLOR][0] == DEPTH
    np.testing.assert_allclose(heard.still[COLOR][1], truth['depth_from_color'], atol=1e-12)
    # Who comes late hears of them, too.
    late = Listener(bench, messages)
    bench.until(lambda: len(late.still) == 2, 'the latched message')


@pytest.mark.slow
def test_a_recordings_moving_frames_go_with_its_images(make_bench, turning_bag, messages):
    """Loops go on, the frames of others are left to them, and what is unusable is left out."""
    bench = make_bench({'bag': turning_bag, 'wait_for_subscriber': 5.0, 'loop': True})
    came = bench.collect(messages, '/tf', 100)
    images = bench.collect(Image, 'depth/image_rect_raw')
    said_by_another(bench, messages, '/tf_static', 'robot', 'wheel')
    bench.add(DepthSourceNode)
    recording = open_recording(turning_bag)
    count = recording.depth_count
    bench.until(lambda: len(images) > 2 * count, 'a third round')
    found = [one for message in came for one in message.transforms]
    assert {one.child_frame_id for one in found} == {'flange'}
    stamps = [stamp_ns(one.header.stamp) for one in found]
    assert (np.diff(stamps) > 0).all()
    first = [stamp_ns(image.header.stamp) for image in images[:count]]
    period = first[1] - first[0]
    # One before the first image, one with each, and none of those after the film.
    rounds = [first[0] + number * period for number in range(-1, 2 * count)]
    np.testing.assert_allclose(stamps[: len(rounds)], rounds, rtol=0.0, atol=1000.0)
    for number in (-1, 0, count - 1):
        matrix = transform_matrix(found[number + 1].transform)
        np.testing.assert_allclose(matrix, turned(number), atol=1e-12)
    np.testing.assert_allclose(transform_matrix(found[count + 1].transform), turned(0), atol=1e-12)
    bench.status(REPLAY, b'\x01', 'the message is no tf2_msgs/msg/TFMessage')
    bench.until(lambda: int(bench.value(REPLAY, '/tf sent') or 0) >= len(rounds), 'the count')


def test_a_pose_from_tf_works_in_a_replay(make_bench, recorded_beam, tmp_path, messages):
    """The recording alone says where the camera is: on a /tf that goes on all the while."""
    truth = true_pose(recorded_beam)

    def extra(writer, stamps):
        for stamp in stamps:
            send_tf(writer, '/tf', turned(3), 'base', 'rig', stamp)
            send_tf(writer, '/tf', turned(3) @ inverse(truth), 'base', DEPTH, stamp)

    folder = tmp_path / 'scene'
    folder.mkdir()
    document = yaml.safe_load(recorded_beam.scene.read_text())
    document.update(pose={'source': 'tf', 'world_frame': 'rig'})
    document.pop('bag', None)
    shutil.copy(recorded_beam.scene.parent / 'beam.tet', folder)
    (folder / 'scene.yaml').write_text(yaml.safe_dump(document))
    bench = make_bench(
        {
            'scene': folder / 'scene.yaml',
            'bag': copy_beam(recorded_beam, tmp_path / 'bag', extra),
            'wait_for_subscriber': 60.0,
            'rate': 0.5,
            # More frames than come, so that nothing is fitted.
            'window.seconds': 3600.0,
        }
    )
    node = bench.add(CalibrationNode)
    bench.add(DepthSourceNode)
    bench.status(REPLAY, OK, 'was replayed to its end')
    bench.status('calibration: fit', OK, 'collecting frames')
    session = node._session
    (seen,) = session.inputs.snapshot(session.window.frames).observe(session.scene)
    np.testing.assert_allclose(seen.depth_from_world, truth, atol=1e-9)


def test_what_another_node_says_is_left_to_it(make_bench, bag, messages):
    bench = make_bench({'bag': bag, 'wait_for_subscriber': 0.0, 'rate': 100.0})
    said_by_another(bench, messages, '/tf_static', 'arm', DEPTH)
    heard = Listener(bench, messages)
    bench.add(DepthSourceNode)
    bench.until(lambda: COLOR in heard.still, 'the frame that is free')
    assert heard.still[DEPTH][0] == 'arm'
    bench.status(REPLAY, OK, 'was replayed to its end')
    assert heard.still[DEPTH][0] == 'arm'


def test_it_can_be_left_out(make_bench, bag, messages):
    bench = make_bench({'bag': bag, 'wait_for_subscriber': 0.0, 'publish_tf': False})
    heard = Listener(bench, messages)
    bench.add(DepthSourceNode)
    bench.status(REPLAY, OK, 'was replayed to its end')
    assert heard.still == {}


def test_a_transform_that_is_given_live_is_sent(make_bench, messages):
    bench = make_bench({'depth_from_color': '[0.01, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]'})
    heard = Listener(bench, messages)
    bench.add(DepthSourceNode)
    bench.publisher(Image, 'in/depth/image_rect_raw').publish(depth_image())
    pixels = np.zeros((4, 5, 3), np.uint8)
    picture = image_message(pixels, encoding='bgr8', time_ns=7, frame_id=COLOR)
    bench.publisher(Image, 'in/color/image_raw').publish(picture)
    bench.until(lambda: COLOR in heard.still, 'the colour camera')
    assert heard.still[COLOR][0] == DEPTH
    np.testing.assert_allclose(heard.still[COLOR][1][:3, 3], [0.01, 0.0, 0.0])


def test_marker_world_and_body_are_where_the_fit_has_them(make_bench, recorded_beam, messages):
    (path,) = recorded_beam.bags.values()
    bench = make_bench(
        {
            'scene': recorded_beam.scene,
            'bag': path,
            'loop': True,
            'wait_for_subscriber': 60.0,
            'subscribers': 2,
            'mesh_error': False,
            'window.frames': 4,
            'refit': 'once',
            'fit': 'youngs_modulus',
            'body_frame': 'beam',
        }
    )
    heard = Listener(bench, messages)
    for node in (CalibrationNode, MarkerPoseNode, DepthSourceNode):
        bench.add(node)
    bench.until(lambda: {'scene_world', 'beam', 'marker'} <= set(heard.moving), 'frames', 300.0)
    scene, truth = load_scene(recorded_beam.scene), json.loads(recorded_beam.truth.read_text())
    (made,) = truth['observations'].values()
    depth_from_world = np.array(made['depth_from_world'])
    near = {'rtol': 0.0, 'atol': 2e-3}  # The marker's pose is measured.
    assert heard.moving['scene_world'][0] == heard.moving['beam'][0] == DEPTH
    np.testing.assert_allclose(heard.moving['scene_world'][1], depth_from_world, **near)
    placed = depth_from_world @ scene.observations[0].world_from_object
    np.testing.assert_allclose(heard.moving['beam'][1], placed, **near)
    color_from_world = inverse(np.array(truth['depth_from_color'])) @ depth_from_world
    assert heard.moving['marker'][0] == COLOR
    seen = color_from_world @ scene.marker.world_from_marker
    # A turn of the print is known less well than its place.
    np.testing.assert_allclose(heard.moving['marker'][1], seen, rtol=0.0, atol=1e-2)
    assert bench.call(Trigger, 'calibration/reset').success


def test_a_world_that_the_camera_hangs_in_is_not_hung_on_the_camera(make_bench, messages):
    bench = make_bench()
    heard = Listener(bench, messages)
    said_by_another(bench, messages, '/tf', 'rig', 'flange', 100)
    sender = FrameSender(bench.probe)
    kept = [
        said_by_another(bench, messages, '/tf_static', parent, child)
        for parent, child in (('rig', 'flange'), ('flange', DEPTH))
    ]
    bench.until(lambda: len(heard.still) == 2, 'what the robot says')

    def send():
        for child in ('rig', 'body', '', DEPTH):
            sender.send(5, DEPTH, child, np.eye(4))
        return 'body' in heard.moving

    bench.until(send, 'the body')
    assert set(heard.moving) <= {'body', 'flange'}
    assert len(kept) == 2
    sender.destroy()


@pytest.mark.skipif(find_spec('tf2_msgs') is not None, reason='tf2_msgs is installed')
def test_without_its_messages_a_replay_goes_on(make_bench, bag):
    bench = make_bench({'bag': bag, 'wait_for_subscriber': 0.0})
    bench.add(DepthSourceNode)
    bench.status(REPLAY, OK, 'was replayed to its end')
