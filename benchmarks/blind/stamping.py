# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""When frames are taken, and what their stamps say of it."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.timing import Timing

QUEUE = 6  # Frames until a queue is full: the last of them is dropped, and the queue is emptied.
_SHORTEST, _LONGEST = 0.4, 1.6  # Waits in a queue that was just emptied, and that is full.


def moments(timing: Timing, faults: Faults) -> list[float]:
    """Return when the frames were taken in truth, after the release [s].

    Of a rolling shutter that is when the middle row was read, of an exposure its middle.
    """
    if faults.stamps_form in _WAITING:
        numbers, waits = _WAITING[faults.stamps_form](timing, faults)
        # The camera's frames are even: the stamps are not.
        taken = timing.period * (numbers - numbers[0]) - waits[0] - timing.release
        return [float(when) for when in taken]
    late = np.full(timing.frame_count, 1e-3 * faults.stamps_late)
    if faults.stamps_form == 'drift':
        late *= np.linspace(0.5, 1.5, len(late))
    if faults.stamps_form == 'jitter':
        random = np.random.default_rng(round(1e5 * abs(faults.stamps_late)))
        late *= 1.0 + random.choice([-1.0, 1.0], len(late)) / 3.0
    return [float(when) for when in np.array(timing.stamps) - late - timing.release]


def stamps(timing: Timing, faults: Faults) -> list[int]:
    """Return the stamps of the frames, after the first one [ns]."""
    numbers, waits = np.arange(timing.frame_count), np.zeros(timing.frame_count)
    if faults.stamps_form in _WAITING:
        numbers, waits = _WAITING[faults.stamps_form](timing, faults)
    more = waits + (np.array(timing.jitter)[numbers] if timing.jitter else 0.0)
    period = round(1e9 * timing.period)
    return [
        int(number - numbers[0]) * period + round(1e9 * float(later - more[0]))
        for number, later in zip(numbers, more, strict=True)
    ]


def backlog(timing: Timing, faults: Faults) -> tuple[np.ndarray, FloatArray]:
    """Return which frames leave a queue, and how long each waited there [s]."""
    place = (np.arange(timing.frame_count) + faults.stamps_phase) % QUEUE
    left = np.flatnonzero(place < QUEUE - 1)
    part = place[left] / (QUEUE - 2.0)
    return left, 1e-3 * faults.stamps_late * (_SHORTEST + (_LONGEST - _SHORTEST) * part)


def polled(timing: Timing, faults: Faults) -> tuple[np.ndarray, FloatArray]:
    """Return the frames, and how long each waited until a driver asked for it next [s].

    It asks at even times, the last of which before the first frame was `stamps_asked` of the way
    from one to the next before that.
    """
    numbers, step = np.arange(timing.frame_count), 2e-3 * faults.stamps_late
    return numbers, step - (timing.period * numbers + faults.stamps_asked * step) % step


def set_over(timing: Timing, faults: Faults) -> tuple[np.ndarray, FloatArray]:
    """Return the frames, and how late each is stamped by a clock that is set as they go on [s]."""
    numbers = np.arange(timing.frame_count)
    return numbers, 1e-3 * faults.stamps_late * (numbers < faults.stamps_set)


def stalled(timing: Timing, faults: Faults) -> tuple[np.ndarray, FloatArray]:
    """Return the frames, and how long each waited for a computer that did something else once [s].

    What piled up by then is worked off evenly.
    """
    numbers = np.arange(timing.frame_count)
    since = numbers - faults.stamps_stall
    left = np.where(since >= 0, np.maximum(1.0 - since / faults.stamps_drain, 0.0), 0.0)
    return numbers, 1e-3 * faults.stamps_late * left


# Which frames there are and how late each is stamped, of forms whose stamps are not even.
_WAITING = {'backlog': backlog, 'polled': polled, 'set over': set_over, 'stalled': stalled}
