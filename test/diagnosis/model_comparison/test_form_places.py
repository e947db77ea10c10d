# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Ways in which effects differ: of each pose, over time, and none of what is not seen."""

from dataclasses import replace

from diffcal_ros.calibration.observations.observation import Instant, pose_owners
from diffcal_ros.diagnosis.model_comparison.form_places import _likeness, Places
import numpy as np
import pytest


@pytest.mark.parametrize('count', [0, 1, 7])
def test_a_group_may_have_any_number_of_patches(count):
    """One that has none after models are put on shared patches had stopped a diagnosis."""
    places = Places(np.zeros((count, 1)), np.zeros((count, 2)), np.eye(3)[1], 1, 3)
    moved = np.full(count, 0.002)
    for name, width in (('load', 4), ('sensor', 9)):
        found = places.times(moved, places.functions(name))
        assert found.shape == (count, 4 * width)
    assert places.in_each(moved).shape == (count, 3)


def test_what_is_of_one_pose_moves_no_other():
    here, there = (
        Places(np.array([[0.2], [0.9]]), np.zeros((2, 2)), np.eye(2)[pose], pose, 2)
        for pose in range(2)
    )
    moved = np.array([0.001, 0.003])
    one, other = (place.times(moved, place.functions('load')) for place in (here, there))
    # Half of the variance is shared by all poses.
    expected = 0.5 * np.outer(moved, moved) * (here.functions('load') @ here.functions('load').T)
    assert np.allclose(one @ other.T, expected)
    assert np.allclose(one @ one.T, 2.0 * expected)
    assert np.allclose(here.in_each(moved) @ there.in_each(moved).T, 0.0)


def test_what_differs_in_a_motion_differs_smoothly_over_time(screened):
    """Frames of a recording have the more in common the nearer they are, and none with others."""
    at_rest, times = screened[0].model.observations[0], [0.0, 0.1, 0.4, 1.0]
    stamped = [*((0, time) for time in times), (1, 0.0), (1, 2.0)]
    frames = [replace(at_rest, instant=Instant(time, number)) for number, time in stamped]
    seen = [at_rest, *frames]
    alike = _likeness(seen, pose_owners(seen))
    assert np.allclose(np.diag(alike), 1.0)
    assert not alike[0, 1:].any()
    assert not alike[1:5, 5:].any()
    # Half scatters from frame to frame; the rest lasts for a quarter of what is filmed.
    apart = np.subtract.outer(times, times) / 0.25
    expected = 0.5 * np.exp(-(apart**2)) + 0.5 * np.eye(len(times))
    assert np.allclose(alike[1:5, 1:5], expected)
    assert np.allclose(alike, alike.T)
