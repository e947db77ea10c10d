# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The gap on pixels that a fit has not seen: two fits, each to every other field of a chequer."""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.residuals.gap import Gap, measure_gap
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Fields are wider than errors of a depth camera stay alike, and many lie on a body [px].
_FIELD = 24


def chequered(observations: Sequence[Observation], parity: int) -> list[Observation]:
    """Return the observations without every other field of their images.

    Args:
        observations: whole.
        parity: 0 or 1: which fields are left out.
    """
    return [replace(item, left_out=_fields(item.depth.shape, parity)) for item in observations]


def held_out_gap(
    scene: Scene,
    observations: Sequence[Observation],
    settings: CalibrationSettings,
    start: FloatArray,
) -> Gap:
    """Measure the gap where neither of two fits looked.

    Args:
        scene: body, clamp, material, priors.
        observations: whole.
        settings: how to fit, with the robust loss.
        start: coordinates of a fit to everything, from where both fits go on, shape (k,).

    Raises:
        InputError: when a half of the pixels cannot be fitted.
    """
    quick = replace(settings, with_mesh_error=False, search=False)
    halves = [Calibration(scene, chequered(observations, parity), quick) for parity in (0, 1)]
    residuals, counted = [], []
    for fitted, other in (halves, halves[::-1]):
        fitted.go_to(start.copy())
        fitted.run()
        likelihood = other.likelihood('the gap on held-out fields')
        for comparison in likelihood.comparisons(fitted.coordinates):
            residuals.append(comparison.difference)
            counted.append(comparison.counted)
    return measure_gap(residuals, counted, scene.masks.truncation)


def _fields(shape: tuple[int, ...], parity: int) -> NDArray[np.bool_]:
    rows, columns = (np.arange(size) // _FIELD for size in shape)
    fields: NDArray[np.bool_] = (rows[:, None] + columns[None, :]) % 2 == parity
    return fields
