# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Parts of a body's surface that a depth camera reads too far or too near, each by its own height.

A side that is painted, strips of tape along the body, stickers, two paints. They are found one
after the other, each beside those that are known, as long as one leaves far less than before.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise

from diffcal_ros.diagnosis.detection.depth_discontinuity import Jumps, jumps_seen, with_jumps
from diffcal_ros.diagnosis.detection.material_boundary import LEFT, may_show_parts, seen_places
from diffcal_ros.diagnosis.detection.rectangles import (
    best_rectangle,
    FROM,
    interval,
    jumps_of,
    numbers_of,
    price,
    PRICES,
)
from diffcal_ros.diagnosis.detection.sharp_limits import are_parts, placed_by_pixels
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.effects import bands
from diffcal_ros.effects.surface_parts import held_by, SurfacePart
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def find_parts(
    evaluator: PatchEvaluator, nominal: Refit, otherwise: float
) -> tuple[SurfacePart, ...]:
    """Return the parts of a body's surface that stand out, the highest first; none where none do.

    Args:
        evaluator: of the nominal model.
        nominal: its fit.
        otherwise: chi-square that the best bands of one height leave, which end along it alone.
    """
    if not may_show_parts(evaluator, nominal):
        return ()
    groups = with_jumps(evaluator, nominal, jumps_of, numbers_of)
    found = _one_after_the_other(jumps_seen(groups, nominal))
    if not found:
        return ()
    views = seen_places(evaluator, nominal.coordinates)
    for number in range(len(found)):
        found[number] = _limited_in_both_ways(evaluator, nominal, found, number)
    found = [placed_by_pixels(views, part) for part in as_stretches(found)]
    parts, left = _with_heights(evaluator, nominal, found)
    is_banded = not any(np.isfinite(part.limits).any() for part in parts)
    # What ends along the body alone are bands, too, each of its own height.
    most = otherwise - PRICES[0] if is_banded and len(parts) > 1 else LEFT * otherwise
    return parts if left < most and are_parts(views, parts) else ()


def _one_after_the_other(jumps: Jumps) -> list[SurfacePart]:
    """Return the parts that explain most, each beside those before, as long as they pay."""
    found = list[SurfacePart]()
    while len(found) < bands.MOST_BANDS:
        part, signs, worth = best_rectangle(jumps)
        if worth <= (1.0 - LEFT) * jumps.whole:
            break
        found.append(part)
        jumps = jumps.beside(signs)
    return found


def _limited_in_both_ways(
    evaluator: PatchEvaluator, nominal: Refit, parts: Sequence[SurfacePart], number: int
) -> SurfacePart:
    """Return one of some parts limited across the axis that does not limit it, too, if that pays.

    Of what has all the width nothing is asked.
    """
    part = parts[number]
    free = [way for way in (0, 1) if not np.isfinite(part.limits[way]).any()]
    if len(free) != 1:
        return part
    others = [own for own in parts if own is not part]
    own_jumps = partial(_beyond_limits, part, others, free[0])
    jumps = jumps_seen(with_jumps(evaluator, nominal, own_jumps), nominal)
    for other in np.eye(len(jumps.pulls))[: len(others)]:
        jumps = jumps.beside(other)
    pairs = np.stack(np.triu_indices(len(FROM) + 1, 1), axis=1)
    signs, rows = np.zeros((len(pairs), len(FROM) + 1)), np.arange(len(pairs))
    signs[rows, pairs[:, 0]], signs[rows, pairs[:, 1]] = 1.0, -1.0
    gains, _ = jumps.gains(np.hstack([np.zeros((len(pairs), len(others))), signs[:, :-1]]))
    limited = (pairs[:, 0] > 0).astype(int) + (pairs[:, 1] < len(FROM))
    low, high = pairs[int((gains - PRICES[1] * limited).argmax())]
    limits = part.limits.copy()
    limits[free[0]] = interval(low, high)
    return replace(part, limits=limits)


def _beyond_limits(
    part: SurfacePart, others: Sequence[SurfacePart], way: int, places: FloatArray
) -> FloatArray:
    """Return what is in other parts, and in a part beyond each limit across an axis, (M, s)."""
    beside = held_by(others, places)
    own = part.holds(places)[:, None] & (places[:, 1 + way, None] > FROM)
    return np.hstack([beside, own.astype(np.float64)])


def as_stretches(parts: Sequence[SurfacePart]) -> list[SurfacePart]:
    """Return parts that have all the width as the stretches between their borders."""
    if any(np.isfinite(part.limits).any() for part in parts):
        return list(parts)
    borders = sorted({end for part in parts for end in (part.begin, part.end)})
    return [
        SurfacePart(begin, end, parts[0].limits)
        for begin, end in pairwise(borders)
        if any(part.begin <= begin and end <= part.end for part in parts)
    ][: bands.MOST_BANDS]


def _with_heights(
    evaluator: PatchEvaluator, nominal: Refit, parts: Sequence[SurfacePart]
) -> tuple[tuple[SurfacePart, ...], float]:
    """Return parts with how many times as high as the highest, their first, each is.

    With them the chi-square that they leave together.
    """
    jumps = jumps_seen(with_jumps(evaluator, nominal, partial(held_by, parts)), nominal)
    jumps, parts = _that_pay(jumps, parts)
    heights, left = jumps.heights()
    order = np.argsort(-np.abs(heights))
    times = heights / heights[order[0]]
    return tuple(replace(parts[n], times=float(times[n])) for n in order), left


def _that_pay(jumps: Jumps, parts: Sequence[SurfacePart]) -> tuple[Jumps, Sequence[SurfacePart]]:
    """Return the parts, one jump each, without which more would be left than their limits cost.

    Limited in both ways and placed, a later part may be all that an earlier one was.
    """
    while len(parts) > 1:
        left = jumps.heights()[1]
        others = [np.arange(len(parts)) != number for number in range(len(parts))]
        without = [_only(jumps, own) for own in others]
        paid = [own.heights()[1] - left - price(p) for own, p in zip(without, parts, strict=True)]
        least = int(np.argmin(paid))
        if paid[least] > 0.0:
            break
        jumps = without[least]
        parts = [part for number, part in enumerate(parts) if number != least]
    return jumps, parts


def _only(jumps: Jumps, chosen: NDArray[np.bool_]) -> Jumps:
    return replace(
        jumps, products=jumps.products[np.ix_(chosen, chosen)], pulls=jumps.pulls[chosen]
    )
