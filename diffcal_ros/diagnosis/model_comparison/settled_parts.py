# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Parts of a surface placed anew once they are in the model.

Until then the modulus has followed them: it bends the body where a part begins, which moves that
by a twentieth of the width, and what further parts are of the first by a fifth.
"""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.calibration.parameters.form_parameters import form_parameters
from diffcal_ros.diagnosis.detection.material_boundary import seen_places
from diffcal_ros.diagnosis.detection.sharp_limits import placed_by_pixels
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_beside
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.screening.candidates import Candidate
from diffcal_ros.effects.registry import seen_boundary
from diffcal_ros.effects.surface_parts import SurfacePart
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_MOST_EVALUATIONS = 6
# Heights are told by data: of what each is beforehand next to nothing is believed, in usual sizes.
_ANY_HEIGHT = 4.0
# A first part that is none of its height has none to compare others with [m].
_LEAST_HEIGHT = 0.0005


def settled_parts(
    evaluator: PatchEvaluator,
    nominal: Refit,
    parts: Sequence[SurfacePart],
    beside: Hypothesis | None = None,
) -> tuple[SurfacePart, ...]:
    """Return parts where pixels see them, and as high as they are, beside all parameters.

    Args:
        evaluator: of the nominal model, whose scene states the parts.
        nominal: its fit.
        parts: those, the highest first.
        beside: model beside whose effects they were seen; None: the nominal one.
    """
    effect = seen_boundary()
    (height,) = (part.name for part in effect.components)
    added = Candidate(effect.identifier, (height,))
    names = {effect.amplitude_name(name) for name in effect.part_forms(len(parts))}
    freed = [own for own in form_parameters(effect, _ANY_HEIGHT) if own.name in names]
    found = try_beside(
        evaluator, nominal, added, beside, max_iterations=_MOST_EVALUATIONS, freed=freed
    )
    if found is None:
        return tuple(parts)
    values = found.fit.values_by_name()
    first = values[effect.amplitude_name(height)]
    if abs(first) < _LEAST_HEIGHT:
        return tuple(parts)
    more = [values[effect.amplitude_name(name)] for name in effect.part_forms(len(parts))]
    times = [own.times + other / first for own, other in zip(parts, (0.0, *more), strict=True)]
    views = _without_effect(found, [first * own for own in times], parts)
    return tuple(
        replace(placed_by_pixels(views, own), times=float(size))
        for own, size in zip(parts, times, strict=True)
    )


def _without_effect(
    found: Hypothesis, heights: Sequence[float], parts: Sequence[SurfacePart]
) -> list[tuple[FloatArray, FloatArray]]:
    """Return what pixels would be off by if the fitted parts were read as they are, by views."""
    return [
        (left + sum(h * own.holds(at) for h, own in zip(heights, parts, strict=True)), at)
        for left, at in seen_places(found.evaluator, found.fit.coordinates)
    ]
