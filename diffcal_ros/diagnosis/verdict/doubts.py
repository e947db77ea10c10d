# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What keeps the model that came nearest from having its name."""

from collections.abc import Sequence

from diffcal_ros.diagnosis.detection.disagreement import ALPHA
from diffcal_ros.diagnosis.model_comparison.absence import (
    differing_by_pose,
    has_doubtful_effect,
    has_nothing_in_common,
    spread_of_amount,
)
from diffcal_ros.diagnosis.model_comparison.hypothesis import (
    FARTHEST_FORM,
    Hypothesis,
    LEAST_LEANING,
)
from diffcal_ros.diagnosis.model_comparison.second_effect import PAIR_GAIN
from diffcal_ros.diagnosis.patch_fits.held_out_frames import gap_frame_by_frame
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patch_fits.strain import unstrained
from diffcal_ros.diagnosis.patches.patch_gap import patch_gap
from diffcal_ros.diagnosis.patches.smooth_sizes import with_larger_error
from diffcal_ros.diagnosis.patches.whitened import Part
from diffcal_ros.diagnosis.verdict.field_witness import FieldWitness
from diffcal_ros.diagnosis.verdict.moved_together import class_with_fixture, words_with_fixture
from diffcal_ros.diagnosis.verdict.unknown import FAR_ABOVE, LEAST_CLOSURE, POOR
from diffcal_ros.diagnosis.verdict.verdict_figures import (
    closed_by,
    closed_in_its_form,
    judged_part,
)
import numpy as np

# What a second effect must add to the log evidence, a further form of a free one must, too.
_MORE = PAIR_GAIN
# What closes more of the gap in the library's form tells the class, if not the name.
MOST_OF_IT = 0.5
# What closes so much of the gap on patches that no fit has seen leaves next to nothing there.
NEARLY_ALL = 0.95


def doubts_about(
    hypothesis: Hypothesis,
    nominal: Refit,
    singles: Sequence[Hypothesis] = (),
    witness: FieldWitness | None = None,
) -> tuple[str, ...]:
    """Say why a model may not be named, however much likelier than others it is.

    A name is for a gap that is there, on patches that no fit has seen, and most of which it
    closes; no model does as well without it.

    Args:
        hypothesis: the model.
        nominal: fit of the model without its effects.
        singles: models with one effect each, best first.
        witness: who may speak for a form that is far off; None: nobody does.
    """
    closures = _closures(hypothesis, nominal)
    reason = (
        _of_amplitudes(hypothesis, nominal, singles)
        or _of_the_gap(hypothesis, nominal, closures)
        or _of_freedom(hypothesis, closures[0], witness)
        or _of_what_is_left(hypothesis, nominal, closures)
    )
    if reason is None:
        return ()
    return (f'{" with ".join(hypothesis.identifiers)} came nearest, {reason}: no name for it',)


def _of_amplitudes(
    hypothesis: Hypothesis, nominal: Refit, singles: Sequence[Hypothesis]
) -> str | None:
    """Say which amplitudes may be none, or another cause's."""
    if has_doubtful_effect(hypothesis, nominal, singles):
        return 'with an amplitude that may be zero'
    if class_with_fixture(hypothesis) is not None:
        return (
            f'but the fixture is displaced as the clamp is, by {words_with_fixture(hypothesis)}: '
            'rig or camera is elsewhere than the scene says, and not the body in its clamp; check '
            'where the marker is on the rig'
        )
    return None


def _of_the_gap(
    hypothesis: Hypothesis, nominal: Refit, closures: tuple[float, float]
) -> str | None:
    """Say whether there is none to close, or none was closed."""
    part, where = _judged_where(hypothesis, nominal)
    # An effect may hide in a parameter that strains what is known of it.
    before = patch_gap(unstrained(nominal), part)
    after = gap_frame_by_frame(hypothesis.fit, part)
    if before.rms <= before.whole_floor:
        return (
            f'but {where} the gap is within the floors '
            f'({1e3 * before.rms:.2f} of {1e3 * before.whole_floor:.2f} mm)'
        )
    _, closed = closures
    if not (closed > 0.0 or after.rms < before.rms or after.most < before.most):
        return f'but leaves as much {where}'
    return None


