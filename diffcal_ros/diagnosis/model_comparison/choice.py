# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which refitted model the data favour, how surely, and what explains them as well."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from diffcal_ros.diagnosis.model_comparison.absence import differing_by_pose, has_needless_effect
from diffcal_ros.diagnosis.model_comparison.as_good_alone import as_good_alone
from diffcal_ros.diagnosis.model_comparison.hypothesis import AS_WELL, FORM_DOUBT, Hypothesis
from diffcal_ros.diagnosis.model_comparison.owed_to_poses import owed_to_poses
from diffcal_ros.diagnosis.model_comparison.selection import Selection
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.patches.patch_gap import excess_over
from diffcal_ros.diagnosis.patches.whitened import Part
import numpy as np

# Log evidence is that of a noise model which is a guess: it counts for so much.
_TEMPERATURE = 2.0
_HARDLY_MORE = 0.0005  # [m]
# With one pose twins differ by details, which mesh and smooth errors have, too: models this close
# in log evidence, per unit of noise scale, explain it as well.
ONE_POSE_AS_WELL = 12.0


@dataclass(frozen=True)
class Choice:
    """The favoured model among all.

    Attributes:
        hypothesis: it.
        confidences: 0 to 1, of each of its effects by identifier.
        alike: identifiers that explain the data as well, its own first.
        runner_up: identifier of the next best, or None.
        beside: identifier of what came nearest beside its effect, without a name; empty: nothing.
        unsure: why it is no surer than something else, in words; empty: for no such reason.
    """

    hypothesis: Hypothesis
    confidences: Mapping[str, float]
    alike: tuple[str, ...]
    runner_up: str | None
    beside: str = ''
    unsure: str = ''

    @property
    def confidence(self) -> float:
        """That of the model: no surer than what is least sure of it."""
        return min(self.confidences.values())


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
    models = selection.singles if len(best.added) == 1 else selection.pairs
    rivals = [own for own in models if own is best or _is_rival(own, selection, nominal)]
    levels: dict[tuple[str, ...], float] = {}
    for hypothesis in rivals:
        level = hypothesis.level / selection.noise_scale
        key = hypothesis.identifiers
        levels[key] = max(levels.get(key, -np.inf), level)
    top = levels[best.identifiers]
    ranked = sorted(levels, key=lambda key: -levels[key])
    weights = {key: float(np.exp((levels[key] - top) / _TEMPERATURE)) for key in levels}
    others = [key for key in ranked if key != best.identifiers]
    has_one_pose = len({seen.setup_index for seen in evaluator.model.observations}) == 1
    as_well = ONE_POSE_AS_WELL if has_one_pose else AS_WELL
    doubt = FORM_DOUBT * best.leaning / selection.noise_scale
    near = {key for key in others if top - levels[key] < as_well + doubt}
    owed = FORM_DOUBT * owed_to_poses(best, evaluator, nominal)
    near |= _as_near_by_poses(best, rivals, owed, as_well * selection.noise_scale)
    near |= _as_good_but_for_a_course(best, rivals, nominal, as_well * selection.noise_scale)
    short = _better_if_more(models, best) - levels.keys()
    near |= short
    if not evaluator.is_measured:
        # The log evidence rests on a floor that is a guess: what is left must tell.
        near |= _as_near(best, rivals)
    alike = [best.identifiers, *(key for key in others if key in near), *sorted(short)]
    first, near_first = selection.singles[0].identifiers[0], set[str]()
    if len(best.added) > 1:
        near_first = _as_good_in_its_place(selection, best, as_well)
        alike += [(name,) for name in near_first]
    if selection.rival is not None:
        # One effect or two others: no recording at hand tells.
        near.add(selection.rival.identifiers)
        alike.insert(1, selection.rival.identifiers)
    # Beside the second effect, too, it may be another one that is the first.
    confidences = {
        name: _confidence(name, weights, near, near_first if name == first else set())
        for name in best.identifiers
    }
    return Choice(
        hypothesis=best,
        confidences=confidences,
        alike=tuple(dict.fromkeys(name for key in alike for name in key)),
        runner_up=_joined(others[0]) if others else None,
    )


