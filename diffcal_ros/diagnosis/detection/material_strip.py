# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A part of a body, limited across, that a depth camera reads too far or too near by one height.

A side that is painted, a strip of tape along the body, a sticker. What is limited along and across
is a sum of four jumps, each beyond one place along and one across, with signs: what any such part
explains is known from the inner products of those jumps.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diffcal_ros.diagnosis.detection.depth_discontinuity import (
    explained,
    Jumps,
    jumps_seen,
    with_jumps,
)
from diffcal_ros.diagnosis.detection.material_boundary import best_nearby, LEFT, seen_places
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.effects import strips
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
# Residuals of depth of each view [m], shape (n,), and where pixels are, shape (n,) or (n, 3).
Views = Sequence[tuple[FloatArray, FloatArray]]

# Limits that are tried: shares of the free length, from the clamp on, and half widths from the
# middle. Beyond the outermost there are faces alone.
_ALONG = np.linspace(0.0, 0.92, 13)
_FACE = 0.97
_ACROSS = np.array([-_FACE, *np.linspace(-0.9, 0.9, 19), _FACE])
_FROM = np.array([-np.inf, *_ACROSS])
_ALL_ACROSS = np.array([[-np.inf, np.inf]] * 2)
# A limit was chosen among so many: what each has to explain of chi-square, see `material_bands`.
_PRICES = 2.0 * np.log([len(_ALONG), len(_ACROSS)])
# It is looked for where patches are off by so much, chi-square each: else nothing is to be found.
_OFF = 2.0
# A limit is sharp or not by what pixels show within so many half widths, but for a share next to
# it, at least so many to either side in a view.
_AROUND, _BLURRED, _LEAST_PIXELS = 0.5, 0.3, 50
# One pose does not tell a part of the body from something before it. In each it is at least so
# high, of what is usual.
_LEAST_POSTURES, _LEAST_OF_HEIGHT = 2, 0.5
# How far pixels move a limit that patches tell, along and across.
_FARTHEST = (0.05, 0.1)


@dataclass(frozen=True)
class Strip:
    """A part of the surface.

    Attributes:
        borders: where it begins along the body, and where it ends short of the tip, as shares of
            the free length.
        limits: within which it is across, in half widths, see `strips`, shape (2, 2).
    """

    borders: tuple[float, ...]
    limits: FloatArray

    @property
    def settings(self) -> dict[str, float]:
        """Those of its limits across."""
        return strips.strip_settings(self.limits)

    def holds(self, places: FloatArray) -> NDArray[np.bool_]:
        """Tell which points are in it, shape (n,).

        Args:
            places: see `BodyAxes.on_surface`, shape (n, 3).
        """
        begin, end = (*self.borders, np.inf)[:2]
        along = (places[:, 0] > begin) & (places[:, 0] <= end)
        return np.asarray(along & strips.is_within(places[:, 1:], self.limits))


def find_strip(evaluator: PatchEvaluator, nominal: Refit, otherwise: float) -> Strip | None:
    """Return the part of a body that stands out; None where none does.

    Args:
        evaluator: of the nominal model.
        nominal: its fit.
        otherwise: chi-square that the best bands leave, which end along the body alone.
    """
    postures = {observation.setup_index for observation in evaluator.model.observations}
    if not evaluator.is_measured or len(postures) < _LEAST_POSTURES:
        return None
    if nominal.chi_square_per_patch < _OFF:
        return None
    found = [_best_of_way(evaluator, nominal, way) for way in (0, 1)]
    way = int(np.argmin([left for _, left in found]))
    strip, left = found[way]
    if left >= LEFT * otherwise:
        return None
    strip = _limited_in_other_way(evaluator, nominal, strip, 1 - way)
    views = seen_places(evaluator, nominal.coordinates)
    strip = _placed_by_pixels(views, strip)
    return strip if _goes_along(views, strip) and _is_sharp(views, strip) else None


def _best_of_way(evaluator: PatchEvaluator, nominal: Refit, way: int) -> tuple[Strip, float]:
    """Return the best part that is limited across one axis, and the chi-square that it leaves."""

    def jumps_of(places: FloatArray) -> FloatArray:
        along = places[:, :1] > _ALONG
        across = places[:, 1 + way, None] > _FROM
        return (along[:, :, None] & across[:, None]).reshape(len(places), -1).astype(np.float64)

    jumps = jumps_seen(with_jumps(evaluator, nominal, jumps_of), nominal)
    rectangles = _rectangles()
    gains = _gains(jumps, rectangles)
    best = int((gains - _limit_counts(rectangles) @ _PRICES).argmax())
    begin, end, low, high = rectangles[best]
    limits = _ALL_ACROSS.copy()
    limits[way] = _interval(low, high)
    strip = Strip((float(_ALONG[begin]), *_ALONG[end : end + 1].tolist()), limits)
    return strip, jumps.whole - float(gains[best])


def _rectangles() -> IntArray:
    """Return from and to which place rectangles go along and across, shape (m, 4).

    The number of places stands for the tip, or the other side; what has all the width is a band.
    """
    along, across = (
        np.stack(np.triu_indices(count + 1, 1), axis=1) for count in (len(_ALONG), len(_FROM))
    )
    across = across[(across[:, 0] > 0) | (across[:, 1] < len(_FROM))]
    return np.hstack([np.repeat(along, len(across), axis=0), np.tile(across, (len(along), 1))])


def _limit_counts(rectangles: IntArray) -> IntArray:
    """Return how many limits rectangles have along and across, shape (m, 2)."""
    begin, end, low, high = rectangles.T
    along = (begin > 0).astype(int) + (end < len(_ALONG))
    return np.stack([along, (low > 0).astype(int) + (high < len(_FROM))], axis=1)


