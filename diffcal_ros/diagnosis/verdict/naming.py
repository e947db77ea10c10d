# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""From refitted models to a verdict: a name, a set of twins, or an effect that is unknown."""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.diagnosis.answers import Evidence, Verdict
from diffcal_ros.diagnosis.detection.disagreement import Disagreement
from diffcal_ros.diagnosis.detection.limits import Drawn, drawn_parameters, upper_limits
from diffcal_ros.diagnosis.detection.local_outlier import LocalOutlier
from diffcal_ros.diagnosis.model_comparison.choice import Choice
from diffcal_ros.diagnosis.model_comparison.hypothesis import (
    FARTHEST_FORM,
    Hypothesis,
)
from diffcal_ros.diagnosis.model_comparison.selection import Selection
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patch_fits.residual_location import where_largest
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.patches.rigid_reference import fixture_offset
from diffcal_ros.diagnosis.patches.whitened import Part, patch_gap
from diffcal_ros.diagnosis.screening.screening import largest_cosines, Screen
from diffcal_ros.diagnosis.screening.shortlist import with_tangents
from diffcal_ros.diagnosis.verdict.doubts import doubts_about, MOST_OF_IT
from diffcal_ros.diagnosis.verdict.moved_together import moves_with_fixture
from diffcal_ros.diagnosis.verdict.time_course import time_course
from diffcal_ros.diagnosis.verdict.unknown import (
    describe_unknown,
    FAR_ABOVE,
    is_unexplained,
    LEAST_CLOSURE,
    Unknown,
)
from diffcal_ros.diagnosis.verdict.verdict import Diagnosis, NamedEffect
from diffcal_ros.diagnosis.verdict.verdict_figures import (
    closed_in_its_form,
    closure_of,
    details_of,
    drawn_beside,
    gap_figures,
    judged_part,
    named_effects,
    of_another_form,
    parameter_table,
    spread_over_poses,
    times_detectable,
    weight_doubt,
)
from diffcal_ros.effects.registry import EFFECTS, what_settles
import numpy as np

# An effect is named by itself from this confidence on.
_NAMED = 0.6
# Classes that are the same in all poses, whatever their form.
_STAYS = ('material', 'shape')
# A mesh that may be off by more hides what would matter [m].
_COARSE = 0.0004
# A fixture that is seen so far from where it is stated is told: thrice what is usual [m].
_FIXTURE_OFF = 0.003
# Of a form that is off by less nothing is said.
_TOLD = 0.05
_OF_THIS_CAUSE = (
    'the parameters are those beside just this cause: beside one that looks the same they would '
    'be others, by more than their errors'
)
_FOLLOWED = (
    'it is small beside the parameters as they are: they may have followed it, by more than their '
    'errors'
)
# Of what comes about as near as the nearest.
_MOST_NEAR = 3


@dataclass(frozen=True)
class _Naming:
    """What a verdict names, and what it leaves open.

    Attributes:
        doubts: why the chosen model may not be named.
        closure: share of the gap above the floor that it closes; NaN where none was chosen.
        unknown: an effect outside the library.
        effects: those named.
        is_open: no name, and none among several either.
    """

    doubts: tuple[str, ...]
    closure: float
    unknown: Unknown | None
    effects: tuple[NamedEffect, ...]
    is_open: bool

    @property
    def imitated(self) -> list[str]:
        """Identifiers of named effects that causes outside the library may imitate."""
        names = [effect.identifier for effect in self.effects]
        return [name for name in names if EFFECTS[name].imitated_by]


def conclude(
    evaluator: PatchEvaluator,
    nominal: Refit,
    scores: Screen,
    disagreement: Disagreement,
    selection: Selection | None,
    choice: Choice | None,
    seconds: float,
    outliers: Sequence[LocalOutlier] = (),
) -> Diagnosis:
    """Put the verdict together."""
    added, fitted, doubt = nominal, nominal, 0.0
    if choice is not None:
        added, fitted = choice.hypothesis.fit, choice.hypothesis.in_any_form
        doubt = weight_doubt(choice.hypothesis)
    singles = () if selection is None else selection.singles
    named = _name(evaluator, nominal, scores, disagreement, choice, singles)
    unknown = named.unknown
    notes = _notes(evaluator, nominal, disagreement, choice, named, outliers)
    return Diagnosis(
        verdict=disagreement.verdict,
        evidence=Evidence.CONFIRMED if evaluator.is_measured else Evidence.SUSPECTED,
        p_value=disagreement.p_value,
        effects=named.effects,
        ambiguity_set=() if choice is None or named.is_open else choice.alike,
        runner_up=None if choice is None else choice.runner_up,
        unknown_class=None if unknown is None else unknown.groups[0],
        unknown_classes=() if unknown is None else unknown.groups,
        stand_in=None if unknown is None else unknown.stand_in,
        separating_recording=_separating_recording(choice, named),
        where=where_largest(evaluator.model, nominal),
        when=time_course(evaluator.model, nominal),
        gap_mm=gap_figures(nominal, added),
        closure=named.closure,
        parameters={
            'before': parameter_table(nominal, nominal),
            'after': parameter_table(
                fitted, nominal, weight_doubt=doubt, is_known=unknown is None
            ),
        },
        times_detectable=times_detectable(scores),
        limits=upper_limits(scores),
        drawn=_drawn(nominal, scores, choice if named.effects else None),
        largest_cosine=largest_cosines(scores.scores),
        seconds=seconds,
        notes=(
            *(outlier.sentence for outlier in outliers),
            *named.doubts,
            *(EFFECTS[name].imitated_by for name in named.imitated),
            *([_of_this_cause(doubt)] if named.imitated else []),
            *(of_another_form(choice.hypothesis) if choice and named.effects else ()),
            *(spread_over_poses(choice.hypothesis) if choice and named.effects else ()),
            *_beside(choice, named.effects),
            *_class_of_all(choice if not (named.is_open or named.effects) else None),
            *notes,
        ),
        details=details_of(nominal, scores, selection, choice),
    )


