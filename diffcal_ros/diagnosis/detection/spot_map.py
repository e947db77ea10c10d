# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which cells of a body's surface a depth camera reads otherwise, told pixel by pixel.

Pixels of all poses that see a cell are averaged beside what is smooth in each pose, whatever bent
or moved the body there: a texture of the surface is finer. Cells are of two levels, as what is
printed or stuck on is; which of the two reads right is not told here.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diffcal_ros.effects.spots import cells_of, ROUND, ROWS
from diffcal_ros.median_spread import median_spread
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]

CELLS = ROWS * ROUND
# What is smooth along the body is of this degree, and of the next what changes across it.
_ALONG, _ASIDE = 4, 2
# Pixels off by so many spreads count half (Cauchy's weights).
_HALF = 3.0
_LEAST_SPREAD = 1e-4
# One that counts less than that is an outlier.
_LEAST_WEIGHT = 0.5
# A cell that fewer pixels see is not known.
_LEAST_PIXELS = 3
_ROUNDS, _MOST_ROUNDS = 10, 20
# So many cells are between pixels of a side that is seen aslant.
_FILLED = 2.0


@dataclass(frozen=True)
class SpottedView:
    """Pixels of one view.

    Attributes:
        left: what the model leaves of their depth [m], shape (n,).
        cells: of the surface that they see, shape (n,).
        smooth: functions of where that is, shape (n, k).
    """

    left: FloatArray
    cells: IntArray
    smooth: FloatArray

    @classmethod
    def of(cls, left: FloatArray, places: FloatArray) -> 'SpottedView':
        """Return it for residuals of depth [m], shape (n,), and their places, shape (n, 3)."""
        along = np.polynomial.legendre.legvander(2.0 * places[:, 0] - 1.0, _ALONG)
        across = [along[:, : _ASIDE + 1] * places[:, way, None] for way in (1, 2)]
        return cls(left, cells_of(places), np.hstack([along, *across]))

    def where(self, chosen: BoolArray) -> 'SpottedView':
        """Return some of the pixels."""
        return SpottedView(self.left[chosen], self.cells[chosen], self.smooth[chosen])

    def is_followed(self, found: 'SpotMap') -> BoolArray:
        """Tell which pixels a map and what is smooth leave no outliers, shape (n,)."""
        left, _ = left_beside(self, self.on(found.levels))
        return np.asarray(robust_weights(left) >= _LEAST_WEIGHT)

    def on(self, levels: FloatArray) -> FloatArray:
        """Return the level of the cell that each pixel sees, shape (n, 1)."""
        return np.asarray(levels[self.cells, None])


@dataclass(frozen=True)
class SpotMap:
    """A map of two levels.

    Attributes:
        is_spot: which cells are of the second, shape (CELLS,).
        is_seen: which are seen at all, likewise.
        is_known: which are seen by several pixels, likewise.
        height: by how much those of the second are read too far [m].
    """

    is_spot: BoolArray
    is_seen: BoolArray
    is_known: BoolArray
    height: float

    @property
    def levels(self) -> FloatArray:
        """What a map of one metre adds to each cell [m], shape (CELLS,)."""
        return self.is_spot.astype(np.float64)


def spot_map(views: Sequence[SpottedView]) -> SpotMap:
    """Return the map that leaves least of what pixels are off by."""
    counts = np.bincount(np.concatenate([view.cells for view in views]), minlength=CELLS)
    start = [_about_the_middle(view) for view in views]
    weights = [np.ones(len(own)) for own in start]
    is_spot = _cell_means(views, start, weights) > 0.0
    found = SpotMap(is_spot, counts > 0, counts >= _LEAST_PIXELS, 0.0)
    for _ in range(_MOST_ROUNDS):
        height, rests, weights = _two_levels(views, found, weights)
        found = replace(found, height=height)
        means = _cell_means(views, rests, weights)
        is_spot = found.is_seen & (np.sign(height) * means > 0.5 * abs(height))
        if (is_spot == found.is_spot).all():
            break
        found = replace(found, is_spot=is_spot)
    return found


def nearer_the_second(views: Sequence[SpottedView], height: float) -> BoolArray:
    """Return which cells are nearer to a level [m] than to none, shape (CELLS,).

    What no pixel happens to see beside cells that some do is as the nearest of those.

    Args:
        views: pixels, with what is off beside all but the map.
        height: of the level.
    """
    values = [view.left for view in views]
    weights = [robust_weights(np.where(own / height > 0.5, own - height, own)) for own in values]
    is_spot = _cell_means(views, values, weights) / height > 0.5
    is_seen = np.bincount(np.concatenate([v.cells for v in views]), minlength=CELLS) > 0
    apart, nearest = distance_transform_edt(~is_seen.reshape(ROWS, ROUND), return_indices=True)
    filled = is_spot.reshape(ROWS, ROUND)[tuple(nearest)] & (apart <= _FILLED)
    return np.asarray(filled.ravel())


