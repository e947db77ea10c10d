# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How well models explain patches whose noise was not measured: its size is each model's own.

Where frames were not repeated the floor is a guess, and what a LIDAR reads of silicone is off by
far more, here and there by centimetres. Squares in units of the guess then rank models by their
few worst patches. Residuals are taken to be Student's t of four degrees of freedom in place of
that, of a size that each model finds for itself (Lange, Little and Taylor, *Robust statistical
modeling using the t distribution*, J. Am. Stat. Assoc. 84, 1989), and an amplitude costs half the
logarithm of the number of patches (Schwarz, *Estimating the dimension of a model*, Ann. Stat. 6,
1978).
"""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.patches.whitened import Part, residuals_by_patch
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_FREEDOM = 4.0
# Sizes of what is left that are tried [m].
_SIZES = np.geomspace(2e-5, 5e-2, 200)


def ranked(models: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Return models with their log evidence on the patches that all of them see, in their order.

    Args:
        models: of one nominal model whose floor is a guess.
    """
    seen = [residuals_by_patch(model.fit.groups, Part.FIT) for model in models]
    common = sorted(set.intersection(*map(set, seen))) if seen else []
    if not common:
        return list(models)
    levels = [log_density(np.array([own[name] for name in common])) for own in seen]
    return [
        replace(model, guessed=level - 0.5 * np.log(len(common)) * model.amplitude_count)
        for model, level in zip(models, levels, strict=True)
    ]


def log_density(residuals: FloatArray) -> float:
    """Return the log density of residuals of the likeliest size, up to a constant.

    Args:
        residuals: [m], shape (n,).
    """
    scaled = residuals[:, None] / _SIZES
    levels = -np.log(_SIZES) - 0.5 * (_FREEDOM + 1.0) * np.log1p(scaled**2 / _FREEDOM)
    return float(levels.sum(axis=0).max())
