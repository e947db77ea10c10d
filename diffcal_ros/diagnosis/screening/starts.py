# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where to start amplitudes of which tangents at zero say little."""

from collections.abc import Sequence

from diffcal_ros.calibration.residuals.seen_fit import SeenFit
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.screening.candidates import Candidate

Starts = dict[str, float]


def more_starts(nominal: PatchEvaluator, base: Refit, added: Sequence[Candidate]) -> list[Starts]:
    """Return starts to be tried on top of what tangents propose, SI units by name.

    Args:
        nominal: evaluates the patches of the nominal model.
        base: its fit.
        added: effects that are added to it.
    """
    seen = SeenFit(nominal, base.coordinates)
    found: list[Starts] = [{}]
    for effect, at in dict.fromkeys((own.effect, own.at) for own in added):
        found = [{**start, **more} for start in found for more in effect.starts(seen, at)]
    return found
