# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A fit by a whole-image loss, as the paper does it."""

from diffcal_ros.calibration.fit_method import Doubts, FitEnd, OnIteration
from diffcal_ros.calibration.parameters.longest_steps import longest_steps
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.calibration.whole_image.demon import learning_rates, minimise_with_demon
from diffcal_ros.calibration.whole_image.image_objective import ImageObjective
from diffcal_ros.errors import InputError
from diffcal_ros.least_squares.levenberg_marquardt import minimise, Minimum
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Doublings of a Gauss-Newton step on a whole-image loss, and Adam's longest step over its.
_DOUBLINGS = 8
_ADAM_FRACTION = 0.1


class ImageFit:
    """Gauss-Newton or Adam from one start.

    Attributes:
        objective: the whole-image loss.
    """

    def __init__(self, objective: ImageObjective, settings: CalibrationSettings) -> None:
        self.objective, self._settings = objective, settings

    def likelihood(self, purpose: str) -> RobustObjective:
        """Refuse: a sum over the whole image has no noise to be measured by.

        Raises:
            InputError: always.
        """
        raise InputError(
            f'{purpose} needs the robust loss, not {self.objective.loss!r}: a whole-image loss '
            'has no likelihood; use the loss robust, which is the default'
        )

    def run(self, start: FloatArray, on_iteration: OnIteration) -> FitEnd:
        """Fit from one start."""
        gap = self.objective.gap(start)
        return FitEnd(self._minimise(start, on_iteration), gap)

    def doubts(self, coordinates: FloatArray) -> Doubts:
        """Return none: the paper takes the mesh as it is."""
        return Doubts(np.zeros_like(coordinates))

    def _minimise(self, start: FloatArray, on_iteration: OnIteration) -> Minimum:
        model, settings = self.objective.model, self._settings
        bounds, longest = model.parameters.bounds(), longest_steps(model.parameters)
        if settings.optimizer == 'adam_demon':
            return minimise_with_demon(
                self.objective,
                start,
                bounds,
                learning_rates(model, start, _ADAM_FRACTION * longest),
                max_iterations=settings.max_iterations or 100,
                on_iteration=on_iteration,
            )
        return minimise(
            self.objective,
            start,
            bounds,
            longest,
            max_iterations=settings.max_iterations or 30,
            max_doublings=_DOUBLINGS,
            is_boxed=model.is_moving,
            on_iteration=on_iteration,
        )
