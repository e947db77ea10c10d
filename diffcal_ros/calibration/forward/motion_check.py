# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whether depth frames show what a motion's scene says: rest, then a release."""

from collections.abc import Sequence

from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.errors import RecordingError
from diffcal_ros.median_spread import SPREAD_OVER_MEDIAN
from diffcal_ros.scene.model import MotionSetup
import numpy as np
from numpy.typing import NDArray

# A pixel has changed when its depth differs by more than this [m]; noise and steps are finer.
_CHANGE = 0.006
# Where nothing moves by so much: a small swing changes pixels by more than so many times the noise
# between the first two frames and than the sensor's steps [m], or covers and uncovers them.
_SIGMAS, _STEPS = 6.0, 0.001
# So much later than the latest release a body may begin to move visibly [s]: it falls 10 mm.
_SLOW = 0.05


def has_changed(first: NDArray[np.float32], other: NDArray[np.float32]) -> bool:
    """Tell whether something moved between two depth images [m], NaN where invalid.

    Flying pixels come and go in lines along edges: only patches of 4x4 pixels count.
    """
    return _has_patch(np.abs(other - first) > _CHANGE)  # NaN compares false.


def _has_changed_a_little(
    first: NDArray[np.float32], other: NDArray[np.float32], least: float
) -> bool:
    """Tell whether something moved by little, or went before a background without depth."""
    came_or_went = np.isnan(first) != np.isnan(other)
    return _has_patch((np.abs(other - first) > least) | came_or_went)


def _has_patch(changed: NDArray[np.bool_]) -> bool:
    pairs = changed[:, :-1] & changed[:, 1:]
    rows = pairs[:, :-2] & pairs[:, 2:]
    pairs = rows[:-1] & rows[1:]
    return bool((pairs[:-2] & pairs[2:]).any())


def check_motion(
    frames: Sequence[DepthFrame], times: Sequence[float], motion: MotionSetup
) -> None:
    """Refuse frames in which nothing moves, or something does too early or too late.

    Args:
        frames: in order of time.
        times: of them, after the first frame [s].
        motion: what the scene says.

    Raises:
        RecordingError: saying what was seen and what to do.
    """
    allowed = motion.release_time
    first = frames[0].depth
    seen = (
        time for frame, time in zip(frames, times, strict=True) if has_changed(first, frame.depth)
    )
    onset = next(seen, None)
    is_small = onset is None
    if is_small:
        onset = _small_onset(frames, times)
    if onset is None:
        raise RecordingError(
            f'nothing moves in {len(frames)} frames over {times[-1]:.3g} s: the release is never '
            'seen; record it, or leave `motion` out for a body at rest'
        )
    if onset < allowed.lower and not is_small:
        raise RecordingError(
            f'something moves {onset:.3g} s after the first frame, before the earliest release '
            f'({allowed.lower:.3g} s): the first frames must show the body at rest on its '
            'support; wait longer before you record, cut the beginning off, or correct `motion.at`'
        )
    if onset > allowed.upper + _SLOW + _spacing(times):
        raise RecordingError(
            f'nothing moves until {onset:.3g} s after the first frame, and the latest release is '
            f'{allowed.upper:.3g} s: widen `motion.at`'
        )


def _small_onset(frames: Sequence[DepthFrame], times: Sequence[float]) -> float | None:
    """Return when something begins to move by little; None for never.

    A frame that has lost pixels must not pass for it: the next one must have moved, too.
    """
    first = frames[0].depth
    apart = np.abs(frames[1].depth - first)
    noise = SPREAD_OVER_MEDIAN * float(np.nanmedian(apart)) if np.isfinite(apart).any() else 0.0
    least = max(_STEPS, _SIGMAS * noise)
    moved = [_has_changed_a_little(first, frame.depth, least) for frame in frames]
    pairs = zip(times, moved, moved[1:], strict=False)
    return next((time for time, one, two in pairs if one and two), None)


def _spacing(times: Sequence[float]) -> float:
    return float(np.diff(times).max()) if len(times) > 1 else 0.0
