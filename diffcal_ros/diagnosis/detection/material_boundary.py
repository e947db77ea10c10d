# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where along a body of one region the depth camera begins to read too far or too near."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from diffcal_ros.diagnosis.patches.boundary_strip import knows_boundary
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.effects import bands
from diffcal_ros.effects.registry import boundary_effects
from diffcal_ros.errors import NotSimulatedError
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

# Borders that are tried, as shares of the free length; the middle is one of them.
_BORDERS = np.linspace(0.14, 0.86, 37).round(3).tolist()
_MIDDLE = 0.5
# A jump stands out when it is at least so high [m], leaves at most this share of what no jump
# leaves, and of what one in the middle leaves.
LEAST_STEP = 0.005
LEFT, _LEFT_OF_MIDDLE = 0.5, 0.7
_ROUNDING = 1e-6


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
    beyond = faces_beyond(evaluator)
    best, at = 0.0, None
    for coordinates in candidates:
        try:
            found = _best_boundary(*_seen_beyond(evaluator, coordinates, beyond))
        except NotSimulatedError:
            continue
        if found is not None and found[1] > best:
            at, best = found
    if at is None:
        return scene
    return with_borders(scene, (at,))


def with_borders(scene: Scene, places: Sequence[float]) -> Scene:
    """Return a scene whose effects of two materials have their borders at shares."""
    settings = bands.band_settings(places)
    own = {effect.identifier: dict(settings) for effect in boundary_effects()}
    return replace(scene, effects={**scene.effects, **own})


def faces_beyond(
    evaluator: PatchEvaluator, borders: Sequence[float] = _BORDERS
) -> dict[float, BoolArray]:
    """Return, by boundary, which triangles of the surface lie beyond it, shape (F,) each.

    All postures have the same mesh, and so the same triangles.
    """
    model = evaluator.model
    nodes = model.body(model.observations[0]).discretisation.nodes
    triangles = model.tracers[0].triangles
    return {
        at: model.effects.second_triangles(nodes, triangles, bands.band_settings((at,)))
        for at in borders
    }


def _seen_beyond(
    evaluator: PatchEvaluator, coordinates: FloatArray, on_faces: Mapping[float, BoolArray]
) -> tuple[FloatArray, dict[float, BoolArray]]:
    """Return residuals of depth [m], shape (n,), and by boundary which pixels lie beyond it."""
    residuals: list[FloatArray] = []
    faces: list[NDArray[np.int32]] = []
    compared = evaluator.comparisons(coordinates)
    views = evaluator.model.views(coordinates)
    for view, comparison in zip(views, compared, strict=True):
        seen = np.isfinite(comparison.difference) & comparison.counted
        own = comparison.difference[seen]
        residuals.append(own - np.median(own) if len(own) else own)
        faces.append(view.trace.faces[seen])
    shown = np.concatenate(faces)
    return np.concatenate(residuals), {at: on[shown] for at, on in on_faces.items()}


def _best_boundary(
    residuals: FloatArray, beyond: Mapping[float, BoolArray]
) -> tuple[float, float] | None:
    """Return the share where a jump stands out, and its height [m]; None where none does."""
    left = {at: _left_by_jump(residuals, second) for at, second in beyond.items()}
    nowhere = np.zeros(len(residuals), dtype=bool)
    at = outstanding_boundary(left, _left_by_jump(residuals, nowhere))
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
    # Borders between the same two elements are alike: the middle one is the safest.
    least = min(left.values()) * (1.0 + _ROUNDING)
    alike = [at for at in left if left[at] <= least]
    at = alike[len(alike) // 2]
    most = min(LEFT * without, _LEFT_OF_MIDDLE * left[_MIDDLE])
    return at if left[at] < most else None


def _left_by_jump(residuals: FloatArray, second: BoolArray) -> float:
    """Return the sum of absolute residuals that a jump leaves [m]."""
    parts = (residuals[second], residuals[~second])
    return sum(float(np.abs(part - np.median(part)).sum()) for part in parts if len(part))
