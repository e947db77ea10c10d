# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The calibration node on its own: services, lifecycle, and inputs that are wrong."""

from dataclasses import replace
from itertools import count

from diffcal_ros.ros.calibration import CalibrationNode
from diffcal_ros.ros.qos import LATCHED
from geometry_msgs.msg import PoseWithCovarianceStamped
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
import numpy as np
import pytest
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Float64
from std_srvs.srv import SetBool, Trigger
from support.ros_images import (
    CAMERA,
    camera_info,
    depth_image,
    FRAME,
    millimetre_image,
    world_pose,
)

FIT, INPUT = 'calibration: fit', 'calibration: input'
OK, WARN, ERROR = b'\x00', b'\x01', b'\x02'
CAMERA_FROM_WORLD = np.diag([1.0, -1.0, -1.0, 1.0])
CAMERA_FROM_WORLD[2, 3] = 0.4


class Rig:
    """A node with a scene, and a camera that films for it."""

    def __init__(self, make_bench, write_scene, **parameters):
        given = {
            'scene': write_scene({'fit': ['youngs_modulus']}),
            'pose_source': 'topic',
            'mesh_error': False,
            'window.frames': 3,
            'window.seconds': 3600.0,
            **parameters,
        }
        self.bench = make_bench(given)
        self.bench.add(CalibrationNode)
        self.depth = self.bench.publisher(Image, 'depth/image_rect_raw')
        self.info = self.bench.publisher(CameraInfo, 'depth/camera_info')
        self.pose = self.bench.publisher(PoseWithCovarianceStamped, 'marker_pose/pose')

    def window(self, count: int) -> None:
        """Wait until so many frames are in the window."""
        self.bench.until(
            lambda: self.bench.value(INPUT, 'frames in the window') == str(count),
            f'a window of {count}',
        )

    def change_state(self, transition: int) -> bool:
        request = ChangeState.Request(transition=Transition(id=transition))
        return self.bench.call(ChangeState, 'calibration/change_state', request).success


@pytest.fixture
def make_rig(make_bench, write_scene):
    return lambda **parameters: Rig(make_bench, write_scene, **parameters)


def test_without_a_scene_every_service_answers_with_the_reason(make_bench):
    bench = make_bench()
    bench.add(CalibrationNode)
    bench.status(FIT, ERROR, 'there is no scene')
    for name in ('reset', 'capture', 'save'):
        answer = bench.call(Trigger, f'calibration/{name}')
        assert not answer.success
        assert "there is no scene: set the parameter 'scene'" in answer.message
    answer = bench.call(SetBool, 'calibration/enable', SetBool.Request(data=True))
    assert not answer.success


def test_services_answer_with_what_was_done_or_why_not(make_rig):
    bench = make_rig().bench
    answer = bench.call(Trigger, 'calibration/capture')
    assert not answer.success
    assert 'nothing has arrived yet on depth/image_rect_raw' in answer.message
    answer = bench.call(Trigger, 'calibration/save')
    assert not answer.success
    assert 'nothing to save' in answer.message
    for data, words in ((False, 'paused'), (False, 'is paused already'), (True, 'collecting')):
        answer = bench.call(SetBool, 'calibration/enable', SetBool.Request(data=data))
        assert answer.success
        assert words in answer.message
    assert bench.call(Trigger, 'calibration/reset').success


def test_bad_depth_images_are_told_and_a_good_one_heals(make_rig):
    rig = make_rig()
    for bad, words in (
        (depth_image(encoding='rgb8'), "encoding is 'rgb8'"),
        (depth_image(step=1), 'bytes a row'),
        (depth_image(height=4 * CAMERA.height), 'cut off'),
    ):
        rig.depth.publish(bad)
        rig.bench.status(FIT, ERROR, words)
    rig.depth.publish(depth_image())
    rig.bench.status(FIT, WARN, 'waiting for depth/camera_info, marker_pose/pose')


