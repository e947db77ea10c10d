# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""TF read from its two topics, where its message type is there but tf2_ros is not."""

from types import SimpleNamespace

from diffcal_ros.ros.conversion import header_message
from diffcal_ros.ros.frame_tree import HeardFrames
from geometry_msgs.msg import TransformStamped
import numpy as np
import pytest

START = 1_700_000_000_000_000_000  # [ns]
SECOND = 1_000_000_000  # [ns]


def _message(parent, child, x, stamp_ns=0):
    stamped = TransformStamped(header=header_message(stamp_ns, parent), child_frame_id=child)
    stamped.transform.translation.x = x
    stamped.transform.rotation.w = 1.0
    return SimpleNamespace(transforms=[stamped])


@pytest.fixture
def heard():
    """A rig whose camera is fixed to an arm that moves by 10 mm a second for five minutes."""
    made = HeardFrames()
    made.take_static(_message('arm', 'camera', 1.0))
    for number in range(3000):
        stamp = START + number * SECOND // 10
        made.take(_message('rig', 'arm', 0.001 * number, stamp))
    return made


def test_a_chain_is_found_at_a_time_and_at_last(heard):
    at = START + 2900 * SECOND // 10
    found = heard.find('rig', 'camera', at + SECOND // 20)
    np.testing.assert_allclose(found[:3, 3], [3.9005, 0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(heard.find('rig', 'camera', None)[:3, 3], [3.999, 0.0, 0.0])


def test_what_is_not_known_is_not_made_up(heard):
    assert heard.find('rig', 'camera', START + 400 * SECOND) is None
    assert heard.find('rig', 'elsewhere', None) is None
    broken = _message('rig', 'broken', 0.0)
    broken.transforms[0].transform.rotation.w = 0.0
    heard.take_static(broken)
    assert heard.find('rig', 'broken', None) is None


def test_what_it_remembers_is_bounded_and_a_clock_set_back_begins_anew(heard):
    assert heard.find('rig', 'camera', START) is None, 'minutes ago'
    samples = [
        len(edge.samples) for tree in (heard._newer, heard._older) for edge in tree._edges.values()
    ]
    assert max(samples) <= 601
    heard.take(_message('rig', 'arm', 7.0, START - 100 * SECOND))
    np.testing.assert_allclose(heard.find('rig', 'camera', None)[:3, 3], [8.0, 0.0, 0.0])
