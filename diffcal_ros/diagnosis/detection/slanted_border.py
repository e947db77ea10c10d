# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A border that goes aslant around a body: what was dipped, painted or lit at an angle.

Straight borders and rectangles leave a wedge of it on either side, as high as the step.
"""

from itertools import product

from diffcal_ros.diagnosis.detection.depth_discontinuity import jumps_seen, LEAST_GAIN, with_jumps
from diffcal_ros.diagnosis.detection.material_boundary import (
    BORDERS,
    LEFT,
    may_show_parts,
    seen_places,
)
from diffcal_ros.diagnosis.detection.sharp_limits import (
    go_along,
    is_sharp,
    LEAST_OF_HEIGHT,
    placed_by_pixels,
)
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.effects.surface_parts import SurfacePart
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Slants that are tried about one axis across: shares of the free length, from the middle of the
# width to its side. Pixels tell the rest, and the other axis's.
_STEEP = np.concatenate([-np.arange(0.4, 0.04, -0.05), np.arange(0.05, 0.44, 0.05)]).round(2)
_TRIED = [
    SurfacePart(at, 1.0, np.array([[-np.inf, np.inf]] * 2), slants=slants)
    for at, slant in product(BORDERS[::2], _STEEP.tolist())
    for slants in ((slant, 0.0), (0.0, slant))
]
# What each of its two numbers has to explain of chi-square, see `material_bands`.
_PRICE = 2.0 * np.log(len(_TRIED))


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
    jumps = jumps_seen(with_jumps(evaluator, nominal, _beyond_each), nominal)
    gains = jumps.gains_of_each()
    best = int(gains.argmax())
    left = jumps.whole - float(gains[best]) + _PRICE
    if gains[best] < LEAST_GAIN + _PRICE or left >= LEFT * otherwise:
        return (), otherwise
    views = seen_places(evaluator, nominal.coordinates)
    part = placed_by_pixels(views, _TRIED[best])
    is_part = 0.0 < part.begin < 1.0 and any(part.slants)
    if is_part and go_along(views, [part], LEAST_OF_HEIGHT) and is_sharp(views, part):
        return (part,), left
    return (), otherwise


def _beyond_each(places: FloatArray) -> FloatArray:
    """Return which points are beyond each border that is tried, shape (M, s)."""
    return np.stack([part.holds(places) for part in _TRIED], axis=1).astype(np.float64)
