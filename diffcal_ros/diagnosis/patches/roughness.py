# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How far single patches of depth are off by themselves, measured on the patches.

Repeated frames tell what flickers in a pixel; an error that stands in the image from frame to
frame, and that no two patches share, only neighbouring patches tell. What parameters, the mesh or
any smooth cause may have put there is projected out first, so that an effect that the model lacks
is not taken for noise: restricted maximum likelihood (Patterson and Thompson 1971), with a prior.
"""

from collections.abc import Collection, Sequence
from dataclasses import replace

from diffcal_ros.diagnosis.patches.noise_model import NoiseModel
from diffcal_ros.diagnosis.patches.patch_group import of_the_body, PatchGroup
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Sizes that are tried, by the one assumed; the prior's spread of their logarithm.
_FRACTIONS = np.geomspace(0.1, 4.0, 60)
# What is believed at least and at most, by the one assumed: a large effect that is not smooth
# would pass for noise.
_LEAST, _MOST = 0.2, 1.0
_SPREAD = np.log(2.0)
# Causes are taken to vary over the image as polynomials up to this degree.
_DEGREE = 3
# Fewer directions beside those say nothing.
_FEWEST = 4


def measured_noises(
    noises: Sequence[NoiseModel], groups: Sequence[PatchGroup], still: Collection[int]
) -> tuple[NoiseModel, ...]:
    """Return the noise of every view with the roughness that its patches show.

    Of one sensor, so one figure for all views of bodies at rest whose frames were repeated. The
    others keep theirs: in a motion, what the model lacks is rough as well.

    Args:
        noises: of every view, as assumed.
        groups: of the nominal fit with that noise.
        still: views of bodies at rest.
    """
    quiet = {view for view in still if noises[view].is_measured}
    if not quiet:
        return tuple(noises)
    assumed = noises[min(quiet)].rough
    found = measured_roughness([group for group in groups if group.view in quiet], assumed)
    rough = float(np.clip(found, _LEAST * assumed, _MOST * assumed))
    return tuple(
        replace(noise, rough=rough) if view in quiet else noise
        for view, noise in enumerate(noises)
    )


def measured_roughness(groups: Sequence[PatchGroup], assumed: float) -> float:
    """Return the error of depth that no two patches share [m].

    Args:
        groups: of the nominal fit; their covariances hold the error that was assumed.
        assumed: one standard deviation [m]; the median of the prior.
    """
    sizes = assumed * _FRACTIONS
    level = -0.5 * (np.log(_FRACTIONS) / _SPREAD) ** 2
    for group in of_the_body(groups):
        if group.kind == 'depth':
            level = level + log_likelihoods(group, assumed, sizes)
    chances = np.exp(level - level.max())
    return float(np.sqrt(chances @ sizes**2 / chances.sum()))


def log_likelihoods(group: PatchGroup, assumed: float, sizes: FloatArray) -> FloatArray:
    """Return the restricted log likelihood of sizes of the error [m], one group's part of it."""
    patches = group.patches
    if len(patches.values) < _FEWEST:
        return np.zeros_like(sizes)
    beside = _beside(np.column_stack([patches.jacobian, group.mesh, _smooth(patches.centers)]))
    if beside.shape[1] < _FEWEST:
        return np.zeros_like(sizes)
    shared = patches.covariance + patches.common.covariance(patches.centers)
    others = shared - assumed**2 * np.eye(len(patches.values))
    known, directions = np.linalg.eigh(beside.T @ others @ beside)
    squares = (directions.T @ (beside.T @ patches.values)) ** 2
    variances = np.maximum(known, 0.0) + sizes[:, None] ** 2
    return np.asarray(-0.5 * (np.log(variances) + squares / variances).sum(axis=1))


def _smooth(centers: FloatArray) -> FloatArray:
    """Return polynomials of places in the image, shape (n, 10)."""
    reach = max(float(np.ptp(centers, axis=0).max(initial=0.0)), 1.0)
    x, y = 2.0 * (centers - centers.mean(axis=0)).T / reach
    powers = [(i, j) for i in range(_DEGREE + 1) for j in range(_DEGREE + 1 - i)]
    return np.column_stack([x**i * y**j for i, j in powers])


def _beside(columns: FloatArray) -> FloatArray:
    """Return an orthonormal basis of all that is orthogonal to the columns, shape (n, m)."""
    lengths = np.linalg.norm(columns, axis=0)
    scaled = columns[:, lengths > 0.0] / lengths[lengths > 0.0]
    left, spans, _ = np.linalg.svd(scaled, full_matrices=True)
    return np.asarray(left[:, int((spans > 1e-9 * spans.max(initial=0.0)).sum()) :])
