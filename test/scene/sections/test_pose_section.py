# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The section `pose` of a scene, and of its observations."""

from diffcal_ros.errors import SceneError
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.model import PoseSetup
import numpy as np
import pytest


def test_a_scene_that_does_not_say_has_the_usual_spread(write_scene):
    (setup,) = load_scene(write_scene()).observations
    assert setup.pose == PoseSetup()
    assert setup.pose.spread == pytest.approx((0.001, np.deg2rad(0.3)))
    assert not setup.pose.is_spread_stated


def test_everything_is_read_and_an_observation_goes_before_the_scene(write_scene):
    path = write_scene(
        {
            'pose': {
                'source': 'tf',
                'world_frame': 'rig_link',
                'topic': '/camera_pose',
                'position_std': 0.002,
                'rotation_std_deg': 0.5,
            },
            'observations': [
                {'name': 'low'},
                {'name': 'high', 'pose': {'source': 'topic', 'position_std': 0.004}},
                {'name': 'exact', 'pose': {'position_std': 0, 'rotation_std_deg': 0}},
            ],
        }
    )
    low, high, exact = (setup.pose for setup in load_scene(path).observations)
    half = np.deg2rad(0.5)
    assert low == PoseSetup('tf', 'rig_link', '/camera_pose', 0.002, half)
    assert high == PoseSetup('topic', 'rig_link', '/camera_pose', 0.004, half)
    assert exact.spread == (0.0, 0.0)


@pytest.mark.parametrize(
    ('pose', 'words'),
    [
        ({'source': 'gps'}, r"pose\.source is 'gps': allowed: marker, stored, tf, topic"),
        ({'sorce': 'tf'}, r'pose\.sorce is no key .*did you mean `source`'),
        ({'source': 'tf'}, r"pose\.world_frame is missing: name TF's frame that is the world"),
        ({'position_std': 2}, r'pose\.position_std is 2: give a standard deviation in metres'),
        ({'position_std': -1}, r'pose\.position_std is -1: give a standard deviation in metres'),
        ({'rotation_std_deg': 'x'}, r"rotation_std_deg is 'x': give a standard .* in degrees"),
        ({'position_std': 0}, r'pose has a standard deviation of 0 beside another: give 0 for b'),
        ({'topic': ''}, r"pose\.topic is '': name a topic"),
        ({'world_frame': ['a']}, r"pose\.world_frame is \['a'\]: name a frame of TF"),
        ('tf', r"pose is 'tf': a mapping is needed here"),
    ],
)
def test_mistakes_are_told_once(write_scene, pose, words):
    with pytest.raises(SceneError, match=words) as error:
        load_scene(write_scene({'pose': pose, 'observations': [{'name': 'a'}, {'name': 'b'}]}))
    assert str(error.value).count('pose') <= 2
