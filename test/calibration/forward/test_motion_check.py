# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whether frames show rest and then a release, in noise and flying pixels."""

from diffcal_ros.calibration.forward.motion_check import check_motion, has_changed
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.errors import RecordingError
from diffcal_ros.scene.model import MotionSetup, Quantity
import numpy as np
import pytest

TIMES = tuple(0.1 * number for number in range(8))


def picture(shift: int, random: np.random.Generator) -> np.ndarray:
    """A body of 20 x 60 px before a wall; beside its edges a third of the pixels fly."""
    depth = np.full((90, 120), 0.9, dtype=np.float32)
    depth[30 + shift : 50 + shift, 20:80] = 0.5
    rim = np.zeros_like(depth, dtype=bool)
    for row in (29 + shift, 50 + shift):
        rim[row, 19:81] = True
    rim[29 + shift : 51 + shift, [19, 80]] = True
    flies = rim & (random.random(depth.shape) < 0.33)
    depth[flies] = random.uniform(0.5, 0.9, flies.sum())
    depth[random.random(depth.shape) < 0.02] = np.nan
    return depth + random.normal(scale=2e-4, size=depth.shape).astype(np.float32)


def frames(shifts: list[int], random: np.random.Generator) -> list[DepthFrame]:
    return [DepthFrame(picture(s, random), n, 'camera') for n, s in enumerate(shifts)]


def motion(lower: float, upper: float) -> MotionSetup:
    return MotionSetup(('ledge',), Quantity(0.5 * (lower + upper), lower, upper))


def test_noise_is_no_motion_and_a_shift_is(random) -> None:
    still = picture(0, random)
    assert not has_changed(still, picture(0, random))
    assert has_changed(still, picture(5, random))


def test_rest_and_then_a_release_is_what_is_wanted(random) -> None:
    check_motion(frames([0, 0, 0, 0, 5, 12, 20, 25], random), TIMES, motion(0.2, 0.5))


def test_a_body_that_never_moves_is_refused(random) -> None:
    with pytest.raises(RecordingError, match=r'nothing moves in 8 frames over 0\.7 s'):
        check_motion(frames([0] * 8, random), TIMES, motion(0.2, 0.5))


def small(move: float, random: np.random.Generator, *, lost: bool = False) -> np.ndarray:
    """The same body before a background without depth, moved by less than 6 mm towards it."""
    depth = picture(0, random)
    depth[depth > 0.7] = np.nan
    depth = depth + np.float32(move)
    if lost:
        depth[35:45, 30:40] = np.nan
    return depth


def test_a_swing_of_millimetres_is_one(random) -> None:
    moves = [0.0, 0.0, 0.0, 0.001, 0.003, 0.004, 0.003, 0.0]
    seen = [DepthFrame(small(m, random), n, 'camera') for n, m in enumerate(moves)]
    check_motion(seen, TIMES, motion(0.2, 0.5))
    with pytest.raises(RecordingError, match=r'nothing moves until 0\.4 s'):
        check_motion(seen, TIMES, motion(0.05, 0.1))


def test_a_fall_before_a_background_without_depth_is_seen(random) -> None:
    pictures = [picture(shift, random) for shift in (0, 0, 0, 0, 6, 9, 9, 6)]
    for depth in pictures:
        depth[depth > 0.7] = np.nan
    seen = [DepthFrame(depth, n, 'camera') for n, depth in enumerate(pictures)]
    check_motion(seen, TIMES, motion(0.2, 0.5))


def test_a_frame_that_lost_pixels_is_no_motion(random) -> None:
    seen = [DepthFrame(small(0.0, random, lost=n == 4), n, 'camera') for n in range(8)]
    with pytest.raises(RecordingError, match='nothing moves in 8 frames'):
        check_motion(seen, TIMES, motion(0.2, 0.5))


def test_a_body_that_does_not_rest_first_is_refused(random) -> None:
    swinging = frames([0, 6, 0, -6, 5, 12, 20, 25], random)
    with pytest.raises(RecordingError, match=r'something moves 0\.1 s after .* at rest'):
        check_motion(swinging, TIMES, motion(0.2, 0.5))


def test_a_release_later_than_allowed_is_refused(random) -> None:
    late = frames([0, 0, 0, 0, 0, 0, 0, 9], random)
    with pytest.raises(RecordingError, match=r'nothing moves until 0\.7 s .* widen `motion\.at`'):
        check_motion(late, TIMES, motion(0.1, 0.3))
