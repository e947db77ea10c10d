# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How a live calibration goes."""

from dataclasses import dataclass, field, replace

from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.live.tracking import TrackingSettings
from diffcal_ros.scene.model import Scene

REFITS = ('once', 'continuous', 'tracking')
# How the sensor's driver rounds depth: as the scene says, or step [m] and mode.
DEPTH_QUANTIZATIONS = {
    'scene': None,
    'none': (0.0, 'round'),
    'round_millimetres': (0.001, 'round'),
    'truncate_millimetres': (0.001, 'truncate'),
}


@dataclass(frozen=True)
class SessionSettings:
    """How a live calibration goes.

    Attributes:
        fit: how to fit.
        pose_source: see `inputs.POSE_SOURCES`.
        observation: which of the scene's postures is in view; empty for the first.
        window_frames: frames that are fused.
        window_seconds: after so long fewer will do [s].
        refit: 'once'; 'continuous': each new window starts a fit from the last values; or
            'tracking': after a fit every frame moves the values.
        depth_quantization: one of `DEPTH_QUANTIZATIONS`.
    """

    fit: CalibrationSettings = field(default_factory=CalibrationSettings)
    pose_source: str = 'scene'
    observation: str = ''
    window_frames: int = 31
    window_seconds: float = 2.0
    refit: str = 'once'
    depth_quantization: str = 'scene'
    tracking: TrackingSettings = field(default_factory=TrackingSettings)


def with_quantization(scene: Scene, name: str) -> Scene:
    """Return the scene with another rounding of depth, see `DEPTH_QUANTIZATIONS`."""
    chosen = DEPTH_QUANTIZATIONS[name]
    if chosen is None:
        return scene
    step, mode = chosen
    # What is stated here is not asked of the images.
    sensor = replace(scene.sensor, quantization=step, quantization_mode=mode, driver_step=0.0)
    return replace(scene, sensor=sensor)
