# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Learning rates of the paper's Adam follow from the model: nobody has to try them."""

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.calibration.whole_image.demon import learning_rates
import numpy as np
import pytest
from support.scenes import beam_scene, GRAVITY, observation, true_depth

_MILLIMETRE = 1e-3
# Of a step's linear prediction: the sag of this soft beam bends away from it by a few percent.
_STRAIGHT = 0.1


def _calibration(**changes) -> Calibration:
    scene = beam_scene(fit=('youngs_modulus', 'rigid_offset'), **changes)
    return Calibration(scene, [observation(true_depth())], CalibrationSettings(loss='l1'))


def test_a_step_of_each_parameter_moves_the_body_by_a_millimetre() -> None:
    calibration = _calibration()
    start = calibration.coordinates
    far = np.full(len(start), np.inf)
    rates = learning_rates(calibration.model, start, far)
    before = calibration.model.views(start)[0].points.copy()
    for place, rate in enumerate(rates):
        step = np.zeros_like(start)
        step[place] = rate
        after = calibration.model.views(start + step)[0].points
        moved = np.sqrt(((after - before) ** 2).sum(axis=1).mean())
        assert moved == pytest.approx(_MILLIMETRE, rel=_STRAIGHT)


def test_a_body_that_hardly_moves_gets_the_longest_step() -> None:
    calibration = _calibration(gravity=1e-3 * GRAVITY)
    longest = np.full(len(calibration.coordinates), 0.07)
    rates = learning_rates(calibration.model, calibration.coordinates, longest)
    assert rates[0] == 0.07
    assert rates[1] == pytest.approx(_MILLIMETRE)
