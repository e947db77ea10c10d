# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Refit the best candidates with all nominal parameters, and compare what is left."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
import time

from diffcal_ros.diagnosis.evidence import Evidence
from diffcal_ros.diagnosis.hypothesis import Hypothesis, try_effects
from diffcal_ros.diagnosis.refit import Refit
from diffcal_ros.diagnosis.screening import Score, Screen, screen
from diffcal_ros.diagnosis.whitened import Part, patch_gap
from diffcal_ros.scene.effects import EFFECTS

# Effects that are refitted, by the order of their scores; twins of those come on top.
_FIRST = 4
_LAST = 7
# Whoever could explain less than this share of what the best one could is left out.
_LEAST_GAIN = 0.5
_LEAST_CONTACT = 0.4
# Evaluations of the model in a first look, and how far behind in log evidence per unit of noise
# scale a model may be then to be fitted to the end.
_BRIEF = 4
_NEARLY = 0.9
_OUT_OF_REACH = 40.0
# Chi-square per patch above which a model does not explain the data.
_POOR = 2.0
# Best single effects that a second one is sought for, and how many for each.
_FIRSTS, _SECONDS = 2, 3
# No further pair is begun after so much work [s of one core].
_PATIENCE = 40.0
# A second effect must close so much of what the first one leaves on held-out patches.
_CLOSES = 0.25
# A second effect must be better by so much log evidence, per unit of noise scale.
_PAIR_GAIN = 8.0


@dataclass(frozen=True)
class Selection:
    """Refitted models.

    Attributes:
        singles: one effect each, best first.
        pairs: two effects each, best first.
        noise_scale: chi-square per patch of the best of all, at least 1.
    """

    singles: tuple[Hypothesis, ...]
    pairs: tuple[Hypothesis, ...] = field(default_factory=tuple)
    noise_scale: float = 1.0

    @property
    def best(self) -> Hypothesis | None:
        """The model that the data favour: two effects only where one is not enough."""
        if not self.singles:
            return None
        one = self.singles[0]
        if self.pairs:
            two = self.pairs[0]
            gain = (two.fit.log_evidence - one.fit.log_evidence) / self.noise_scale
            if gain > _PAIR_GAIN and _closed(one.fit, two.fit) > _CLOSES:
                return two
        return one


def select(
    nominal: Evidence, base: Refit, scores: Screen, tell: Callable[[str], None]
) -> Selection:
    """Refit candidates, and pairs where no single one is enough.

    Args:
        nominal: evidence of the nominal model.
        base: its fit.
        scores: of all candidates.
        tell: told what is being done.
    """
    begun = time.process_time()
    singles: list[Hypothesis] = []
    for score in _to_refit(scores):
        tell(f'refitting with {score.candidate.identifier}')
        found = try_effects(
            nominal, base, [score.candidate], _starts([score]), max_iterations=_BRIEF
        )
        if found is not None:
            singles.append(found)
    singles = _finished(nominal, base, singles, tell, _front_runners(scores))
    pairs: list[Hypothesis] = []
    # Two effects fit a floor that is only a guess all too well.
    if singles and nominal.is_measured and singles[0].fit.chi_square_per_patch > _POOR:
        deadline = begun + _PATIENCE
        pairs = _pairs(nominal, base, singles, scores, tell, deadline)
    best = min([*singles, *pairs], key=lambda h: h.fit.chi_square_per_patch, default=None)
    scale = 1.0 if best is None else max(1.0, best.fit.chi_square_per_patch)
    return Selection(tuple(singles), tuple(pairs), scale)


def _finished(
    nominal: Evidence,
    base: Refit,
    brief: Sequence[Hypothesis],
    tell: Callable[[str], None],
    front: frozenset[str] = frozenset(),
) -> list[Hypothesis]:
    """Fit the models that may still win, or lead by their scores, to the end; best first."""
    if not brief:
        return []
    least = min(h.fit.chi_square_per_patch for h in brief)
    leader = max(h.fit.log_evidence for h in brief)
    finished = []
    for hypothesis in brief:
        behind = (leader - hypothesis.fit.log_evidence) / max(1.0, least)
        leads = bool(front & set(hypothesis.identifiers))
        if hypothesis.fit.is_converged or (behind > _OUT_OF_REACH and not leads):
            finished.append(hypothesis)
            continue
        tell(f'refitting with {" and ".join(hypothesis.identifiers)} to the end')
        longer = try_effects(nominal, base, hypothesis.added, _fitted(hypothesis))
        finished.append(hypothesis if longer is None else longer)
    return sorted(finished, key=_order)


