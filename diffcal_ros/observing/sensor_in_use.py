# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The depth camera as its images show it: steps a driver made, and what contradicts the scene."""

from collections.abc import Sequence
from dataclasses import replace
import math

from diffcal_ros.calibration.observations.frame_noise import MEASURED_FRAMES
from diffcal_ros.calibration.observations.observation import FusedDepth
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.scene.model import DepthSensor
from diffcal_ros.scene.sections.depth_sensors import SENSOR_MODELS
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Values that are looked at; steps show in few.
_MOST_VALUES = 20_000
# Nearly all values lie on the steps of an image in steps: this share of them, this near in steps.
_NEARLY_ALL = 0.99
_ON_STEP = 0.05
# More than this share out of range is more than flying pixels.
_MANY = 0.05
# Data sheets state limits: a camera in order stays below, with room for dark or oblique surfaces.
_FAR_MORE_NOISE = 3.0


def sensor_in_use(
    sensor: DepthSensor,
    frames: Sequence[DepthFrame],
    fused: FusedDepth,
    camera: PinholeCamera,
    distance: float,
) -> tuple[DepthSensor, list[str]]:
    """Return the depth camera as these images need it, and what a person should know of it.

    Args:
        sensor: what the scene says.
        frames: images as they came, at least one.
        fused: what was made of them.
        camera: intrinsics of the depth images.
        distance: of the body along the optical axis [m].
    """
    if not sensor.model:
        return sensor, []
    known = SENSOR_MODELS[sensor.model]
    values = _values(frames)
    stated = known.noise_at(distance, camera.fx) if distance > 0.0 else sensor.noise
    notes = [*_range_notes(sensor, values), *_noise_notes(sensor, fused, stated)]
    used = replace(sensor, noise=max(stated, sensor.noise))
    if sensor.driver_step > 0.0 and _are_in_steps(values, sensor.driver_step):
        notes.append(
            f'depth comes in whole steps of {1e3 * sensor.driver_step:g} mm, which the ROS driver '
            f'of the {known.title} cuts it down to: half a step is put back; where yours rounds, '
            'state quantization_mode: round under sensor'
        )
        used = replace(used, quantization=sensor.driver_step, quantization_mode='truncate')
    elif sensor.quantization > 0.0 and not _are_in_steps(values, sensor.quantization):
        notes.append(
            f'depth lies between the steps of {1e3 * sensor.quantization:g} mm of a '
            f'{known.title}: it was filtered, or comes from another camera; correct '
            'sensor.model, or state sensor.quantization'
        )
        used = replace(used, quantization=0.0)
    return used, notes


def _values(frames: Sequence[DepthFrame]) -> FloatArray:
    """Return depths of the first image that holds any [m], shape (n,)."""
    for frame in frames:
        valid = frame.depth[np.isfinite(frame.depth)]
        if valid.size:
            return valid[:: max(1, valid.size // _MOST_VALUES)].astype(np.float64)
    return np.zeros(0)


def _are_in_steps(values: FloatArray, step: float) -> bool:
    """Tell whether depths are whole multiples of a step [m]."""
    steps = values / step
    return bool(np.mean(np.abs(steps - np.round(steps)) < _ON_STEP) > _NEARLY_ALL)


def _range_notes(sensor: DepthSensor, values: FloatArray) -> list[str]:
    outside = float(np.mean((values < sensor.nearest) | (values > sensor.farthest)))
    if outside <= _MANY:
        return []
    return [
        f'{outside:.0%} of the depth lies outside {sensor.nearest:g} to {sensor.farthest:g} m, '
        f'where a {SENSOR_MODELS[sensor.model].title} sees, and is left out: correct '
        'sensor.model, or state nearest and farthest under sensor'
    ]


def _noise_notes(sensor: DepthSensor, fused: FusedDepth, stated: float) -> list[str]:
    if fused.frame_count < MEASURED_FRAMES or not math.isfinite(fused.noise):
        return []
    single = fused.noise * math.sqrt(fused.frame_count)
    if single <= _FAR_MORE_NOISE * max(stated, sensor.noise):
        return []
    return [
        f"a pixel's depth varies by {1e3 * single:.2g} mm from frame to frame, and a "
        f'{SENSOR_MODELS[sensor.model].title} at the body by at most {1e3 * stated:.2g} mm: '
        'look at the light, the surface, or sensor.model'
    ]
