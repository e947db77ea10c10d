# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fit the patches of one model, nonlinearly, with all nominal parameters free."""

from dataclasses import dataclass

from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.diagnosis.model_comparison.descent import Descent
from diffcal_ros.diagnosis.patches.evidence import Evidence
from diffcal_ros.diagnosis.patches.patch_group import Block
from diffcal_ros.diagnosis.patches.whitened import Part
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

MAX_ITERATIONS = 12
# What one refinement tells of an error of mesh and step is off by about this share of it.
_SHIFT_DOUBT = 0.25


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
        shifts: from the coordinates to those of the body itself, see `Numerics`, shape (k,).
        promise: what one more step would gain of the log evidence, if all were linear.
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
    shifts: FloatArray
    promise: float
    patch_count: int
    evaluations: int
    is_converged: bool

    @property
    def chi_square_per_patch(self) -> float:
        """Chi-square per degree of freedom: 1 where noise alone is left."""
        return self.chi_square / max(self.patch_count - len(self.coordinates), 1)

    def of_the_body(self, place: int) -> tuple[float, float]:
        """Return a coordinate of the body itself, not of its mesh, and its standard error."""
        shift = float(self.shifts[place])
        variance = float(self.covariance[place, place]) + (_SHIFT_DOUBT * shift) ** 2
        return float(self.coordinates[place]) + shift, float(np.sqrt(variance))


def refit(
    evidence: Evidence,
    start: FloatArray,
    *,
    max_iterations: int = MAX_ITERATIONS,
    part: Part = Part.FIT,
    least_evidence: float = -np.inf,
) -> Refit:
    """Fit by Gauss-Newton with Levenberg and Marquardt's damping.

    Args:
        evidence: of the model.
        start: coordinates, shape (k,).
        max_iterations: evaluations of the model at most.
        part: patches that are fitted.
        least_evidence: logarithm of the evidence below which the fit is of no use: it is given
            up where it will hardly come so far.

    Raises:
        EquilibriumError: when the start cannot be simulated.
        MotionError: likewise.
        OutOfViewError: when a camera does not see the body at the start.
    """
    descent = Descent(evidence, start, part)
    descent.run(max_iterations, -least_evidence)
    seen, precision = descent.seen, descent.precision
    information = seen.jacobian.T @ seen.jacobian + precision
    return Refit(
        parameters=evidence.model.parameters,
        coordinates=descent.here,
        blocks=descent.blocks,
        chi_square=seen.chi_square,
        log_evidence=-descent.cost - 0.5 * _log_volumes(information, precision),
        covariance=np.linalg.pinv(information),
        shifts=evidence.numerics.shifts_of(evidence.model.parameters),
        promise=descent.promise(),
        patch_count=len(seen),
        evaluations=descent.evaluations,
        is_converged=max_iterations == 1 or descent.is_done or descent.is_exhausted,
    )


def _log_volumes(information: FloatArray, precision: FloatArray) -> float:
    return float(np.linalg.slogdet(information)[1] - np.linalg.slogdet(precision)[1])
