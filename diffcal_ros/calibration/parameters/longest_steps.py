# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How far one step of an optimiser may move each kind of parameter."""

from diffcal_ros.calibration.parameters.parameters import Kind, Parameter, ParameterSet
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_LONGEST_STEPS = {
    Kind.YOUNGS_MODULUS: 0.7,
    Kind.DENSITY: 0.7,
    Kind.DAMPING: 0.7,
    Kind.RELEASE_TIME: 0.03,
    Kind.POISSONS_RATIO: 0.05,
    Kind.REST_LENGTH: 0.01,
    Kind.CABLE_STIFFNESS: 1.0,
    Kind.GRAVITY_TILT: 0.1,
    Kind.EDGE_BIAS: 2.0,
}
_LONGEST_SHIFT, _LONGEST_TURN = 0.03, 0.15


def longest_steps(parameters: ParameterSet) -> FloatArray:
    """Return how far one step may move each coordinate, shape (k,)."""
    return np.array([_longest_step(parameter) for parameter in parameters])


def _longest_step(parameter: Parameter) -> float:
    if parameter.component is not None:
        return parameter.component.longest_step * parameter.component.scale
    usual = _LONGEST_SHIFT if parameter.axis < 3 else _LONGEST_TURN
    return _LONGEST_STEPS.get(parameter.kind, usual)
