# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fitted models with a tolerance for the form of their effects, held against one another."""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison.form_basis import FormBasis
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis, with_tolerance
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.model_comparison.refit_rounds import by_evidence, Judge
from diffcal_ros.diagnosis.model_comparison.shared_patches import (
    on_shared_patches,
    on_shared_patches_of_the_near,
)
from diffcal_ros.diagnosis.patches.patch_group import full_names


def nominal_basis(pool: RefitPool) -> FormBasis | None:
    """Return what forms are told by around the nominal model; None where models are judged as are.

    A floor that is a guess, and motions: see `with_tolerance`.

    Args:
        pool: who refit, and what the nominal model is.
    """
    seen = pool.nominal.model.observations
    is_exact = not pool.nominal.is_measured or any(one.instant is not None for one in seen)
    return None if is_exact else FormBasis.of(pool.nominal, pool.base, pool.base)


def judge_by(basis: FormBasis | None) -> Judge | None:
    """Return who judges models by a basis; None where there is none."""
    return None if basis is None else lambda models: judged(models, basis, is_brief=True)


def judged(
    models: Sequence[Hypothesis], basis: FormBasis | None, *, is_brief: bool = False
) -> list[Hypothesis]:
    """Judge models with a tolerance for the form of their effects, in their order.

    They are held against one another on the patches that all near the best see; their fits stay
    those of all patches.

    Args:
        models: of one nominal model.
        basis: by which their forms are told; None: they are judged as they are.
        is_brief: see `tolerated`.
    """
    return [
        replace(with_tolerance(counted, basis, is_brief=is_brief), fit=model.fit)
        for model, counted in zip(models, on_shared_patches_of_the_near(models), strict=True)
    ]


def judged_side_by_side(
    one: Hypothesis, two: Hypothesis, basis: FormBasis | None
) -> tuple[Hypothesis, Hypothesis]:
    """Judge two models on the patches that both see, however far one is behind.

    The better one may see what the other has left out as strange, and lose by it.

    Args:
        one: a model, judged.
        two: another one of the same nominal model, judged.
        basis: by which their forms are told; None: they are judged as they are.

    Returns:
        Both, with fits that count these patches; as they are where both see the same.
    """
    names = [set(full_names(model.fit.groups)) for model in (one, two)]
    if names[0] == names[1]:
        return one, two
    one, two = (with_tolerance(model, basis) for model in on_shared_patches([one, two]))
    return one, two


def judged_singles(
    pool: RefitPool, singles: Sequence[Hypothesis], basis: FormBasis | None
) -> tuple[list[Hypothesis], FormBasis | None]:
    """Judge models with one effect each, best first, and say by what their forms are told.

    What effects may do besides is found around the best of them, whose body stands about where the
    measured one does; which that is, around the nominal one.

    Args:
        pool: who refitted them, and what the nominal model is.
        singles: models with one effect each.
        basis: around the nominal model; None: they are judged as they are.
    """
    if basis is None or not singles:
        return sorted(judged(singles, None), key=by_evidence), None
    best = min(judged(singles, basis, is_brief=True), key=by_evidence)
    basis = FormBasis.of(best.evaluator, best.fit, pool.base)
    return sorted(judged(singles, basis), key=by_evidence), basis
