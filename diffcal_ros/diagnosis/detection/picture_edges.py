# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A sharp edge in the picture, beyond which a depth camera reads too far or too near.

No body in one piece has steps, whatever bends it: they are the camera's, or of a surface that it
reads otherwise. What is the camera's own is elsewhere on the body in another pose.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diffcal_ros.diagnosis.detection.material_boundary import LEAST_POSTURES, may_show_parts
from diffcal_ros.diagnosis.detection.pictured_views import (
    is_there,
    LEAST_PIXELS,
    left_by,
    pictured_views,
    PicturedView,
    SeenEdge,
)
from diffcal_ros.diagnosis.detection.spot_map import left_by_smooth, regular, robust_weights
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.effects.picture_edge import OF_POSES, PictureEdge
from diffcal_ros.effects.registry import edge_effect
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Ways that are tried first, by ten degrees; then by one about the best; and places along each.
_TURNS = np.deg2rad(np.arange(-90.0, 90.0, 10.0))
_NEAR_TURNS = np.deg2rad(np.arange(-6.0, 7.0, 1.0))
_PLACES = 96
# Heights of an edge that is elsewhere in each pose [m].
_HEIGHTS = np.geomspace(0.0008, 0.03, 24)
_WIDTHS = (0.0, 0.01, 0.02, 0.04, 0.08)


def find_picture_edge(evaluator: PatchEvaluator, fit: Refit) -> SeenEdge | None:
    """Return the edge in the picture that pixels show in several poses; None where they show none.

    Args:
        evaluator: of the nominal model, or of one with an effect.
        fit: of it.
    """
    if not may_show_parts(evaluator, fit) or _is_known(evaluator.model.scene):
        return None
    views = [
        view for view in pictured_views(evaluator, fit) if len(view.directions) >= LEAST_PIXELS
    ]
    postures = {view.posture for view in views}
    if len(postures) < LEAST_POSTURES or max(postures) >= len(OF_POSES):
        return None
    found = _fixed_edge(views)
    if not is_there(views, found):
        found = _moved_edge(views)
    return found if is_there(views, found) else None


def _is_known(scene: Scene) -> bool:
    """Tell whether a scene states an edge, or how all depths are read."""
    return edge_effect().identifier in scene.effects


def with_edge(scene: Scene, found: SeenEdge) -> Scene:
    """Return a scene whose depth camera may read otherwise beyond an edge."""
    first = next(iter(found.edges.values()))
    settings = {'edge_turn': round(first.turn, 4), 'edge_width': first.width}
    if found.is_fixed:
        settings['edge_at'] = round(first.place, 5)
    else:
        settings |= {OF_POSES[k]: round(own.place, 5) for k, own in found.edges.items()}
    own = {edge_effect().identifier: settings}
    return replace(scene, effects={**scene.effects, **own})


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

    def along(self, turn: float) -> FloatArray:
        """Return how far along a way pixels are, shape (n,)."""
        return PictureEdge(turn, 0.0).along(self.view.directions)

    def steps(self, turn: float, places: FloatArray) -> _Steps:
        """Return what steps at places along a way explain, shape (p,)."""
        along = self.along(turn)
        order = np.argsort(along)
        first = np.searchsorted(along[order], places)
        from_each = np.cumsum(self.columns[order][::-1], axis=0)[::-1]
        sums = np.vstack([from_each, np.zeros(from_each.shape[1])])[first]
        followed = np.linalg.solve(self.products, sums[:, 2:].T)
        sizes = sums[:, 0] - np.einsum('pk,kp->p', sums[:, 2:], followed)
        # What is left was fitted with these weights: it has nothing in common with what is smooth.
        return _Steps(sums[:, 1], np.maximum(sizes, 0.0))


def _fixed_edge(views: Sequence[PicturedView]) -> SeenEdge:
    """Return the likeliest edge that is at one place in all poses."""
    smoothed, turns, best = [_Smoothed.of(view) for view in views], _TURNS, (-1.0, 0.0, 0.0)
    for _ in range(2):
        best = max(best, *(_fixed_along(smoothed, turn) for turn in turns.tolist()))
        turns = best[1] + _NEAR_TURNS
    _, turn, place = best
    edges = {view.posture: PictureEdge(turn, place) for view in views}
    return _as_wide(views, SeenEdge(edges, is_fixed=True))


def _fixed_along(views: Sequence[_Smoothed], turn: float) -> tuple[float, float, float]:
    """Return what the best edge along a way explains, it, and where that is."""
    along = [view.along(turn) for view in views]
    ends = min(own.min() for own in along), max(own.max() for own in along)
    places = np.linspace(*ends, _PLACES)
    steps = [view.steps(turn, places) for view in views]
    sizes = np.sum([own.sizes for own in steps], axis=0)
    gains = np.sum([own.pulls for own in steps], axis=0) ** 2 / (sizes + LEAST_PIXELS)
    number = int(gains.argmax())
    return float(gains[number]), turn, float(places[number])


def _moved_edge(views: Sequence[PicturedView]) -> SeenEdge:
    """Return the likeliest edge that goes the same way in all poses, as high, wherever it is."""
    smoothed, turns = [_Smoothed.of(view) for view in views], _TURNS
    best: tuple[float, float, tuple[float, ...]] = (-1.0, 0.0, ())
    for _ in range(2):
        best = max(best, *(_moved_along(smoothed, turn) for turn in turns.tolist()))
        turns = best[1] + _NEAR_TURNS
    _, turn, places = best
    edges = {
        view.posture: PictureEdge(turn, place) for view, place in zip(views, places, strict=True)
    }
    return _as_wide(views, SeenEdge(edges, is_fixed=False))


def _moved_along(
    views: Sequence[_Smoothed], turn: float
) -> tuple[float, float, tuple[float, ...]]:
    """Return what the best edges along a way explain, it, and where they are in the views."""
    ways = [view.along(turn) for view in views]
    offered = [np.linspace(own.min(), own.max(), _PLACES) for own in ways]
    steps = [view.steps(turn, places) for view, places in zip(views, offered, strict=True)]
    best: tuple[float, tuple[float, ...]] = (-1.0, ())
    for height in np.concatenate([_HEIGHTS, -_HEIGHTS]).tolist():
        gains = [2.0 * height * own.pulls - height**2 * own.sizes for own in steps]
        places = [own[int(gain.argmax())] for own, gain in zip(offered, gains, strict=True)]
        whole = float(sum(gain.max() for gain in gains))
        best = max(best, (whole, tuple(map(float, places))))
    return best[0], turn, best[1]


def _as_wide(views: Sequence[PicturedView], found: SeenEdge) -> SeenEdge:
    """Return an edge as wide as leaves least."""
    offered = [
        replace(found, edges={k: replace(own, width=width) for k, own in found.edges.items()})
        for width in _WIDTHS
    ]
    return offered[int(np.argmin([left_by(views, own) for own in offered]))]
