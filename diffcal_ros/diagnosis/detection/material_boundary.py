# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where along a body of one region the depth camera begins to read too far or too near."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.boundary_strip import knows_boundary
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.effects import bands
from diffcal_ros.effects.registry import boundary_effects, seen_boundary
from diffcal_ros.effects.spots import spot_settings
from diffcal_ros.effects.surface_parts import part_settings, SurfacePart
from diffcal_ros.errors import NotSimulatedError
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

# Borders that are tried, as shares of the free length; the middle is one of them.
BORDERS = np.linspace(0.14, 0.86, 73).round(3).tolist()
_MIDDLE = 0.5
# A jump stands out when it is at least so high [m], leaves at most this share of what no jump
# leaves, and of what one in the middle leaves.
LEAST_STEP = 0.005
LEFT, _LEFT_OF_MIDDLE = 0.5, 0.7
_ROUNDING = 1e-6
# Parts of a surface are looked for where patches are off by so much, chi-square each: less is as
# good as noise. One pose does not tell a part of the body from something before it.
OFF, LEAST_POSTURES = 2.0, 2
# How far pixels move a border that patches tell, as a share of the free length, and by what steps.
_FARTHEST, _OFFERED = 0.03, 25


def with_material_boundary(
    scene: Scene, evaluator: PatchEvaluator, candidates: Iterable[FloatArray]
) -> Scene:
    """Return a scene whose effects of two materials have their boundary where a jump is seen.

    Args:
        scene: one that has several regions knows its boundaries, and is returned as it is.
        evaluator: of its model.
        candidates: coordinates at which the residual is read: a fit may have followed the jump.
    """
    if knows_boundary(scene):
        return scene
    best, at = 0.0, None
    for coordinates in candidates:
        try:
            found = _best_boundary(*_seen_beyond(evaluator, coordinates))
        except NotSimulatedError:
            continue
        if found is not None and found[1] > best:
            at, best = found
    if at is None:
        return scene
    return with_borders(scene, (at,))


def with_borders(scene: Scene, places: Sequence[float]) -> Scene:
    """Return a scene whose effects of two materials have their borders at shares.

    Args:
        scene: that knows none.
        places: shares of the free length.
    """
    settings = bands.band_settings(places)
    own = {effect.identifier: dict(settings) for effect in boundary_effects()}
    return replace(scene, effects={**scene.effects, **own})


def with_parts(scene: Scene, parts: Sequence[SurfacePart]) -> Scene:
    """Return a scene whose depth camera reads parts of the surface otherwise.

    Effects of two materials whose borders are elements' have them where the first part has.

    Args:
        scene: that knows none.
        parts: the first one is as high as the effect says.
    """
    ends = [end for end in (parts[0].begin, parts[0].end) if end < 1.0]
    found = with_borders(scene, ends)
    own = {seen_boundary().identifier: part_settings(parts)}
    return replace(found, effects={**found.effects, **own})


def with_spots(scene: Scene, cells: BoolArray) -> Scene:
    """Return a scene whose depth camera reads spots of the surface otherwise.

    Args:
        scene: that knows of no border.
        cells: which of the surface are in spots, see `effects.spots`, shape (ROWS, ROUND).
    """
    own = {seen_boundary().identifier: spot_settings(cells)}
    return replace(scene, effects={**scene.effects, **own})


def placed_by_pixels(
    evaluator: PatchEvaluator, coordinates: FloatArray, places: Sequence[float]
) -> tuple[float, ...]:
    """Return borders where pixels see them that patches know to half of one.

    Args:
        evaluator: of the nominal model.
        coordinates: of its fit, shape (k,).
        places: of the borders, shares of the free length, ascending.
    """
    views = [(own, where[:, 0]) for own, where in seen_places(evaluator, coordinates)]
    halves = 0.5 * np.diff([0.0, *places, 1.0])
    reaches = np.minimum(halves[:-1], halves[1:])
    return tuple(
        best_nearby(views, place, min(_FARTHEST, reach))
        for place, reach in zip(places, reaches.tolist(), strict=True)
    )


