# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Refit the best candidates with all nominal parameters, and compare what is left."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from diffcal_ros.chi_square import exceeded_with
from diffcal_ros.diagnosis.detection.disagreement import ALPHA
from diffcal_ros.diagnosis.model_comparison.absence import differing_by_pose, has_doubtful_effect
from diffcal_ros.diagnosis.model_comparison.form_basis import FormBasis
from diffcal_ros.diagnosis.model_comparison.form_fits import each_alone, one_of_each
from diffcal_ros.diagnosis.model_comparison.freed_effects import with_those_freed
from diffcal_ros.diagnosis.model_comparison.freed_rivals import with_halves_freed
from diffcal_ros.diagnosis.model_comparison.fuller_pairs import with_all_amplitudes
from diffcal_ros.diagnosis.model_comparison.guessed_floor import predicts_better, ranked
from diffcal_ros.diagnosis.model_comparison.hypothesis import (
    AS_WELL,
    FARTHEST_FORM,
    FORM_DOUBT,
    Hypothesis,
)
from diffcal_ros.diagnosis.model_comparison.judged_models import (
    judge_by,
    judged,
    judged_side_by_side,
    judged_singles,
    nominal_basis,
)
from diffcal_ros.diagnosis.model_comparison.less_freedom import with_less_freedom
from diffcal_ros.diagnosis.model_comparison.looks_in_any_form import others_in_any_form
from diffcal_ros.diagnosis.model_comparison.moved_in_place import with_what_moves
from diffcal_ros.diagnosis.model_comparison.over_time import others_over_time
from diffcal_ros.diagnosis.model_comparison.pair_search import best_pairs, halves
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.model_comparison.refit_rounds import by_evidence
from diffcal_ros.diagnosis.model_comparison.second_effect import (
    Explained,
    most_added,
    most_gain,
    PAIR_GAIN,
    second_adds,
)
from diffcal_ros.diagnosis.model_comparison.single_effects import refitted_singles
from diffcal_ros.diagnosis.model_comparison.swapped_pairs import with_swapped
from diffcal_ros.diagnosis.patch_fits.refit import AS_NOISE
from diffcal_ros.diagnosis.patches.patch_gap import patch_gap
from diffcal_ros.diagnosis.patches.whitened import independent_count, Part, whiten
from diffcal_ros.diagnosis.screening.screening import Screen
from diffcal_ros.diagnosis.screening.shortlist import with_tangents
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Where the floor is a guess, what most patches are off by in floors where something may be left.
_POOR_FLOORS = 2.0
# A second effect must explain so much more, in log evidence per unit of noise scale, than any form
# of the first.
_LEAST_GAIN = 4.0
# A second effect must be better by so much log likelihood on held-out patches, and on each pose
# given the others.
_HELD_OUT_GAIN = 4.0


