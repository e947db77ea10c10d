# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which of the screened candidates are worth a refit."""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.diagnosis.screening.screening import Score, Screen
from diffcal_ros.effects.registry import EFFECTS
import numpy as np

# Effects that are refitted, by the order of their scores; twins of those come on top.
_FIRST = 4
_LAST = 7
# Whoever could explain less than this share of what the best one could is left out.
_LEAST_GAIN = 0.5
_LEAST_WITHOUT_TANGENT = 0.4
# Tangents that explain so much of what the best ones do are those of a twin.
_NEARLY = 0.9
_CLOSE, _CLOSE_FRACTION = 5.0, 0.1


def shortlist(scores: Screen, *, is_measured: bool) -> list[Score]:
    """Return the scores whose candidates are refitted.

    Args:
        scores: of all candidates.
        is_measured: whether the sensor floor was; scores by a guessed one rule no effect out.
    """
    if not is_measured:
        return distinct(scores.scores)
    best: dict[str, list[Score]] = {}
    for score in scores.scores:
        best.setdefault(score.candidate.identifier, []).append(score)
    gains = {name: max(score.gain for score in listed) for name, listed in best.items()}
    by_pose = {name: max(score.gain_by_pose for score in own) for name, own in best.items()}
    least = _LEAST_GAIN * max(gains.values(), default=0.0)
    # What is another one in each pose is not seen as one that is the same in all.
    in_any = {name: max(gain, by_pose[name]) for name, gain in gains.items()}
    first = list(best)[:_FIRST]
    wanted = [*first, *(twin for name in first for twin in EFFECTS[name].twins)]
    chosen = [name for name in dict.fromkeys(wanted) if in_any.get(name, 0.0) > least][:_LAST]
    # What stands in for an effect does so badly where that does much.
    chosen += [
        name
        for name, gain in gains.items()
        if not EFFECTS[name].has_tangent
        and gain > _LEAST_WITHOUT_TANGENT * least
        and name not in chosen
    ]
    chosen += [name for name, gain in by_pose.items() if gain > max(2.0 * least, 0.0)]
    chosen = list(dict.fromkeys(chosen))
    variants = {name: _variants(best[name]) for name in chosen}
    most = {name: max(map(_amplitude_count, listed)) for name, listed in variants.items()}
    for name, listed in variants.items():
        # Against a twin with all its amplitudes one with fewer would lose by their number alone.
        of_twins = max((most[twin] for twin in EFFECTS[name].twins if twin in most), default=0)
        fullest = max(best[name], key=_amplitude_count)
        if min(of_twins, _amplitude_count(fullest)) > most[name]:
            listed.append(fullest)
        listed.extend(other_kinds(best[name], listed, _LEAST_WITHOUT_TANGENT * least))
    return [score for listed in variants.values() for score in listed]


def other_kinds(
    scores: Sequence[Score], listed: Sequence[Score], least: float = -np.inf
) -> list[Score]:
    """Return the best of each kind of an effect that none listed is of, where it may be it.

    Only of those without tangents: what stands in for all of a plane explains more than what does
    for a bar below one place, whichever of the two is there.

    Args:
        scores: of the effect, best first.
        listed: those of them that are chosen.
        least: chi-square that a kind has to explain more of.
    """
    known = {score.candidate.components for score in listed}
    first: dict[tuple[str, ...], Score] = {}
    for score in scores:
        if not score.candidate.effect.has_tangent and score.gain > least:
            first.setdefault(score.candidate.components, score)
    return [score for kind, score in first.items() if kind not in known]


def _amplitude_count(score: Score) -> int:
    return len(score.candidate.components)


def with_tangents(scores: Screen) -> Screen:
    """Return the scores of effects that are absent at zero, and have tangents there."""
    smooth = (score for score in scores.scores if score.candidate.effect.has_tangent)
    return replace(scores, scores=tuple(smooth))


def front_runners(scores: Screen) -> frozenset[str]:
    """Return the effects whose tangents explain nearly as much as the best one's: its twins.

    Those without tangents are none of them: what stands in explains more than they can.
    """
    smooth = with_tangents(scores).scores
    most = max((score.gain for score in smooth), default=0.0)
    return frozenset(s.candidate.identifier for s in smooth if s.gain > _NEARLY * most)


def distinct(scores: Sequence[Score]) -> list[Score]:
    """Return the best variant of every effect."""
    first: dict[str, Score] = {}
    for score in scores:
        first.setdefault(score.candidate.identifier, score)
    return list(first.values())


def starts_of(score: Score) -> dict[str, float]:
    """Return the amplitudes that tangents expect, SI units by name among the parameters.

    What has no tangent at zero is not expected anywhere: such an effect says where it may start.
    """
    candidate = score.candidate
    if not candidate.effect.has_tangent:
        return dict(candidate.screened)
    found = {n: float(v) for n, v in zip(candidate.names, score.amplitudes, strict=True)}
    return {**found, **candidate.screened}


def _variants(scores: Sequence[Score]) -> list[Score]:
    """Keep the variants whose scores are near the best one's: tangents cannot tell them apart."""
    leader = scores[0].log_evidence
    within = max(_CLOSE, _CLOSE_FRACTION * abs(leader))
    near = [score for score in scores if leader - score.log_evidence < within]
    # The fullest one tells how sure each amplitude is when none is left out.
    fullest = max(near, key=_amplitude_count)
    chosen = near[:2]
    return chosen if any(score is fullest for score in chosen) else [*chosen, fullest]
