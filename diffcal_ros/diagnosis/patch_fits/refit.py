# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fit the patches of one model, nonlinearly, with all nominal parameters free."""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.chi_square import chance_beyond
from diffcal_ros.diagnosis.patch_fits.patch_fit import AT_FIRST, Pace, PatchFit, prior_of
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.patches.patch_group import PatchGroup
from diffcal_ros.diagnosis.patches.regularised_prior import regularised_prior
from diffcal_ros.diagnosis.patches.whitened import Part, whiten, Whitened
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

MAX_ITERATIONS = 12
# What is left is small beside its noise where noise leaves as much with this chance.
AS_NOISE = 0.05
# What one refinement tells of an error of mesh and time step is off by about this share of it.
_SHIFT_DOUBT = 0.25


@dataclass(frozen=True)
class Refit:
    """Where a fit of patches ended.

    Attributes:
        parameters: of the model.
        coordinates: shape (k,).
        groups: all patches there.
        chi_square: of the part that was fitted, without priors.
        log_evidence: of the model: half chi-square, priors, what uneven patches cost and the
            volume of the posterior against that of the prior, negative.
        covariance: of the coordinates, shape (k, k).
        shifts: from the coordinates to those of the body itself, see `DiscretisationError`,
            shape (k,).
        promise: what one more step would gain of the log evidence, if all were linear.
        patch_count: number of patches fitted.
        evaluations: of the model.
        is_converged: whether it came to rest, or ran out of evaluations.
        pace: how it got on when it stopped.
    """

    parameters: ParameterSet
    coordinates: FloatArray
    groups: list[PatchGroup]
    chi_square: float
    log_evidence: float
    covariance: FloatArray
    shifts: FloatArray
    promise: float
    patch_count: int
    evaluations: int
    is_converged: bool
    pace: Pace = AT_FIRST

    @property
    def chi_square_per_patch(self) -> float:
        """Chi-square per degree of freedom: 1 where noise alone is left."""
        return self.chi_square / max(self.patch_count - len(self.coordinates), 1)

    @property
    def chance_of_noise(self) -> float:
        """Return the chance that noise alone leaves as much."""
        freedom = max(self.patch_count - len(self.coordinates), 1)
        return float(chance_beyond(self.chi_square, freedom))

    @property
    def leaves_noise(self) -> bool:
        """Tell whether what is left is small beside its noise."""
        return self.chance_of_noise > AS_NOISE

    def values_by_name(self) -> dict[str, float]:
        """Return the coordinates by the names of their parameters: where another fit may start."""
        return dict(zip(self.parameters.names, self.coordinates.tolist(), strict=True))

    def prior_offset(self) -> tuple[FloatArray, FloatArray]:
        """Return how far the body's coordinates are from where they are likely, and its precision.

        Shapes (k,) and (k, k); what is known of a parameter is known of the body, not of its mesh.
        """
        mean, precision = regularised_prior(self.parameters)
        return self.coordinates - (mean - self.shifts), precision

    @property
    def prior_chi_square(self) -> float:
        """What the prior adds to twice the cost."""
        offset, precision = self.prior_offset()
        return float(offset @ precision @ offset)

    def of_the_body(self, index: int) -> tuple[float, float]:
        """Return a coordinate of the body itself, not of its mesh, and its standard error."""
        shift = float(self.shifts[index])
        variance = float(self.covariance[index, index]) + (_SHIFT_DOUBT * shift) ** 2
        return float(self.coordinates[index]) + shift, float(np.sqrt(variance))


def refit(
    evaluator: PatchEvaluator,
    start: FloatArray,
    *,
    max_iterations: int = MAX_ITERATIONS,
    part: Part = Part.FIT,
    least_log_evidence: float = -np.inf,
    known: Sequence[PatchGroup] | None = None,
    pace: Pace = AT_FIRST,
) -> Refit:
    """Fit by Gauss-Newton with Levenberg and Marquardt's damping.

    Args:
        evaluator: of the model.
        start: coordinates, shape (k,).
        max_iterations: evaluations of the model at most.
        part: patches that are fitted.
        least_log_evidence: log evidence below which the fit is of no use: it is given
            up where it will hardly come so far.
        known: all patches at the start, where they were evaluated before.
        pace: of the fit that stopped at the start.

    Raises:
        EquilibriumError: when the start cannot be simulated.
        MotionError: likewise.
        OutOfViewError: when a camera does not see the body at the start.
        NotSimulatedError: when no patch shows it there; all others are kinds of it.
    """
    fit = PatchFit(evaluator, start, part, known, pace)
    fit.run(max_iterations, -least_log_evidence)
    return ended(
        evaluator,
        fit.here,
        fit.groups,
        fit.seen,
        promise=fit.promise(),
        evaluations=fit.evaluations,
        is_converged=max_iterations == 1 or fit.is_done or fit.is_exhausted,
        pace=fit.pace,
    )


def ended(
    evaluator: PatchEvaluator,
    coordinates: FloatArray,
    groups: list[PatchGroup],
    seen: Whitened,
    *,
    promise: float,
    evaluations: int,
    is_converged: bool,
    pace: Pace = AT_FIRST,
) -> Refit:
    """Return what a fit tells that ended somewhere.

    Args:
        evaluator: of the model.
        coordinates: where it ended, shape (k,).
        groups: all patches there.
        seen: those that were fitted, whitened.
        promise: see `Refit`.
        evaluations: of the model.
        is_converged: whether it came to rest.
        pace: how it got on.
    """
    parameters = evaluator.model.parameters
    prior = prior_of(evaluator)
    information = seen.jacobian.T @ seen.jacobian + prior.precision
    # Far-off patches count less, and what that takes from their density is a price: without it the
    # model that is farther off as a whole would be held to less.
    price = seen.volume + seen.tolerance
    cost = 0.5 * (seen.chi_square + price) + prior.cost(coordinates)
    return Refit(
        parameters=parameters,
        coordinates=coordinates,
        groups=groups,
        chi_square=seen.chi_square,
        log_evidence=-cost - 0.5 * _log_volumes(information, prior.precision),
        covariance=np.linalg.pinv(information),
        shifts=evaluator.discretisation_error.shifts_of(parameters),
        promise=promise,
        patch_count=len(seen),
        evaluations=evaluations,
        is_converged=is_converged,
        pace=pace,
    )


def weighed_anew(fit: Refit, evaluator: PatchEvaluator) -> Refit:
    """Return a fit where it stands, with what is known beforehand by another evaluator.

    Args:
        fit: not at rest any more where that moves it.
        evaluator: of a model with the same parameters.
    """
    return ended(
        evaluator,
        fit.coordinates,
        fit.groups,
        whiten(fit.groups, Part.FIT),
        promise=fit.promise,
        evaluations=fit.evaluations,
        is_converged=False,
        pace=fit.pace,
    )


def _log_volumes(information: FloatArray, precision: FloatArray) -> float:
    return float(np.linalg.slogdet(information)[1] - np.linalg.slogdet(precision)[1])
