# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Tell when a body that is followed is no longer the one that it was."""

from dataclasses import dataclass

from diffcal_ros.calibration.parameters.parameters import ParameterSet
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_SURE = 4.0  # Standard errors that a change must exceed.
# A median gap that grows so much is a change that no parameter follows: a payload, for one.
_GROWN, _LEAST_GROWTH = 2.0, 0.0003  # [m]


@dataclass(frozen=True)
class BodyChange:
    """Parameters that left the values they had, or a gap that no parameter closes.

    Attributes:
        stamp_ns: of the frame that showed it [ns].
        before: values before, in SI units by name, of the parameters that changed.
        after: values after.
        gap_before: median gap before [m].
        gap_after: median gap after [m].
        is_sudden: it came within a few frames.
    """

    stamp_ns: int
    before: dict[str, float]
    after: dict[str, float]
    gap_before: float
    gap_after: float
    is_sudden: bool


class ChangeWatch:
    """Compares with the last state that was told.

    Attributes:
        is_sudden: what is seen next came within a few frames; set from outside.
    """

    def __init__(
        self, parameters: ParameterSet, coordinates: FloatArray, least: FloatArray
    ) -> None:
        """Start from a state.

        Args:
            parameters: what the coordinates mean.
            coordinates: shape (k,).
            least: change of each that is told, shape (k,).
        """
        self.is_sudden = False
        self._parameters = parameters
        self._least = least
        self._coordinates = coordinates.copy()
        self._gap: float | None = None

    def look(
        self, stamp_ns: int, coordinates: FloatArray, errors: FloatArray, gap: float
    ) -> BodyChange | None:
        """Return what has left the state told last; from then on this state counts.

        Args:
            stamp_ns: of the frame [ns].
            coordinates: shape (k,).
            errors: statistical standard errors of them, shape (k,).
            gap: median [m].
        """
        is_sudden, self.is_sudden = self.is_sudden, False
        before_gap = gap if self._gap is None else self._gap
        self._gap = before_gap
        moved = np.abs(coordinates - self._coordinates)
        is_moved = moved > np.maximum(self._least, _SURE * errors)
        names = [
            p.name
            for p, is_told in zip(self._parameters, is_moved, strict=True)
            if is_told and not p.is_nuisance
        ]
        if not names and not gap > _GROWN * before_gap + _LEAST_GROWTH:
            return None
        before = self._parameters.values(self._coordinates)
        after = self._parameters.values(coordinates)
        self._coordinates, self._gap = coordinates.copy(), gap
        return BodyChange(
            stamp_ns=stamp_ns,
            before={name: before[name] for name in names},
            after={name: after[name] for name in names},
            gap_before=before_gap,
            gap_after=gap,
            is_sudden=is_sudden,
        )
