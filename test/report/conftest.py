# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One small calibration that the report's tests look at."""

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.results.result import CalibrationResult
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.offline.calibrate_recordings import open_inputs, run_calibration
from diffcal_ros.report.figures.observed_view import observed_views, ObservedView
from diffcal_ros.scene.load import load_scene
import pytest


@pytest.fixture(scope='session')
def fitted(recorded_beam, tmp_path_factory) -> tuple[Calibration, CalibrationResult]:
    """The recorded beam, modulus and offset fitted."""
    inputs = open_inputs(load_scene(recorded_beam.scene), [])
    settings = CalibrationSettings(fit=('youngs_modulus', 'rigid_offset'))
    return run_calibration(inputs, settings, tmp_path_factory.mktemp('fitted'))


@pytest.fixture(scope='session')
def view(fitted) -> ObservedView:
    """What the camera saw of it and what the simulator shows."""
    (only,) = observed_views(*fitted)
    return only