@dataclass(frozen=True)
class Selection:
    """Refitted models.

    Attributes:
        singles: one effect each, best first.
        pairs: two effects each, best first.
        noise_scale: chi-square per patch of the best of all, at least 1.
        is_measured: whether the sensor floor was.
        added: what the best pair adds to what one effect in any form explains; None: not known.
        one_and_two: the best of one effect and of two, judged on the patches that both see; None:
            on those that each sees.
    """

    singles: tuple[Hypothesis, ...]
    pairs: tuple[Hypothesis, ...] = field(default_factory=tuple)
    noise_scale: float = 1.0
    is_measured: bool = True
    added: Explained | None = None
    one_and_two: tuple[Hypothesis, Hypothesis] | None = None

    @property
    def best(self) -> Hypothesis | None:
        """The model that the data favour: two effects only where one is not enough."""
        if not self.singles:
            return None
        two = self._needed_pair()
        if two is None or self.rival is not None:
            return self.leader
        return two

    @property
    def rival(self) -> Hypothesis | None:
        """Two effects that explain more than the best one, which is none of them and may be it.

        What the one leaves in about its own form is noise: nothing says that there are two.
        """
        needed = self._needed_pair()
        if needed is None or not self.is_measured:
            return None
        one, two = self._best_of_each()
        doubt = PAIR_GAIN * self.noise_scale + FORM_DOUBT * one.leaning
        is_clear = two.level - one.level > doubt
        return None if _is_half(one, two) or is_clear or one.chance_of_noise < ALPHA else needed

    def _best_of_each(self) -> tuple[Hypothesis, Hypothesis]:
        """Return the best model of one effect and the best of two."""
        return self.one_and_two or (self.leader, self.pairs[0])

    def _needed_pair(self) -> Hypothesis | None:
        """Return the best pair where one effect is not enough, in whatever form."""
        if not (self.singles and self.pairs):
            return None
        one, two = self._best_of_each()
        if self.is_measured and _is_half(one, two) and one.leaves_noise and one.fit.leaves_noise:
            # All that is left to explain is how far poses are off, and these may be misstated.
            return None
        # What is in doubt of the one speaks against a second one beside it.
        level = max(one.level, one.log_evidence) if _is_half(one, two) else one.level
        is_more = two.level - level > PAIR_GAIN * self.noise_scale
        transfer = np.inf
        if self.added is not None:
            is_more &= self.added.log_evidence > _LEAST_GAIN * self.noise_scale
            transfer = self.added.log_transfer
        is_everywhere = transfer > _HELD_OUT_GAIN * self.noise_scale
        is_needed = is_more and is_everywhere and self._is_confirmed(one, two)
        return self.pairs[0] if is_needed else None

    def _is_confirmed(self, one: Hypothesis, two: Hypothesis) -> bool:
        """Tell whether held-out patches want the second effect, too."""
        if not self.is_measured:
            return predicts_better(one, two) > _HELD_OUT_GAIN
        in_form = one.judged is not None and one.judged.fraction <= FARTHEST_FORM
        if one.judged is not None and two.judged is not None and in_form:
            told = two.judged.log_prediction - one.judged.log_prediction
            # Cells between those that were fitted are told by these, whatever the model. Of
            # several poses each is told by the others (`Explained`): with what was fitted, cells
            # need not be against it.
            has_others = self.added is not None and np.isfinite(self.added.log_transfer)
            if not has_others:
                return told / self.noise_scale > _HELD_OUT_GAIN
            whole = two.level - one.level + told
            # What may be noise is, and none of it is more than another.
            is_as_near = two.judged.left <= max(one.judged.left, _most_noise(two))
            return is_as_near and whole / self.noise_scale > PAIR_GAIN
        # A form so far from the library's goes between the patches that were fitted.
        fits = (one.fit, two.fit)
        likelihoods = [-0.5 * whiten(fit.groups, Part.REPORT).chi_square for fit in fits]
        return (likelihoods[1] - likelihoods[0]) / self.noise_scale > _HELD_OUT_GAIN

    @property
    def leader(self) -> Hypothesis:
        """The variant of the best effect with most amplitudes that explains the data as well.

        One that leaves an amplitude out is sure of what it cannot know.
        """
        leader = self.singles[0]
        least = leader.level - AS_WELL * self.noise_scale
        variants = [
            h
            for h in self.singles
            if h.identifiers == leader.identifiers
            and h.level > least
            and not (h.is_at_bound or h.has_absent_amplitude)
        ]
        return max(variants, key=lambda h: h.amplitude_count, default=leader)


def _most_noise(model: Hypothesis) -> float:
    """Return what noise alone hardly leaves more of on held-out patches [m], root mean square.

    Floors are what is to be expected: of noise as large half of all draws leave more.
    """
    count = independent_count(model.fit.groups, Part.REPORT)
    floor = patch_gap(model.fit.groups, Part.REPORT).whole_floor
    return floor * float(np.sqrt(exceeded_with(AS_NOISE, count) / count))


@dataclass(frozen=True)
class Begun:
    """Models with one effect each as they were refitted first.

    Attributes:
        singles: those, best first.
        basis: of the nominal model; None where models are judged as they are.
    """

    singles: tuple[Hypothesis, ...]
    basis: FormBasis | None


def begin(pool: RefitPool, scores: Screen, *, in_any_form: bool = True) -> Begun:
    """Refit the best candidates; see `select`.

    Of a gap that does not matter nothing is named: what takes long is not looked at beside others.
    """
    basis = nominal_basis(pool)
    judge = judge_by(basis)
    singles = refitted_singles(pool, scores, judge, looks_long=in_any_form)
    if singles and all(h.has_idle_effect for h in singles):
        # What stood in for those without a tangent kept others out, and they do nothing.
        singles = refitted_singles(pool, with_tangents(scores), judge)
    singles, basis = judged_singles(pool, singles, basis)
    if in_any_form:
        singles = with_those_freed(pool, singles, basis)
    return Begun(tuple(singles), basis)


