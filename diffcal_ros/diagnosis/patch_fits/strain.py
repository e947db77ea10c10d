# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What hides in parameters, or camera poses, of which better is known."""

from collections.abc import Collection

from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.chi_square import chance_beyond, exceeded_with
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_group import moved, PatchGroup
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# A parameter so many standard deviations from what is known of it is strained; and a pose is
# that is as unlikely.
_STRAINED = 3.0
_UNLIKELY = float(chance_beyond(_STRAINED**2, 1))


def unstrained(fit: Refit, nominal: ParameterSet | None = None) -> list[PatchGroup]:
    """Return the patches as they would be if nothing strained its prior, to first order.

    An effect may hide in a parameter of which better is known, and one of the camera in its pose:
    the gap is then small, and the parameter absurd. What a model has besides hides nothing: how
    large an effect usually is says nothing of how large it may be.

    Args:
        fit: of a model.
        nominal: parameters of the model without what was added; None: nothing was.
    """
    beyond = _beyond(fit, nominal or fit.parameters)
    if not beyond.any():
        return fit.groups
    return moved(fit.groups, -beyond)


def is_strained(fit: Refit) -> bool:
    """Tell whether a parameter or a camera pose is farther from what is known than likely."""
    return bool(_beyond(fit, fit.parameters).any())


def _beyond(fit: Refit, nominal: ParameterSet) -> FloatArray:
    """Return how far coordinates are beyond what is known of them, shape (k,)."""
    known = frozenset(nominal.names)
    return _parameters_beyond(fit, known) + _poses_beyond(fit.parameters, fit.coordinates)


def _parameters_beyond(fit: Refit, known: Collection[str]) -> FloatArray:
    beyond = np.zeros(len(fit.coordinates))
    for index, parameter in enumerate(fit.parameters):
        mean, std = parameter.quantity.prior_mean, parameter.quantity.prior_std
        if mean is None or std is None or parameter.is_nuisance or parameter.name not in known:
            continue
        allowed = _STRAINED * (std / mean if parameter.is_logarithmic else std)
        here, _ = fit.of_the_body(index)
        offset = here - parameter.coordinate(mean)
        beyond[index] = offset - np.clip(offset, -allowed, allowed)
    return beyond


def _poses_beyond(parameters: ParameterSet, coordinates: FloatArray) -> FloatArray:
    """Return how far camera poses are off, beyond what their covariances allow, shape (k,)."""
    beyond = np.zeros(len(coordinates))
    for observation, covariance in parameters.pose_covariances:
        indices = parameters.pose_indices(observation)
        offset = coordinates[indices]
        size = float(np.sqrt(offset @ np.linalg.solve(covariance, offset)))
        allowed = float(np.sqrt(exceeded_with(_UNLIKELY, len(indices))))
        if size > allowed:
            beyond[indices] = (1.0 - allowed / size) * offset
    return beyond
