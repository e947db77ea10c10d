# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whether pixels of several poses show an edge in the picture, and not one of the body."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diffcal_ros.diagnosis.detection.depth_discontinuity import OF_SMOOTH
from diffcal_ros.diagnosis.detection.material_boundary import LEAST_POSTURES, LEFT
from diffcal_ros.diagnosis.detection.sharp_limits import LEAST_OF_HEIGHT
from diffcal_ros.diagnosis.detection.spot_map import (
    left_beside,
    robust_weights,
    SpottedView,
    sum_left,
)
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.effects.picture_edge import PictureEdge
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

# On either side of an edge that a view shows.
LEAST_PIXELS = 200
# Poses that show one that is elsewhere in each.
_LEAST_MOVED = 3
# What goes over into each other over so much of what a view shows is no edge.
_SOFT = 0.3
# Borders on the body that are tried in its place, along it and across both axes, and how far from
# there pixels see one of a body that is elsewhere than its model.
_ASIDE = np.linspace(-0.9, 0.9, 19)
_BORDERS = (np.linspace(0.03, 0.97, 33), _ASIDE, _ASIDE)
_ELSEWHERE = (0.05, 0.15, 0.15)
# Pixels that count less are outliers.
_LEAST_WEIGHT = 0.5


@dataclass(frozen=True)
class PicturedView:
    """Pixels of one view.

    Attributes:
        pixels: what the model leaves of their depth, and what is smooth.
        directions: in which they are seen, x / z and y / z, shape (n, 2).
        places: of the body that they see, see `BodyAxes.on_surface`, shape (n, 3).
        posture: number of the pose.
    """

    pixels: SpottedView
    directions: FloatArray
    places: FloatArray
    posture: int

    def where(self, chosen: BoolArray) -> 'PicturedView':
        """Return some of the pixels."""
        return PicturedView(
            self.pixels.where(chosen), self.directions[chosen], self.places[chosen], self.posture
        )


@dataclass(frozen=True)
class SeenEdge:
    """An edge.

    Attributes:
        edges: by the number of the pose.
        is_fixed: whether it is at the same place in all.
    """

    edges: dict[int, PictureEdge]
    is_fixed: bool

    def column(self, view: PicturedView) -> FloatArray:
        """Return by how much pixels of a view are beyond it, shape (n, 1)."""
        return self.edges[view.posture].beyond(view.directions)[:, None]


def pictured_views(evaluator: PatchEvaluator, fit: Refit) -> list[PicturedView]:
    """Return what a model leaves of the pixels of all views, see `find_picture_edge`."""
    model, found = evaluator.model, []
    compared = evaluator.comparisons(fit.coordinates)
    views = model.views(fit.coordinates)
    own = zip(evaluator.comparers, views, compared, model.observations, strict=True)
    for comparer, view, comparison, observation in own:
        is_seen = np.isfinite(comparison.difference) & comparison.counted
        seen = comparer.seen(view, np.flatnonzero(is_seen).astype(np.int32))
        assert seen.directions is not None
        assert seen.places is not None
        pixels = SpottedView.of(comparison.difference[is_seen], seen.places)
        found.append(PicturedView(pixels, seen.directions, seen.places, observation.setup_index))
    return found


def left_by(views: Sequence[PicturedView], found: SeenEdge | None) -> float:
    """Return the sum of absolute residuals that an edge and what is smooth leave [m].

    Args:
        views: pixels.
        found: the edge; None: what is smooth alone.
    """
    if found is None:
        return _left([(view, np.zeros((len(view.directions), 0))) for view in views])
    return _left([(view, found.column(view)) for view in views])


def is_there(views: Sequence[PicturedView], found: SeenEdge) -> bool:
    """Tell whether poses show an edge, sharp and about as high in all, and none of the body's.

    By the pixels that it can follow, as of spots; and a border of the body leaves far more. One
    that is elsewhere in each pose is shown by three: two may have a step each.

    Args:
        views: pixels.
        found: the edge.
    """
    showing = [view for view in views if _divides(view, found)]
    least = LEAST_POSTURES if found.is_fixed else _LEAST_MOVED
    if len({view.posture for view in showing}) < least:
        return False
    heights = np.array([left_beside(v.pixels, found.column(v))[1][0] for v in showing])
    if (heights / np.median(heights) < LEAST_OF_HEIGHT).any():
        return False
    kept = [view.where(_is_followed(view, found)) for view in showing]
    left = left_by(kept, found)
    most = min(LEFT * left_by(kept, None), OF_SMOOTH * _left_by_soft(kept, found))
    return left < most and left < LEFT * _left_by_borders(kept)


def _left(columns: Sequence[tuple[PicturedView, FloatArray]]) -> float:
    return sum_left([view.pixels for view, _ in columns], [own for _, own in columns])


def _divides(view: PicturedView, found: SeenEdge) -> bool:
    """Tell whether a view shows both sides of an edge."""
    is_beyond = found.column(view)[:, 0] > 0.5
    return min(int(is_beyond.sum()), int((~is_beyond).sum())) >= LEAST_PIXELS


def _is_followed(view: PicturedView, found: SeenEdge) -> BoolArray:
    left, _ = left_beside(view.pixels, found.column(view))
    return np.asarray(robust_weights(left) >= _LEAST_WEIGHT)


def _left_by_soft(views: Sequence[PicturedView], found: SeenEdge) -> float:
    """Return what a slope over a part of each view leaves in place of an edge [m]."""
    columns = []
    for view in views:
        edge = found.edges[view.posture]
        width = _SOFT * float(np.ptp(edge.along(view.directions)))
        columns.append((view, replace(edge, width=width).beyond(view.directions)[:, None]))
    return _left(columns)


def _left_by_borders(views: Sequence[PicturedView]) -> float:
    """Return what the best border on the body leaves, along it or across [m].

    It is at one place of the body in all poses, as far as the model knows where that is.
    """
    left = []
    for way, (places, reach) in enumerate(zip(_BORDERS, _ELSEWHERE, strict=True)):
        by_view = np.array([[_left_beyond(view, way, own) for own in places] for view in views])
        near = np.abs(places[:, None] - places) <= reach
        nearby = np.where(near, by_view[:, None, :], np.inf).min(axis=-1)
        left.append(float(nearby.sum(axis=0).min()))
    return min(left)


def _left_beyond(view: PicturedView, way: int, border: float) -> float:
    """Return what a border of the body leaves of a view [m]."""
    return _left([(view, (view.places[:, way, None] > border).astype(np.float64))])
