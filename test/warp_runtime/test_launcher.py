# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Launches that are kept: also where the first one has nothing to do."""

from diffcal_ros.warp_runtime.launcher import Launcher
import numpy as np
import pytest
import warp as wp


@wp.kernel
def _count(out: wp.array(dtype=int)):
    wp.atomic_add(out, 0, 1)


@pytest.mark.parametrize('nothing', [0, (0, 3)])
def test_a_launch_over_nothing_does_nothing_and_later_ones_work(nothing):
    launcher = Launcher('cpu')
    out = wp.zeros(1, dtype=int, device='cpu')
    for dim, count in ((nothing, 0), (2, 2), (nothing, 2), ((2, 3), 8)):
        launcher.launch(_count, dim, [], [out])
        np.testing.assert_array_equal(out.numpy(), [count])