def select(
    pool: RefitPool,
    scores: Screen,
    begun: Begun | None = None,
    *,
    with_pairs: bool = True,
    in_any_form: bool = True,
) -> Selection:
    """Refit candidates, and pairs where no single one is enough.

    Args:
        pool: who refit, and what the nominal model is.
        scores: of all candidates.
        begun: what was refitted already; None: nothing.
        with_pairs: whether two effects may be named; else only which one comes nearest is asked.
        in_any_form: whether effects are fitted in forms that the library does not have, too; else
            only which one comes nearest in the library's.
    """
    begun = begun or begin(pool, scores, in_any_form=in_any_form)
    singles, basis = list(begun.singles), begun.basis
    if not in_any_form:
        return compared(pool, singles, [], basis)
    judge = judge_by(basis)
    others = [] if judge is None else others_in_any_form(pool, scores, singles, judge)
    if others:
        others = with_those_freed(pool, judged(others, basis, is_brief=True), basis, singles)
        singles, basis = judged_singles(pool, [*singles, *others], basis)
    if pool.nominal.stays_robust:
        singles = sorted(ranked(singles), key=by_evidence)
    pairs, over_time = list[Hypothesis](), list[Hypothesis]()
    if with_pairs and singles and _is_poor(pool, singles[0], basis):
        over_time = others_over_time(pool, scores, singles)
    # Beside an effect that is free to be another one at any time a second one may be anything.
    leaders = sorted([*singles[:1], *over_time], key=by_evidence)
    if with_pairs and leaders and _is_poor(pool, leaders[0], basis):
        judge = judge_by(basis)
        pairs = best_pairs(pool, singles, scores, basis)
        pairs = with_swapped(pool, pairs, singles, scores, judge)
        pairs = with_all_amplitudes(pool, pairs, singles, scores, judge)
        pairs = with_less_freedom(pool, judged(pairs, basis, is_brief=True), basis)
        pairs = with_those_freed(pool, pairs, basis, singles)
        pairs = with_what_moves(pool, pairs, singles, scores, judge)
        singles = sorted([*singles, *halves(pool, singles, pairs, basis)], key=by_evidence)
        singles = with_halves_freed(pool, singles, pairs, basis)
    return compared(pool, [*singles, *over_time], pairs, basis)


def compared(
    pool: RefitPool,
    singles: Sequence[Hypothesis],
    pairs: Sequence[Hypothesis],
    basis: FormBasis | None,
) -> Selection:
    """Hold refitted models against one another; those that do nothing fall out.

    Args:
        pool: who refitted them, and what the nominal model is.
        singles: models with one effect each.
        pairs: with two.
        basis: of the nominal model; None where models are judged as they are.
    """
    singles = [h for h in singles if not h.has_idle_effect]
    pairs = [
        h for h in pairs if not (h.has_idle_effect or has_doubtful_effect(h, pool.base, singles))
    ]
    if basis is not None and pairs:
        best = min(judged(pairs, basis, is_brief=True), key=by_evidence)
        singles = [*singles, *each_alone(pool, best, basis)]
    models = judged([*singles, *pairs], basis)
    if pool.nominal.stays_robust:
        models = ranked(models)
    singles = sorted(one_of_each(models[: len(singles)]), key=by_evidence)
    pairs = sorted(models[-len(pairs) :] if pairs else [], key=by_evidence)
    scale = _noise_scale([*singles, *pairs])
    pairs = _with_something_in_common_first(_believable_first(pairs, scale))
    added = None
    if singles and pairs and basis is not None:
        added = second_adds(singles, pairs[0], basis)
        pairs[0] = replace(pairs[0], larger=added.larger)
    found = Selection(tuple(singles), tuple(pairs), scale, pool.nominal.is_measured, added)
    if added is None:
        return found
    return replace(found, one_and_two=judged_side_by_side(found.leader, pairs[0], basis))


def _believable_first(pairs: Sequence[Hypothesis], scale: float) -> list[Hypothesis]:
    """Return pairs, the best one that may be believed first, where others are as good.

    That is like itself in all poses, and not free in form and in each pose, which may be anything.

    Args:
        pairs: best first.
        scale: of the noise.
    """
    if not pairs or _is_believable(pairs[0]):
        return list(pairs)
    least = pairs[0].level - AS_WELL * scale
    first = next((p for p in pairs if _is_believable(p) and p.level > least), pairs[0])
    return [first, *(pair for pair in pairs if pair is not first)]


def _with_something_in_common_first(pairs: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Return pairs, those last whose effects have hardly anything in common in all poses.

    These have no name, and are a doubt of what they do better than (`choose`).
    """
    return sorted(pairs, key=lambda pair: differing_by_pose(pair) is not None)


def _is_believable(pair: Hypothesis) -> bool:
    return not (pair.is_unlike_itself or pair.is_free_in_everything)


def _is_half(one: Hypothesis, two: Hypothesis) -> bool:
    """Tell whether a model of two effects has that of another one."""
    return set(one.identifiers) <= set(two.identifiers)


def _is_poor(pool: RefitPool, hypothesis: Hypothesis, basis: FormBasis | None) -> bool:
    """Tell whether one effect leaves so much that a second one is sought."""
    if pool.nominal.is_measured:
        least = PAIR_GAIN * max(1.0, hypothesis.chi_square_per_patch)
        if most_gain(hypothesis) <= least:
            return False
        return basis is None or most_added(hypothesis, basis) > least
    left = patch_gap(hypothesis.fit.groups, Part.FIT)
    return left.most > _POOR_FLOORS * left.whole_floor


def _noise_scale(models: Sequence[Hypothesis]) -> float:
    """Return chi-square per patch of the best model; 1 where the size of the noise is its own."""
    if any(model.guessed is not None for model in models):
        return 1.0
    return max(1.0, min((h.chi_square_per_patch for h in models), default=1.0))
