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
_MOTION = 0.99  # So much of a motion, of its squares, is followed.


@dataclass(frozen=True)
class ShapeMatch:
    """Linear elements that lie as nearly as they can where the calibrated body is.

    Attributes:
        ceiling: no region's Poisson's ratio is above it.
        coordinates: of the moduli and ratios, shape (k,).
        distance: of the vertices from the calibrated ones, RMS; of a swing, of that along it [m].
        is_settled: the numbers moved no more at the end.
    """

    ceiling: float
    coordinates: FloatArray
    distance: float
    is_settled: bool = True


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


def match_swing(
    target: Calibration, wanted: Sequence[FloatArray], coordinates: FloatArray
) -> ShapeMatch | None:
    """Match a motion by moduli and dampings; None where none is found to start from.

    What is compared is how far the body is along the motions that the calibrated one makes.
    Linear tetrahedra bend a body sideways as well, where their diagonals lie all one way; the
    calibrated one does not, and more damping would be found only to quench that.

    Args:
        target: whose bodies the simulator lets swing.
        wanted: calibrated vertices as each observation's camera sees them [m], shape (V, 3) each.
        coordinates: of its parameters to start from, shape (k,).
    """
    kinds = (Kind.YOUNGS_MODULUS, Kind.DAMPING)
    return _match(target, wanted, 0.5, coordinates, kinds, _ways(target, wanted))


def _ways(target: Calibration, wanted: Sequence[FloatArray]) -> list[FloatArray | None]:
    """Return directions of each observation's motion, shape (m, 3V); None of a body at rest."""
    owners = [own.setup_index for own in target.model.observations]
    ways: dict[int, FloatArray | None] = {}
    for owner in set(owners):
        pairs = zip(wanted, owners, strict=True)
        frames = np.array([points.reshape(-1) for points, own in pairs if own == owner])
        _, sizes, directions = np.linalg.svd(frames - frames.mean(axis=0), full_matrices=False)
        shares = np.cumsum(sizes**2) / max(float((sizes**2).sum()), 1e-300)
        count = int(np.searchsorted(shares, _MOTION)) + 1
        ways[owner] = directions[:count] if sizes[0] > 0.0 else None
    return [ways[owner] for owner in owners]


def _match(
    target: Calibration,
    wanted: Sequence[FloatArray],
    ceiling: float,
    coordinates: FloatArray,
    kinds: Sequence[Kind] = (Kind.YOUNGS_MODULUS,),
    ways: Sequence[FloatArray | None] | None = None,
) -> ShapeMatch | None:
    """Fit moduli, and what else is asked for; None where the body finds no state to start from."""
    fitted = [index for kind in kinds for index in target.parameters.find(kind)]
    along = [None] * len(wanted) if ways is None else ways

    def moved(change: FloatArray) -> FloatArray:
        there = coordinates.copy()
        there[fitted] += change
        return there

    def residual(change: FloatArray) -> FloatArray:
        try:
            off = _off(target, wanted, moved(change))
        except NotSimulatedError:  # A step that ends so is shortened.
            off = [np.full_like(own, np.nan) for own in wanted]
        return np.concatenate([_along(own, way) for own, way in zip(off, along, strict=True)])

    def jacobian(change: FloatArray) -> FloatArray:
        tangents = target.model.tangents(moved(change))
        columns = [
            np.array([_along(one, way) for one in own[fitted]])
            for own, way in zip(tangents, along, strict=True)
        ]
        return np.concatenate(columns, axis=1).T

    nothing = np.zeros(len(fitted))
    if np.isnan(residual(nothing)).any():
        return None
    # From no change the trust region begins with a step of one in the logarithm of the moduli.
    found = least_squares(
        residual, nothing, jacobian, xtol=_SETTLED, gtol=None, max_nfev=_MOST_EVALUATIONS
    )
    distance = float(np.sqrt((found.fun**2).sum() / sum(map(len, wanted))))
    return ShapeMatch(ceiling, moved(found.x), distance, is_settled=found.status > 0)


def _along(off: FloatArray, way: FloatArray | None) -> FloatArray:
    """Return vertices' offsets as numbers, or how far they are along some directions."""
    return off.reshape(-1) if way is None else way @ off.reshape(-1)


def _off(
    target: Calibration, wanted: Sequence[FloatArray], coordinates: FloatArray
) -> list[FloatArray]:
    views = target.model.views(coordinates)
    return [view.points - own for view, own in zip(views, wanted, strict=True)]
