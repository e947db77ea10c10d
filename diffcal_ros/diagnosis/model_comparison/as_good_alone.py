# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Single effects that explain the data about as well as the best one does."""

from collections.abc import Sequence

from diffcal_ros.diagnosis.model_comparison.hypothesis import FORM_DOUBT, Hypothesis


def as_good_alone(singles: Sequence[Hypothesis], within: float) -> set[str]:
    """Return identifiers of single effects that explain about as much as the best, its own too.

    Args:
        singles: models with one effect each, best first, at least one.
        within: log evidence within which models are as good; what of the best one's is in doubt
            comes on top.
    """
    best = singles[0]
    least = best.level - within - FORM_DOUBT * best.leaning
    return {own.identifiers[0] for own in singles if own.level > least and not own.is_at_bound}
