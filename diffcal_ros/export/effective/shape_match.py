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

FloatArray = NDArray[np.float64]

# Poisson's ratios that are tried beside the material's own.
CEILINGS = (0.45, 0.4, 0.35, 0.3, 0.2, 0.1, 0.0)
# A ratio nearer to the material's is taken where it leaves only so much more than the best: in a
# contact, or where the body is squeezed, the ratio counts for itself.
_WORTH = 1.2
_ROUNDS = 12
_LONGEST_STEP = 0.7  # Of a modulus' logarithm.
_SETTLED = 1e-3


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
    """Fit the moduli by Gauss-Newton steps that are halved until they bring the body nearer."""
    moduli = target.parameters.find(Kind.YOUNGS_MODULUS)
    try:
        residual = _residual(target, wanted, coordinates)
    except NotSimulatedError:
        return None
    for _ in range(_ROUNDS):
        tangents = target.model.tangents(coordinates)
        columns = np.concatenate(
            [own[moduli].reshape(len(moduli), -1) for own in tangents], axis=1
        )
        step = -np.linalg.lstsq(columns.T, residual, rcond=None)[0]
        step *= min(1.0, _LONGEST_STEP / max(np.abs(step).max(), 1e-12))
        moved = _nearer(target, wanted, coordinates, residual, moduli, step)
        if moved is None:
            break
        coordinates, residual = moved
        if np.abs(step).max() < _SETTLED:
            break
    distance = float(np.sqrt(3.0 * np.mean(residual**2)))
    return ShapeMatch(ceiling, coordinates, distance)


def _nearer(
    target: Calibration,
    wanted: Sequence[FloatArray],
    coordinates: FloatArray,
    residual: FloatArray,
    moduli: Sequence[int],
    step: FloatArray,
) -> tuple[FloatArray, FloatArray] | None:
    for halvings in range(5):
        trial = coordinates.copy()
        trial[moduli] += 0.5**halvings * step
        try:
            moved = _residual(target, wanted, trial)
        except NotSimulatedError:
            continue
        if moved @ moved < residual @ residual:
            return trial, moved
    return None


def _residual(
    target: Calibration, wanted: Sequence[FloatArray], coordinates: FloatArray
) -> FloatArray:
    views = target.model.views(coordinates)
    pairs = zip(views, wanted, strict=True)
    return np.concatenate([(view.points - own).reshape(-1) for view, own in pairs])