def _drawn(nominal: Refit, scores: Screen, named: Choice | None) -> Drawn:
    """Return how far what hides may have drawn parameters, beside what is named or as before."""
    if named is None:
        return drawn_parameters(scores, nominal.parameters)
    return drawn_beside(named.hypothesis, scores)


def _of_this_cause(doubt: float) -> str:
    """Say what parameters are worth beside a cause that another one imitates.

    Args:
        doubt: what that may add to the weight, as a share of it; 0: what it does is not known.
    """
    if doubt == 0.0:
        return _OF_THIS_CAUSE
    return f'what looks the same may add to the weight: {doubt:.0%} of the moduli, in their errors'


def _name(
    evaluator: PatchEvaluator,
    nominal: Refit,
    scores: Screen,
    disagreement: Disagreement,
    choice: Choice | None,
    singles: Sequence[Hypothesis],
) -> _Naming:
    """Name the chosen effects, a class outside the library, or nothing."""
    doubts: tuple[str, ...] = ()
    closure = float('nan')
    if choice is not None:
        doubts = doubts_about(choice.hypothesis, nominal, singles)
        part = judged_part(nominal, is_moving=evaluator.model.is_moving)
        closure = closure_of(nominal, choice.hypothesis.fit, evaluator.is_measured, part)
    nearest = _nearest_class(evaluator, nominal, scores, disagreement, choice, closure)
    if nearest is None and choice is not None and doubts:
        is_large = disagreement.verdict is Verdict.DISAGREE
        nearest = _class_of(choice.hypothesis) if is_large else None
    is_sure = choice is not None and _tells_class(nominal, choice.hypothesis, closure)
    unknown = None
    if nearest is not None:
        # A form that is free may close anything.
        is_free = choice is not None and bool(choice.hypothesis.freed)
        closes = float('nan') if is_free else closure
        unknown = describe_unknown(evaluator, nominal, nearest, is_sure=is_sure, closes=closes)
    effects: tuple[NamedEffect, ...] = ()
    is_open = choice is None or unknown is not None or bool(doubts)
    # A name is for a disagreement: at the size of what sensor and forms are off by anyway several
    # causes look alike, whatever the log evidence says of those in the library.
    matters = disagreement.verdict is Verdict.DISAGREE
    if choice is not None and not is_open and matters:
        sure = {name: own for name, own in choice.confidences.items() if own >= _NAMED}
        effects = named_effects(choice.hypothesis, sure)
    return _Naming(doubts, closure, unknown, effects, is_open)


def _class_of(hypothesis: Hypothesis) -> str:
    """Return the class of a model that may not be named."""
    # What moves rig, clamp and body alike is where the camera is, or is said to be.
    group = hypothesis.added[0].effect.group
    return EFFECTS['camera_offset'].group if moves_with_fixture(hypothesis) else group


def _separating_recording(choice: Choice | None, named: _Naming) -> str | None:
    """Say what to record to settle a doubt, where there is one that a recording settles."""
    if choice is not None and not named.doubts and len(choice.alike) > 1:
        return what_settles(choice.alike[:3])
    return what_settles(named.imitated) if named.imitated else None


def _beside(choice: Choice | None, effects: Sequence[NamedEffect]) -> list[str]:
    """Say what else is there, where one of two effects is sure and the other one is not."""
    named = {effect.identifier for effect in effects}
    if choice is not None and named and choice.beside:
        return [
            f'{", ".join(named)} is not all that is missing: {choice.beside} came nearest beside '
            'it, and has no name'
        ]
    if choice is None or not named or named >= set(choice.hypothesis.identifiers):
        return []
    others = ', '.join(name for name in choice.alike if name not in named)
    return [
        f'{", ".join(named)} is not all that is missing: beside it is one of {others}, and '
        'parameters are those beside the first of these'
    ]


def _class_of_all(choice: Choice | None) -> list[str]:
    """Say what class it is, where the name is not sure and the class is."""
    if choice is None or len(choice.alike) < 2:
        return []
    groups = {EFFECTS[name].group for name in choice.alike}
    if len(groups) > 1:
        return []
    return [f'whichever of them it is, it is of the class {groups.pop()}']


