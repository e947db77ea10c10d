# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""When a body is let go, and how long it is filmed."""

from dataclasses import dataclass, replace

import numpy as np

LEDGE = 1e-4  # The support holds the end face: what is this near to it [m].
PERIOD = 1.0 / 30.0  # Between frames of a swing [s].
# Of stamps: standard deviation, and the most [s].
_JITTER, _MOST = 0.0002, 0.0005


@dataclass(frozen=True)
class Timing:
    """Times of one recording.

    Attributes:
        release: when the support goes, after the first frame [s].
        period: between frames [s].
        frame_count: frames.
        damping: true one [Pa s].
        stated_damping: what is known of it, to a tenth [Pa s].
        is_slow: a load that is held, filmed for a while, and not a swing.
        jitter: by how much each stamp is off, as those of all cameras are [s]; empty: by nothing.
    """

    release: float
    period: float
    frame_count: int
    damping: float
    stated_damping: float
    is_slow: bool = False
    jitter: tuple[float, ...] = ()

    @property
    def stamps(self) -> list[float]:
        """Stamps of the frames after the first one [s]."""
        return [number * self.period for number in range(self.frame_count)]


def draw_swing(random: np.random.Generator) -> Timing:
    """Draw the timing of a body that swings for a third of a second."""
    damping = float(f'{random.uniform(8.0, 40.0):.4g}')
    stated = float(f'{damping * (1.0 + 0.1 * random.standard_normal()):.4g}')
    release = round(float(random.uniform(0.175, 0.195)), 4)
    return Timing(release, PERIOD, 17, damping, max(stated, 0.5 * damping))


def draw_hold(random: np.random.Generator) -> Timing:
    """Draw the timing of a load that is held for some forty seconds."""
    release = round(float(random.uniform(11.0, 11.8)), 3)
    return Timing(release, 2.0, 24, 20.0, 20.0, is_slow=True)


def jittery(timing: Timing, random: np.random.Generator) -> Timing:
    """Return a timing whose stamps are off by some tenths of a millisecond, but for the first."""
    off = np.clip(_JITTER * random.standard_normal(timing.frame_count), -_MOST, _MOST)
    off[0] = 0.0
    return replace(timing, jitter=tuple(round(float(value), 9) for value in off))
