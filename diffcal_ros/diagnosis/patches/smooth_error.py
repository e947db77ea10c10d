# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How large a sensor's smooth error is, over what it changes, and how much of it all poses share.

What a depth camera reads too far or too near varies smoothly over its picture, and most of that is
its own: it stands in the image in every pose, where a small scale of depth beside a larger effect
would look just like it. Its size is found on the patches, with all that parameters, mesh and every
effect of the library may have put there projected out (restricted maximum likelihood, Patterson
and Thompson 1971), so that what the model lacks is not taken for the sensor's.

Nor is all that is left smooth. Where tangents take most smooth ways, what edges leave beside them
would be the weak tail of a smooth error of millimetres; so all other noise may be larger than it
is known to be, too, and how much of either there is the data tell. A few patches that are far off
say nothing of either.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from itertools import product

from diffcal_ros.diagnosis.patches.noise_model import kernel, NoiseModel
from diffcal_ros.diagnosis.patches.patch_group import of_the_body, PatchGroup
from diffcal_ros.diagnosis.patches.whitened import more_by_far_off
from diffcal_ros.median_spread import median_spread
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, cholesky, solve_triangular

FloatArray = NDArray[np.float64]

# Sizes that are tried, by the one assumed; the prior's spread of their logarithm. Sensors that are
# better than assumed are not told from those whose error the parameters have followed. How much
# worse than assumed one may be the prior says alone: a camera twice as far away reads worse.
_SIZES = np.geomspace(0.25, 16.0, 49)
_SPREAD = np.log(2.0)
# What a scene states was measured on a target, and here are effects that tangents do not follow.
# That it may be misstated is for the verdict to ask, as of all that is stated.
_STATED = np.ones(1)
# Lengths by the one assumed, and shares of the variance that stand in the image of every pose.
_LENGTHS = (0.5, 1.0, 2.0)
_STANDING = (0.0, 0.5, 0.9)
# Whether it changes over one length or over lengths of all sizes: by the second alone, an error of
# one length is taken for a part of a larger one that changes over a longer length.
_MIXED = (False, True)
# By how much all other noise may be larger than is known; believed like the size.
_ROUGHER = np.geomspace(1.0, 8.0, 7)
# Which patches are far off is found by so many turns.
_TURNS = 3
# Fewer directions beside all that is projected out say nothing.
_FEWEST = 12


@dataclass(frozen=True)
class SmoothError:
    """A sensor's smooth error of depth.

    Attributes:
        size: one standard deviation [m].
        length: over which it changes [px].
        standing: share of its variance that all poses have in common.
    """

    size: float
    length: float
    standing: float


def with_smooth_error(
    noises: Sequence[NoiseModel],
    groups: Sequence[PatchGroup],
    still: Collection[int],
    *,
    is_hidden: bool = False,
) -> tuple[NoiseModel, ...]:
    """Return the noise of every view with the smooth error that its patches show.

    Of one sensor, so one for all views of bodies at rest whose frames were repeated.

    Args:
        noises: of every view, as assumed.
        groups: of the nominal fit with that noise, with tangents of all effects.
        still: views of bodies at rest.
        is_hidden: whether an effect is so large that tangents leave much of it: what they show is
            then the most that the error may be, and no more is believed than beforehand.
    """
    quiet = {view for view in still if noises[view].is_measured}
    if not quiet:
        return tuple(noises)
    assumed = noises[min(quiet)]
    own = [group for group in groups if group.view in quiet]
    found = measured_smooth_error(own, assumed, is_hidden=is_hidden)
    if is_hidden:
        found = min(found, expected_smooth_error(assumed), key=lambda error: error.size)
    return tuple(
        replace(
            noise,
            smooth=found.size,
            smooth_length=found.length,
            standing=found.standing,
            is_mixed=True,
        )
        if view in quiet
        else noise
        for view, noise in enumerate(noises)
    )


