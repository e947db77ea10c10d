# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The view that frames are compared with: when it is rendered and informed anew."""

from dataclasses import replace

from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.residuals.residual_scales import Scales
from diffcal_ros.calibration.tracking.linearised_view import LinearisedView
from diffcal_ros.depth_frame import DepthFrame
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_MOST_REFINEMENTS = 4
_LOOKING = 1_000_000_000  # Between two looks at what lies beside the body [ns].
_INFORMING = 15  # Frames between two looks at how sure a frame is.


class CurrentView:
    """A linearised view, and what a recent frame says of its errors and its gap.

    Attributes:
        view: the body where it was rendered last.
        information: how sure one frame is there, see `Linearisation`.
        gap: of the last frame whose gap was measured.
    """

    def __init__(
        self, objective: RobustObjective, coordinates: FloatArray, frame: DepthFrame
    ) -> None:
        """Render once, residuals weighed by what one frame shows.

        Args:
            objective: gives the model, and compares with the frame that is shown to it.
            coordinates: where, shape (k,).
            frame: to weigh by.

        Raises:
            EquilibriumError: when the body has no equilibrium there.
            OutOfViewError: when the camera does not see it.
        """
        self._objective = objective
        self._next_look_ns = self._age = 0
        self.gap = Gap(float('nan'), float('nan'), 0.0, 0)
        (comparer,) = objective.comparers
        comparer.show(frame.depth)
        self.weigh_anew(coordinates, frame)

    def weigh_anew(self, coordinates: FloatArray, frame: DepthFrame) -> None:
        """Weigh residuals by what the frame shown last shows there, and render there.

        Raises:
            EquilibriumError: when the body has no equilibrium there; the weights stay.
            OutOfViewError: when the camera does not see it; likewise.
        """
        objective = self._objective.under(Scales())
        while not objective.is_annealed:
            objective.anneal(coordinates)
        self._refine_and_render(objective, coordinates, frame)

    def weigh_by(self, scales: Scales, coordinates: FloatArray, frame: DepthFrame) -> None:
        """Weigh residuals by what a fit found, as far as the frame shows no less; render there.

        Raises:
            EquilibriumError: when the body has no equilibrium there; the weights stay.
            OutOfViewError: when the camera does not see it; likewise.
        """
        self._refine_and_render(self._objective.under(scales), coordinates, frame)

    def render(self, coordinates: FloatArray, frame: DepthFrame) -> None:
        """Render somewhere else, and inform by a frame.

        Raises:
            EquilibriumError: when the body has no equilibrium there; the view stays.
            OutOfViewError: when the camera does not see it; likewise.
        """
        self.view = LinearisedView(self._objective, coordinates)
        self._inform(frame)

    def _refine_and_render(
        self, objective: RobustObjective, coordinates: FloatArray, frame: DepthFrame
    ) -> None:
        """Weigh by the noise and correlation that residuals show there, and render there."""
        for _ in range(_MOST_REFINEMENTS):
            if not objective.refine(coordinates):
                break
        self.view = LinearisedView(objective, coordinates)
        self._objective = objective
        self._inform(frame)

    def grow_older(self, frame: DepthFrame) -> None:
        """Take note of a frame that was compared; every so often one says how sure it is."""
        self._age += 1
        if self._age >= _INFORMING:
            self._inform(frame)

    def look_beside_soon(self) -> None:
        """Look with the next frame that informs at what lies beside the body."""
        self._next_look_ns = 0

    def _inform(self, frame: DepthFrame) -> None:
        self.information = self.view.inform(frame.depth)
        # What lies beside the body takes longer to look for than all else, and changes slowly.
        is_due = frame.stamp_ns >= self._next_look_ns
        gap = self.view.gap(frame.depth, is_both_ways=is_due)
        if is_due:
            self._next_look_ns = frame.stamp_ns + _LOOKING
        else:
            gap = replace(gap, explained=self.gap.explained, hidden=self.gap.hidden)
        self.gap = gap
        self._age = 0
