# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A second witness for a name: smooth fields that know nothing of the library's effects."""

from functools import cached_property

from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.verdict.frame_test import ClassScore, frame_test

# Log density by which one class must predict poses better than any other: as a second effect
# must explain more.
_CLEARLY = 8.0


class FieldWitness:
    """The fields of all classes around a nominal fit, tested once they are asked for."""

    def __init__(self, evaluator: PatchEvaluator, nominal: Refit) -> None:
        """Test nothing yet.

        Args:
            evaluator: of the nominal model.
            nominal: its fit.
        """
        self._evaluator, self._nominal = evaluator, nominal

    @cached_property
    def scores(self) -> tuple[ClassScore, ...]:
        """Scores of all classes, best first; empty of one view and of motions.

        Frames of a motion are no poses of which one could be predicted from the others.
        """
        is_moving = any(seen.instant is not None for seen in self._evaluator.model.observations)
        return () if is_moving else frame_test(self._evaluator, self._nominal)

    def speaks_for(self, hypothesis: Hypothesis) -> bool:
        """Tell whether the class of a model's effects, of one of two, predicts poses best."""
        if len(self.scores) < 2:
            return False
        best, second, *_ = self.scores
        groups = {added.effect.group for added in hypothesis.added}
        return best.group in groups and best.prediction - second.prediction > _CLEARLY