def test_both_byte_orders_of_millimetres_are_read(make_rig):
    rig = make_rig()
    rig.depth.publish(millimetre_image(0, is_bigendian=True))
    rig.depth.publish(millimetre_image(1, is_bigendian=False))
    rig.window(2)
    assert rig.bench.value(INPUT, 'valid pixels [share]') == '0.500'
    assert rig.bench.health[INPUT].level == OK


def test_bad_camera_infos_are_told(make_rig):
    rig = make_rig()
    info = camera_info()
    info.k[0] = 0.0
    info.p[0] = 0.0
    rig.info.publish(info)
    rig.bench.status(FIT, ERROR, 'depth/camera_info')
    assert 'foc' in rig.bench.health[FIT].message or 'fx' in rig.bench.health[FIT].message
    rig.info.publish(camera_info(replace(CAMERA, width=640, height=480)))
    rig.pose.publish(world_pose(CAMERA_FROM_WORLD))
    for number in range(3):
        rig.depth.publish(depth_image(number))
    rig.bench.status(FIT, ERROR, 'is for 640x480 pixels, but the depth images are 64x48')


def test_bad_poses_are_told(make_rig):
    rig = make_rig()
    exact = world_pose(CAMERA_FROM_WORLD)
    for axis, value in (('x', float('nan')), ('z', float('inf'))):
        bad = world_pose(CAMERA_FROM_WORLD)
        setattr(bad.pose.pose.position, axis, value)
        rig.pose.publish(bad)
        rig.bench.status(FIT, ERROR, 'marker_pose/pose')
        rig.pose.publish(exact)
        rig.bench.status(FIT, WARN, 'waiting for')
    unsure = world_pose(CAMERA_FROM_WORLD)
    unsure.pose.covariance[0] = float('nan')
    rig.pose.publish(unsure)
    rig.bench.status(FIT, ERROR, 'the covariance holds NaN or Inf')


def test_depth_without_a_single_valid_pixel_is_an_error(make_rig):
    rig = make_rig()
    rig.info.publish(camera_info())
    rig.pose.publish(world_pose(CAMERA_FROM_WORLD))
    for number in range(3):
        rig.depth.publish(depth_image(number, depth=float('nan')))
    status = rig.bench.status(FIT, ERROR, '')
    assert 'please report' not in status.message
    assert 'depth' in status.message
    # The node lives, and says what it wants.
    assert rig.bench.call(Trigger, 'calibration/reset').success


@pytest.mark.slow
def test_a_fit_that_fails_is_logged_once_and_its_values_stay_on_their_topics(make_rig, capfd):
    rig = make_rig()
    rig.info.publish(camera_info())
    rig.pose.publish(world_pose(CAMERA_FROM_WORLD))
    # A wall far behind where the body should be, again and again.
    numbers = count()
    for _ in range(2):
        before = rig.bench.value(FIT, 'fits')
        rig.bench.film(
            lambda: rig.depth.publish(depth_image(next(numbers), depth=3.0)),
            lambda before=before: rig.bench.value(FIT, 'fits') not in ('', before),
            'the end of a fit',
        )
    rig.bench.status(FIT, ERROR, 'the last fit')
    assert capfd.readouterr().err.count('the last fit') == 1
    values = rig.bench.collect(Float64, 'calibration/parameters/youngs_modulus/value', LATCHED)
    rig.bench.until(lambda: values, 'the last value')
    assert len(values) == 1


def test_millimetres_under_the_label_of_metres_are_an_error_that_stays(make_rig):
    rig = make_rig()
    rig.info.publish(camera_info())
    rig.pose.publish(world_pose(CAMERA_FROM_WORLD))
    numbers = count()

    def is_told() -> bool:
        status = rig.bench.health.get(FIT)
        return status is not None and '32FC1 is in metres' in status.message

    rig.bench.film(
        lambda: rig.depth.publish(depth_image(next(numbers), depth=400.0)), is_told, 'the reason'
    )
    assert rig.bench.health[FIT].level == ERROR
    assert rig.bench.value(FIT, 'fits') == '0'