def _front_runners(scores: Screen) -> frozenset[str]:
    """Return the effects whose tangents explain nearly as much as the best one's: its twins."""
    most = max((score.gain for score in scores.scores), default=0.0)
    return frozenset(
        score.candidate.identifier for score in scores.scores if score.gain > _NEARLY * most
    )


def _closed(one: Refit, two: Refit) -> float:
    """Return the share of the excess on held-out patches that the second effect closes."""
    before, after = patch_gap(one.blocks, Part.REPORT), patch_gap(two.blocks, Part.REPORT)
    floor = before.whole_floor
    excess = before.rms - floor
    return (before.rms - max(after.rms, floor)) / excess if excess > 0.2 * floor else 0.0


def _order(hypothesis: Hypothesis) -> tuple[bool, float]:
    return hypothesis.is_at_bound, -hypothesis.fit.log_evidence


def _to_refit(scores: Screen) -> list[Score]:
    """Return the best variant of each of the first effects, of their twins and of contact."""
    best: dict[str, list[Score]] = {}
    for score in scores.scores:
        best.setdefault(score.candidate.identifier, []).append(score)
    gains = {name: max(score.gain for score in listed) for name, listed in best.items()}
    least = _LEAST_GAIN * max(gains.values(), default=0.0)
    first = list(best)[:_FIRST]
    wanted = list(first)
    for identifier in first:
        wanted.extend(twin for twin in EFFECTS[identifier].twins if gains.get(twin, 0.0) > least)
    chosen = [name for name in dict.fromkeys(wanted) if name in best][:_LAST]
    chosen = [name for name in chosen if gains[name] > least]
    # Forces stand in for a plane badly where it lifts much.
    if gains.get('contact_plane', 0.0) > _LEAST_CONTACT * least and 'contact_plane' not in chosen:
        chosen.append('contact_plane')
    return [score for name in chosen for score in _variants(best[name])]


def _variants(scores: Sequence[Score]) -> list[Score]:
    """Keep the variants whose scores are near the best one's: tangents cannot tell them apart."""
    leader = scores[0].log_evidence
    near = [s for s in scores if leader - s.log_evidence < max(5.0, 0.1 * abs(leader))]
    return near[:2]


def _starts(scores: Sequence[Score]) -> dict[str, float]:
    return {
        name: float(value)
        for score in scores
        for name, value in zip(score.candidate.names, score.amplitudes, strict=True)
    }


def _pairs(
    nominal: Evidence,
    base: Refit,
    singles: Sequence[Hypothesis],
    scores: Screen,
    tell: Callable[[str], None],
    deadline: float,
) -> list[Hypothesis]:
    """Add a second effect to the best single ones, by the scores around each."""
    found: dict[tuple[str, ...], Hypothesis] = {}
    listed = [score.candidate for score in scores.scores]
    for one in _distinct(singles)[:_FIRSTS]:
        (first,) = one.added
        others = [c for c in listed if c.identifier != first.identifier]
        again = screen(one.evidence, one.fit.coordinates, others)
        for score in _distinct_scores(again.scores)[:_SECONDS]:
            key = tuple(sorted((first.identifier, score.candidate.identifier)))
            if key in found or time.process_time() > deadline:
                continue
            tell(f'refitting with {key[0]} and {key[1]}')
            starts = {**_fitted(one), **_starts([score])}
            pair = try_effects(
                nominal, base, [first, score.candidate], starts, max_iterations=_BRIEF
            )
            if pair is not None:
                found[key] = pair
    if time.process_time() > deadline:
        return sorted(found.values(), key=_order)
    return _finished(nominal, base, list(found.values()), tell)


def _fitted(hypothesis: Hypothesis) -> dict[str, float]:
    fit = hypothesis.fit
    return dict(zip(fit.parameters.names, fit.coordinates.tolist(), strict=True))


def _distinct(singles: Sequence[Hypothesis]) -> list[Hypothesis]:
    first: dict[str, Hypothesis] = {}
    for hypothesis in singles:
        first.setdefault(hypothesis.added[0].identifier, hypothesis)
    return list(first.values())


def _distinct_scores(scores: Sequence[Score]) -> list[Score]:
    first: dict[str, Score] = {}
    for score in scores:
        first.setdefault(score.candidate.identifier, score)
    return list(first.values())
