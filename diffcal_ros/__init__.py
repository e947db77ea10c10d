# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Find a soft body's simulator parameters from depth images, with error bars.

>>> from diffcal_ros import calibrate, load_scene, open_inputs  # doctest: +SKIP
>>> inputs = open_inputs(load_scene('scene.yaml'), ['recording'])  # doctest: +SKIP
>>> result = calibrate(inputs.scene, inputs.observations)  # doctest: +SKIP
>>> result['youngs_modulus'].value  # doctest: +SKIP
"""

from importlib import import_module
from typing import Any

__version__ = '0.1.0'

# Imported when first used: `diffcal --help` must not wait for SciPy and Warp.
_HOMES = {
    'Calibration': 'calibration.calibrate',
    'CalibrationResult': 'calibration.result',
    'CalibrationSettings': 'calibration.settings',
    'InputError': 'errors',
    'Observation': 'calibration.observation',
    'Scene': 'scene.model',
    'calibrate': 'calibration.calibrate',
    'load_scene': 'scene.load',
    'open_inputs': 'offline.calibrate_recordings',
    'open_recording': 'recording.bag_reader',
    'save_result': 'calibration.result',
}
__all__ = ['__version__', *_HOMES]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    return getattr(import_module(f'{__name__}.{_HOMES[name]}'), name)


def __dir__() -> list[str]:
    return sorted(__all__)
