# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A beam of two halves, seen by a noisy camera, to be fitted as one."""

from functools import cache

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.field.fit import FieldFit, fit_field
from diffcal_ros.calibration.field.layout import FieldKind
from diffcal_ros.calibration.settings import CalibrationSettings
import numpy as np

from support.beams import beam_mesh
from support.scenes import beam_scene, noisy, observation, SIZE, true_depth

STIFF, SOFT = 150e3, 50e3
QUICK = CalibrationSettings(with_mesh_error=False, search=False)
FIT = ('youngs_modulus', 'rigid_offset')
_COUNTS = (14, 4, 3)


@cache
def two_halves_depth() -> np.ndarray:
    """Depth of the beam whose clamped half is stiff, from a finer mesh, with noise."""
    centroids = beam_mesh(_COUNTS, SIZE).centroids
    truth = np.where(centroids[:, 0] < 0.5 * SIZE[0], STIFF, SOFT)
    return noisy(true_depth(truth, counts=_COUNTS), np.random.default_rng(4))


@cache
def fitted_halves(spacing: float | None = None) -> tuple[Calibration, FieldFit]:
    """The beam fitted as one region, and a field beside it."""
    scene = beam_scene((8, 2, 2), modulus=80e3, fit=FIT)
    calibration = Calibration(scene, [observation(two_halves_depth())], QUICK)
    uniform = calibration.run()
    return calibration, fit_field(calibration, uniform, FieldKind(spacing))


def log_truth(calibration: Calibration) -> np.ndarray:
    """The true log modulus at the fitted mesh's tetrahedra, shape (T,)."""
    along = calibration.scene.mesh.centroids[:, 0]
    truth: np.ndarray = np.log(np.where(along < 0.5 * SIZE[0], STIFF, SOFT))
    return truth


def area_under_curve(values: np.ndarray, is_high: np.ndarray) -> float:
    """Return how often a value of one class is above one of the other."""
    high, low = values[is_high], values[~is_high]
    above = (high[:, None] > low).mean() + 0.5 * (high[:, None] == low).mean()
    return float(above)
