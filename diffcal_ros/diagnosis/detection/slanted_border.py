# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A border that goes aslant around a body: what was dipped, painted or lit at an angle.

Straight borders and rectangles leave a wedge of it on either side, as high as the step.
"""

from functools import partial
from itertools import product

from diffcal_ros.diagnosis.detection.depth_discontinuity import jumps_seen, LEAST_GAIN, with_jumps
from diffcal_ros.diagnosis.detection.material_boundary import (
    BORDERS,
    LEFT,
    may_show_parts,
    seen_places,
)
from diffcal_ros.diagnosis.detection.sharp_limits import are_parts, placed_by_pixels
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.effects.surface_parts import along_aslant, SurfacePart
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Where a border is first tried, with what slants about one axis across: shares of the free length,
# from the middle of the width to its side.
_PLACES = np.linspace(0.14, 0.86, 19).round(3)
_STEEP = np.array([-0.4, -0.3, -0.2, -0.1, 0.1, 0.2, 0.3, 0.4])
_ALONE = ((1.0, 0.0), (0.0, 1.0))
# Around the best one, by so much less and more of each of these.
_NEAR = np.array([-1.0, -0.5, 0.0, 0.5, 1.0])
_NEAR_PLACE, _NEAR_SLANT = 0.04, 0.1
# What each of its two numbers has to explain of chi-square, see `material_bands`: it was chosen
# among so many places and slants.
_PRICE = 2.0 * np.log(len(BORDERS)) + 2.0 * np.log(2 * (4 * len(_STEEP) + 1))


def find_slanted_border(
    evaluator: PatchEvaluator, nominal: Refit, otherwise: float
) -> tuple[tuple[SurfacePart, ...], float]:
    """Return the part of a body beyond a slanted border, and the chi-square that it leaves.

    Args:
        evaluator: of the nominal model, or of one with an effect.
        nominal: its fit.
        otherwise: chi-square that the best bands leave, whose borders are straight.

    Returns:
        No part where none stands out, and then what bands leave.
    """
    if not may_show_parts(evaluator, nominal):
        return (), otherwise
    rows = [
        (at, *(slant * own for own in way)) for way in _ALONE for slant in _STEEP for at in _PLACES
    ]
    best, left = _best_of(evaluator, nominal, np.array(rows))
    if left >= otherwise:
        return (), otherwise
    # About the axis that the best one is slanted about.
    moves = np.array([[1.0, 0.0, 0.0], [0.0, *(best[1:] != 0.0)]])
    near = np.array([*product(_NEAR_PLACE * _NEAR, _NEAR_SLANT * _NEAR)])
    best, left = _best_of(evaluator, nominal, best + near @ moves)
    if left >= LEFT * otherwise:
        return (), otherwise
    views = seen_places(evaluator, nominal.coordinates)
    part = placed_by_pixels(views, _part(best))
    is_aslant = 0.0 < part.begin < 1.0 and any(part.slants)
    if is_aslant and are_parts(views, [part]):
        return (part,), left
    return (), otherwise


def _best_of(
    evaluator: PatchEvaluator, nominal: Refit, borders: FloatArray
) -> tuple[FloatArray, float]:
    """Return the border that explains most, and the chi-square that it leaves with its price.

    Args:
        evaluator: of the nominal model.
        nominal: its fit.
        borders: places and both slants, shape (s, 3).
    """
    jumps = jumps_seen(with_jumps(evaluator, nominal, partial(_beyond_each, borders)), nominal)
    gains = jumps.gains_of_each()
    best = int(gains.argmax())
    if gains[best] < LEAST_GAIN + _PRICE:
        return borders[best], np.inf
    return borders[best], jumps.whole - float(gains[best]) + _PRICE


def _part(border: FloatArray) -> SurfacePart:
    at, *slants = border.tolist()
    return SurfacePart(at, 1.0, slants=(slants[0], slants[1]))


def _beyond_each(borders: FloatArray, places: FloatArray) -> FloatArray:
    """Return which points are beyond each border, see `_best_of`, shape (M, s)."""
    ways, own = np.unique(borders[:, 1:], axis=0, return_inverse=True)
    along = along_aslant(places, ways)
    return (along[:, own.ravel()] > borders[:, 0]).astype(np.float64)
