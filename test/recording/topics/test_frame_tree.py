# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Transforms over time between named frames."""

from diffcal_ros.errors import RecordingError
from diffcal_ros.recording.topics.frame_tree import FrameTree, TOLERANCE_NS
from diffcal_ros.rigid_transform import inverse, rotation_matrix, transform
import numpy as np
import pytest

_SECOND = 1_000_000_000  # [ns]


def pose(turn, shift):
    return transform(rotation_matrix(np.array(turn)), np.array(shift))


A_FROM_B = pose([0.2, -0.1, 0.3], [1.0, 2.0, 3.0])
B_FROM_C = pose([0.0, 0.5, 0.0], [0.1, 0.0, 0.0])


def test_a_chain_is_followed_up_and_down():
    tree = FrameTree()
    tree.add('/a', 'b', A_FROM_B)
    tree.add('b', 'c', B_FROM_C)
    np.testing.assert_allclose(tree.find('a', '/c'), A_FROM_B @ B_FROM_C)
    np.testing.assert_allclose(tree.find('c', 'a'), inverse(A_FROM_B @ B_FROM_C))
    assert tree.frames == ['a', 'b', 'c']
    assert tree.find('a', 'd') is None
    assert tree.find('', '') is None


def test_between_two_samples_it_moves_evenly_in_whatever_order_they_came():
    tree = FrameTree()
    for second in (2, 0, 1):
        tree.add('a', 'b', pose([0.2 * second, 0, 0], [second, 0, 0]), stamp_ns=second * _SECOND)
    half = tree.find('a', 'b', 3 * _SECOND // 2)
    np.testing.assert_allclose(half, pose([0.3, 0, 0], [1.5, 0, 0]), atol=1e-12)
    np.testing.assert_allclose(tree.find('a', 'b'), pose([0.4, 0, 0], [2, 0, 0]), atol=1e-12)


def test_beyond_its_samples_it_is_what_it_was_for_a_moment_only():
    tree = FrameTree()
    tree.add('a', 'b', A_FROM_B, stamp_ns=_SECOND)
    for stamp in (_SECOND - TOLERANCE_NS, _SECOND, _SECOND + TOLERANCE_NS):
        np.testing.assert_array_equal(tree.find('a', 'b', stamp), A_FROM_B)
    with pytest.raises(RecordingError, match=r'b to a is needed 0\.30 s before it is first known'):
        tree.find('a', 'b', _SECOND - 300_000_000)
    with pytest.raises(RecordingError, match=r'b to a is needed 0\.30 s after it is last known'):
        tree.find('a', 'b', _SECOND + 300_000_000)


def test_what_is_unusable_is_told_where_it_is_needed_alone():
    tree = FrameTree()
    tree.add('a', 'b', None, problem='its quaternion is zero')
    tree.add('b', 'c', B_FROM_C)
    assert tree.find('b', 'c') is not None
    with pytest.raises(RecordingError, match='from b to a is unusable, its quaternion is zero'):
        tree.find('a', 'c')
    # Another way round, it is not needed.
    tree.add('c', 'a', np.eye(4))
    np.testing.assert_allclose(tree.find('a', 'b'), inverse(B_FROM_C))
