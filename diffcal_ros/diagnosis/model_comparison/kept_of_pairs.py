# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One effect of a fitted pair, all parameters where the pair has them."""

from collections.abc import Sequence

from diffcal_ros.calibration.parameters.parameters import Parameter
from diffcal_ros.diagnosis.model_comparison.effect_refit import with_effects
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.patch_fits.refit import Refit, refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.screening.candidates import Candidate
from diffcal_ros.diagnosis.screening.screening import Score, screen
from diffcal_ros.errors import NotSimulatedError
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def freed_of(pair: Hypothesis, kept: Candidate) -> tuple[Parameter, ...]:
    """Return what one effect of a pair is besides, in single postures and in other forms."""
    return tuple(own for own in pair.freed if own.effect == kept.identifier)


def scores_beside(
    nominal: PatchEvaluator,
    base: Refit,
    pair: Hypothesis,
    kept: Candidate,
    others: Sequence[Candidate],
) -> list[Score]:
    """Score other effects beside one of a pair, best first; none where it finds no rest alone.

    Args:
        nominal: evaluates the patches of the nominal model.
        base: its fit.
        pair: with two effects.
        kept: the one that stays.
        others: that are scored.
    """
    _, evaluator, here = _where_it_is(nominal, base, pair, kept)
    try:
        return list(screen(evaluator, here, others).scores)
    except NotSimulatedError:
        return []  # The pair held up what falls without one of its effects.


def kept_alone(
    nominal: PatchEvaluator, base: Refit, pair: Hypothesis, kept: Candidate
) -> Hypothesis | None:
    """Return the model with one effect of a pair; None where it finds no rest alone.

    Args:
        nominal: evaluates the patches of the nominal model.
        base: its fit.
        pair: with two effects.
        kept: the one that stays.
    """
    scene, evaluator, here = _where_it_is(nominal, base, pair, kept)
    try:
        fit = refit(evaluator, here, max_iterations=1)
    except NotSimulatedError:
        return None
    return Hypothesis((kept,), scene, evaluator, fit)


def _where_it_is(
    nominal: PatchEvaluator, base: Refit, pair: Hypothesis, kept: Candidate
) -> tuple[Scene, PatchEvaluator, FloatArray]:
    """Return scene and evaluator with one effect of a pair, and its parameters, shape (k,)."""
    scene, evaluator = with_effects(nominal, base, [kept], freed_of(pair, kept))
    values = pair.fit.values_by_name()
    return scene, evaluator, np.array([values[n] for n in evaluator.model.parameters.names])