def best_nearby(
    views: Sequence[tuple[FloatArray, FloatArray]], place: float, reach: float
) -> float:
    """Return where within reach a jump leaves least on pixels up to twice as far.

    Args:
        views: residuals of depth [m] and where pixels are, such as shares of the free length,
            shape (n,) each.
        place: such a share.
        reach: likewise.
    """
    offered = place + reach * np.linspace(-1.0, 1.0, _OFFERED)
    left = np.zeros(_OFFERED)
    for residuals, shares in views:
        near = np.abs(shares - place) < 2.0 * reach
        own, along = residuals[near], shares[near]
        left += [left_by_jump(own, along > at) for at in offered]
    return float(offered[left.argmin()].round(4))


def may_show_parts(evaluator: PatchEvaluator, nominal: Refit) -> bool:
    """Tell whether parts of a body's surface that are read otherwise can be told by a fit."""
    postures = {observation.setup_index for observation in evaluator.model.observations}
    is_known = evaluator.is_measured and len(postures) >= LEAST_POSTURES
    return is_known and nominal.chi_square_per_patch >= OFF


def seen_places(
    evaluator: PatchEvaluator, coordinates: FloatArray
) -> list[tuple[FloatArray, FloatArray]]:
    """Return residuals of depth [m] of each view, shape (n,), and where on the body, shape (n, 3).

    Args:
        evaluator: of a model of a body of one region.
        coordinates: of its parameters, shape (k,).
    """
    found = []
    compared = evaluator.comparisons(coordinates)
    views = evaluator.model.views(coordinates)
    for comparer, view, comparison in zip(evaluator.comparers, views, compared, strict=True):
        seen = np.isfinite(comparison.difference) & comparison.counted
        places = comparer.places(view.trace, np.flatnonzero(seen).astype(np.int32))
        found.append((comparison.difference[seen], places))
    return found


def _seen_beyond(
    evaluator: PatchEvaluator, coordinates: FloatArray
) -> tuple[FloatArray, dict[float, BoolArray]]:
    """Return residuals of depth [m], shape (n,), and by boundary which pixels lie beyond it."""
    views = seen_places(evaluator, coordinates)
    residuals = [own - np.median(own) if len(own) else own for own, _ in views]
    along = np.concatenate([places[:, 0] for _, places in views])
    return np.concatenate(residuals), {at: along > at for at in BORDERS}


def _best_boundary(
    residuals: FloatArray, beyond: Mapping[float, BoolArray]
) -> tuple[float, float] | None:
    """Return the share where a jump stands out, and its height [m]; None where none does."""
    left = {at: left_by_jump(residuals, second) for at, second in beyond.items()}
    nowhere = np.zeros(len(residuals), dtype=bool)
    at = outstanding_boundary(left, left_by_jump(residuals, nowhere))
    if at is None:
        return None
    second = beyond[at]
    if second.all() or not second.any():
        return None
    height = abs(float(np.median(residuals[second]) - np.median(residuals[~second])))
    return (at, height) if height > LEAST_STEP else None


def outstanding_boundary(left: Mapping[float, float], without: float) -> float | None:
    """Return the boundary whose jump leaves far less than none and one in the middle; else None.

    Args:
        left: what a jump at each boundary leaves.
        without: what no jump leaves.
    """
    # Borders between which no pixel lies are alike: the middle one is the safest.
    least = min(left.values()) * (1.0 + _ROUNDING)
    alike = [at for at in left if left[at] <= least]
    at = alike[len(alike) // 2]
    most = min(LEFT * without, _LEFT_OF_MIDDLE * left[_MIDDLE])
    return at if left[at] < most else None


def left_by_jump(residuals: FloatArray, second: BoolArray) -> float:
    """Return the sum of absolute residuals that a jump leaves [m]."""
    parts = (residuals[second], residuals[~second])
    return sum(float(np.abs(part - np.median(part)).sum()) for part in parts if len(part))