def _nearest_class(
    evaluator: PatchEvaluator,
    nominal: Refit,
    scores: Screen,
    disagreement: Disagreement,
    choice: Choice | None,
    closure: float,
) -> str | None:
    """Return the class that comes nearest where no effect explains the gap; else None."""
    if choice is None:
        if disagreement.verdict is not Verdict.DISAGREE:
            return None
        # Whatever was refitted does nothing.
        best = next(iter(with_tangents(scores).scores), None)
        return 'load' if best is None else best.candidate.effect.group
    closed = closed_in_its_form(nominal, choice.hypothesis, closure)
    if is_unexplained(
        nominal,
        choice.hypothesis,
        closed,
        disagreement.margin,
        is_measured=evaluator.is_measured,
    ):
        return choice.hypothesis.added[0].effect.group
    return None


def _tells_class(nominal: Refit, hypothesis: Hypothesis, closure: float) -> bool:
    """Tell whether a model that may not be named tells the class of what is missing.

    It closes most of the gap: in about the library's form, whatever it is from pose to pose, with
    what that may be, and in the library's own. No material or shape is another one in each pose.
    """
    judged = hypothesis.judged
    if judged is None or hypothesis.is_at_bound:
        return False
    stays = all(own.effect.group in _STAYS for own in hypothesis.added)
    if stays and judged.by_pose > FARTHEST_FORM:
        return False
    if judged.fraction <= 0.5 * FARTHEST_FORM:
        return closed_in_its_form(nominal, hypothesis, closure) >= LEAST_CLOSURE
    return judged.fraction <= FARTHEST_FORM and closure > MOST_OF_IT


def _notes(
    evaluator: PatchEvaluator,
    nominal: Refit,
    disagreement: Disagreement,
    choice: Choice | None,
    named: _Naming,
    outliers: Sequence[LocalOutlier],
) -> tuple[str, ...]:
    notes, unknown = [], named.unknown
    left_out = len(evaluator.left_out) - sum(len(outlier.patches) for outlier in outliers)
    if left_out:
        notes.append(f'{left_out} patches show something else than the body and were left out')
    if disagreement.verdict is Verdict.BELOW_MARGIN:
        notes.append('something is there, but it is too small to matter: no name for it')
        notes.append(_FOLLOWED)
        notes += [] if named.is_open else _nearest(choice, named.closure)
    if disagreement.verdict is Verdict.CANNOT_TELL and disagreement.gap.mesh > _COARSE:
        notes.append(
            f'the mesh may be off by {1e3 * disagreement.gap.mesh:.2f} mm, more than the sensor: '
            'refine the mesh first'
        )
    elif disagreement.may_be_misstated:
        notes.append(
            f'a gap of {1e3 * disagreement.gap.rms:.2f} mm stands out from the errors that are '
            'stated of the sensor and the poses, and not from twice these: measure them, or '
            'record more poses'
        )
        notes += [] if named.is_open else _nearest(choice, named.closure)
    elif disagreement.verdict is Verdict.CANNOT_TELL:
        notes.append('the data are too few or too noisy: record more poses, or come closer')
    if unknown is not None:
        notes.append(unknown.sentence)
        notes += _nearest(choice, named.closure)
    if choice is not None and unknown is None:
        notes += _left(choice.hypothesis)
    if choice is not None and choice.hypothesis.is_at_bound:
        notes.append('an amplitude stopped at its bound')
    hidden = evaluator.without_fixture(nominal.groups)
    notes += [f'{name} does not show the fixture' for name in hidden]
    shift = float(np.linalg.norm(fixture_offset(nominal.parameters, nominal.coordinates)[:3]))
    if shift > _FIXTURE_OFF:
        notes.append(
            f'the fixture is seen {1e3 * shift:.1f} mm from where the scene states it beside the '
            'body: check the shape, and how far the body is in the clamp'
        )
    return tuple(notes)


def _left(hypothesis: Hypothesis) -> list[str]:
    """Say how much a model leaves, and what of that its form may be."""
    left = patch_gap(hypothesis.fit.groups, Part.REPORT)
    if left.rms <= FAR_ABOVE * left.whole_floor:
        return []
    judged = hypothesis.judged
    if judged is not None and judged.left <= FAR_ABOVE * left.whole_floor:
        shares = {'in itself': judged.fraction, 'from pose to pose': judged.by_pose}
        own = [f'{share:.0%} {words}' for words, share in shares.items() if share >= _TOLD]
        words = f', as where it is another one by {" and ".join(own)}' if own else ''
        return [f'{1e3 * left.rms:.2f} mm are still left in the form that the library has{words}']
    return [f'{1e3 * left.rms:.2f} mm are still left: this is not all that is missing']


def _nearest(choice: Choice | None, closure: float) -> list[str]:
    """Say what comes nearest where nothing explains the gap."""
    if choice is None:
        return []
    best = choice.hypothesis.identifiers
    words = f'nearest comes {" with ".join(best)}'
    if np.isfinite(closure):
        words += f': it closes {max(closure, 0.0):.0%} of the gap on held-out patches'
    others = [name for name in choice.alike if name not in best]
    if others:
        words += f'; about as near: {", ".join(others[:_MOST_NEAR])}'
    return [words]
