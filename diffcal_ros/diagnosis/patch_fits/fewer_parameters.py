# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where the fit of a smaller model ends, told from that of a larger one: nothing is simulated."""

from dataclasses import replace

from diffcal_ros.diagnosis.patch_fits.patch_fit import prior_of
from diffcal_ros.diagnosis.patch_fits.refit import ended, Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.patches.patch_group import moved, PatchGroup
from diffcal_ros.diagnosis.patches.whitened import Part, whiten
from diffcal_ros.least_squares.gauss_newton import gauss_newton_step
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# The first step is exact where all is linear, but for bounds and for how little a patch counts
# that is far off.
_STEPS = 3


def fitted_with_fewer(fit: Refit, evaluator: PatchEvaluator) -> Refit:
    """Return where a model's fit ends without some of its parameters, to first order.

    Exact where the patches follow the parameters linearly between the two ends; a parameter that
    is far from zero there makes the smaller model look worse than it is, or better, by what the
    tangents miss.

    Args:
        fit: of the larger model.
        evaluator: of the smaller one; the parameters that it lacks are zero in it.

    Raises:
        ValueError: when the smaller model has a parameter of its own.
    """
    parameters = evaluator.model.parameters
    lacking = set(parameters.names) - set(fit.parameters.names)
    if lacking:
        raise ValueError(f'the larger model lacks {sorted(lacking)}: it must have all parameters')
    kept = np.array([fit.parameters.names.index(name) for name in parameters.names])
    gone = np.setdiff1d(np.arange(len(fit.coordinates)), kept)
    step = np.zeros_like(fit.coordinates)
    step[gone] = -fit.coordinates[gone]
    groups = [_with_columns(group, kept) for group in moved(fit.groups, step)]
    here, prior, bounds = fit.coordinates[kept], prior_of(evaluator), parameters.bounds()
    is_stated = np.diag(parameters.prior().precision) != 0.0
    for _ in range(_STEPS):
        told = whiten(groups, Part.FIT).equations()
        step = gauss_newton_step(told.under(prior, here), here, *bounds)
        # The wide prior that stands in for none would lead what neither data nor the scene tell of
        # to where nobody has said that it is: a plane that touches nowhere through the body.
        is_told = is_stated | (np.diag(told.curvature) != 0.0)
        there = np.where(is_told, np.clip(here + step, *bounds), here)
        groups, here = moved(groups, there - here), there
    seen = whiten(groups, Part.FIT)
    return ended(evaluator, here, groups, seen, promise=0.0, evaluations=0, is_converged=True)


def _with_columns(group: PatchGroup, kept: IntArray) -> PatchGroup:
    patches = group.patches
    return replace(group, patches=replace(patches, jacobian=patches.jacobian[:, kept]))
