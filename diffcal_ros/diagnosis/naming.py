# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""From refitted models to a verdict: a name, a set of twins, or an effect that is unknown."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from diffcal_ros.diagnosis.disagreement import Disagreement
from diffcal_ros.diagnosis.evidence import Evidence
from diffcal_ros.diagnosis.frames import frame_of
from diffcal_ros.diagnosis.hypothesis import Hypothesis
from diffcal_ros.diagnosis.limits import upper_limits
from diffcal_ros.diagnosis.refit import Refit
from diffcal_ros.diagnosis.screening import largest_cosines, Screen
from diffcal_ros.diagnosis.selection import AS_WELL, Selection
from diffcal_ros.diagnosis.time_course import time_course
from diffcal_ros.diagnosis.unknown import (
    describe_unknown,
    FAR_ABOVE,
    is_unexplained,
    Unknown,
)
from diffcal_ros.diagnosis.verdict import Diagnosis, GapFigures, NamedEffect, Verdict
from diffcal_ros.diagnosis.whereabouts import where_largest
from diffcal_ros.diagnosis.whitened import closed_share, excess_over, Part, patch_gap
from diffcal_ros.scene.effects import what_settles
import numpy as np

# Log evidence is that of a noise model which is a guess: it counts for so much.
_TEMPERATURE = 2.0
# An effect is named by itself from this confidence on.
_NAMED = 0.6
# A mesh that may be off by more hides what would matter [m].
_COARSE = 0.0004
_HARDLY_MORE = 0.0005  # [m]
# What one refinement tells of an error of mesh and step is off by about this share of it.
_SHIFT_DOUBT = 1.0 / 3.0
# With one pose twins differ by details, which mesh and smooth errors have, too: models this close
# in log evidence, per unit of noise scale, explain it as well.
_ONE_POSE_AS_WELL = 12.0


@dataclass(frozen=True)
class _Choice:
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


def conclude(
    evidence: Evidence,
    nominal: Refit,
    scores: Screen,
    disagreement: Disagreement,
    selection: Selection | None,
    seconds: float,
) -> Diagnosis:
    """Put the verdict together."""
    choice = None if selection is None else _choose(selection, evidence)
    added = choice.hypothesis.fit if choice is not None else nominal
    closure = float('nan')
    if choice is not None:
        closure = _closure(nominal, added, evidence.is_measured)
    unknown: Unknown | None = None
    if choice is not None and is_unexplained(
        nominal, choice.hypothesis.fit, closure, is_measured=evidence.is_measured
    ):
        nearest = choice.hypothesis.added[0].effect.group
        unknown = describe_unknown(evidence, nominal, nearest)
    effects: tuple[NamedEffect, ...] = ()
    if choice is not None and unknown is None and choice.confidence >= _NAMED:
        effects = named_effects(choice.hypothesis, choice.confidence)
    separating = None
    if choice is not None and len(choice.alike) > 1:
        separating = what_settles(choice.alike[:3])
    return Diagnosis(
        verdict=disagreement.verdict,
        evidence='confirmed' if evidence.is_measured else 'suspected',
        p_value=disagreement.p_value,
        effects=effects,
        ambiguity_set=() if choice is None or unknown is not None else choice.alike,
        runner_up=None if choice is None else choice.runner_up,
        unknown_class=None if unknown is None else unknown.group,
        stand_in=None if unknown is None else unknown.stand_in,
        separating_recording=separating,
        where=where_largest(evidence.model, nominal),
        when=time_course(evidence.model, nominal),
        gap_mm=gap_figures(nominal, added),
        closure=closure,
        parameters={
            'before': parameter_table(nominal, nominal),
            'after': parameter_table(added, nominal),
        },
        times_detectable=_times_detectable(scores),
        limits=upper_limits(scores),
        largest_cosine=largest_cosines(scores.scores),
        seconds=seconds,
        notes=_notes(disagreement, choice, unknown, len(evidence.left_out)),
        details=_details(nominal, scores, selection, choice),
    )


