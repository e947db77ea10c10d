# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Coordinates and their errors as values, standard errors and intervals in SI units."""

from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.calibration.results.result import FittedParameter
from diffcal_ros.calibration.uncertainty.uncertainty import MESH_SHIFT_FACTOR, Uncertainty, Z_95
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# No interval reaches further in a coordinate: what is not known is not known.
_WIDEST = 50.0


def fitted_parameters(
    parameters: ParameterSet, coordinates: FloatArray, uncertainty: Uncertainty
) -> tuple[FittedParameter, ...]:
    """Turn coordinates and their errors into values and standard errors."""
    lower, upper = parameters.bounds()
    fitted = []
    for index, parameter in enumerate(parameters):
        value = parameter.value(coordinates[index])
        fine, error = coordinates[index], uncertainty.standard_errors[index]
        if parameter.is_logarithmic:  # Of a placement the whole mesh error is doubt.
            fine += np.clip(uncertainty.fine_shift[index], -_WIDEST, _WIDEST)
            error = uncertainty.fine_errors[index]
        reach = min(Z_95 * error, _WIDEST)
        rate = value if parameter.is_logarithmic else 1.0
        fitted.append(
            FittedParameter(
                name=parameter.name,
                value=value,
                std_error=float(rate * uncertainty.standard_errors[index]),
                mesh_error=float(rate * abs(MESH_SHIFT_FACTOR * uncertainty.mesh_shift[index])),
                unit=parameter.unit,
                start=parameter.quantity.start,
                at_bound=bool(
                    coordinates[index] <= lower[index] or coordinates[index] >= upper[index]
                ),
                is_nuisance=parameter.is_nuisance,
                fine_value=parameter.value(fine),
                interval_95=(parameter.value(fine - reach), parameter.value(fine + reach)),
            )
        )
    return tuple(fitted)