def _of_freedom(
    hypothesis: Hypothesis, closure: float, witness: FieldWitness | None
) -> str | None:
    """Say by what freedom a model follows more than what it is, where nothing speaks for it.

    Of what is another one in each pose its class is all that fields tell.
    """
    reason = freedom_of(hypothesis)
    if reason is not None and not is_spoken_for(hypothesis, closure, witness):
        return reason
    imitated = _imitated_over_time(hypothesis)
    if imitated is not None:
        return imitated
    differs = _differs_by_pose(hypothesis)
    if differs is not None:
        return f'with {differs}'
    fraction = off_in_form(hypothesis) if reason is None else 0.0
    if _is_another_by_pose(hypothesis, fraction):
        return 'in a form that is another one in each pose'
    return None


def is_spoken_for(hypothesis: Hypothesis, closure: float, witness: FieldWitness | None) -> bool:
    """Tell whether two witnesses who know nothing of one another speak for a form that is far off.

    Patches that no fit has seen, where as it is fitted it leaves next to no gap, and smooth fields
    of its class, which predict each pose best by the others. What forms may explain besides, by
    tangents, says nothing. Fields are of one class: of two effects the other one may be anything,
    so that a free form is forgiven no more than another one.
    """
    if witness is None or not closure >= NEARLY_ALL:
        return False
    count = len(hypothesis.added)
    is_far = hypothesis.is_free_in_everything or off_in_form(hypothesis) > FARTHEST_FORM / count
    return not (count > 1 and is_far) and witness.speaks_for(hypothesis)


def _imitated_over_time(hypothesis: Hypothesis) -> str | None:
    """Say what else may be another one in the course of a recording as an effect is."""
    own = {one.effect for one in hypothesis.freed if one.knot is not None}
    for added in hypothesis.added:
        words = added.effect.imitated_over_time
        if words and added.identifier in own:
            return f'as another one in the course of the recording, which {words} may be as well'
    return None


def freedom_of(hypothesis: Hypothesis) -> str | None:
    """Say by what freedom a model follows more than what the library says of it."""
    if hypothesis.is_free_in_everything:
        # Of seven names that were given so two were right, both beside another effect: a lens and
        # a place of its own in each pose follow what contact, a mass or a bend does, too.
        return 'in another form and as another one in each pose, which may be anything'
    if hypothesis.is_free_in_time and hypothesis.fit.chi_square_per_patch > POOR:
        return 'as another one in the course of the recording, and leaves more than noise'
    fraction = off_in_form(hypothesis)
    if fraction > _farthest_form(hypothesis):
        return f'in a form that is off by {fraction:.0%} of what it does'
    return None


def _of_what_is_left(
    hypothesis: Hypothesis, nominal: Refit, closures: tuple[float, float]
) -> str | None:
    """Say whether most of what is missing is something else."""
    _, where = _judged_where(hypothesis, nominal)
    library, closed = closures
    if closed < LEAST_CLOSURE:
        # Whatever it follows on the patches that were fitted, most of what is missing is not it.
        return f'but closes {closed:.0%} of the gap {where}'
    if hypothesis.is_free_in_time and closed < NEARLY_ALL:
        # What may be anything at any time follows much that it is not.
        return (
            f'as another one in the course of the recording, and closes {closed:.0%} of the gap '
            f'{where}'
        )
    if len(hypothesis.added) > 1 and _leaves_more(hypothesis):
        return 'but this is not all that is missing'
    # Two effects close much by what each may be besides.
    least = MOST_OF_IT if len(hypothesis.added) == 1 else LEAST_CLOSURE
    if hypothesis.judged is not None and library < least:
        return f'but in the form that the library has closes {library:.0%} of the gap {where}'
    return None