def _gains(jumps: Jumps, rectangles: IntArray) -> FloatArray:
    """Return what rectangles explain of chi-square, shape (m,)."""
    begin, end, low, high = rectangles.T
    nowhere = len(jumps.pulls)  # Beyond the tip, and beyond the other side.
    products, pulls = np.pad(jumps.products, (0, 1)), np.append(jumps.pulls, 0.0)
    jump_at = np.full((len(_ALONG) + 1, len(_FROM) + 1), nowhere)
    jump_at[:-1, :-1] = np.arange(nowhere).reshape(len(_ALONG), len(_FROM))
    parts = (
        (1.0, jump_at[begin, low]),
        (-1.0, jump_at[end, low]),
        (-1.0, jump_at[begin, high]),
        (1.0, jump_at[end, high]),
    )
    pull, size = np.zeros(len(rectangles)), np.zeros(len(rectangles))
    for sign, own in parts:
        pull += sign * pulls[own]
        for other_sign, other in parts:
            size += sign * other_sign * products[own, other]
    gains, _ = explained(pull, size)
    return gains


def _interval(low: int, high: int) -> tuple[float, float]:
    """Return from where to where it is across, in half widths."""
    return float(_FROM[low]), float(np.append(_FROM, np.inf)[high])


def _limited_in_other_way(
    evaluator: PatchEvaluator, nominal: Refit, strip: Strip, way: int
) -> Strip:
    """Return a part limited across the other axis, too, if that pays."""

    def jumps_of(places: FloatArray) -> FloatArray:
        own = strip.holds(places)[:, None] & (places[:, 1 + way, None] > _FROM)
        return own.astype(np.float64)

    jumps = jumps_seen(with_jumps(evaluator, nominal, jumps_of), nominal)
    pairs = np.stack(np.triu_indices(len(_FROM) + 1, 1), axis=1)
    signs, rows = np.zeros((len(pairs), len(_FROM) + 1)), np.arange(len(pairs))
    signs[rows, pairs[:, 0]], signs[rows, pairs[:, 1]] = 1.0, -1.0
    gains, _ = jumps.gains(signs[:, :-1])
    limited = (pairs[:, 0] > 0).astype(int) + (pairs[:, 1] < len(_FROM))
    low, high = pairs[int((gains - _PRICES[1] * limited).argmax())]
    limits = strip.limits.copy()
    limits[way] = _interval(low, high)
    return replace(strip, limits=limits)


def _placed_by_pixels(views: Views, strip: Strip) -> Strip:
    """Return a part whose limits are where pixels see them."""
    across = Strip((-np.inf,), strip.limits)
    borders = tuple(
        _moved(views, across, 0, place, _FARTHEST[0]) if place > 0.0 else place
        for place in strip.borders
    )
    limits = strip.limits.copy()
    for way, end in np.argwhere(np.abs(strip.limits) < _FACE):
        others = _without_limit(strip, way)
        limits[way, end] = _moved(views, others, 1 + way, limits[way, end], _FARTHEST[1])
    return Strip(borders, limits)


def _moved(views: Views, part: Strip, way: int, place: float, reach: float) -> float:
    """Return where a limit leaves least, of pixels within the others."""
    return best_nearby(_within(views, part, way), float(place), reach)


def _goes_along(views: Views, strip: Strip) -> bool:
    """Tell whether each view in which a part and its surroundings are seen shows it.

    What is before a body, or before the camera, is somewhere else on it in another pose.
    """
    heights = []
    for residuals, places in views:
        own = strip.holds(places)
        if min(own.sum(), (~own).sum()) >= _LEAST_PIXELS:
            heights.append(float(np.median(residuals[own]) - np.median(residuals[~own])))
    usual = float(np.median(heights)) if len(heights) > 1 else np.nan
    return all(height / usual > _LEAST_OF_HEIGHT for height in heights) and np.isfinite(usual)


def _is_sharp(views: Views, strip: Strip) -> bool:
    """Tell whether jumps across leave less on the pixels around them than slopes do.

    Either has two numbers in each view. To patches, a tenth of the width each, both are alike; and
    next to a jump a camera that compares windows of its images blurs it.
    """
    jumps, slopes = 0.0, 0.0
    for way, end in np.argwhere(np.abs(strip.limits) < _FACE):
        limit = float(strip.limits[way, end])
        around = min(_AROUND, 0.5 * float(np.ptp(np.clip(strip.limits[way], -1.0, 1.0))))
        for residuals, across in _within(views, _without_limit(strip, way), 1 + way):
            apart = np.abs(across - limit)
            near = (apart < around) & (apart > _BLURRED * around)
            own, places = residuals[near], across[near] - limit
            is_beyond = places > 0.0
            if min(is_beyond.sum(), (~is_beyond).sum()) < _LEAST_PIXELS:
                continue
            jumps += _left_by(own, is_beyond.astype(np.float64))
            slopes += _left_by(own, places)
    return jumps <= slopes


def _left_by(values: FloatArray, shape: FloatArray) -> float:
    """Return the squares that a level and some of a shape leave of values, shape (n,) each."""
    columns = np.stack([np.ones(len(values)), shape], axis=1)
    found, *_ = np.linalg.lstsq(columns, values, rcond=None)
    return float(np.square(values - columns @ found).sum())


def _without_limit(strip: Strip, way: int) -> Strip:
    limits = strip.limits.copy()
    limits[way] = _ALL_ACROSS[way]
    return replace(strip, limits=limits)


def _within(views: Views, part: Strip, way: int) -> Views:
    """Return residuals of the pixels in a part, and how far along or across those are."""
    inside = [part.holds(places) for _, places in views]
    return [
        (residuals[held], places[held, way])
        for (residuals, places), held in zip(views, inside, strict=True)
    ]
