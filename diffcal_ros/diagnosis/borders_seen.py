# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where what a camera reads ends on a body or in the picture, and what that makes of its model."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

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
from diffcal_ros.diagnosis.detection.picture_edges import find_picture_edge, with_edge
from diffcal_ros.diagnosis.detection.pictured_views import SeenEdge
from diffcal_ros.diagnosis.detection.slanted_border import find_slanted_border
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.settled_parts import settled_parts
from diffcal_ros.diagnosis.model_comparison.settled_spots import settled_spots
from diffcal_ros.diagnosis.patch_fits.refit import Refit, refit
from diffcal_ros.diagnosis.patches.boundary_strip import knows_boundary
from diffcal_ros.diagnosis.patches.make_evaluator import make_patch_evaluator
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.effects import bands
from diffcal_ros.effects.registry import boundary_effects, edge_effect
from diffcal_ros.effects.surface_parts import parts_of, SeenPart, SurfacePart
from diffcal_ros.errors import NotSimulatedError
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

BoolArray = NDArray[np.bool_]

# Borders are looked for beside so many of the best models of one effect.
_LOOKED_BESIDE = 2
_MOST_ROUNDS = 3


@dataclass(frozen=True)
class _Seen:
    """What shows of where materials end.

    Attributes:
        maps: of spots, the likeliest first.
        parts: of the surface, the highest first.
        places: of borders along the body, shares of the free length.
        edge: in the picture.
    """

    maps: Sequence[BoolArray] = ()
    parts: tuple[SurfacePart, ...] = ()
    places: tuple[float, ...] = ()
    edge: SeenEdge | None = None


def with_borders_seen(evaluator: PatchEvaluator, nominal: Refit) -> tuple[PatchEvaluator, Refit]:
    """Return evaluator and fit of a scene that knows where materials end, if patches show that."""
    seen = _seen(evaluator, nominal)
    if seen is None:
        return evaluator, nominal
    return _knowing_what_shows(seen, evaluator, nominal)


def with_borders_seen_beside(
    models: Sequence[Hypothesis], evaluator: PatchEvaluator, nominal: Refit
) -> tuple[PatchEvaluator, Refit] | None:
    """Return evaluator and fit of a scene that knows where materials end beside another effect.

    What else is missing leaves more than a border does where it bends the body by millimetres; and
    of a body that is elsewhere in each pose than the nominal model has it, by more than spots are
    wide, pixels of different poses that see a cell do not see one place.

    Args:
        models: with one effect each, best first.
        evaluator: of the nominal model.
        nominal: its fit.

    Returns:
        None where nothing shows, or where materials end is known.
    """
    if knows_boundary(evaluator.model.scene):
        return None
    others = [own for own in models if not any(one.effect.has_boundary for one in own.added)]
    for model in others[:_LOOKED_BESIDE]:
        try:
            seen = _seen(model.evaluator, model.fit)
        except NotSimulatedError:
            continue
        if seen is not None:
            return _knowing_what_shows(seen, evaluator, nominal, model)
    return None


def with_none_seen(
    stated: Scene, evaluator: PatchEvaluator, nominal: Refit
) -> tuple[PatchEvaluator, Refit]:
    """Return evaluator and fit of a scene that knows no more borders and edges than was stated.

    Those that pixels showed beside a body that is elsewhere are to be looked for anew.

    Args:
        stated: the scene as it was given.
        evaluator: of a nominal model that may know more.
        nominal: its fit.
    """
    scene = evaluator.model.scene
    seen = {effect.identifier for effect in (*boundary_effects(), edge_effect())}
    found = seen & (scene.effects.keys() - stated.effects.keys())
    if not found:
        return evaluator, nominal
    kept = {name: own for name, own in scene.effects.items() if name not in found}
    return knowing(replace(scene, effects=kept), evaluator, nominal)


def _seen(evaluator: PatchEvaluator, fit: Refit) -> _Seen | None:
    """Return what shows of where materials end beside a model; None where nothing does."""
    found, left = find_bands(evaluator, fit)
    aslant, left = find_slanted_border(evaluator, fit, left)
    parts = find_parts(evaluator, fit, left) or aslant
    maps = find_spots(evaluator, fit, parts or _between(found))
    if maps:
        return _Seen(maps=maps)
    if parts:
        return _Seen(parts=parts)
    edge = find_picture_edge(evaluator, fit)
    if edge is not None:
        return _Seen(edge=edge)
    if not found:
        at = find_depth_discontinuity(evaluator, fit)
        if at is None:
            return None
        found = (at,)
    return _Seen(places=placed_by_pixels(evaluator, fit.coordinates, found))


def _knowing_what_shows(
    seen: _Seen, evaluator: PatchEvaluator, nominal: Refit, beside: Hypothesis | None = None
) -> tuple[PatchEvaluator, Refit]:
    """Return evaluator and fit of a scene that knows what shows beside a model, or the nominal."""
    scene = evaluator.model.scene
    if seen.maps:
        return _knowing_spots(seen.maps, evaluator, nominal, beside)
    if seen.parts:
        known = knowing(with_parts(scene, seen.parts), evaluator, nominal)
        parts = settled_parts(*known, seen.parts, beside)
        return knowing(with_parts(scene, parts), evaluator, nominal)
    if seen.edge is not None:
        return knowing(with_edge(scene, seen.edge), evaluator, nominal)
    return knowing(with_borders(scene, seen.places), evaluator, nominal)


def _between(borders: Sequence[float]) -> tuple[SeenPart, ...]:
    """Return the bands between borders as parts of the surface."""
    return parts_of(bands.band_settings(borders)) if borders else ()


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