def _judged_where(hypothesis: Hypothesis, nominal: Refit) -> tuple[Part, str]:
    """Return the patches by which a model is judged, and how they are called."""
    part = judged_part(nominal, is_moving=hypothesis.evaluator.model.is_moving)
    return part, 'on held-out patches' if part is Part.REPORT else 'on all patches'


def _closures(hypothesis: Hypothesis, nominal: Refit) -> tuple[float, float]:
    """Return what a model closes in the library's form, and in the form that the data favour."""
    library = closed_by(nominal, hypothesis)
    return library, closed_in_its_form(nominal, hypothesis, library)


def _leaves_more(hypothesis: Hypothesis) -> bool:
    """Tell whether even the likeliest form leaves much more than the floors.

    Those of the sensor beside it: where noise alone is left on what was fitted, that tells how
    large its smooth error is. What leaves more would make one of whatever is missing.
    """
    if hypothesis.judged is None:
        return False
    larger = hypothesis.larger if hypothesis.leaves_noise else 1.0
    groups = with_larger_error(hypothesis.fit.groups, hypothesis.evaluator.noises, larger)
    floor = patch_gap(groups, Part.REPORT).whole_floor
    return hypothesis.judged.left > FAR_ABOVE * floor


def off_in_form(hypothesis: Hypothesis) -> float:
    """Return by what share effects are off from the library's form, as far as data ask for that.

    They do not where that form leaves noise, or where next to nothing is owed to other forms and
    little is left. What is in a form of its own has been fitted in as many ways as are known:
    little that yet another one explains is much.
    """
    judged = hypothesis.judged
    if judged is None:
        return 0.0
    asks = hypothesis.leaning >= (_MORE if hypothesis.is_free_in_form else LEAST_LEANING)
    if hypothesis.fit.chance_of_noise >= ALPHA:
        # As another one in each pose much leaves noise that is not it.
        asks &= any(part.posture is not None for part in hypothesis.freed)
    else:
        left = patch_gap(hypothesis.fit.groups, Part.REPORT)
        asks |= left.rms > FAR_ABOVE * left.whole_floor
    return judged.fraction if asks else 0.0


def _farthest_form(hypothesis: Hypothesis) -> float:
    """Return what share forms may be off by for a name.

    Of two effects either of which may be far off nothing is known. What is of a free form already,
    and asks for another one yet, is hardly it.
    """
    if hypothesis.fit.chance_of_noise >= ALPHA:
        return FARTHEST_FORM
    return FARTHEST_FORM / (len(hypothesis.added) * (2 if hypothesis.is_free_in_form else 1))


def _is_another_by_pose(hypothesis: Hypothesis, fraction: float) -> bool:
    """Tell whether a model is by too much another one in each pose, or in itself and in each.

    What is moved, clamped anew or warms up may be.

    Args:
        hypothesis: the model.
        fraction: by what share its effects are off in themselves.
    """
    judged = hypothesis.judged
    if judged is None or hypothesis.fit.chance_of_noise >= ALPHA:
        return False
    is_moved = len(hypothesis.added) == 1 and hypothesis.added[0].effect.most_by_pose >= 1.0
    return not is_moved and bool(np.hypot(fraction, judged.by_pose) > FARTHEST_FORM)


def _differs_by_pose(hypothesis: Hypothesis) -> str | None:
    """Say what was fitted as another one in each pose, and cannot be so by as much."""
    differing = differing_by_pose(hypothesis)
    if differing is None:
        return None
    article = 'an' if differing.identifier[0] in 'aeiou' else 'a'
    words = f'{article} {differing.identifier} that is another one in each pose'
    if has_nothing_in_common(hypothesis, differing):
        return f'{words}, and may be none in all'
    return f'{words} by {spread_of_amount(hypothesis, differing):.0%}'
