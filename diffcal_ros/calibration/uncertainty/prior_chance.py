# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whether a fit stands where the scene says that body and cameras are."""

from diffcal_ros.calibration.parameters.parameters import ParameterSet, PLACING
from diffcal_ros.chi_square import chance_beyond
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def placement_chance(parameters: ParameterSet, coordinates: FloatArray) -> float:
    """Return the chance that placement and poses lie so far off what is stated, or farther.

    It is that of chi-square under the priors alone: the data pull a fit away from them, and a
    model that lacks something, or a wrong pose, pulls without limit. 1 where nothing is stated.

    Args:
        parameters: with their priors.
        coordinates: where the fit ended, shape (k,).
    """
    prior = parameters.prior()
    indices = [
        index
        for index, parameter in enumerate(parameters)
        if parameter.kind in PLACING and prior.precision[index, index] > 0.0
    ]
    if not indices:
        return 1.0
    off = (np.asarray(coordinates) - prior.mean)[indices]
    return float(
        chance_beyond(off @ prior.precision[np.ix_(indices, indices)] @ off, len(indices))
    )
