# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a verdict says besides its name."""

from collections.abc import Sequence

from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.detection.disagreement import Disagreement
from diffcal_ros.diagnosis.detection.local_outlier import LocalOutlier
from diffcal_ros.diagnosis.model_comparison.choice import Choice
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.patch_fits.held_out_frames import gap_frame_by_frame
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.patches.rigid_reference import fixture_offset
from diffcal_ros.diagnosis.verdict.doubts import freedom_of
from diffcal_ros.diagnosis.verdict.effect_course import spread_over_time
from diffcal_ros.diagnosis.verdict.naming import Naming
from diffcal_ros.diagnosis.verdict.unknown import FAR_ABOVE
from diffcal_ros.diagnosis.verdict.verdict import NamedEffect
from diffcal_ros.diagnosis.verdict.verdict_figures import (
    of_another_form,
    spread_over_poses,
    weight_doubt,
)
from diffcal_ros.effects.registry import EFFECTS
import numpy as np

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
_TOO_SMALL = 'something is there, but it is too small to matter: no name for it'
_FOLLOWED = (
    'it is small beside the parameters as they are: they may have followed it, by more than their '
    'errors'
)
# Of what comes about as near as the nearest.
_MOST_NEAR = 3


def notes_of(
    evaluator: PatchEvaluator,
    nominal: Refit,
    disagreement: Disagreement,
    choice: Choice | None,
    named: Naming,
    outliers: Sequence[LocalOutlier],
) -> tuple[str, ...]:
    """Return all notes of a verdict.

    Args:
        evaluator: of the nominal model.
        nominal: its fit.
        disagreement: whether there is one.
        choice: the favoured model; None where nothing was refitted.
        named: what it is called.
        outliers: places that were left out.
    """
    doubt = 0.0 if choice is None else weight_doubt(choice.hypothesis)
    nearest = _nearest(choice, named.closure)
    return (
        *(outlier.sentence for outlier in outliers),
        *named.doubts,
        *_of_form_in_doubt(disagreement, choice, named),
        *(EFFECTS[name].imitated_by for name in named.imitated),
        *([_of_this_cause(doubt)] if named.imitated else []),
        *(of_another_form(choice.hypothesis) if choice and named.effects else ()),
        *(_in_spite_of_form(choice.hypothesis) if choice and named.effects else ()),
        *(spread_over_poses(choice.hypothesis) if choice and named.effects else ()),
        *(spread_over_time(choice.hypothesis) if choice and named.effects else ()),
        *_beside(choice, named.effects),
        *_class_of_all(choice if not (named.is_open or named.effects) else None),
        *_left_out(evaluator, outliers),
        *_of_size(disagreement, [] if named.is_open else nearest),
        *_of_model(choice, named, nearest),
        *_of_fixture(evaluator, nominal),
    )


def _of_this_cause(doubt: float) -> str:
    """Say what parameters are worth beside a cause that another one imitates.

    Args:
        doubt: what that may add to the weight, as a share of it; 0: what it does is not known.
    """
    if doubt == 0.0:
        return _OF_THIS_CAUSE
    return f'what looks the same may add to the weight: {doubt:.0%} of the moduli, in their errors'


def _of_form_in_doubt(
    disagreement: Disagreement, choice: Choice | None, named: Naming
) -> list[str]:
    """Say why what may be named has no name, or no surer one."""
    matters = disagreement.verdict is Verdict.DISAGREE
    if choice is None or named.is_open or not matters:
        return []
    return [choice.unsure] if choice.unsure else []


def _in_spite_of_form(hypothesis: Hypothesis) -> list[str]:
    """Say why a model has its name that is free to follow more than the library says of it."""
    freedom = freedom_of(hypothesis)
    if freedom is None:
        return []
    names = ' and '.join(hypothesis.identifiers)
    return [
        f'{names} is there {freedom}: it has its name because it leaves next to no gap on '
        'patches that no fit has seen, and smooth fields that know nothing of it tell the same '
        'class'
    ]


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


def _left_out(evaluator: PatchEvaluator, outliers: Sequence[LocalOutlier]) -> list[str]:
    """Say how many patches show something else, beside those of places that are told."""
    count = len(evaluator.left_out) - sum(len(outlier.patches) for outlier in outliers)
    words = 'patches show something else than the body and were left out'
    return [f'{count} {words}'] if count else []


def _of_size(disagreement: Disagreement, nearest: Sequence[str]) -> list[str]:
    """Say what a gap is worth that is small, or not told from what is stated.

    Args:
        disagreement: with that gap.
        nearest: what comes nearest, where nothing keeps it from being told.
    """
    notes: list[str] = []
    if disagreement.verdict is Verdict.BELOW_MARGIN:
        notes += [_TOO_SMALL, _FOLLOWED, *nearest]
    if disagreement.verdict is Verdict.CANNOT_TELL and disagreement.gap.mesh > _COARSE:
        notes.append(
            f'the mesh may be off by {1e3 * disagreement.gap.mesh:.2f} mm, more than the sensor: '
            'refine the mesh first'
        )
    elif disagreement.may_be_misstated:
        notes.append(
            f'a gap of {1e3 * disagreement.gap.rms:.2f} mm stands out from the errors that are '
            'stated of the sensor and the poses, and not from twice these: measure them (what a '
            'flat target shows is sensor.smooth_error in the scene), or record more poses'
        )
        notes += nearest
    elif disagreement.verdict is Verdict.CANNOT_TELL:
        notes.append(_too_noisy(disagreement))
    return notes


def _too_noisy(disagreement: Disagreement) -> str:
    """Say why the data cannot tell."""
    floor, margin = disagreement.gap.whole_floor, disagreement.margin
    if floor > margin:
        return (
            f'the sensor may be off by {1e3 * floor:.2f} mm, more than the {1e3 * margin:.2f} mm '
            'that are to matter: come closer, or ask for larger gaps (--margin)'
        )
    return 'the data are too few: record more poses'


def _of_model(choice: Choice | None, named: Naming, nearest: Sequence[str]) -> list[str]:
    """Say what a model is like that has no name, or leaves something."""
    notes: list[str] = []
    if named.unknown is not None:
        notes += [named.unknown.sentence, *nearest]
    elif choice is not None:
        notes += _left(choice.hypothesis)
    if choice is not None and choice.hypothesis.is_at_bound:
        notes.append('an amplitude stopped at its bound')
    return notes


def _of_fixture(evaluator: PatchEvaluator, nominal: Refit) -> list[str]:
    """Say where the fixture is not seen, and where it is seen elsewhere."""
    hidden = evaluator.without_fixture(nominal.groups)
    notes = [f'{name} does not show the fixture' for name in hidden]
    shift = float(np.linalg.norm(fixture_offset(nominal.parameters, nominal.coordinates)[:3]))
    if shift > _FIXTURE_OFF:
        notes.append(
            f'the fixture is seen {1e3 * shift:.1f} mm from where the scene states it beside the '
            'body: check the shape, and how far the body is in the clamp'
        )
    return notes


def _left(hypothesis: Hypothesis) -> list[str]:
    """Say how much a model leaves, and what of that its form may be."""
    left = gap_frame_by_frame(hypothesis.fit)
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
