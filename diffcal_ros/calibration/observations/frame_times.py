# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""When the frames of a motion were taken, which of them are used, and which are held out."""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.errors import RecordingError
from diffcal_ros.scene.model import MotionSetup
import numpy as np

_SECOND = 1_000_000_000  # [ns]
# Stamps that jump back or repeat are left out, up to this share of a recording.
_BAD_FRACTION = 0.2
# After so long without a frame [s] nobody knows what happened to the body.
_LONGEST_GAP = 1.0
FEWEST_FRAMES = 4


@dataclass(frozen=True)
class FrameTime:
    """One frame of a recording.

    Attributes:
        index: of the frame among all depth images of the recording.
        time: after the first frame [s].
        is_held_out: it is kept from the fit.
    """

    index: int
    time: float
    is_held_out: bool = False


def frame_times(
    stamps_ns: Sequence[int | None], *, is_slow: bool = False
) -> tuple[list[FrameTime], list[str]]:
    """Turn header stamps into times, ascending.

    Args:
        stamps_ns: of the images in the order of recording [ns]; None where one is unreadable.
        is_slow: of a load that is held: any time may pass between frames.

    Returns:
        The frames with good stamps up to the first long gap, and notes for a person.

    Raises:
        RecordingError: when the stamps are no times.
    """
    known = [(index, stamp) for index, stamp in enumerate(stamps_ns) if stamp is not None]
    if len(known) < FEWEST_FRAMES:
        raise RecordingError(
            f'there are {len(known)} depth frames: a motion needs at least {FEWEST_FRAMES}'
        )
    if len({stamp for _, stamp in known}) == 1:
        raise RecordingError(
            f'all {len(known)} depth frames carry the same stamp: the clock stands still; let '
            'the driver stamp each image with the time of its exposure, and record again'
        )
    rising: list[tuple[int, int]] = []
    bad = {'jump back': 0, 'repeat the one before': 0}
    for index, stamp in known:
        if not rising or stamp > rising[-1][1]:
            rising.append((index, stamp))
        else:
            bad['jump back' if stamp < rising[-1][1] else 'repeat the one before'] += 1
    told = ' and '.join(f'{count} stamps {what}' for what, count in bad.items() if count)
    if sum(bad.values()) > _BAD_FRACTION * len(known):
        raise RecordingError(
            f'of {len(known)} depth frames {told}: their order in time is not known; record with '
            'one clock, and do not join recordings'
        )
    notes = [f'{told}: these frames are left out'] if told else []
    first = rising[0][1]
    frames = [FrameTime(index, (stamp - first) / _SECOND) for index, stamp in rising]
    return (frames, notes) if is_slow else _up_to_gap(frames, notes)


def _up_to_gap(frames: list[FrameTime], notes: list[str]) -> tuple[list[FrameTime], list[str]]:
    waits = np.diff([frame.time for frame in frames])
    long = np.flatnonzero(waits > _LONGEST_GAP)
    if len(long) == 0:
        return frames, notes
    end = int(long[0])
    note = (
        f'no frame for {waits[end]:.1f} s after {frames[end].time:.2f} s: the '
        f'{len(frames) - end - 1} frames after this gap are left out'
    )
    return frames[: end + 1], [*notes, note]


def chosen_frames(frames: Sequence[FrameTime], motion: MotionSetup) -> list[FrameTime]:
    """Choose the frames to compare, evenly, and mark those that are held out.

    Args:
        frames: see `frame_times`.
        motion: says how many, until when, and when the release is expected.

    Raises:
        RecordingError: when they end before the release.
    """
    until = float('inf') if motion.duration is None else motion.duration
    inside = [frame for frame in frames if frame.time <= until]
    expected = motion.release_time.start
    after = [frame for frame in inside if frame.time > expected]
    if len(after) < 2:
        last = inside[-1].time if inside else 0.0
        raise RecordingError(
            f'the frames end {last:.3g} s after the first one, and the release is expected at '
            f'{expected:.3g} s: it is never seen; record longer, or correct `motion.at` (and '
            '`duration`) in the scene'
        )
    indices = np.linspace(0, len(inside) - 1, min(motion.most_frames, len(inside)))
    used = [inside[index] for index in indices.round().astype(int)]
    if not motion.hold_out:
        return used
    middle = motion.hold_out // 2
    return [
        FrameTime(frame.index, frame.time, number % motion.hold_out == middle)
        for number, frame in enumerate(used)
    ]
