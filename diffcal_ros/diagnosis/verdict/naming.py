# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a chosen model is called: by its effects, by a class, or not at all."""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.detection.disagreement import Disagreement
from diffcal_ros.diagnosis.model_comparison.choice import Choice
from diffcal_ros.diagnosis.model_comparison.hypothesis import FARTHEST_FORM, Hypothesis
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.screening.screening import Screen
from diffcal_ros.diagnosis.screening.shortlist import with_tangents
from diffcal_ros.diagnosis.verdict.doubts import doubts_about, MOST_OF_IT
from diffcal_ros.diagnosis.verdict.field_witness import FieldWitness
from diffcal_ros.diagnosis.verdict.moved_together import class_with_fixture
from diffcal_ros.diagnosis.verdict.unknown import (
    describe_unknown,
    is_unexplained,
    LEAST_CLOSURE,
    Unknown,
)
from diffcal_ros.diagnosis.verdict.verdict import NamedEffect
from diffcal_ros.diagnosis.verdict.verdict_figures import (
    closed_by,
    closed_in_its_form,
    named_effects,
)
from diffcal_ros.effects.registry import EFFECTS

# An effect is named by itself from this confidence on.
_NAMED = 0.6
# Classes that are the same in all poses, whatever their form.
_STAYS = ('material', 'shape')


@dataclass(frozen=True)
class Naming:
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


def find_name(
    evaluator: PatchEvaluator,
    nominal: Refit,
    scores: Screen,
    disagreement: Disagreement,
    choice: Choice | None,
    singles: Sequence[Hypothesis],
    witness: FieldWitness,
) -> Naming:
    """Name the chosen effects, a class outside the library, or nothing."""
    doubts: tuple[str, ...] = ()
    closure = float('nan')
    if choice is not None:
        doubts = doubts_about(choice.hypothesis, nominal, singles, witness)
        closure = closed_by(nominal, choice.hypothesis)
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
        unknown = describe_unknown(witness, nearest, is_sure=is_sure, closes=closes)
    effects: tuple[NamedEffect, ...] = ()
    is_open = choice is None or unknown is not None or bool(doubts)
    # A name is for a disagreement: at the size of what sensor and forms are off by anyway several
    # causes look alike, whatever the log evidence says of those in the library.
    matters = disagreement.verdict is Verdict.DISAGREE
    if choice is not None and not is_open and matters:
        sure = {name: own for name, own in choice.confidences.items() if own >= _NAMED}
        effects = named_effects(choice.hypothesis, sure)
    return Naming(doubts, closure, unknown, effects, is_open)


def _class_of(hypothesis: Hypothesis) -> str:
    """Return the class of a model that may not be named."""
    # What moves rig, clamp and body alike is where the camera is, or is said to be.
    return class_with_fixture(hypothesis) or hypothesis.added[0].effect.group


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
