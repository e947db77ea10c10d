# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""At which times a prediction looks at a body."""

from dataclasses import dataclass

from diffcal_ros.errors import InputError
from diffcal_ros.scene.model import ObservationSetup
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_AFTER_RELEASE = 1.0  # What is shown where nobody says how long [s].
_MOST_FRAMES = 2000


@dataclass(frozen=True)
class FilmTimes:
    """How often and how long a moving body is looked at.

    Attributes:
        rate: frames a second [Hz].
        duration: from the beginning [s]; None: as the scene says, else until a second after the
            release.
    """

    rate: float = 30.0
    duration: float | None = None

    def __post_init__(self) -> None:
        if not 0.1 <= self.rate <= 10000.0:
            raise InputError(f'the frame rate is {self.rate:g} Hz: give 0.1 to 10000')
        if self.duration is not None and not 0.0 < self.duration <= 600.0:
            raise InputError(f'the duration is {self.duration:g} s: give more than 0, up to 600')

    def of(self, setup: ObservationSetup) -> FloatArray:
        """Return the times of the frames of one observation [s], shape (F,); at rest just 0.

        Raises:
            InputError: when there would be too many.
        """
        motion = setup.motion
        if motion is None:
            return np.zeros(1)
        end = self.duration or motion.duration or motion.release_time.start + _AFTER_RELEASE
        # A whole number of periods counts although its quotient may round down.
        count = int(np.floor(end * self.rate * (1.0 + 1e-9))) + 1
        if count > _MOST_FRAMES:
            raise InputError(
                f'{end:g} s at {self.rate:g} Hz are {count} frames of {setup.name!r}, and '
                f'{_MOST_FRAMES} are the most: give a lower rate or a shorter duration'
            )
        return np.arange(count) / self.rate
