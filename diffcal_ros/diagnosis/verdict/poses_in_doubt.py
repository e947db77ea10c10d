# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What parameters are known to, where camera poses may be better or worse than is stated of them.

A covariance of poses is stated to a factor of two or so, and a modulus that is told by how much a
body sags hangs on it. How much larger the errors are is told by how far poses had to go, and is
integrated out around the fit; its prior is log-normal.
"""

from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison.form_sizes import Products
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.smooth_error import log_belief
from diffcal_ros.diagnosis.patches.whitened import Part, whiten
import numpy as np

# By how much larger the errors of all poses may be than is stated.
_FACTORS = np.geomspace(0.5, 8.0, 9)


def with_poses_in_doubt(fit: Refit) -> Refit:
    """Return a fit whose covariance is about where it ended, the size of poses' errors unknown.

    It holds how far the fit would have gone with each size, too.
    """
    known = fit.parameters.pose_covariances
    places = [place for number, _ in known for place in fit.parameters.pose_indices(number)]
    if not places:
        return fit
    products = Products.of(fit, whiten(fit.groups, Part.FIT))
    levels, steps, covariances = [], [], []
    for factor in _FACTORS:
        sizes = np.ones(len(fit.coordinates))
        sizes[places] = factor
        levels.append(products.level(sizes))
        steps.append(products.step(sizes))
        covariances.append(products.covariance(sizes))
    believed = np.array(levels) + log_belief(_FACTORS)
    chances = np.exp(believed - np.logaddexp.reduce(believed))
    # What is left to go as stated is the fit's own affair.
    moved = np.array(steps) - products.step(np.ones(len(fit.coordinates)))
    outer = np.einsum('fi,fj->fij', moved, moved)
    found = np.einsum('f,fij->ij', chances, np.array(covariances) + outer)
    return replace(fit, covariance=found)