def test_stamps_that_jump_back_start_the_window_anew(make_rig):
    rig = make_rig(**{'window.frames': 10})
    for number in (100, 101, 102):
        rig.depth.publish(depth_image(number))
    rig.window(3)
    rig.depth.publish(depth_image(0))
    rig.window(1)
    rig.depth.publish(depth_image(1))
    rig.window(2)


def test_deactivated_it_takes_nothing_and_activated_it_goes_on(make_rig):
    rig = make_rig(**{'window.frames': 10})
    rig.depth.publish(depth_image(0))
    rig.window(1)
    assert rig.change_state(Transition.TRANSITION_DEACTIVATE)
    rig.bench.status(FIT, WARN, 'inactive, nothing is listened to: call ros2 lifecycle set')
    for kind, name in ((SetBool, 'enable'), (Trigger, 'capture')):
        request = kind.Request(data=True) if kind is SetBool else None
        answer = rig.bench.call(kind, f'calibration/{name}', request)
        assert not answer.success
        assert 'ros2 lifecycle set /calibration activate' in answer.message
    # Discovery tells the sender a moment after the node let go.
    rig.bench.until(lambda: rig.depth.get_subscription_count() == 0, 'the end of the subscription')
    assert rig.change_state(Transition.TRANSITION_ACTIVATE)
    rig.bench.until(rig.depth.get_subscription_count, 'the subscription')
    rig.depth.publish(depth_image(1))
    rig.depth.publish(depth_image(2))
    rig.window(2)


def test_unconfigured_it_waits_and_a_missing_scene_fails_the_transition(make_bench):
    bench = make_bench({'autostart': False})
    bench.add(CalibrationNode)
    bench.status(FIT, WARN, 'unconfigured')
    request = ChangeState.Request(transition=Transition(id=Transition.TRANSITION_CONFIGURE))
    assert not bench.call(ChangeState, 'calibration/change_state', request).success
    bench.status(FIT, ERROR, 'there is no scene')


def test_shut_down_it_says_that_it_is_over(make_rig, write_scene):
    rig = make_rig()
    assert rig.change_state(Transition.TRANSITION_ACTIVE_SHUTDOWN)
    rig.bench.status(FIT, WARN, 'finalized, it was shut down for good')
    answer = rig.bench.call(Trigger, 'calibration/reset')
    assert not answer.success
    assert 'start the node again' in answer.message
    changed = rig.bench.set_parameter('calibration', 'scene', str(write_scene({})))
    assert not changed.successful
    assert 'start the node again' in changed.reason


def test_another_camera_begins_anew_and_a_topic_is_named_once(make_rig):
    rig = make_rig(**{'window.frames': 10})
    rig.info.publish(camera_info())
    for number in range(2):
        rig.depth.publish(depth_image(number))
    rig.window(2)
    rig.info.publish(camera_info(replace(CAMERA, fx=1.1 * CAMERA.fx)))
    rig.bench.until(
        lambda: rig.bench.value(INPUT, 'frames in the window') == '0', 'an empty window'
    )
    bad = camera_info()
    bad.k[0] = bad.p[0] = 0.0
    rig.info.publish(bad)
    status = rig.bench.status(FIT, ERROR, 'depth/camera_info')
    assert status.message.count('depth/camera_info') == 1


def test_what_is_missing_between_two_cameras_is_named_with_its_cure(make_rig):
    rig = make_rig()
    rig.info.publish(camera_info())
    pose = world_pose(CAMERA_FROM_WORLD)
    pose.header.frame_id = 'color_frame'
    rig.pose.publish(pose)
    rig.depth.publish(depth_image())
    status = rig.bench.status(FIT, WARN, f"where the frame 'color_frame' is in '{FRAME}'")
    assert 'set the parameter depth_from_color' in status.message
