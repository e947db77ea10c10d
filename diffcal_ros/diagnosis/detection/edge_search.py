# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The likeliest edge in the picture, straight or round, beside what is smooth in each pose.

Steps at all places along a way are told at once, by sums over the pixels between them.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import product

from diffcal_ros.diagnosis.detection.pictured_views import (
    LEAST_PIXELS,
    left_by,
    PicturedView,
    SeenEdge,
)
from diffcal_ros.diagnosis.detection.spot_map import left_by_smooth, regular, robust_weights
from diffcal_ros.effects.picture_edge import MOST_CURVED, PictureEdge
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

FloatArray = NDArray[np.float64]
# Ways along which edges lie, each of one that is there at none of its places.
Ways = Iterable[PictureEdge]
# What an edge along a way explains at best, that way, and where it is in each view.
_Offer = tuple[float, PictureEdge, tuple[float, ...]]

# Ways that are tried first, by ten degrees; then by one about the best; and places along each.
_TURNS = np.deg2rad(np.arange(-90.0, 90.0, 10.0))
_NEAR_TURNS = np.deg2rad(np.arange(-6.0, 7.0, 1.0))
_PLACES = 96
# Of round edges one over how far the middle is, on either side, and near those: by few pixels at
# first.
_CURVES = np.array([0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0])
_NEAR_ROUND = (
    (np.deg2rad([-6.0, -3.0, 0.0, 3.0, 6.0]), np.array([0.7, 0.85, 1.0, 1.2, 1.4])),
    (np.deg2rad([-1.5, 0.0, 1.5]), np.array([0.92, 1.0, 1.08])),
)
_FEW_PIXELS, _MORE_PIXELS = 1200, 5000
# Heights of an edge that is elsewhere in each pose [m].
_HEIGHTS = np.geomspace(0.0008, 0.03, 24)
_WIDTHS = (0.0, 0.01, 0.02, 0.04, 0.08)


@dataclass(frozen=True)
class _Steps:
    """What steps at some places explain of one view, beside what is smooth.

    Attributes:
        pulls: of a step of one metre with what is left [m], shape (p,).
        sizes: of what it does, squared, shape (p,).
    """

    pulls: FloatArray
    sizes: FloatArray


@dataclass(frozen=True)
class _Smoothed:
    """A view beside what is smooth.

    Attributes:
        view: pixels.
        columns: by pixel its weight, that times what is left [m], and times what is smooth, shape
            (n, 2 + k).
        products: of what is smooth, by weight, shape (k, k).
    """

    view: PicturedView
    columns: FloatArray
    products: FloatArray

    @classmethod
    def of(cls, view: PicturedView) -> '_Smoothed':
        """Return it for a view."""
        left, smooth = left_by_smooth(view.pixels), view.pixels.smooth
        weights = robust_weights(left)
        products = regular(smooth.T @ (weights[:, None] * smooth))
        weighted = weights[:, None] * np.column_stack([np.ones(len(left)), left, smooth])
        return cls(view, weighted, products)

    def along(self, way: PictureEdge) -> FloatArray:
        """Return how far along a way pixels are, shape (n,)."""
        return way.along(self.view.directions)

    def steps(self, way: PictureEdge, places: FloatArray) -> _Steps:
        """Return what steps at places along a way, in their order, explain, shape (p,)."""
        # Between which of the places each pixel is: all of the last such are beyond all of them.
        beyond = np.searchsorted(places, self.along(way), side='right')
        count = len(beyond)
        of_pixels = csc_array(
            (np.ones(count), beyond, np.arange(count + 1)), shape=(len(places) + 1, count)
        )
        between = np.asarray(of_pixels @ self.columns)
        sums = np.cumsum(between[::-1], axis=0)[::-1][1:]
        followed = np.linalg.solve(self.products, sums[:, 2:].T)
        sizes = sums[:, 0] - np.einsum('pk,kp->p', sums[:, 2:], followed)
        # What is left was fitted with these weights: it has nothing in common with what is smooth.
        return _Steps(sums[:, 1], np.maximum(sizes, 0.0))