def _details(
    nominal: Refit, scores: Screen, selection: Selection | None, choice: '_Choice | None'
) -> dict[str, Any]:
    """Return scores and refits, for whoever wants to know how it came to a verdict."""
    return {
        'patches': nominal.patch_count,
        'chi_square_per_patch': nominal.chi_square / max(nominal.patch_count, 1),
        'scores': [
            {
                'identifier': score.candidate.identifier,
                'components': list(score.candidate.components),
                'at': score.candidate.at,
                'log_evidence': score.log_evidence,
                'gain': score.gain,
            }
            for score in scores.scores
        ],
        'candidates': [] if selection is None else _candidate_table(selection, choice),
        'refits': [] if selection is None else _refit_table(selection),
    }


def named_effects(hypothesis: Hypothesis, confidence: float) -> tuple[NamedEffect, ...]:
    """Describe the effects of a model."""
    found = []
    for candidate in hypothesis.added:
        amplitudes = hypothesis.amplitudes(candidate)
        found.append(
            NamedEffect(
                identifier=candidate.identifier,
                group=candidate.effect.group,
                amplitude={a.name: a.value for a in amplitudes},
                std_error={a.name: a.std_error for a in amplitudes},
                unit={a.name: a.unit for a in amplitudes},
                setting=candidate.settings,
                frame=frame_of(
                    candidate.identifier, hypothesis.evidence.model, hypothesis.fit.coordinates
                ),
                confidence=confidence,
                sentence=candidate.effect.sentence,
            )
        )
    return tuple(found)


def gap_figures(nominal: Refit, added: Refit) -> GapFigures:
    """Measure the gap on the patches that no fit has seen."""
    before = patch_gap(nominal.blocks, Part.REPORT)
    after = patch_gap(added.blocks, Part.REPORT)
    return GapFigures(
        nominal=1e3 * before.rms,
        added=1e3 * after.rms,
        floor_sensor=1e3 * before.floor,
        floor_numerics=1e3 * before.mesh,
        median_nominal=1e3 * before.median,
        median_added=1e3 * after.median,
    )


def parameter_table(fit: Refit, asked: Refit) -> dict[str, dict[str, float | str]]:
    """Return value, standard error and unit of the parameters that were asked for.

    Those of a motion are fitted to this mesh and step: what they took up of these is put back.

    Args:
        fit: where they are.
        asked: a fit of those that are wanted.
    """
    wanted = set(asked.parameters.names)
    table: dict[str, dict[str, float | str]] = {}
    for place, parameter in enumerate(fit.parameters):
        if parameter.is_nuisance or parameter.name not in wanted:
            continue
        shift = fit.shifts[place]
        value = parameter.value(fit.coordinates[place] + shift)
        rate = value if parameter.is_logarithmic else 1.0
        variance = fit.covariance[place, place] + (_SHIFT_DOUBT * shift) ** 2
        table[parameter.name] = {
            'value': value,
            'std_error': rate * float(np.sqrt(variance)),
            'unit': parameter.unit,
        }
    return table


def _times_detectable(scores: Screen) -> dict[str, float]:
    found: dict[str, float] = {}
    for score in scores.scores:
        found.setdefault(score.candidate.identifier, score.times_detectable)
    return found


def _candidate_table(selection: Selection, choice: '_Choice | None') -> list[dict[str, Any]]:
    """Return every effect that has been refitted, with its amplitudes, the favoured first."""
    found: dict[str, NamedEffect] = {}
    favoured = [] if choice is None else [choice.hypothesis]
    for hypothesis in (*favoured, *selection.singles):
        confidence = choice.confidence if choice and hypothesis is choice.hypothesis else 0.0
        for effect in named_effects(hypothesis, confidence):
            found.setdefault(effect.identifier, effect)
    return [asdict(effect) for effect in found.values()]


