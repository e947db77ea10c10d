# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How much roughness a field may have: as little as the sensor's noise allows.

Weights are lowered step by step, each from where the last one ended. Where the residuals reach
the noise, that weight is taken (Morozov's discrepancy principle). Real residuals often do not,
for the model lacks more than a field; the corner of the L-curve is taken then: the point beyond
which roughness grows and the misfit hardly falls.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from diffcal_ros.calibration.field.search import FieldSearch, FieldState
from diffcal_ros.calibration.residuals.gap import Gap
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Patterns that the data see a hundred times worse than the best take up what is wrong elsewhere:
# on a real twisted beam the halves blur again below.
FRACTIONS = tuple(float(10.0 ** (-0.5 * step)) for step in range(1, 5))
_FIRST_ROUNDS, _ROUNDS = 12, 4
# What a robust cost loses and gains as pixels leave and join.
_LEAST_FALL = 0.03
# The noise is stated and residuals are quantised: this much above it is at it.
_AT_NOISE = 1.05
_AT_NOISE_REASON = "the residuals reach the sensor's noise"


@dataclass(frozen=True)
class WeightTrial:
    """The fit under one weight.

    Attributes:
        fraction: the weight, see `field.search`.
        misfit: chi-square of data and ordinary priors.
        roughness: of the field.
        residual: robust standard deviation of the depth residuals [m].
        gap: on the body.
        rounds: of Gauss-Newton.
        state: where the fit ended.
    """

    fraction: float
    misfit: float
    roughness: float
    residual: float
    gap: Gap
    rounds: int
    state: FieldState


@dataclass(frozen=True)
class WeightChoice:
    """Which weight was taken, and why.

    Attributes:
        trials: one a weight, the highest first.
        chosen: number of the one that was taken.
        reason: in words.
        is_stopped: it was told to stop.
    """

    trials: tuple[WeightTrial, ...]
    chosen: int
    reason: str
    is_stopped: bool = False


def choose_weight(
    search: FieldSearch, noise: float, *, on_trial: Callable[[WeightTrial], bool]
) -> WeightChoice:
    """Find the weight, and leave the search at its fit.

    Args:
        search: at a fit without a field.
        noise: standard deviation of a pixel's depth [m].
        on_trial: told of every fit; returns False to stop.
    """
    trials: list[WeightTrial] = []
    for number, fraction in enumerate(FRACTIONS):
        trials.append(_fit_under(search, fraction, is_first=number == 0))
        goes_on = on_trial(trials[-1])
        if trials[-1].residual <= _AT_NOISE * noise:
            return WeightChoice(tuple(trials), number, _AT_NOISE_REASON)
        if not goes_on:
            return WeightChoice(tuple(trials), number, 'the last one tried', is_stopped=True)
    chosen, reason = by_l_curve([t.misfit for t in trials], [t.roughness for t in trials])
    search.go_to(trials[chosen].state)
    return WeightChoice(tuple(trials), chosen, reason)


def fit_under(search: FieldSearch, fraction: float) -> WeightChoice:
    """Fit under a given weight."""
    return WeightChoice((_fit_under(search, fraction, is_first=True),), 0, 'given')


def _fit_under(search: FieldSearch, fraction: float, *, is_first: bool) -> WeightTrial:
    rounds = 0
    if is_first:
        rounds = search.descend(fraction, _FIRST_ROUNDS)
        # What the field explains was taken for noise before.
        search.refine()
        search.fix_unit(fraction)
    rounds += search.descend(fraction, _ROUNDS)
    return WeightTrial(
        fraction=fraction,
        misfit=search.misfit(),
        roughness=search.roughness(),
        residual=search.residual_spread(),
        gap=search.objective.gap(search.state.coordinates),
        rounds=rounds,
        state=search.state,
    )


def by_l_curve(misfits: Sequence[float], roughnesses: Sequence[float]) -> tuple[int, str]:
    """Return the number of the point to take of an L-curve, the smoothest first, and why."""
    if min(misfits) > (1.0 - _LEAST_FALL) * misfits[0]:
        return 0, 'rougher fields hardly fit better'
    return corner(misfits, roughnesses), 'the corner of the L-curve'


def corner(misfits: Sequence[float], roughnesses: Sequence[float]) -> int:
    """Return the number of the point at which an L-curve bends most.

    Args:
        misfits: falling, but for what a robust cost trembles.
        roughnesses: growing likewise, all positive.
    """
    across = _normalised(np.log(np.minimum.accumulate(misfits)))
    up = _normalised(np.log(np.maximum.accumulate(roughnesses)))
    points = np.stack([across, up], axis=1)
    before, after = points[1:-1] - points[:-2], points[2:] - points[1:-1]
    turns = before[:, 1] * after[:, 0] - before[:, 0] * after[:, 1]
    # Menger's curvature: of the circle through three neighbours.
    sizes = [np.linalg.norm(v, axis=1) for v in (before, after, before + after)]
    bends = 2.0 * turns / np.maximum(np.prod(sizes, axis=0), 1e-12)
    return 1 + int(np.argmax(bends)) if len(bends) else len(points) - 1


def _normalised(values: FloatArray) -> FloatArray:
    normalised: FloatArray = (values - values.min()) / max(float(np.ptp(values)), 1e-12)
    return normalised