def expected_smooth_error(assumed: NoiseModel) -> SmoothError:
    """Return what is to be expected of a sensor before its patches are looked at.

    Args:
        assumed: noise with the median of the prior of its size.
    """
    # The root of the mean square of what is log-normal.
    larger = 1.0 if assumed.is_stated else float(np.exp(_SPREAD**2))
    return SmoothError(larger * assumed.smooth, assumed.smooth_length, float(np.mean(_STANDING)))


def measured_smooth_error(
    groups: Sequence[PatchGroup], assumed: NoiseModel, *, is_hidden: bool = False
) -> SmoothError:
    """Measure it on patches of depth whose covariance holds the error assumed.

    Args:
        groups: with tangents of all that may have put something there.
        assumed: noise with the median of the prior of its size.
        is_hidden: whether the most is asked for that the error may be: all that is left is it,
            but for other noise as it is known to be.
    """
    depth = [b for b in of_the_body(groups) if b.kind == 'depth' and len(b.patches.values)]
    nothing = SmoothError(assumed.smooth, assumed.smooth_length, assumed.standing)
    if not depth:
        return nothing
    beside = _beside(depth)
    if beside.shape[1] < _FEWEST:
        return nothing
    values = np.concatenate([group.patches.values for group in depth])
    seen = _Seen(depth, beside, values, _without_smooth(depth, assumed))
    rougher = _ROUGHER[:1] if is_hidden else _ROUGHER
    told = _told_by(seen, assumed, rougher)
    more = np.zeros(1) if is_hidden else _of_far_off(seen, told)
    if more.any():
        told = _told_by(replace(seen, others=seen.others + np.diag(more)), assumed, rougher)
    return replace(told.expected, size=max(told.expected.size, assumed.smooth))


@dataclass(frozen=True)
class _Seen:
    """Patches of depth, n in all.

    Attributes:
        depth: groups of these.
        beside: basis of what was not projected out, shape (n, d).
        values: residuals [m], shape (n,).
        others: covariance of all noise but the smooth error [m^2], shape (n, n).
    """

    depth: Sequence[PatchGroup]
    beside: FloatArray
    values: FloatArray
    others: FloatArray


@dataclass(frozen=True)
class _Told:
    """What patches tell of a smooth error.

    Attributes:
        expected: its covariance to be expected, by size and share, and its likeliest length.
        is_mixed: whether it is likeliest to change over lengths of all sizes.
    """

    expected: SmoothError
    is_mixed: bool


def _told_by(seen: _Seen, assumed: NoiseModel, rougher: FloatArray) -> _Told:
    """Return what patches tell.

    Args:
        seen: they.
        assumed: see `measured_smooth_error`.
        rougher: by how much all other noise may be larger than is known, shape (r,).
    """
    factor = cholesky(seen.beside.T @ seen.others @ seen.beside, lower=True)
    wide = np.column_stack([seen.beside.T @ seen.values, seen.beside.T])
    scaled = solve_triangular(factor, wide, lower=True)
    values, ways = scaled[:, 0], scaled[:, 1:]
    sizes = _STATED if assumed.is_stated else _SIZES
    kinds = list(product(_LENGTHS, _STANDING, _MIXED))
    table = np.zeros((len(kinds), len(rougher), len(sizes)))
    for row, (length, standing, is_mixed) in enumerate(kinds):
        changes_over = length * assumed.smooth_length
        shared = _kernel(seen.depth, changes_over, standing, is_mixed=is_mixed)
        table[row] = _levels(values, ways @ shared @ ways.T, assumed.smooth * sizes, rougher)
    table += log_belief(sizes) + log_belief(rougher)[:, None]
    chances = np.exp(table - table.max()).sum(axis=1)
    chances /= chances.sum()
    # The covariance to be expected: in the mean, squares are of this size and so much is shared.
    squares = chances @ sizes**2
    share = squares @ np.array([standing for _, standing, _ in kinds]) / squares.sum()
    length, _, is_mixed = kinds[int(chances.sum(axis=1).argmax())]
    size = assumed.smooth * float(np.sqrt(squares.sum()))
    return _Told(SmoothError(size, length * assumed.smooth_length, float(share)), is_mixed)


