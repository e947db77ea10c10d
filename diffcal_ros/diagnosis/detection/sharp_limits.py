# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whether parts of a surface end where pixels say, and at once: what is smooth is no part."""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.diagnosis.detection.material_boundary import best_nearby, left_by_jump
from diffcal_ros.effects.surface_parts import FACE, SurfacePart
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
# Residuals of depth of each view [m], shape (n,), and where pixels are, shape (n,) or (n, 3).
Views = Sequence[tuple[FloatArray, FloatArray]]

# A limit is sharp or not by what pixels show within so much, along and across, but for a share
# next to it, at least so many to either side in a view.
_AROUND, _BLURRED, _LEAST_PIXELS = (0.1, 0.5), 0.3, 50
# A body's bend along it that a modulus makes, of this degree.
_BENT = 2
# In each pose a part is at least so high, of what is usual.
LEAST_OF_HEIGHT = 0.5
# How far pixels move a limit that patches tell.
_FARTHEST = (0.05, 0.1)
# A slanted border is placed by pixels so near to it, along the body, by three steps of each size:
# its place and either slant go by one up, down, or stay.
_NEAR_SLANT, _SLANT_STEPS = 0.2, np.repeat([0.04, 0.02, 0.01, 0.005], 3)
_CUBE = np.stack(np.meshgrid(*[(0.0, -1.0, 1.0)] * 3, indexing='ij'), axis=-1).reshape(-1, 3)
# Limits on the surface, along and across: what is farther out is none, or a face's edge.
_ALONG, _ACROSS = (0.0, 1.0), (-FACE, FACE)


def placed_by_pixels(views: Views, part: SurfacePart) -> SurfacePart:
    """Return a part whose limits are where pixels see them."""
    for way, end, place in _limits_of(part):
        others = _with_limit(part, way, end, None)
        found = best_nearby(_within(views, others, way), place, _FARTHEST[way > 0])
        part = _with_limit(part, way, end, found)
    return slanted_by_pixels(views, part) if any(part.slants) else part


def slanted_by_pixels(views: Views, part: SurfacePart) -> SurfacePart:
    """Return a part that begins along the body and goes on to the tip as aslant as pixels see.

    Args:
        views: residuals and places of pixels.
        part: limited along the body alone, and about where it begins.
    """
    near = [np.abs(part.along(places) - part.begin) < _NEAR_SLANT for _, places in views]
    own = [(left[kept], where[kept]) for (left, where), kept in zip(views, near, strict=True)]

    def at(border: FloatArray) -> SurfacePart:
        begin, *slants = border.tolist()
        return replace(part, begin=begin, slants=(slants[0], slants[1]))

    best = np.array([part.begin, *part.slants])
    for step in _SLANT_STEPS:
        around = best + step * _CUBE
        best = around[int(np.argmin([_left_beyond(own, at(border)) for border in around]))]
    return at(best.round(4))


def _left_beyond(views: Views, part: SurfacePart) -> float:
    """Return the sum of absolute residuals that a jump where a part begins leaves [m]."""
    return sum(left_by_jump(own, part.along(places) > part.begin) for own, places in views)


def is_sharp(views: Views, part: SurfacePart) -> bool:
    """Tell whether jumps leave less on the pixels around limits than slopes do.

    Either has two numbers in each view. To patches, a tenth of the width each, both are alike; and
    next to a jump a camera that compares windows of its images blurs it.
    """
    jumps, slopes = 0.0, 0.0
    ends = [(part.begin, part.end), *np.clip(part.limits, -1.0, 1.0).tolist()]
    for way, end, place in _limits_of(part):
        around = min(_AROUND[way > 0], 0.5 * (ends[way][1] - ends[way][0]))
        for residuals, places in _within(views, _with_limit(part, way, end, None), way):
            apart = np.abs(places - place)
            near = (apart < around) & (apart > _BLURRED * around)
            own, beyond = residuals[near], places[near] - place
            is_beyond = beyond > 0.0
            if min(is_beyond.sum(), (~is_beyond).sum()) < _LEAST_PIXELS:
                continue
            jumps += _left_by(own, is_beyond.astype(np.float64))
            slopes += _left_by(own, beyond)
    return jumps <= slopes


def are_parts(views: Views, parts: Sequence[SurfacePart]) -> bool:
    """Tell whether all poses show parts, and sharp ones."""
    return _go_along(views, parts) and all(is_sharp(views, own) for own in parts)


def _go_along(views: Views, parts: Sequence[SurfacePart]) -> bool:
    """Tell whether each view in which a part and what is no part are seen shows it, of all parts.

    What is before a body, or before the camera, is somewhere else on it in another pose.

    Args:
        views: residuals and places of pixels.
        parts: of the surface.
    """
    heights = np.array([_heights_in(residuals, at, parts) for residuals, at in views])
    shown = np.isfinite(heights)
    # One view does not tell.
    if (shown.sum(axis=0) < 2).any():
        return False
    usual = np.nanmedian(heights, axis=0)
    return bool((heights / usual > LEAST_OF_HEIGHT)[shown].all())


def _heights_in(
    residuals: FloatArray, places: FloatArray, parts: Sequence[SurfacePart]
) -> FloatArray:
    """Return how high parts are in one view [m], shape (p,); NaN of what is hardly seen there.

    Beside other parts, and a body that may be bent otherwise.
    """
    columns = [*np.vander(places[:, 0], 1 + _BENT).T, *(own.holds(places) for own in parts)]
    heights = []
    for number in range(1 + _BENT, len(columns)):
        others = np.array(columns[:number] + columns[number + 1 :], dtype=np.float64).T
        both = np.array([columns[number], residuals], dtype=np.float64).T
        followed, *_ = np.linalg.lstsq(others, both, rcond=None)
        own, left = (both - others @ followed).T
        size = float(own @ own)
        heights.append(float(own @ left) / size if size > _LEAST_PIXELS else np.nan)
    return np.array(heights)


def _limits_of(part: SurfacePart) -> list[tuple[int, int, float]]:
    """Return a part's limits on the surface: along or across which axis, which end, and where."""
    ends = np.array([(part.begin, part.end), *part.limits])
    least, most = np.array([_ALONG, _ACROSS, _ACROSS]).T
    own = np.argwhere((ends > least[:, None]) & (ends < most[:, None]))
    return [(int(way), int(end), float(ends[way, end])) for way, end in own]


def _with_limit(part: SurfacePart, way: int, end: int, place: float | None) -> SurfacePart:
    """Return a part with another limit; None: with none there."""
    if way == 0:
        if end == 0:
            return replace(part, begin=-1.0 if place is None else place)
        return replace(part, end=1.0 if place is None else place)
    limits = part.limits.copy()
    limits[way - 1, end] = (-np.inf, np.inf)[end] if place is None else place
    return replace(part, limits=limits)


def _within(views: Views, part: SurfacePart, way: int) -> Views:
    """Return residuals of the pixels in a part, and how far along or across those are."""
    inside = [part.holds(places) for _, places in views]
    return [
        (residuals[held], part.along(places[held]) if way == 0 else places[held, way])
        for (residuals, places), held in zip(views, inside, strict=True)
    ]


def _left_by(values: FloatArray, shape: FloatArray) -> float:
    """Return the squares that a level and some of a shape leave of values, shape (n,) each."""
    columns = np.stack([np.ones(len(values)), shape], axis=1)
    found, *_ = np.linalg.lstsq(columns, values, rcond=None)
    return float(np.square(values - columns @ found).sum())