def left_beside(view: SpottedView, columns: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return what something and what is smooth leave of a view [m], shape (n,), and their sizes.

    Args:
        view: pixels.
        columns: what else may be there, shape (n, p).

    Returns:
        What is left, and how much there is of each column, shape (p,).
    """
    both = np.hstack([columns, view.smooth])
    weights = np.ones(len(view.left))
    for _ in range(_ROUNDS):
        sizes = _solved(both, view.left, weights)
        left = view.left - both @ sizes
        weights = robust_weights(left)
    return left, sizes[: columns.shape[1]]


def left_by_smooth(view: SpottedView) -> FloatArray:
    """Return what is left beside what is smooth alone [m], shape (n,)."""
    return left_beside(view, np.zeros((len(view.left), 0)))[0]


def left_by_map(views: Sequence[SpottedView], levels: FloatArray) -> float:
    """Return the sum of absolute residuals that a map and what is smooth leave of views [m].

    Args:
        views: pixels.
        levels: of the cells, shape (CELLS,).
    """
    return sum_left(views, [view.on(levels) for view in views])


def sum_left(views: Sequence[SpottedView], columns: Sequence[FloatArray]) -> float:
    """Return the same for anything else, of each view by columns, shape (n, p) [m]."""
    pairs = zip(views, columns, strict=True)
    return sum(float(np.abs(left_beside(view, own)[0]).sum()) for view, own in pairs)


def _about_the_middle(view: SpottedView) -> FloatArray:
    """Return what a view is off by from the middle of two levels [m], shape (n,)."""
    rough = left_by_smooth(view)
    return rough - middle_of_two(rough[np.argsort(np.abs(rough))][: int(0.98 * len(rough))])


def middle_of_two(values: FloatArray) -> float:
    """Return the threshold that parts values into two most unlike groups (Otsu 1979).

    Args:
        values: shape (n,).
    """
    ordered = np.sort(values)
    count = np.arange(1, len(ordered))
    sums = np.cumsum(ordered)[:-1]
    others = len(ordered) - count
    apart = sums / count - (ordered.sum() - sums) / others
    best = int((apart**2 * count * others).argmax())
    return float(0.5 * (ordered[best] + ordered[best + 1]))


def _two_levels(
    views: Sequence[SpottedView], found: SpotMap, weights: Sequence[FloatArray]
) -> tuple[float, list[FloatArray], list[FloatArray]]:
    """Return a map's height [m], what views are off by beside what is smooth, and new weights."""
    pull = size = 0.0
    parts = []
    for view, own in zip(views, weights, strict=True):
        both = np.column_stack([view.on(found.levels), view.left])
        smooth = view.smooth * own[:, None]
        followed = np.linalg.solve(regular(smooth.T @ view.smooth), smooth.T @ both)
        level, left = (both - view.smooth @ followed).T
        pull += float((own * level) @ left)
        size += float((own * level) @ level)
        parts.append((level, left, view.on(found.levels)[:, 0]))
    height = pull / max(size, 1e-12)
    # Off from the lower level, as if the map's own part of what is smooth were not taken out.
    rests = [left - height * level + height * on for level, left, on in parts]
    return height, rests, [robust_weights(left - height * level) for level, left, _ in parts]


def _cell_means(
    views: Sequence[SpottedView], values: Sequence[FloatArray], weights: Sequence[FloatArray]
) -> FloatArray:
    """Return the mean of each cell [m], shape (CELLS,); 0 of those that none sees."""
    cells = np.concatenate([view.cells for view in views])
    shares = np.concatenate(weights)
    total = np.bincount(cells, shares, minlength=CELLS)
    sums = np.bincount(cells, shares * np.concatenate(values), minlength=CELLS)
    return np.asarray(sums / np.maximum(total, 1e-12))


def _solved(columns: FloatArray, values: FloatArray, weights: FloatArray) -> FloatArray:
    weighted = columns * weights[:, None]
    return np.linalg.solve(regular(weighted.T @ columns), weighted.T @ values)


def regular(products: FloatArray) -> FloatArray:
    """Return inner products of functions of which some may be alike, or none."""
    return products + 1e-9 * (1.0 + np.trace(products)) * np.eye(len(products))


def robust_weights(left: FloatArray) -> FloatArray:
    """Return how much pixels count that are off by so much [m], shape (n,)."""
    spread = median_spread(left) + _LEAST_SPREAD
    return np.asarray(1.0 / (1.0 + (left / (_HALF * spread)) ** 2))
