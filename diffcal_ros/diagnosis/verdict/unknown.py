# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is said where no effect of the library explains a gap: a class, and a field for it."""

from dataclasses import dataclass

from diffcal_ros.diagnosis.detection.disagreement import ALPHA
from diffcal_ros.diagnosis.model_comparison.hypothesis import FARTHEST_FORM, Hypothesis
from diffcal_ros.diagnosis.patch_fits.held_out_frames import gap_frame_by_frame
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patch_fits.strain import unstrained
from diffcal_ros.diagnosis.patches.patch_gap import patch_gap
from diffcal_ros.diagnosis.patches.whitened import Part
from diffcal_ros.diagnosis.verdict.field_witness import FieldWitness
from diffcal_ros.diagnosis.verdict.frame_test import ClassScore
from diffcal_ros.diagnosis.verdict.verdict import StandIn
import numpy as np

# A model that leaves more chi-square per patch, and a gap of so many floors, is not it.
POOR = 2.0
FAR_ABOVE = 1.7
# One that closes less of the gap, or where the floor was measured of chi-square, is not it.
LEAST_CLOSURE = 0.7
# Fields that close less of it know little of the cause, whichever predict poses best: of ten such
# in six sets none was of its class, and the effect that came nearest was in four.
_KNOWS = 0.25
# Where the fields of a class stay the same from pose to pose.
_FRAMES = {
    'sensor': 'the frame of the camera',
    'load': 'the frame of the world',
    'boundary': 'how the clamp holds the body',
    'shape': 'the frame of the body, whatever its load',
    'material': 'the stiffness of the body',
}


@dataclass(frozen=True)
class Unknown:
    """An effect outside the library.

    Attributes:
        groups: classes that it is most like, the likelier first: one where the effect that comes
            nearest and smooth fields tell the same.
        stand_in: smooth fields of that class in its place; None with a single view, where the
            class is that of the library's effect which leaves least when refitted.
    """

    groups: tuple[str, ...]
    stand_in: StandIn | None

    @property
    def sentence(self) -> str:
        """Say so to a person."""
        words = 'no effect of the library explains the gap; it is most like one of the class '
        words += ' or '.join(self.groups)
        if self.stand_in is None or not np.isfinite(self.stand_in.closes):
            return words
        return (
            f'{words}: smooth fields that are fixed to {self.stand_in.frame} would close '
            f'{max(self.stand_in.closes, 0.0):.0%} of it (a stand-in, not a cause)'
        )


def is_unexplained(
    nominal: Refit, added: Hypothesis, closure: float, margin: float, *, is_measured: bool
) -> bool:
    """Tell whether so much is left that the model cannot be it.

    Where the sensor floor was measured, what is left must look like noise, on patches that no fit
    has seen, too, or like an effect whose form is a little off. Where the floor is a guess, only a
    gap that stays open counts.

    Args:
        nominal: fit of the model as it is.
        added: the model with effects.
        closure: share of the gap that it closes.
        margin: an excess over the floors that does not matter [m].
        is_measured: whether the sensor floor was.
    """
    if not is_measured:
        return not closure >= LEAST_CLOSURE
    gap = gap_frame_by_frame(added.fit)
    judged, left = added.judged, gap.rms
    if judged is not None and judged.fraction <= FARTHEST_FORM:
        # In a form that may have its name.
        left = min(left, judged.left)
    is_far_above = left > FAR_ABOVE * gap.whole_floor
    owes_it_to_forms = added.fit.chance_of_noise < ALPHA
    if owes_it_to_forms and is_far_above and left**2 > gap.whole_floor**2 + margin**2:
        # What is missing beside it matters, too, and no form of it is that.
        return True
    if is_far_above and closure < LEAST_CLOSURE:
        # It follows the patches that were fitted, and does not predict the others.
        return True
    if added.chance_of_noise >= ALPHA:
        return False
    before = patch_gap(unstrained(nominal), Part.REPORT).rms
    if before > FAR_ABOVE * gap.whole_floor >= FAR_ABOVE * left and closure >= LEAST_CLOSURE:
        # A clear gap is gone where no fit has seen it: what a form that is a little off leaves on
        # the other patches is no other cause.
        return False
    excess = nominal.chi_square_per_patch - 1.0
    fraction = (nominal.chi_square_per_patch - added.chi_square_per_patch) / excess
    if not fraction >= LEAST_CLOSURE:
        return True
    return added.chi_square_per_patch > POOR and is_far_above


def describe_unknown(
    witness: FieldWitness,
    nearest: str,
    *,
    is_sure: bool = False,
    closes: float = float('nan'),
) -> Unknown:
    """Tell what class an effect outside the library is most like.

    That of the library's effect which comes nearest, or of the fields that predict poses best:
    whichever closes more on patches that no fit has seen comes first, and fields that close hardly
    anything second. Fields know small motions only. Where both tell the same they were right in
    10 of 11 cases of development; where they differ it was one of the two in 7 of 9.

    Args:
        witness: smooth fields of all classes.
        nearest: class of the library's effect that comes nearest.
        is_sure: whether that tells the class, whatever fields close.
        closes: share of the held-out gap that it closes; NaN: not to be told by that.
    """
    tested = witness.scores
    if not tested:
        return Unknown((nearest,), None)
    best, own = tested[0], next((score for score in tested if score.group == nearest), tested[0])
    if is_sure:
        return Unknown((own.group,), _stand_in(own, tested))
    is_first = closes >= best.closes or best.closes < _KNOWS
    first, second = (own, best) if is_first else (best, own)
    groups = tuple(dict.fromkeys((first.group, second.group)))
    return Unknown(groups, _stand_in(first, tested))


def _stand_in(best: ClassScore, tested: tuple[ClassScore, ...]) -> StandIn:
    return StandIn(
        group=best.group,
        frame=_FRAMES[best.group],
        size_mm=best.size,
        closes=best.closes,
        predictions={score.group: score.prediction for score in tested},
    )
