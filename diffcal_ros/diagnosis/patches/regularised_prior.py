# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is known of the parameters before any data, wide where nothing is stated."""

from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.calibration.uncertainty.uncertainty import natural_scales
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def regularised_prior(parameters: ParameterSet) -> tuple[FloatArray, FloatArray]:
    """Return mean and precision of the prior; where none is given, a wide one at the start."""
    mean, precision = parameters.prior()
    scales = natural_scales(parameters)
    for index, value in enumerate(np.diag(precision)):
        if value == 0.0:
            precision[index, index] = 1.0 / scales[index] ** 2
            mean[index] = parameters.start()[index]
    return mean, precision
