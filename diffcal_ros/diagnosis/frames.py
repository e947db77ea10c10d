# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the numbers of an effect refer to: a point turned about, axes, a normal."""

from collections.abc import Mapping

from diffcal_ros.calibration.effect_model import plane_normal
from diffcal_ros.calibration.forward_model import ForwardModel
from diffcal_ros.rigid_motion import tilt_axes
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Frame = dict[str, list[float]]


def frame_of(identifier: str, model: ForwardModel, coordinates: FloatArray) -> Frame:
    """Return points [m] and unit vectors, each of three numbers, by name.

    `camera_offset` moves the body as the depth camera sees it (the camera itself is off by the
    inverse) and turns `about` a point in that camera's frame. `clamp_offset` turns `about` a point
    in the object's frame, and `a` and `b` of `rest_curvature` are axes in it. `gravity_tilt` turns
    about `a` and `b` in the world; the `normal` of `contact_plane` is given there, too. Other
    effects have no frame.

    Args:
        identifier: of the effect.
        model: that has it.
        coordinates: of the model's parameters, shape (k,).
    """
    if identifier == 'camera_offset':
        return _listed(about=model.cameras.offset_pivot)
    axes = model.effects.object_axes(0)
    if identifier == 'clamp_offset':
        return _listed(about=axes.center)
    if identifier == 'rest_curvature':
        return _listed(a=axes.axes[1], b=axes.axes[2])
    gravity = model.scene.observations[0].gravity
    if identifier == 'gravity_tilt':
        first, second = tilt_axes(gravity)
        return _listed(a=first, b=second)
    if identifier == 'contact_plane':
        plane: Mapping[str, float] = model.effects.amplitudes(coordinates)['contact_plane']
        return _listed(normal=plane_normal(gravity, plane))
    return {}


def _listed(**vectors: FloatArray) -> Frame:
    return {name: [round(float(x), 9) for x in vector] for name, vector in vectors.items()}
