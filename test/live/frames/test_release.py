# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""When the body was let go, as far as a swing's frames tell."""

from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.errors import InputError
from diffcal_ros.live.frames.release import require_release_time, with_release
from diffcal_ros.live.frames.swing_window import Swing
import numpy as np
import pytest
from support.filmed import filmed_scene


def _swing(onset: float, gap: float = 0.05) -> Swing:
    """Frames at 20 Hz with one longer gap, the last but one."""
    times = np.array([0.0, 0.05, 0.10, 0.10 + gap, 0.15 + gap])
    stamps = (5e9 + 1e9 * times).round().astype(int)
    nothing = np.zeros((2, 2), dtype=np.float32)
    return Swing(tuple(DepthFrame(nothing, int(stamp), 'camera') for stamp in stamps), onset)


@pytest.mark.parametrize('gap', [0.05, 0.08])
def test_the_release_lies_up_to_a_frame_and_a_slow_start_before_the_onset(gap):
    scene = filmed_scene(is_small=True)
    release = with_release(scene, 0, _swing(0.4, gap)).observations[0].motion.release_time
    assert release.upper == 0.4
    assert release.lower == pytest.approx(0.4 - 0.12 - gap, abs=1e-9)
    assert release.start == pytest.approx(0.4 - 0.03)
    # Nothing else of the scene changes.
    assert scene.observations[0].motion.release_time != release


def test_the_release_does_not_lie_before_the_first_frame():
    scene = with_release(filmed_scene(is_small=True), 0, _swing(0.02))
    release = scene.observations[0].motion.release_time
    assert (release.lower, release.start, release.upper) == (0.0, 0.0, 0.02)


def test_a_motion_is_not_fitted_without_the_time_of_its_release():
    require_release_time(('youngs_modulus', 'release_time'))
    with pytest.raises(InputError, match='release_time'):
        require_release_time(('youngs_modulus',))