def straight_edge(views: Sequence[PicturedView], *, is_fixed: bool) -> SeenEdge:
    """Return the likeliest straight edge.

    Args:
        views: pixels.
        is_fixed: whether it is at one place in all poses; else it goes the same way in all, as
            high, wherever it is.
    """
    smoothed, best_along = [_Smoothed.of(view) for view in views], _best_along(is_fixed)
    best = best_along(smoothed, [PictureEdge(turn, 0.0) for turn in _TURNS.tolist()])
    near = [PictureEdge(best[1].turn + turn, 0.0) for turn in _NEAR_TURNS.tolist()]
    return _seen(views, max(best, best_along(smoothed, near), key=_gain), is_fixed)


def round_edge(views: Sequence[PicturedView], *, is_fixed: bool) -> SeenEdge:
    """Return the likeliest round edge; see `straight_edge`.

    One that is elsewhere in each pose is as far from the same middle as may be there.
    """
    best_along = _best_along(is_fixed)
    ways = [
        PictureEdge(turn, 0.0, curve=curve)
        for turn, curve in product(_TURNS.tolist(), np.append(-_CURVES, _CURVES).tolist())
    ]
    _, way, places = best_along([_Smoothed.of(_some_of(v, _FEW_PIXELS)) for v in views], ways)
    best: _Offer = (-1.0, way, places)
    smoothed = [_Smoothed.of(_some_of(view, _MORE_PIXELS)) for view in views]
    for turns, shares in _NEAR_ROUND:
        near = [
            replace(best[1], turn=best[1].turn + turn, curve=_within(best[1].curve * share))
            for turn, share in product(turns.tolist(), shares.tolist())
        ]
        best = max(best, best_along(smoothed, near), key=_gain)
    return _seen(views, best, is_fixed)


def _within(curve: float) -> float:
    return float(np.clip(curve, -MOST_CURVED, MOST_CURVED))


def _some_of(view: PicturedView, count: int) -> PicturedView:
    """Return about so many of the pixels of a view, wherever it has some."""
    step = max(len(view.directions) // count, 1)
    return view.where(np.arange(len(view.directions)) % step == 0)


def _gain(offer: _Offer) -> float:
    return offer[0]


def _best_along(is_fixed: bool) -> Callable[[Sequence[_Smoothed], Ways], _Offer]:
    """Return who finds the edge that explains most along one of some ways."""
    along = _fixed_along if is_fixed else _moved_along
    return lambda views, ways: max((along(views, way) for way in ways), key=_gain)


def _seen(views: Sequence[PicturedView], best: _Offer, is_fixed: bool) -> SeenEdge:
    """Return an edge as wide as leaves least."""
    _, way, places = best
    edges = {
        view.posture: replace(way, place=own) for view, own in zip(views, places, strict=True)
    }
    found = SeenEdge(edges, is_fixed=is_fixed)
    offered = [
        replace(found, edges={k: replace(own, width=width) for k, own in found.edges.items()})
        for width in _WIDTHS
    ]
    some = [_some_of(view, _MORE_PIXELS) for view in views]
    return offered[int(np.argmin([left_by(some, own) for own in offered]))]


def _fixed_along(views: Sequence[_Smoothed], way: PictureEdge) -> _Offer:
    along = [view.along(way) for view in views]
    ends = min(own.min() for own in along), max(own.max() for own in along)
    places = np.linspace(*ends, _PLACES)
    steps = [view.steps(way, places) for view in views]
    sizes = np.sum([own.sizes for own in steps], axis=0)
    gains = np.sum([own.pulls for own in steps], axis=0) ** 2 / (sizes + LEAST_PIXELS)
    number = int(gains.argmax())
    return float(gains[number]), way, (float(places[number]),) * len(views)


def _moved_along(views: Sequence[_Smoothed], way: PictureEdge) -> _Offer:
    ways = [view.along(way) for view in views]
    offered = [np.linspace(own.min(), own.max(), _PLACES) for own in ways]
    steps = [view.steps(way, places) for view, places in zip(views, offered, strict=True)]
    heights = np.concatenate([_HEIGHTS, -_HEIGHTS])[:, None]
    gains = [2.0 * heights * own.pulls - heights**2 * own.sizes for own in steps]
    wholes = np.sum([own.max(axis=1) for own in gains], axis=0)
    best = int(wholes.argmax())
    places = [float(own[gain[best].argmax()]) for own, gain in zip(offered, gains, strict=True)]
    return float(wholes[best]), way, tuple(places)
