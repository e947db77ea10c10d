# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Is there a disagreement, and does it matter?"""

from dataclasses import dataclass, replace

from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.detection.null_distribution import chances_of_clean
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patch_fits.strain import unstrained
from diffcal_ros.diagnosis.patches.patch_gap import patch_gap, PatchGap
from diffcal_ros.diagnosis.patches.whitened import Part
from diffcal_ros.diagnosis.screening.screening import Screen
import numpy as np

ALPHA = 0.003
# Where floors hide what would matter a gap must stand out from them so many times, unless it is a
# sensor's that was measured: from twice its errors, then, as every gap must.
_FAR_ABOVE = 3.0
# In a motion, mesh and time step err a little in many ways: less than this share of the floors
# is that.
_LEAST_EXCESS = 0.5
# How far a sensor's smooth error, or the error of a pose, is from what is stated of it: where
# these may be all of a gap, it is none of the model's.
_MISSTATED = 2.0
# Fewer patches say nothing.
_LEAST_PATCHES = 12


@dataclass(frozen=True)
class Disagreement:
    """How the nominal model fares.

    Attributes:
        verdict: in one word.
        p_value: chance that clean data look as bad, over all candidates.
        gap: on all patches, with no parameter farther from what is known of it than its prior
            allows.
        excess: root mean square of the gap above the floors [m].
        margin: an excess that does not matter [m].
        may_be_misstated: whether a gap that would matter may come of errors twice as large as
            those that are stated of sensor and poses.
    """

    verdict: Verdict
    p_value: float
    gap: PatchGap
    excess: float
    margin: float
    may_be_misstated: bool = False

    @property
    def is_worth_naming(self) -> bool:
        """Tell whether to look for a name: what hides in a parameter leaves a small gap.

        And what may be misstated may be an effect: what comes nearest is told.
        """
        is_there = self.verdict in (Verdict.DISAGREE, Verdict.BELOW_MARGIN)
        return is_there or self.may_be_misstated

    @property
    def error_factor(self) -> float:
        """By how much errors of parameters are larger than those of sensor and poses say."""
        return _MISSTATED if self.may_be_misstated else 1.0

    @property
    def may_matter(self) -> bool:
        """Tell whether the gap is larger than what does not matter, floors included.

        Beside no model is what is smaller a disagreement, see `beside_a_model`.
        """
        return self.gap.rms > self.margin


def measure_disagreement(
    nominal: Refit,
    screen: Screen,
    margin: float,
    *,
    is_moving: bool = False,
    is_measured: bool = True,
) -> Disagreement:
    """Judge the nominal fit.

    Three questions, as a verdict must answer all: could clean data look like that, is it large
    enough to matter, and could it come of errors of sensor and poses that are misstated by two?

    Args:
        nominal: the fit.
        screen: scores around it.
        margin: an excess that does not matter [m].
        is_moving: whether a motion is among the recordings.
        is_measured: whether the sensor's floor was measured, and not guessed.
    """
    gap = patch_gap(unstrained(nominal), Part.ALL)
    excess = float(np.sqrt(max(gap.rms**2 - gap.floor**2 - gap.mesh**2, 0.0)))
    p_value, doubted = chances_of_clean(nominal, screen, (1.0, _MISSTATED))
    floor = gap.whole_floor
    if gap.count < _LEAST_PATCHES or floor > margin:
        # Too little, or too noisy, to see what would matter.
        is_told = is_measured and not is_moving and gap.count >= _LEAST_PATCHES
        unsure = gap.mesh if is_told and doubted < ALPHA else floor
        is_clear = p_value < ALPHA and excess > max(margin, _FAR_ABOVE * unsure)
        verdict = Verdict.DISAGREE if is_clear else Verdict.CANNOT_TELL
    elif p_value >= ALPHA or (is_moving and excess < _LEAST_EXCESS * floor):
        verdict = Verdict.AGREE
    else:
        verdict = Verdict.DISAGREE if excess > margin else Verdict.BELOW_MARGIN
    found = Disagreement(verdict, p_value, gap, excess, margin)
    if verdict is not Verdict.DISAGREE or is_moving or doubted < ALPHA:
        return found
    return replace(found, verdict=Verdict.CANNOT_TELL, may_be_misstated=True)


def beside_a_model(found: Disagreement, fit: Refit) -> Disagreement:
    """Return a disagreement as it is once a model is there that leaves less than the floors.

    What a sensor's smooth error adds is believed beforehand, or was measured beside tangents that
    do not follow what is missing to its border. Where a model leaves less, it was believed too
    large: no more than that is the sensor's, and what the model takes away may matter.

    Args:
        found: with the floors that are believed.
        fit: of the model.
    """
    left = patch_gap(fit.groups, Part.ALL)
    if found.verdict is not Verdict.BELOW_MARGIN or not left.rms < left.whole_floor:
        return found
    excess = float(np.sqrt(max(found.gap.rms**2 - left.rms**2, 0.0)))
    if excess <= found.margin:
        return found
    return replace(found, verdict=Verdict.DISAGREE, excess=excess)
