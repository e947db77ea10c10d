# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where materials end on a body whose scene does not say so, and what that makes of its model."""

from collections.abc import Sequence

from diffcal_ros.diagnosis.detection.depth_discontinuity import find_depth_discontinuity
from diffcal_ros.diagnosis.detection.find_spots import find_spots
from diffcal_ros.diagnosis.detection.material_bands import find_bands
from diffcal_ros.diagnosis.detection.material_boundary import (
    OFF,
    placed_by_pixels,
    with_borders,
    with_parts,
    with_spots,
)
from diffcal_ros.diagnosis.detection.material_parts import find_parts
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.settled_parts import settled_parts
from diffcal_ros.diagnosis.model_comparison.settled_spots import settled_spots
from diffcal_ros.diagnosis.patch_fits.refit import Refit, refit
from diffcal_ros.diagnosis.patches.boundary_strip import knows_boundary
from diffcal_ros.diagnosis.patches.patch_evaluator import make_patch_evaluator, PatchEvaluator
from diffcal_ros.effects import bands
from diffcal_ros.effects.surface_parts import parts_of, SeenPart
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

# Spots are looked for beside so many of the best models of one effect.
_LOOKED_BESIDE = 2
_MOST_ROUNDS = 3

BoolArray = NDArray[np.bool_]


def with_borders_seen(evaluator: PatchEvaluator, nominal: Refit) -> tuple[PatchEvaluator, Refit]:
    """Return evaluator and fit of a scene that knows where materials end, if patches show that."""
    scene = evaluator.model.scene
    found, left = find_bands(evaluator, nominal)
    parts = find_parts(evaluator, nominal, left)
    maps = find_spots(evaluator, nominal, parts or _between(found))
    if maps:
        return _knowing_spots(maps, evaluator, nominal)
    if parts:
        known = knowing(with_parts(scene, parts), evaluator, nominal)
        return knowing(with_parts(scene, settled_parts(*known, parts)), evaluator, nominal)
    if not found:
        at = find_depth_discontinuity(evaluator, nominal)
        if at is None:
            return evaluator, nominal
        found = (at,)
    placed = placed_by_pixels(evaluator, nominal.coordinates, found)
    return knowing(with_borders(scene, placed), evaluator, nominal)


def _between(borders: Sequence[float]) -> tuple[SeenPart, ...]:
    """Return the bands between borders as parts of the surface."""
    return parts_of(bands.band_settings(borders)) if borders else ()


def with_spots_seen_beside(
    models: Sequence[Hypothesis], evaluator: PatchEvaluator, nominal: Refit
) -> tuple[PatchEvaluator, Refit] | None:
    """Return evaluator and fit of a scene that knows spots which show beside another effect.

    Of a body that is elsewhere in each pose than the nominal model has it, by more than spots are
    wide, pixels of different poses that see a cell do not see one place.

    Args:
        models: with one effect each, best first.
        evaluator: of the nominal model.
        nominal: its fit.

    Returns:
        None where no spots show, or where materials end is known.
    """
    scene = evaluator.model.scene
    if knows_boundary(scene):
        return None
    others = [own for own in models if not any(one.effect.has_boundary for one in own.added)]
    for model in others[:_LOOKED_BESIDE]:
        maps = find_spots(model.evaluator, model.fit, ())
        if maps:
            return _knowing_spots(maps, evaluator, nominal, model)
    return None


def _knowing_spots(
    maps: Sequence[BoolArray],
    evaluator: PatchEvaluator,
    nominal: Refit,
    beside: Hypothesis | None = None,
) -> tuple[PatchEvaluator, Refit]:
    """Return evaluator and fit of a scene that knows the likeliest of some maps of spots.

    It is made anew as long as much is left beside it: each map leads the fit nearer to the body,
    and the body's pixels to their cells.
    """
    scene = evaluator.model.scene
    for _ in range(_MOST_ROUNDS):
        read = [knowing(with_spots(scene, cells), evaluator, nominal) for cells in maps]
        cells, left = settled_spots(read, beside)
        maps = [cells]
        if left < OFF:
            break
    return knowing(with_spots(scene, maps[0]), evaluator, nominal)


def knowing(
    scene: Scene, evaluator: PatchEvaluator, nominal: Refit
) -> tuple[PatchEvaluator, Refit]:
    """Return evaluator and fit of a scene that knows where materials end.

    The model stays what it is, and so does its fit: no effect is in it yet.
    """
    model = evaluator.model.with_parameters(scene, evaluator.model.parameters)
    # What few patches show of a band beside its borders is no strange thing before the body.
    found = make_patch_evaluator(model, nominal.coordinates).without(evaluator.left_out)
    # Along the border nothing is compared from now on.
    return found, refit(found, nominal.coordinates, max_iterations=1)