def _is_rival(model: Hypothesis, selection: Selection, nominal: Refit) -> bool:
    """Tell whether a model is there, and of a pair whether it is believable."""
    is_unlike = len(model.added) > 1 and model.is_unlike_itself
    if model.is_at_bound or is_unlike:
        return False
    return not has_needless_effect(model, nominal, selection.singles)


def _confidence(
    name: str,
    weights: Mapping[tuple[str, ...], float],
    near: Collection[tuple[str, ...]],
    in_its_place: Collection[str],
) -> float:
    """Return the confidence in one effect of the favoured model, whatever is beside it.

    A name that shares the answer with others is no surer than one of them.

    Args:
        name: identifier of the effect.
        weights: of all models, by their identifiers.
        near: models that explain the data as well as the favoured one.
        in_its_place: effects that may be there in place of this one.
    """
    share = sum(weight for key, weight in weights.items() if name in key)
    without = sum(name not in key for key in near)
    least = 1.0 / (1 + max(without, len(in_its_place)))
    return min(share / sum(weights.values()), least)


def _as_good_in_its_place(selection: Selection, best: Hypothesis, as_well: float) -> set[str]:
    """Return what may be there in place of the best single effect, which is a part of a pair.

    Alone it explains about as much. Where it was refitted beside the other one, what that came to
    tells, and not this.
    """
    first = selection.singles[0].identifiers[0]
    if first not in best.identifiers:
        return set()  # It is no part of what explains more.
    others, known = set(best.identifiers) - {first}, {own.identifiers for own in selection.pairs}
    found = as_good_alone(selection.singles, as_well * selection.noise_scale)
    return {
        name
        for name in found - set(best.identifiers)
        if tuple(sorted([name, *others])) not in known
    }


def _better_if_more(models: Sequence[Hypothesis], best: Hypothesis) -> set[tuple[str, ...]]:
    """Return the effects that explain more than the best, and would be more than they may be.

    Beside another effect so may one that is another one in each pose with nothing in common: it
    has no name, and that of what follows it is no surer for that.
    """
    better = {
        h.identifiers
        for h in models
        if h.level > best.level
        and (h.would_be_more or (len(h.added) > 1 and differing_by_pose(h) is not None))
    }
    return better - {best.identifiers}


def _as_near(best: Hypothesis, rivals: Sequence[Hypothesis]) -> set[tuple[str, ...]]:
    """Return the effects that leave hardly more on held-out patches than the best."""
    return {
        rival.identifiers
        for rival in rivals
        if rival.identifiers != best.identifiers
        and excess_over(rival.fit.groups, best.fit.groups, Part.REPORT) < _HARDLY_MORE
    }


def _as_near_by_poses(
    best: Hypothesis, rivals: Sequence[Hypothesis], doubt: float, as_well: float
) -> set[tuple[str, ...]]:
    """Return the effects that what is believed of poses alone puts behind the best.

    In doubt is that belief, not what is seen: what leaves more on the patches is no nearer by it.

    Args:
        best: favoured model.
        rivals: others.
        doubt: log evidence that is in doubt of what it owes to poses.
        as_well: log evidence within which models are as good.
    """
    return {
        rival.identifiers
        for rival in rivals
        if rival.identifiers != best.identifiers
        and best.level - rival.level < as_well + doubt
        and 0.5 * (rival.chi_square - best.chi_square) < as_well
        and doubt > 0.0
    }


def _as_good_but_for_a_course(
    best: Hypothesis, rivals: Sequence[Hypothesis], nominal: Refit, as_well: float
) -> set[tuple[str, ...]]:
    """Return effects that only a best one that is free in time puts behind, by its freedom.

    Of what it owes to that, no more than all that it explains, a share is in doubt: beside what is
    the same at all times, and where it leaves more than noise beside what is as free.

    Args:
        best: favoured model.
        rivals: others.
        nominal: fit of the model without effects.
        as_well: log evidence within which models are as good.
    """
    if not best.is_free_in_time:
        return set()
    owed = max(best.log_evidence - nominal.log_evidence, 0.0)
    least = best.level - FORM_DOUBT * owed - as_well
    return {
        rival.identifiers
        for rival in rivals
        if not (rival.is_free_in_time and best.leaves_noise)
        and rival.identifiers != best.identifiers
        and rival.level > least
    }


def _joined(identifiers: Sequence[str]) -> str:
    return ' and '.join(identifiers)