def _choose(selection: Selection, evidence: Evidence) -> _Choice | None:
    best = selection.best
    if best is None:
        return None
    rivals = selection.singles if len(best.added) == 1 else selection.pairs
    levels: dict[tuple[str, ...], float] = {}
    for hypothesis in rivals:
        level = hypothesis.fit.log_evidence / selection.noise_scale
        if hypothesis.is_at_bound and hypothesis is not best:
            continue
        key = hypothesis.identifiers
        levels[key] = max(levels.get(key, -np.inf), level)
    top = levels[best.identifiers]
    ranked = sorted(levels, key=lambda key: -levels[key])
    weights = {key: np.exp((levels[key] - top) / _TEMPERATURE) for key in levels}
    confidence = float(weights[best.identifiers] / sum(weights.values()))
    others = [key for key in ranked if key != best.identifiers]
    has_one_pose = len({seen.setup_index for seen in evidence.model.observations}) == 1
    as_well = _ONE_POSE_AS_WELL if has_one_pose else AS_WELL
    near = {key for key in others if top - levels[key] < as_well}
    if not evidence.is_measured:
        # The log evidence rests on a floor that is a guess: what is left must tell.
        near |= _as_near(best, rivals)
    if has_one_pose or not evidence.is_measured:
        confidence = min(confidence, 1.0 / (1 + len(near)))
    alike = [best.identifiers, *(key for key in others if key in near)]
    return _Choice(
        hypothesis=best,
        confidence=confidence,
        alike=tuple(dict.fromkeys(name for key in alike for name in key)),
        runner_up=_joined(others[0]) if others else None,
    )


def _as_near(best: Hypothesis, rivals: Sequence[Hypothesis]) -> set[tuple[str, ...]]:
    """Return the effects that leave hardly more on held-out patches than the best."""
    return {
        rival.identifiers
        for rival in rivals
        if rival.identifiers != best.identifiers
        and excess_over(rival.fit.blocks, best.fit.blocks, Part.REPORT) < _HARDLY_MORE
    }


def _joined(identifiers: Sequence[str]) -> str:
    return ' and '.join(identifiers)


def _closure(nominal: Refit, added: Refit, is_measured: bool) -> float:
    """Return (nominal - added) / (nominal - floor) on the report patches."""
    before, after = patch_gap(nominal.blocks, Part.REPORT), patch_gap(added.blocks, Part.REPORT)
    floor = before.whole_floor
    old, new = before.size(is_measured=is_measured), after.size(is_measured=is_measured)
    return closed_share(old, new, floor)


def _notes(
    disagreement: Disagreement, choice: _Choice | None, unknown: Unknown | None, left_out: int
) -> tuple[str, ...]:
    notes = []
    if left_out:
        notes.append(f'{left_out} patches show something else than the body and were left out')
    if disagreement.verdict is Verdict.BELOW_MARGIN:
        notes.append('something is there, but it is too small to matter')
    if disagreement.verdict is Verdict.CANNOT_TELL and disagreement.gap.mesh > _COARSE:
        notes.append(
            f'the mesh may be off by {1e3 * disagreement.gap.mesh:.2f} mm, more than the sensor: '
            'refine the mesh first'
        )
    elif disagreement.verdict is Verdict.CANNOT_TELL:
        notes.append('the data are too few or too noisy: record more poses, or come closer')
    if unknown is not None:
        notes.append(unknown.sentence)
    if choice is not None and unknown is None:
        left = patch_gap(choice.hypothesis.fit.blocks, Part.REPORT)
        if left.rms > FAR_ABOVE * left.whole_floor:
            notes.append(
                f'{1e3 * left.rms:.2f} mm are still left: this is not all that is missing'
            )
    if choice is not None and choice.hypothesis.is_at_bound:
        notes.append('an amplitude stopped at its bound')
    return tuple(notes)


def _refit_table(selection: Selection) -> list[dict[str, object]]:
    return [
        {
            'effects': list(h.identifiers),
            'components': [list(c.components) for c in h.added],
            'at': [c.at for c in h.added],
            'log_evidence': h.fit.log_evidence,
            'chi_square': h.fit.chi_square,
            'at_bound': h.is_at_bound,
            'evaluations': h.fit.evaluations,
        }
        for h in (*selection.singles, *selection.pairs)
    ]
