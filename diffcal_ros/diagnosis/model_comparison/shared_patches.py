# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Models side by side on the patches that all of them see.

Where a model's outline goes a patch at the border comes or goes with it. One that is off by four
standard errors is worth 8 of log evidence, as much as a second effect must add: the model that
lost it would win by having looked away.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import compress

from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.refit_rounds import within_reach
from diffcal_ros.diagnosis.patch_fits.refit import ended
from diffcal_ros.diagnosis.patches.patch_group import full_names, only, PatchGroup
from diffcal_ros.diagnosis.patches.whitened import Part, whiten


def on_shared_patches(models: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Return models with fits that count only the patches which all of them see, in their order.

    Args:
        models: of one nominal model.
    """
    if not models:
        return []
    shared = set.intersection(*(set(full_names(model.fit.groups)) for model in models))
    return [with_groups(model, only(model.fit.groups, shared)) for model in models]


def on_shared_patches_of_the_near(models: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Do so for the models that may win; those far behind have no say in it, and stay as they are.

    Args:
        models: of one nominal model whose floor was measured.
    """
    least = within_reach(models)
    is_near = [model.fit.log_evidence > least for model in models]
    near = iter(on_shared_patches(list(compress(models, is_near))))
    return [next(near) if own else m for m, own in zip(models, is_near, strict=True)]


def with_groups(model: Hypothesis, groups: list[PatchGroup]) -> Hypothesis:
    """Return a model whose fit counts these patches, where it stands."""
    fit = model.fit
    counted = ended(
        model.evaluator,
        fit.coordinates,
        groups,
        whiten(groups, Part.FIT),
        promise=fit.promise,
        evaluations=fit.evaluations,
        is_converged=fit.is_converged,
    )
    return replace(model, fit=counted)
