# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which refitted model the data favour, how surely, and what explains them as well."""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.diagnosis.model_comparison.absence import has_doubtful_effect
from diffcal_ros.diagnosis.model_comparison.hypothesis import FORM_DOUBT, Hypothesis
from diffcal_ros.diagnosis.model_comparison.selection import AS_WELL, Selection
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.patches.whitened import excess_over, Part
import numpy as np

# Log evidence is that of a noise model which is a guess: it counts for so much.
_TEMPERATURE = 2.0
_HARDLY_MORE = 0.0005  # [m]
# With one pose twins differ by details, which mesh and smooth errors have, too: models this close
# in log evidence, per unit of noise scale, explain it as well.
_ONE_POSE_AS_WELL = 12.0


@dataclass(frozen=True)
class Choice:
    """The favoured model among all.

    Attributes:
        hypothesis: it.
        confidence: 0 to 1.
        alike: identifiers that explain the data as well, its own first.
        runner_up: identifier of the next best, or None.
    """

    hypothesis: Hypothesis
    confidence: float
    alike: tuple[str, ...]
    runner_up: str | None


def choose(selection: Selection, evaluator: PatchEvaluator, nominal: Refit) -> Choice | None:
    """Return the favoured model; None where there is none.

    Args:
        selection: refitted models.
        evaluator: of the nominal model.
        nominal: its fit: what may as well be absent explains no more than that.
    """
    best = selection.best
    if best is None:
        return None
    rivals = [
        hypothesis
        for hypothesis in (selection.singles if len(best.added) == 1 else selection.pairs)
        if hypothesis is best
        or not (
            hypothesis.is_at_bound or has_doubtful_effect(hypothesis, nominal, selection.singles)
        )
    ]
    levels: dict[tuple[str, ...], float] = {}
    for hypothesis in rivals:
        level = hypothesis.level / selection.noise_scale
        key = hypothesis.identifiers
        levels[key] = max(levels.get(key, -np.inf), level)
    top = levels[best.identifiers]
    ranked = sorted(levels, key=lambda key: -levels[key])
    weights = {key: np.exp((levels[key] - top) / _TEMPERATURE) for key in levels}
    confidence = float(weights[best.identifiers] / sum(weights.values()))
    others = [key for key in ranked if key != best.identifiers]
    has_one_pose = len({seen.setup_index for seen in evaluator.model.observations}) == 1
    as_well = _ONE_POSE_AS_WELL if has_one_pose else AS_WELL
    doubt = FORM_DOUBT * best.leaning / selection.noise_scale
    near = {key for key in others if top - levels[key] < as_well + doubt}
    if not evaluator.is_measured:
        # The log evidence rests on a floor that is a guess: what is left must tell.
        near |= _as_near(best, rivals)
    # A name that shares the answer with others is no surer than one of them.
    confidence = min(confidence, 1.0 / (1 + len(near)))
    alike = [best.identifiers, *(key for key in others if key in near)]
    if len(best.added) > 1:
        near_first = _as_good_alone(selection, as_well) - set(best.identifiers)
        if near_first:
            # Beside the second effect, too, it may be another one that is the first.
            confidence = min(confidence, 1.0 / (1 + len(near_first)))
            alike += [(name,) for name in near_first]
    if selection.rival is not None:
        # One effect or two others: no recording at hand tells.
        confidence = min(confidence, 1.0 / (1 + len(near) + 1))
        alike.insert(1, selection.rival.identifiers)
    return Choice(
        hypothesis=best,
        confidence=confidence,
        alike=tuple(dict.fromkeys(name for key in alike for name in key)),
        runner_up=_joined(others[0]) if others else None,
    )


def _as_good_alone(selection: Selection, as_well: float) -> set[str]:
    """Return the single effects that explain the data about as well as the best one."""
    best = selection.singles[0]
    if selection.best is None or best.identifiers[0] not in selection.best.identifiers:
        return set()  # Neither is a part of what explains more.
    least = best.level - as_well * selection.noise_scale - FORM_DOUBT * best.leaning
    return {h.identifiers[0] for h in selection.singles if h.level > least and not h.is_at_bound}


def _as_near(best: Hypothesis, rivals: Sequence[Hypothesis]) -> set[tuple[str, ...]]:
    """Return the effects that leave hardly more on held-out patches than the best."""
    return {
        rival.identifiers
        for rival in rivals
        if rival.identifiers != best.identifiers
        and excess_over(rival.fit.groups, best.fit.groups, Part.REPORT) < _HARDLY_MORE
    }


def _joined(identifiers: Sequence[str]) -> str:
    return ' and '.join(identifiers)
