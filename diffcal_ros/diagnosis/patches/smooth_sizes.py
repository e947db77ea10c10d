# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Patches as they are known if a sensor's smooth error is larger than is believed."""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.diagnosis.patches.noise_model import kernel, NoiseModel
from diffcal_ros.diagnosis.patches.patch_group import PatchGroup
from diffcal_ros.diagnosis.patches.smooth_error import log_belief
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# By which it may be larger.
_FACTORS = (1.0, 1.5, 2.2, 3.3, 5.0)


def size_factors(noises: Sequence[NoiseModel]) -> tuple[float, ...]:
    """Return by what factors smooth errors may be larger than is believed.

    What a scene states was measured on a target, and may be misstated; and beside its effects a
    model is off by what is smooth, too, whatever the sensor does. What was not measured is
    guessed large.

    Args:
        noises: of all views.
    """
    return _FACTORS if all(noise.is_measured for noise in noises) else (1.0,)


def log_beliefs(noises: Sequence[NoiseModel], factors: Sequence[float]) -> FloatArray:
    """Return the log of how much is believed in each factor beforehand, shape (f,).

    Sizes are believed by the one that is usual, those of sensors whose error is stated by that.

    Args:
        noises: of all views.
        factors: by which smooth errors are larger than is believed of them.
    """
    if len(factors) == 1:
        return np.zeros(1)
    usual = max(1.0 if n.is_stated else n.smooth / NoiseModel.smooth for n in noises)
    believed = log_belief(usual * np.array(factors))
    return np.asarray(believed - np.logaddexp.reduce(believed))


def with_larger_error(
    groups: Sequence[PatchGroup], noises: Sequence[NoiseModel], factor: float
) -> list[PatchGroup]:
    """Return patches as they are known if smooth errors of depth are larger by a factor.

    Args:
        groups: of all views.
        noises: by which their patches were averaged.
        factor: 1 or more.
    """
    if factor == 1.0:
        return list(groups)
    return [
        _with_larger(own, noises[own.view], factor) if own.kind == 'depth' else own
        for own in groups
    ]


def _with_larger(group: PatchGroup, noise: NoiseModel, factor: float) -> PatchGroup:
    patches = group.patches
    more = (factor**2 - 1.0) * (1.0 - noise.standing) * noise.smooth**2
    shared = more * kernel(patches.centers, noise.smooth_length, is_mixed=noise.is_mixed)
    standing = patches.standing
    return replace(
        group,
        patches=replace(
            patches,
            covariance=patches.covariance + (1.0 - noise.common) * shared,
            common=patches.common.of(factor * patches.common.spread),
            standing=None if standing is None else standing.of(factor * standing.spread),
        ),
    )
