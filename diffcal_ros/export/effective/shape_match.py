# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where a simulator's fit starts: linear elements in the shape of the calibrated body.

Linear tetrahedra lock: near nu = 0.5 they are far too stiff, and in some places more than in
others, so that no modulus gives them the right shape. A lower Poisson's ratio does. Which one is
no matter of the recording: vertices are compared with those of the calibrated body itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.parameters.parameters import Kind
from diffcal_ros.errors import NotSimulatedError
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

FloatArray = NDArray[np.float64]

# Poisson's ratios that are tried beside the material's own.
CEILINGS = (0.45, 0.4, 0.35, 0.3, 0.2, 0.1, 0.0)
# A ratio nearer to the material's is taken where it leaves only so much more than the best: in a
# contact, or where the body is squeezed, the ratio counts for itself.
_WORTH = 1.2
_MOST_EVALUATIONS = 12
_SETTLED = 1e-3  # Of the change in the moduli's logarithms.


@dataclass(frozen=True)
class ShapeMatch:
    """Linear elements that lie as nearly as they can where the calibrated body is.

    Attributes:
        ceiling: no region's Poisson's ratio is above it.
        coordinates: of the moduli and ratios, shape (k,).
        distance: of the vertices from the calibrated ones, RMS [m].
    """

    ceiling: float
    coordinates: FloatArray
    distance: float


def match_shapes(target: Calibration, wanted: Sequence[FloatArray]) -> list[ShapeMatch]:
    """Match the calibrated shape under the material's own ratios and under lower ones.

    Args:
        target: whose parameters are moduli and Poisson's ratios of linear elements.
        wanted: calibrated vertices as each observation's camera sees them [m], shape (V, 3) each.

    Returns:
        Matches, those with the material's own ratios first; ratios with which the body finds no
        equilibrium are left out.
    """
    start = target.parameters.start()
    ratios = target.parameters.find(Kind.POISSONS_RATIO)
    matches: list[ShapeMatch] = []
    for ceiling in (0.5, *(own for own in CEILINGS if own < start[ratios].max())):
        coordinates = matches[-1].coordinates.copy() if matches else start.copy()
        coordinates[ratios] = np.minimum(start[ratios], ceiling)
        found = _match(target, wanted, ceiling, coordinates)
        if found is not None:
            matches.append(found)
    return matches


def choose(matches: Sequence[ShapeMatch]) -> ShapeMatch:
    """Return the match with the highest ratio that leaves little more than the best."""
    best = min(own.distance for own in matches)
    return next(own for own in matches if own.distance <= _WORTH * best)


def _match(
    target: Calibration, wanted: Sequence[FloatArray], ceiling: float, coordinates: FloatArray
) -> ShapeMatch | None:
    """Fit the moduli; None where the body finds no equilibrium to start from."""
    moduli = target.parameters.find(Kind.YOUNGS_MODULUS)

    def moved(change: FloatArray) -> FloatArray:
        there = coordinates.copy()
        there[moduli] += change
        return there

    def residual(change: FloatArray) -> FloatArray:
        try:
            return _residual(target, wanted, moved(change))
        except NotSimulatedError:  # A step that ends so is shortened.
            return np.full(3 * sum(map(len, wanted)), np.nan)

    def jacobian(change: FloatArray) -> FloatArray:
        tangents = target.model.tangents(moved(change))
        return np.concatenate([own[moduli].reshape(len(moduli), -1) for own in tangents], axis=1).T

    nothing = np.zeros(len(moduli))
    if np.isnan(residual(nothing)).any():
        return None
    # From no change the trust region begins with a step of one in the logarithm of the moduli.
    found = least_squares(
        residual, nothing, jacobian, xtol=_SETTLED, gtol=None, max_nfev=_MOST_EVALUATIONS
    )
    distance = float(np.sqrt(3.0 * np.mean(found.fun**2)))
    return ShapeMatch(ceiling, moved(found.x), distance)


def _residual(
    target: Calibration, wanted: Sequence[FloatArray], coordinates: FloatArray
) -> FloatArray:
    views = target.model.views(coordinates)
    pairs = zip(views, wanted, strict=True)
    return np.concatenate([(view.points - own).reshape(-1) for view, own in pairs])
