# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a model owes to its effects being other ones in each pose.

A form that all poses have in common is confirmed by each of them. What an effect is more in a
single pose only that pose tells, whose data it was fitted to: it rests on what is believed of
poses, and is in doubt by as much as what is owed to forms that were not fitted.
"""

from diffcal_ros.diagnosis.model_comparison.effect_refit import with_effects
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.patch_fits.fewer_parameters import fitted_with_fewer
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator


def owed_to_poses(model: Hypothesis, evaluator: PatchEvaluator, nominal: Refit) -> float:
    """Return the log evidence that a model would lack with the same effects in all poses.

    To first order around where it stands; zero where they are fitted so.

    Args:
        model: fitted.
        evaluator: of the nominal model.
        nominal: its fit.
    """
    common = [own for own in model.freed if own.posture is None]
    if len(common) == len(model.freed):
        return 0.0
    _, same = with_effects(evaluator, nominal, model.added, common)
    in_all = fitted_with_fewer(model.fit, same)
    return max(model.fit.log_evidence - in_all.log_evidence, 0.0)
