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
from diffcal_ros.diagnosis.patches.patch_gap import residuals_by_patch
from diffcal_ros.diagnosis.patches.patch_group import PatchName
from diffcal_ros.diagnosis.patches.whitened import Part
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_FREEDOM = 4.0
# Sizes of what is left that are tried [m].
_SIZES = np.geomspace(2e-5, 5e-2, 200)
# The same in floors that are a guess.
_RELATIVE_SIZES = np.geomspace(0.05, 1e3, 200)


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


def predicts_better(one: Hypothesis, other: Hypothesis) -> float:
    """Return by how much more log density another model gives to held-out patches.

    Sizes are those of what each leaves on the patches that it was fitted to.

    Args:
        one: fitted model.
        other: another one of the same nominal model.
    """
    told = [_told(model) for model in (one, other)]
    common = sorted(told[0].keys() & told[1].keys())
    before, after = (sum(own[name] for name in common) for own in told)
    return float(after - before)


def noise_scale(whitened: FloatArray) -> float:
    """Return by how much the variances of amplitudes exceed those by a guessed floor.

    Of an amplitude Student's t of four degrees of freedom and size s tells as much as a Gaussian
    of variance 7/5 s^2: its Fisher information is (f + 1) / (f + 3) / s^2. A few patches that are
    off by centimetres make no amplitude less sure.

    Args:
        whitened: what is left of patches in units of the floor, shape (n,).
    """
    size = _likeliest(whitened, _RELATIVE_SIZES)
    return max(1.0, (_FREEDOM + 3.0) / (_FREEDOM + 1.0) * size**2)


def log_density(residuals: FloatArray) -> float:
    """Return the log density of residuals of the likeliest size, up to a constant.

    Args:
        residuals: [m], shape (n,).
    """
    return float(_log_densities(residuals, _SIZES).sum(axis=0).max())


def _told(model: Hypothesis) -> dict[PatchName, float]:
    """Return the log densities of a model's held-out patches by their names."""
    fitted = residuals_by_patch(model.fit.groups, Part.FIT)
    size = _likeliest(np.array(list(fitted.values())), _SIZES)
    held_out = residuals_by_patch(model.fit.groups, Part.REPORT)
    densities = _log_densities(np.array(list(held_out.values())), np.array([size]))
    return dict(zip(held_out, densities[:, 0].tolist(), strict=True))


def _likeliest(residuals: FloatArray, sizes: FloatArray) -> float:
    """Return the likeliest size of residuals, shape (n,)."""
    return float(sizes[_log_densities(residuals, sizes).sum(axis=0).argmax()])


def _log_densities(residuals: FloatArray, sizes: FloatArray) -> FloatArray:
    """Return log densities of residuals, shape (n,), by size, up to a constant, shape (n, s)."""
    scaled = residuals[:, None] / sizes
    tails = -0.5 * (_FREEDOM + 1.0) * np.log1p(scaled**2 / _FREEDOM)
    return np.asarray(tails - np.log(sizes))
