# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What every loss can tell a fit, a live picture and a person."""

from typing import Protocol

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.forward.solution import View
from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.least_squares.levenberg_marquardt import Objective
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class FitObjective(Objective, Protocol):
    """A loss over all views of a model.

    Attributes:
        model: simulates and traces.
        truncation: residuals beyond this belong to something else than the body [m].
    """

    model: ForwardModel
    truncation: float

    def gap(self, coordinates: FloatArray) -> Gap:
        """Measure the gap on the body at some coordinates, shape (k,)."""

    def standing(self, coordinates: FloatArray) -> tuple[Gap, float]:
        """Return the gap, and a figure that falls as the data are met better."""

    def counted(self, number: int, view: View) -> NDArray[np.bool_]:
        """Tell which pixels of a view's window are unmasked body."""

    def read_depth(self, number: int, view: View, coordinates: FloatArray) -> FloatArray:
        """Return the depth in a view's window that the sensor would read [m], NaN elsewhere."""
