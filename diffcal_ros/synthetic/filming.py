# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""When a synthetic camera takes its frames: rate, exposure, jitter of its stamps, lost frames."""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.errors import InputError
from diffcal_ros.synthetic.scan import Scan
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_SCANS = 5  # Instants within an exposure at which a moving body is looked at.
_SECOND = 1_000_000_000  # [ns]
_MOST_FRAMES = 100_000
_LARGEST_JITTER = 0.4  # In periods: stamps must not overtake one another.


@dataclass(frozen=True)
class Timing:
    """How a camera takes frames.

    Attributes:
        frames: that it takes, lost ones included.
        rate: frames a second [Hz].
        exposure: a scanning LIDAR's lines are taken one after the other over this time, around
            the stamp [s].
        stamp_jitter: standard deviation of a stamp's error [s].
        drop_share: of the frames after the first one, those that are lost.
    """

    frames: int = 15
    rate: float = 30.0
    exposure: float = 0.0
    stamp_jitter: float = 0.0
    drop_share: float = 0.0

    def __post_init__(self) -> None:
        if self.frames < 1:
            raise InputError(f'{self.frames} depth frames were asked for: give at least one')
        if self.frames > _MOST_FRAMES:
            raise InputError(
                f'{self.frames} depth frames were asked for: give at most {_MOST_FRAMES}'
            )
        if not 0.1 <= self.rate <= 1000.0:
            raise InputError(f'the frame rate is {self.rate:g} Hz: give 0.1 to 1000')
        period = 1.0 / self.rate
        if not 0.0 <= self.exposure <= period:
            raise InputError(
                f'the exposure is {self.exposure:g} s: give 0 to the {period:.4g} s that a frame '
                f'takes at {self.rate:g} Hz'
            )
        if not 0.0 <= self.stamp_jitter <= period:
            raise InputError(
                f'the jitter of the stamps is {self.stamp_jitter:g} s: give 0 to {period:.4g}, '
                f'the time between two frames at {self.rate:g} Hz'
            )
        if not 0.0 <= self.drop_share < 1.0:
            raise InputError(
                f'the share of lost frames is {self.drop_share:g}: give 0 to less than 1'
            )

    def times(self) -> FloatArray:
        """Return the middle of each frame's exposure [s], shape (frames,)."""
        return np.arange(self.frames) / self.rate

    def instants(self) -> FloatArray:
        """Return when the body is looked at, after each frame's middle [s], shape (s,)."""
        if self.exposure == 0.0:
            return np.zeros(1)
        return self.exposure * ((np.arange(_SCANS) + 0.5) / _SCANS - 0.5)

    def stamps_ns(self, random: np.random.Generator) -> list[int]:
        """Return what the camera writes on each frame, after the first one [ns]."""
        limit = _LARGEST_JITTER / self.rate
        errors = np.clip(
            random.normal(scale=1.0, size=self.frames) * self.stamp_jitter, -limit, limit
        )
        period = round(_SECOND / self.rate)
        return [k * period + round(_SECOND * float(error)) for k, error in enumerate(errors)]

    def kept(self, random: np.random.Generator) -> list[int]:
        """Return the numbers of the frames that are not lost; the first one never is."""
        chance = random.random(self.frames)
        return [k for k in range(self.frames) if k == 0 or chance[k] >= self.drop_share]


def line_by_line(scans: Sequence[Scan]) -> Scan:
    """Return what is seen when the image's lines are taken one after the other, top first.

    Args:
        scans: of the whole image at instants evenly spread over the exposure.
    """
    if len(scans) == 1:
        return scans[0]
    height = scans[0].depth.shape[0]
    owner = np.arange(height) * len(scans) // height
    rows = np.arange(height)
    depth, cosine, things = (
        np.stack([getattr(scan, name) for scan in scans])[owner, rows]
        for name in ('depth', 'cosine', 'things')
    )
    return Scan(depth, cosine, things)
