# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which reading of a map of spots is the right one, and the map anew once it is in the model.

Until then poses and modulus have followed the spots, and which level a side of the body reads
right is told by what is left of them.
"""

from collections.abc import Sequence

from diffcal_ros.diagnosis.detection.material_boundary import seen_places
from diffcal_ros.diagnosis.detection.spot_map import (
    left_by_map,
    nearer_the_second,
    SpottedView,
)
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_beside
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.screening.candidates import Candidate
from diffcal_ros.effects.registry import seen_boundary
from diffcal_ros.effects.spots import ROUND, ROWS, Spots
import numpy as np
from numpy.typing import NDArray

BoolArray = NDArray[np.bool_]

_MOST_EVALUATIONS = 6
# Of spots that are none of their height nothing more is told [m].
_LEAST_HEIGHT = 0.0005


def settled_spots(
    known: Sequence[tuple[PatchEvaluator, Refit]], beside: Hypothesis | None = None
) -> tuple[BoolArray, float]:
    """Return the map of the scene that explains most, made anew, and what it left as it was.

    A map, shape (ROWS, ROUND), and chi-square per patch.

    Args:
        known: evaluators of the nominal model, each of a scene with another map, and its fit.
        beside: model beside whose effects the spots were seen; None: the nominal one.
    """
    effect = seen_boundary()
    (height_name,) = (part.name for part in effect.components)
    spots = Candidate(effect.identifier, (height_name,))
    maps = [_map_of(evaluator) for evaluator, _ in known]
    found = [try_beside(*own, spots, beside, max_iterations=_MOST_EVALUATIONS) for own in known]
    likely = [-np.inf if own is None else own.fit.log_evidence for own in found]
    number = int(np.argmax(likely))
    best, own_map = found[number], maps[number]
    if best is None:
        return own_map.cells, np.inf
    left = best.fit.chi_square_per_patch
    height = best.fit.values_by_name()[effect.amplitude_name(height_name)]
    if abs(height) < _LEAST_HEIGHT:
        return own_map.cells, left
    views = [
        SpottedView.of(off + height * own_map.holds(places), places)
        for off, places in seen_places(best.evaluator, best.fit.coordinates)
        if len(off)
    ]
    anew = nearer_the_second(views, height)
    were, are = (
        left_by_map(views, own.astype(np.float64)) for own in (own_map.cells.ravel(), anew)
    )
    # What else is missing may be smooth, and far larger than spots: then the first map stands.
    return (anew.reshape(ROWS, ROUND) if are < were else own_map.cells), left


def _map_of(evaluator: PatchEvaluator) -> Spots:
    """Return the map that all views of a model have."""
    (spots,) = evaluator.comparers[0].surface.parts
    assert isinstance(spots, Spots)
    return spots
