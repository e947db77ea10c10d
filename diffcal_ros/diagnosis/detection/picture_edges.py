# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A sharp edge in the picture, beyond which a depth camera reads too far or too near.

No body in one piece has steps, whatever bends it: they are the camera's, or of a surface that it
reads otherwise. What is the camera's own is elsewhere on the body in another pose.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

from diffcal_ros.diagnosis.detection.edge_search import round_edge, straight_edge
from diffcal_ros.diagnosis.detection.material_boundary import LEAST_POSTURES, LEFT, may_show_parts
from diffcal_ros.diagnosis.detection.pictured_views import (
    is_there,
    LEAST_PIXELS,
    pictured_views,
    PicturedView,
    SeenEdge,
)
from diffcal_ros.diagnosis.detection.spot_map import left_beside
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.effects.picture_edge import OF_POSES
from diffcal_ros.effects.registry import edge_effect
from diffcal_ros.scene.model import Scene
import numpy as np

# A pixel is beyond one of two edges and not beyond the other.
_APART = 0.5


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
    return edge_in_views(views)


def edge_in_views(views: Sequence[PicturedView]) -> SeenEdge | None:
    """Return the edge that pixels of several poses show; None where they show none.

    Straight ones come before round ones, and what is at one place in all poses before what is not.
    """
    straight, curved = _shown(views, straight_edge), _shown(views, round_edge)
    if straight is None or curved is None:
        return straight or curved
    return curved if _is_rounder(views, curved, straight) else straight


def _shown(views: Sequence[PicturedView], search: Callable[..., SeenEdge]) -> SeenEdge | None:
    """Return the edge that a search finds, where pixels show it."""
    found = (search(views, is_fixed=is_fixed) for is_fixed in (True, False))
    return next((edge for edge in found if is_there(views, edge)), None)


def _is_rounder(views: Sequence[PicturedView], curved: SeenEdge, straight: SeenEdge) -> bool:
    """Tell whether a round edge leaves far less where the two differ: many pixels are off by both.

    Nearly straight ones differ by few pixels.
    """
    left, count = np.zeros(2), 0
    for view in views:
        columns = [found.column(view) for found in (curved, straight)]
        apart = np.abs(columns[0] - columns[1])[:, 0] > _APART
        count += int(apart.sum())
        left += [float(np.abs(left_beside(view.pixels, own)[0][apart]).sum()) for own in columns]
    return count >= LEAST_PIXELS and bool(left[0] < LEFT * left[1])


def _is_known(scene: Scene) -> bool:
    """Tell whether a scene states an edge, or how all depths are read."""
    return edge_effect().identifier in scene.effects


def with_edge(scene: Scene, found: SeenEdge) -> Scene:
    """Return a scene whose depth camera may read otherwise beyond an edge."""
    first = next(iter(found.edges.values()))
    settings = {'edge_turn': round(first.turn, 4), 'edge_width': first.width}
    if first.curve != 0.0:
        settings['edge_curve'] = round(first.curve, 4)
    if found.is_fixed:
        settings['edge_at'] = round(first.place, 5)
    else:
        settings |= {OF_POSES[k]: round(own.place, 5) for k, own in found.edges.items()}
    own = {edge_effect().identifier: settings}
    return replace(scene, effects={**scene.effects, **own})
