# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What keeps the model that came nearest from having its name."""

from collections.abc import Sequence

from diffcal_ros.diagnosis.detection.disagreement import ALPHA
from diffcal_ros.diagnosis.model_comparison.absence import (
    has_doubtful_effect,
    has_nothing_in_common,
    spread_of_amount,
)
from diffcal_ros.diagnosis.model_comparison.hypothesis import (
    FARTHEST_FORM,
    Hypothesis,
    LEAST_LEANING,
)
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patch_fits.strain import unstrained
from diffcal_ros.diagnosis.patches.whitened import Part, patch_gap
from diffcal_ros.diagnosis.verdict.moved_together import class_with_fixture
from diffcal_ros.diagnosis.verdict.unknown import FAR_ABOVE, LEAST_CLOSURE
from diffcal_ros.diagnosis.verdict.verdict_figures import (
    closed_in_its_form,
    closure_of,
    judged_part,
)
import numpy as np

# What closes more of the gap in the library's form tells the class, if not the name.
MOST_OF_IT = 0.5


def doubts_about(
    hypothesis: Hypothesis, nominal: Refit, singles: Sequence[Hypothesis] = ()
) -> tuple[str, ...]:
    """Say why a model may not be named, however much likelier than others it is.

    A name is for a gap that is there, on patches that no fit has seen, and most of which it
    closes; no model does as well without it.

    Args:
        hypothesis: the model.
        nominal: fit of the model without its effects.
        singles: models with one effect each, best first.
    """
    words = ' with '.join(hypothesis.identifiers)
    if has_doubtful_effect(hypothesis, nominal, singles):
        return (f'{words} came nearest, with an amplitude that may be zero: no name for it',)
    if class_with_fixture(hypothesis) is not None:
        return (
            f'{words} came nearest, but the fixture is displaced as the clamp is: rig or camera '
            'is elsewhere than the scene says, and not the body in its clamp: no name for it',
        )
    # An effect may hide in a parameter that strains what is known of it.
    evaluator = hypothesis.evaluator
    part = judged_part(nominal, is_moving=evaluator.model.is_moving)
    where = 'on held-out patches' if part is Part.REPORT else 'on all patches'
    before = patch_gap(unstrained(nominal), part)
    after = patch_gap(hypothesis.fit.groups, part)
    if before.rms <= before.whole_floor:
        return (
            f'{words} came nearest, but {where} the gap is within the floors '
            f'({1e3 * before.rms:.2f} of {1e3 * before.whole_floor:.2f} mm): no name for it',
        )
    library = closure_of(nominal, hypothesis.fit, evaluator.is_measured, part)
    closed = closed_in_its_form(nominal, hypothesis, library)
    if not (closed > 0.0 or after.rms < before.rms or after.most < before.most):
        return (f'{words} came nearest, but leaves as much {where}: no name for it',)
    if hypothesis.is_free_in_everything:
        # Of seven names that were given so two were right, both beside another effect: a lens and
        # a place of its own in each pose follow what contact, a mass or a bend does, too.
        return (
            f'{words} came nearest, in another form and as another one in each pose, which may be '
            'anything: no name for it',
        )
    differs = _differs_by_pose(hypothesis)
    if differs is not None:
        return (f'{words} came nearest, with a {differs}: no name for it',)
    off = _off_in_form(hypothesis)
    if off is not None:
        return (f'{words} came nearest, in a form that is {off}: no name for it',)
    if closed < LEAST_CLOSURE:
        # Whatever it follows on the patches that were fitted, most of what is missing is not it.
        return (
            f'{words} came nearest, but closes {closed:.0%} of the gap {where}: no name for it',
        )
    if len(hypothesis.added) > 1 and _leaves_more(hypothesis):
        return (f'{words} came nearest, but this is not all that is missing: no name for it',)
    # Two effects close much by what each may be besides.
    least = MOST_OF_IT if len(hypothesis.added) == 1 else LEAST_CLOSURE
    if hypothesis.judged is not None and library < least:
        return (
            f'{words} came nearest, but in the form that the library has closes {library:.0%} of '
            f'the gap {where}: no name for it',
        )
    return ()


def _leaves_more(hypothesis: Hypothesis) -> bool:
    """Tell whether even the likeliest form leaves much more than the floors."""
    floor = patch_gap(hypothesis.fit.groups, Part.REPORT).whole_floor
    return hypothesis.judged is not None and hypothesis.judged.left > FAR_ABOVE * floor


def _off_in_form(hypothesis: Hypothesis) -> str | None:
    """Say by how much effects are off from the library's form, where that is too much for a name.

    It is not where that form leaves noise, or owes other forms next to nothing and leaves little.
    What is moved, clamped anew or warms up may be another one in each pose. Of two effects either
    of which may be far off nothing is known.
    """
    judged = hypothesis.judged
    if judged is None:
        return None
    if hypothesis.fit.chance_of_noise >= ALPHA:
        # As another one in each pose much leaves noise that is not it.
        is_set_anew = any(part.posture is not None for part in hypothesis.freed)
        asks = is_set_anew and hypothesis.leaning >= LEAST_LEANING
        is_far = asks and judged.fraction > FARTHEST_FORM
        return f'off by {judged.fraction:.0%} of what it does' if is_far else None
    left = patch_gap(hypothesis.fit.groups, Part.REPORT)
    asks_for_it = hypothesis.leaning >= LEAST_LEANING or left.rms > FAR_ABOVE * left.whole_floor
    fraction = judged.fraction if asks_for_it else 0.0
    # What is of a free form already, and asks for another one yet, is hardly it.
    is_free = any(part.posture is None for part in hypothesis.freed)
    if fraction > FARTHEST_FORM / (len(hypothesis.added) * (2 if is_free else 1)):
        return f'off by {fraction:.0%} of what it does'
    is_moved = len(hypothesis.added) == 1 and hypothesis.added[0].effect.most_by_pose >= 1.0
    if not is_moved and np.hypot(fraction, judged.by_pose) > FARTHEST_FORM:
        return 'another one in each pose'
    return None


def _differs_by_pose(hypothesis: Hypothesis) -> str | None:
    """Say what was fitted as another one in each pose, and cannot be so by as much."""
    for added in hypothesis.added:
        words = f'{added.identifier} that is another one in each pose'
        if has_nothing_in_common(hypothesis, added):
            return f'{words}, and may be none in all'
        spread = spread_of_amount(hypothesis, added)
        if spread > FARTHEST_FORM:
            return f'{words} by {spread:.0%}'
    return None
