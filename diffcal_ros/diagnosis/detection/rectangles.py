# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which part of a surface, limited along and across one axis, explains most, all of them tried.

What is limited along and across is a sum of four jumps, each beyond one place along and one
across, with signs: what any such part explains is known from the inner products of those jumps.
"""

from diffcal_ros.diagnosis.detection.depth_discontinuity import explained, Jumps
from diffcal_ros.effects.surface_parts import no_limits, SurfacePart
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Limits that are tried: shares of the free length, from the clamp on, and half widths from the
# middle. Beyond the outermost there are faces alone, see `surface_parts.FACE`.
ALONG = np.linspace(0.0, 0.96, 25)
_EDGE = 0.97
_ACROSS = np.array([-_EDGE, *np.linspace(-0.9, 0.9, 19), _EDGE])
FROM = np.array([-np.inf, *_ACROSS])
_COUNT = len(ALONG) * len(FROM)
# A limit was chosen among so many: what each has to explain of chi-square, see `material_bands`.
PRICES = 2.0 * np.log([len(ALONG), len(_ACROSS)])


def jumps_of(places: FloatArray) -> FloatArray:
    """Return the jumps beyond each pair of places along and across either axis, (M, 2 s)."""
    along = places[:, :1] > ALONG
    both = [along[:, :, None] & (places[:, way, None] > FROM)[:, None] for way in (1, 2)]
    return np.stack(both, axis=1).reshape(len(places), -1).astype(np.float64)


def numbers_of(places: FloatArray) -> IntArray:
    """Return numbers that are alike of what is beyond the same jumps, shape (M,)."""
    along = np.searchsorted(ALONG, places[:, 0])
    across = [np.searchsorted(FROM, places[:, way]) for way in (1, 2)]
    shape = (len(ALONG) + 1, len(FROM) + 1, len(FROM) + 1)
    return np.asarray(np.ravel_multi_index((along, *across), shape), dtype=np.int64)


def best_rectangle(jumps: Jumps) -> tuple[SurfacePart, FloatArray, float]:
    """Return the part that explains most for what its limits cost.

    Args:
        jumps: of `jumps_of`.

    Returns:
        The part, by how much each jump is in it, and what it explains beyond that price.
    """
    tried = _rectangles()
    prices = _limit_counts(tried) @ PRICES
    worth = [gains_of(jumps, way, tried) - prices for way in (0, 1)]
    way = int(np.argmax([own.max() for own in worth]))
    best = int(worth[way].argmax())
    begin, end, low, high = tried[best]
    limits = no_limits()
    limits[way] = interval(low, high)
    signs = np.zeros(2 * _COUNT + 1)
    for sign, place in _corners(way, tried[best]):
        signs[place] += sign
    part = SurfacePart(float(ALONG[begin]), float(np.append(ALONG, 1.0)[end]), limits)
    return part, signs[:-1], float(worth[way][best])


def price(part: SurfacePart) -> float:
    """Return what a part has to explain of chi-square for its limits."""
    along = (part.begin > 0.0) + (part.end < 1.0)
    return float(along * PRICES[0] + np.isfinite(part.limits).sum() * PRICES[1])


def interval(low: int, high: int) -> tuple[float, float]:
    """Return from where to where it is across, in half widths."""
    return float(FROM[low]), float(np.append(FROM, np.inf)[high])


def gains_of(jumps: Jumps, way: int, tried: IntArray) -> FloatArray:
    """Return what rectangles explain of chi-square, shape (m,).

    Args:
        jumps: of `jumps_of`.
        way: axis across that limits them.
        tried: from and to which place they go along and across, see `_rectangles`, shape (m, 4).
    """
    # Beyond the tip, and beyond the other side, there is nothing.
    products, pulls = np.pad(jumps.products, (0, 1)), np.append(jumps.pulls, 0.0)
    corners = _corners(way, tried.T)
    pull, size = np.zeros(len(tried)), np.zeros(len(tried))
    for sign, own in corners:
        pull += sign * pulls[own]
        for other_sign, other in corners:
            size += sign * other_sign * products[own, other]
    gains, _ = explained(pull, size)
    return gains


def _rectangles() -> IntArray:
    """Return from and to which place rectangles go along and across, shape (m, 4).

    The number of places stands for the tip, or the other side. Of what has all the width and
    begins at the clamp the rest is tried.
    """
    along, across = (
        np.stack(np.triu_indices(count + 1, 1), axis=1) for count in (len(ALONG), len(FROM))
    )
    tried = np.hstack([np.repeat(along, len(across), axis=0), np.tile(across, (len(along), 1))])
    is_rest = (tried[:, 0] == 0) & (tried[:, 2] == 0) & (tried[:, 3] == len(FROM))
    return tried[~is_rest]


def _limit_counts(tried: IntArray) -> IntArray:
    """Return how many limits rectangles have along and across, shape (m, 2)."""
    begin, end, low, high = tried.T
    along = (begin > 0).astype(int) + (end < len(ALONG))
    return np.stack([along, (low > 0).astype(int) + (high < len(FROM))], axis=1)


def _corners(way: int, tried: IntArray) -> list[tuple[float, IntArray]]:
    """Return the jumps at the corners of rectangles with their signs; the last one is nowhere."""
    begin, end, low, high = tried
    jump_at = np.full((len(ALONG) + 1, len(FROM) + 1), 2 * _COUNT)
    numbers = np.arange(_COUNT).reshape(len(ALONG), len(FROM))
    jump_at[:-1, :-1] = way * _COUNT + numbers
    return [
        (1.0, jump_at[begin, low]),
        (-1.0, jump_at[end, low]),
        (-1.0, jump_at[begin, high]),
        (1.0, jump_at[end, high]),
    ]
