# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Spots of a body's surface that a depth camera reads too far or too near: print, stickers, dots.

A map of them is believed where it predicts what a pose shows that it was not made from: what is
before the body, or the camera's own, is somewhere else on it in another pose.
"""

from collections.abc import Sequence
from itertools import product

from diffcal_ros.diagnosis.detection.depth_discontinuity import jumps_seen, OF_SMOOTH, with_jumps
from diffcal_ros.diagnosis.detection.material_boundary import (
    LEAST_POSTURES,
    LEFT,
    may_show_parts,
    seen_places,
)
from diffcal_ros.diagnosis.detection.spot_map import (
    left_by_map,
    spot_map,
    SpotMap,
    SpottedView,
    sum_left,
)
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.effects.spots import cells_of, OF_SIDE, ROUND, ROWS, SIDES
from diffcal_ros.effects.surface_parts import held_by, SeenPart
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, uniform_filter

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

# Of a view that shows fewer nothing is told.
_LEAST_PIXELS = 200
# A spot's usual half width is that of its middle.
_MIDDLE = 0.9
_SIDE_OF_CELL = np.arange(ROWS * ROUND) % ROUND // OF_SIDE


def find_spots(
    evaluator: PatchEvaluator, nominal: Refit, parts: Sequence[SeenPart]
) -> list[BoolArray]:
    """Return maps of which cells of a body's surface are in spots, shape (ROWS, ROUND) each.

    Args:
        evaluator: of the nominal model.
        nominal: its fit.
        parts: of the surface that were found to be read otherwise: spots have to leave far less.

    Returns:
        None where there are no spots; else the likeliest one, and the one of all that it has not,
        as tangents do not tell the two apart where a fit has followed the spots.
    """
    if not may_show_parts(evaluator, nominal):
        return []
    seen = seen_places(evaluator, nominal.coordinates)
    postures = [observation.setup_index for observation in evaluator.model.observations]
    own = [number for number, (left, _) in enumerate(seen) if len(left) >= _LEAST_PIXELS]
    if len({postures[number] for number in own}) < LEAST_POSTURES:
        return []
    views = [SpottedView.of(*seen[number]) for number in own]
    found = spot_map(views)
    held = [held_by(parts, seen[number][1]) for number in own]
    if not _is_there(views, [postures[number] for number in own], held, found):
        return []
    return _as_read(evaluator, nominal, found)


def _is_there(
    views: Sequence[SpottedView],
    postures: Sequence[int],
    held: Sequence[FloatArray],
    found: SpotMap,
) -> bool:
    """Tell whether a map is one of the surface, by the pixels that it can follow.

    What is far off beside it, at outlines above all, is none of it, and no other map's.

    Args:
        views: pixels.
        postures: number of the pose of each.
        held: what is in parts of the surface that were found, of each view, shape (n, p).
        found: the map.
    """
    kept = [view.is_followed(found) for view in views]
    views = [view.where(own) for view, own in zip(views, kept, strict=True)]
    others = [columns[own] for columns, own in zip(held, kept, strict=True)]
    return (
        is_of_all_poses(views, postures)
        and _is_sharp(views, found)
        and left_by_map(views, found.levels) < LEFT * sum_left(views, others)
    )


def is_of_all_poses(views: Sequence[SpottedView], postures: Sequence[int]) -> bool:
    """Tell whether maps predict most of what poses show that those were not made from.

    Args:
        views: pixels.
        postures: number of the pose of each.
    """
    before = after = 0.0
    for posture in dict.fromkeys(postures):
        others = [v for v, own in zip(views, postures, strict=True) if own != posture]
        map_of_others = spot_map(others)
        for view, own in zip(views, postures, strict=True):
            known = view.where(map_of_others.is_known[view.cells])
            if own != posture or len(known.left) < _LEAST_PIXELS:
                continue
            before += sum_left([known], [np.zeros((len(known.left), 0))])
            after += left_by_map([known], map_of_others.levels)
    return after < LEFT * before


def _is_sharp(views: Sequence[SpottedView], found: SpotMap) -> bool:
    """Tell whether levels that go over into each other leave more: waves of a surface do."""
    soft = _softened(found.is_spot.reshape(ROWS, ROUND), found.is_seen.reshape(ROWS, ROUND))
    return left_by_map(views, found.levels) < OF_SMOOTH * left_by_map(views, soft)


def _softened(is_spot: BoolArray, is_seen: BoolArray) -> FloatArray:
    """Return levels averaged over as many cells as spots are wide, shape (CELLS,)."""
    inside = np.maximum(distance_transform_edt(is_spot), distance_transform_edt(~is_spot))
    width = 2 * round(float(np.quantile(inside[is_seen], _MIDDLE))) + 1
    modes = ('nearest', 'wrap')
    sums, shares = (
        uniform_filter(own.astype(np.float64), width, mode=modes)
        for own in (is_spot & is_seen, is_seen)
    )
    return np.asarray(sums / np.maximum(shares, 1e-9)).ravel()


def _as_read(evaluator: PatchEvaluator, nominal: Refit, found: SpotMap) -> list[BoolArray]:
    """Return the cells that may be read wrong, the likeliest first, see `find_spots`.

    Beside what is smooth in each pose either level may be the right one, on each side of the body
    by itself; how sides go together is told by poses and modulus.
    """
    ways = np.array(list(product([False, True], repeat=SIDES)))
    spots = found.is_seen & (found.is_spot ^ ways[:, _SIDE_OF_CELL])

    def on_spots(places: FloatArray) -> FloatArray:
        return np.asarray(spots[:, cells_of(places)].T, dtype=np.float64)

    jumps = jumps_seen(with_jumps(evaluator, nominal, on_spots), nominal)
    best = spots[int(jumps.gains(np.eye(len(ways)))[0].argmax())]
    return [own.reshape(ROWS, ROUND) for own in (best, found.is_seen & ~best)]