def _of_far_off(seen: _Seen, told: _Told) -> FloatArray:
    """Return by how much the variances are larger of patches that are far off [m^2], shape (n,).

    Far from what all others tell of them: these count in proportion to that, and not to its
    square, as in fits.
    """
    error, more = told.expected, np.zeros(len(seen.values))
    # What is far off may have made it large; most patches are not.
    size = min(error.size, median_spread(seen.values))
    smooth = _kernel(seen.depth, error.length, error.standing, is_mixed=told.is_mixed)
    believed, beside = seen.others + size**2 * smooth, seen.beside
    for _ in range(_TURNS):
        whole = believed + np.diag(more)
        known = beside @ np.linalg.solve(beside.T @ whole @ beside, beside.T)
        precision = np.maximum(np.diag(known), 1e-12 / np.diag(whole))
        # Left out, a patch is off by residual over precision, whose variance is its inverse.
        further = more_by_far_off(known @ seen.values / precision, 1.0 / precision)
        if not further.any():
            break
        more += further
    return more


def log_belief(sizes: FloatArray) -> FloatArray:
    """Return the log of how much is believed beforehand of sizes, by the one assumed, shape (n,).

    The prior is log-normal; its density is over the logarithm, and up to a constant.
    """
    return np.asarray(-0.5 * (np.log(sizes) / _SPREAD) ** 2)


def _levels(
    values: FloatArray, smooth: FloatArray, sizes: FloatArray, rougher: FloatArray
) -> FloatArray:
    """Return the restricted log likelihood of each size, for each of other noise, (r, n).

    Args:
        values: in units of all other noise as it is known, shape (d,).
        smooth: covariance of a smooth error of one, in these units, shape (d, d).
        sizes: that are tried, shape (n,).
        rougher: likewise, by how much all other noise is larger, shape (r,).
    """
    known, directions = np.linalg.eigh(smooth)
    squares = (directions.T @ values) ** 2
    own = np.maximum(known, 0.0) * sizes[:, None] ** 2
    variances = rougher[:, None, None] ** 2 + own
    return np.asarray(-0.5 * (np.log(variances) + squares / variances).sum(axis=2))


def _without_smooth(groups: Sequence[PatchGroup], assumed: NoiseModel) -> FloatArray:
    """Return the covariance of all noise but the smooth error, shape (n, n)."""
    own = []
    for group in groups:
        patches = group.patches
        shared = kernel(patches.centers, assumed.smooth_length, is_mixed=assumed.is_mixed)
        smooth = assumed.smooth**2 * shared
        # What was taken off before rounding may leave a little less than nothing.
        rest = patches.covariance + patches.common.covariance(patches.centers) - smooth
        own.append(rest + np.diag(1e-6 * patches.variances))
    return np.asarray(block_diag(*own))


def _kernel(
    groups: Sequence[PatchGroup], length: float, standing: float, *, is_mixed: bool
) -> FloatArray:
    centers = np.concatenate([group.patches.centers for group in groups])
    views = np.concatenate([np.full(len(b.patches.values), b.view) for b in groups])
    fraction = np.where(views[:, None] == views, 1.0, standing)
    return np.asarray(fraction * kernel(centers, length, is_mixed=is_mixed))


def _beside(groups: Sequence[PatchGroup]) -> FloatArray:
    """Return an orthonormal basis of what no tangent and no mesh may have put there."""
    tangents = np.concatenate([group.patches.jacobian for group in groups])
    columns = np.column_stack([tangents, block_diag(*(b.mesh[:, None] for b in groups))])
    lengths = np.linalg.norm(columns, axis=0)
    kept = columns[:, lengths > 0.0] / lengths[lengths > 0.0]
    left, spans, _ = np.linalg.svd(kept, full_matrices=True)
    return np.asarray(left[:, int((spans > 1e-9 * spans.max(initial=0.0)).sum()) :])
