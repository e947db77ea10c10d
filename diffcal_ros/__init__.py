# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Find a soft body's simulator parameters from depth images, with error bars.

The names listed here are the public ones; `docs/api.md` describes them. What else the subpackages
hold may change from one version to the next.

>>> from diffcal_ros import calibrate, load_scene, open_inputs  # doctest: +SKIP
>>> inputs = open_inputs(load_scene('scene.yaml'), ['recording'])  # doctest: +SKIP
>>> result = calibrate(inputs.scene, inputs.observations)  # doctest: +SKIP
>>> result['youngs_modulus'].value  # doctest: +SKIP
"""

from importlib import import_module
from typing import Any, TYPE_CHECKING

if TYPE_CHECKING:
    from diffcal_ros.calibration.calibrate import calibrate as calibrate
    from diffcal_ros.calibration.calibrate import Calibration as Calibration
    from diffcal_ros.calibration.observations.observation import Observation as Observation
    from diffcal_ros.calibration.results.outcome import Outcome as Outcome
    from diffcal_ros.calibration.results.result import CalibrationResult as CalibrationResult
    from diffcal_ros.calibration.results.result import save_result as save_result
    from diffcal_ros.calibration.settings import CalibrationSettings as CalibrationSettings
    from diffcal_ros.camera import PinholeCamera as PinholeCamera
    from diffcal_ros.damping import Damping as Damping
    from diffcal_ros.depth.tracer import DepthTracer as DepthTracer
    from diffcal_ros.diagnosis.answers import Verdict as Verdict
    from diffcal_ros.diagnosis.diagnose import diagnose as diagnose
    from diffcal_ros.diagnosis.settings import DiagnosisSettings as DiagnosisSettings
    from diffcal_ros.diagnosis.verdict.verdict import Diagnosis as Diagnosis
    from diffcal_ros.diagnosis.verdict.verdict import save_verdict as save_verdict
    from diffcal_ros.errors import InputError as InputError
    from diffcal_ros.fem.elements.element import Element as Element
    from diffcal_ros.fem.motion.inputs import Release as Release
    from diffcal_ros.fem.motion.moving_body import MovingBody as MovingBody
    from diffcal_ros.fem.statics.force_changes import Change as Change
    from diffcal_ros.fem.statics.static_body import StaticBody as StaticBody
    from diffcal_ros.fem.terms.conditions import Conditions as Conditions
    from diffcal_ros.material import LameConvention as LameConvention
    from diffcal_ros.material import Material as Material
    from diffcal_ros.offline.calibrate_recordings import open_inputs as open_inputs
    from diffcal_ros.recording.bag_reader import open_recording as open_recording
    from diffcal_ros.scene.load import load_scene as load_scene
    from diffcal_ros.scene.model import Scene as Scene
    from diffcal_ros.scene.save import save_fitted_scene as save_fitted_scene
    from diffcal_ros.synthetic.recorder import record as record
    from diffcal_ros.synthetic.recorder import RecorderSettings as RecorderSettings
    from diffcal_ros.tet_mesh import TetMesh as TetMesh

__version__ = '0.1.0'

# Imported when first used: `diffcal --help` must not wait for SciPy and Warp. Type checkers read
# the imports above, and a test holds the two together.
_HOMES = {
    # A set-up.
    'load_scene': 'scene.load',
    'save_fitted_scene': 'scene.save',
    'Scene': 'scene.model',
    # Recordings.
    'Observation': 'calibration.observations.observation',
    'open_inputs': 'offline.calibrate_recordings',
    'open_recording': 'recording.bag_reader',
    # Fits.
    'calibrate': 'calibration.calibrate',
    'Calibration': 'calibration.calibrate',
    'CalibrationResult': 'calibration.results.result',
    'CalibrationSettings': 'calibration.settings',
    'Outcome': 'calibration.results.outcome',
    'save_result': 'calibration.results.result',
    # What a model lacks.
    'diagnose': 'diagnosis.diagnose',
    'Diagnosis': 'diagnosis.verdict.verdict',
    'DiagnosisSettings': 'diagnosis.settings',
    'save_verdict': 'diagnosis.verdict.verdict',
    'Verdict': 'diagnosis.answers',
    # Bodies.
    'Change': 'fem.statics.force_changes',
    'Conditions': 'fem.terms.conditions',
    'Damping': 'damping',
    'Element': 'fem.elements.element',
    'LameConvention': 'material',
    'Material': 'material',
    'MovingBody': 'fem.motion.moving_body',
    'Release': 'fem.motion.inputs',
    'StaticBody': 'fem.statics.static_body',
    'TetMesh': 'tet_mesh',
    # Depth images.
    'DepthTracer': 'depth.tracer',
    'PinholeCamera': 'camera',
    # Recordings of a body that is simulated.
    'record': 'synthetic.recorder',
    'RecorderSettings': 'synthetic.recorder',
    # Errors.
    'InputError': 'errors',
}
__all__ = ['__version__', *_HOMES]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    return getattr(import_module(f'{__name__}.{_HOMES[name]}'), name)


def __dir__() -> list[str]:
    return sorted(__all__)
