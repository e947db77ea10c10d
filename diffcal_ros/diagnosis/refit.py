# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fit the patches of one model, nonlinearly, with all nominal parameters free."""

from dataclasses import dataclass

from diffcal_ros.calibration.calibrate import longest_steps
from diffcal_ros.calibration.parameters import ParameterSet
from diffcal_ros.calibration.uncertainty import natural_scales
from diffcal_ros.depth.tracer import OutOfViewError
from diffcal_ros.diagnosis.evidence import Block, Evidence
from diffcal_ros.diagnosis.whitened import Part, residual_size, whiten, Whitened
from diffcal_ros.fem.equilibrium import EquilibriumError
from diffcal_ros.fem.motion.inputs import MotionError
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

MAX_ITERATIONS = 12
_MAX_REJECTIONS = 4
# A step that promises less than this (half chi-square) is a fifth of a standard error.
_SMALL_GAIN = 0.02
_SMALL_SHARE = 1e-4
# Share of the present residual that is allowed for while a fit is on its way.
_SLACK = 0.3
_FIRST_DAMPING = 1e-2
# Patches join and leave: a step is not refused for less than this share.
_ROUGHNESS = 0.01


@dataclass(frozen=True)
class Refit:
    """Where a fit of patches ended.

    Attributes:
        parameters: of the model.
        coordinates: shape (k,).
        blocks: all patches there.
        chi_square: of the part that was fitted, without priors.
        log_evidence: of the model: half chi-square, priors and the volume of the posterior
            against that of the prior, negative.
        covariance: of the coordinates, shape (k, k).
        patch_count: number of patches fitted.
        evaluations: of the model.
        is_converged: whether it came to rest, or ran out of evaluations.
    """

    parameters: ParameterSet
    coordinates: FloatArray
    blocks: list[Block]
    chi_square: float
    log_evidence: float
    covariance: FloatArray
    patch_count: int
    evaluations: int
    is_converged: bool

    @property
    def chi_square_per_patch(self) -> float:
        """Chi-square per degree of freedom: 1 where noise alone is left."""
        return self.chi_square / max(self.patch_count - len(self.coordinates), 1)


def refit(
    evidence: Evidence,
    start: FloatArray,
    *,
    max_iterations: int = MAX_ITERATIONS,
    part: Part = Part.FIT,
) -> Refit:
    """Fit by Gauss-Newton with Levenberg and Marquardt's damping.

    Args:
        evidence: of the model.
        start: coordinates, shape (k,).
        max_iterations: evaluations of the model at most.
        part: patches that are fitted.

    Raises:
        EquilibriumError: when the start cannot be simulated.
        MotionError: likewise.
        OutOfViewError: when a camera does not see the body at the start.
    """
    parameters = evidence.model.parameters
    lower, upper = parameters.bounds()
    mean, precision = full_prior(parameters)
    limits = longest_steps(parameters)
    here = np.clip(start, lower, upper)
    blocks = evidence.blocks(here)
    # A model that is far off is not held to the last tenth of a millimetre on its way.
    slack = _SLACK * residual_size(blocks, part)
    seen = whiten(blocks, part, slack)
    cost = _cost(seen, here, mean, precision)
    damping, rejections, evaluations, is_done = 0.0, 0, 1, False
    while evaluations < max_iterations and rejections <= _MAX_REJECTIONS:
        step, gain = _step(seen, here, mean, precision, (lower, upper), damping)
        step /= max(1.0, float((np.abs(step) / limits).max()))
        if gain < _SMALL_GAIN:
            if slack == 0.0:
                is_done = True
                break
            slack = 0.0
            seen = whiten(blocks, part)
            cost = _cost(seen, here, mean, precision)
            continue
        trial = np.clip(here + step, lower, upper)
        evaluations += 1
        try:
            trial_blocks = evidence.blocks(trial)
        except (EquilibriumError, MotionError, OutOfViewError):
            damping, rejections = max(_FIRST_DAMPING, 10.0 * damping), rejections + 1
            continue
        trial_seen = whiten(trial_blocks, part, slack)
        trial_cost = _cost(trial_seen, trial, mean, precision)
        if not _per_patch(trial_cost, trial_seen) < (1.0 + _ROUGHNESS) * _per_patch(cost, seen):
            damping, rejections = max(_FIRST_DAMPING, 10.0 * damping), rejections + 1
            continue
        is_done = abs(trial_cost - cost) < max(_SMALL_GAIN, _SMALL_SHARE * trial_cost)
        here, blocks, seen, cost = trial, trial_blocks, trial_seen, trial_cost
        damping, rejections = 0.1 * damping if damping > 1e-3 else 0.0, 0
        if is_done and slack == 0.0:
            break
        smaller = 0.0 if is_done else min(slack, _SLACK * residual_size(blocks, part))
        if smaller < slack:
            slack, is_done = smaller, False
            seen = whiten(blocks, part, slack)
            cost = _cost(seen, here, mean, precision)
    if slack:
        seen = whiten(blocks, part)
        cost = _cost(seen, here, mean, precision)
    information = seen.jacobian.T @ seen.jacobian + precision
    return Refit(
        parameters=parameters,
        coordinates=here,
        blocks=blocks,
        chi_square=seen.chi_square,
        log_evidence=-cost - 0.5 * _log_volumes(information, precision),
        covariance=np.linalg.pinv(information),
        patch_count=len(seen),
        evaluations=evaluations,
        is_converged=max_iterations == 1
        or (is_done and slack == 0.0)
        or rejections > _MAX_REJECTIONS,
    )


def full_prior(parameters: ParameterSet) -> tuple[FloatArray, FloatArray]:
    """Return mean and precision of the prior; where none is given, a wide one at the start."""
    mean, precision = parameters.prior()
    scales = natural_scales(parameters)
    for place, value in enumerate(np.diag(precision)):
        if value == 0.0:
            precision[place, place] = 1.0 / scales[place] ** 2
            mean[place] = parameters.start()[place]
    return mean, precision


def _cost(
    seen: Whitened, coordinates: FloatArray, mean: FloatArray, precision: FloatArray
) -> float:
    offset = coordinates - mean
    return 0.5 * (seen.chi_square + float(offset @ precision @ offset))


def _per_patch(cost: float, seen: Whitened) -> float:
    return cost / max(len(seen), 1)


def _log_volumes(information: FloatArray, precision: FloatArray) -> float:
    return float(np.linalg.slogdet(information)[1] - np.linalg.slogdet(precision)[1])


def _step(
    seen: Whitened,
    coordinates: FloatArray,
    mean: FloatArray,
    precision: FloatArray,
    bounds: tuple[FloatArray, FloatArray],
    damping: float,
) -> tuple[FloatArray, float]:
    """Return the damped step among what no bound stops, and the gain that it promises."""
    descent = seen.jacobian.T @ seen.values - precision @ (coordinates - mean)
    curvature = seen.jacobian.T @ seen.jacobian + precision
    stopped = (coordinates <= bounds[0]) & (descent < 0.0)
    stopped |= (coordinates >= bounds[1]) & (descent > 0.0)
    free = np.flatnonzero(~stopped)
    step = np.zeros_like(coordinates)
    own = curvature[np.ix_(free, free)]
    damped = own + np.diag(damping * np.diag(own))
    step[free] = np.linalg.solve(damped, descent[free])
    gain = float(descent @ step - 0.5 * step @ curvature @ step)
    return step, gain
