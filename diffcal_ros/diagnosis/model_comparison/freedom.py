# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What effects may be besides in each pose, and in other forms, and models refitted with that."""

from collections.abc import Sequence

from diffcal_ros.calibration.parameters.form_parameters import form_parameters, posture_parameters
from diffcal_ros.calibration.parameters.parameters import Parameter
from diffcal_ros.diagnosis.model_comparison.form_basis import FormBasis
from diffcal_ros.diagnosis.model_comparison.form_sizes import refitted
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.judged_models import judged
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.model_comparison.refit_requests import RefitRequest
from diffcal_ros.diagnosis.screening.candidates import Candidate
import numpy as np

# Of what an effect does: what data say that differs by less is as well judged as fitted. A tenth
# is one of the shares that are tried, and their mean may be a little less.
LEAST_SHARE = 0.09
# Of the model, in a fit whose effects are free.
MOST_EVALUATIONS = 6


def freed_parts(model: Hypothesis, least_fraction: float = 0.0) -> list[Parameter]:
    """Return what a model's effects may be besides in each posture, and in other forms.

    See `freeing_request`.
    """
    judged, found = model.judged, list[Parameter]()
    if judged is None:
        return found
    known = model.fit.parameters
    for added in model.added:
        effect, size = added.effect, _size(model, added)
        if size == 0.0:
            continue  # What is not there is of no other form either.
        is_moved = effect.most_by_pose >= 1.0
        if is_moved and judged.by_pose >= LEAST_SHARE:
            found += _in_each(model, added.names, judged.by_pose * size)
        fraction = max(judged.fraction, least_fraction)
        if fraction >= LEAST_SHARE:
            form = form_parameters(effect, fraction * size, added.body)
            names = [own.name for own in form]
            if not set(names) <= set(known.names):
                found += form
            elif is_moved and len(model.evaluator.model.bodies) > 1:
                # Its form is free, and still it is another one: in each pose, then.
                found += _in_each(model, names, fraction * size)
    return [parameter for parameter in found if parameter.name not in known.names]


def _in_each(model: Hypothesis, names: Sequence[str], size: float) -> list[Parameter]:
    """Return what parameters of a model are more in each posture."""
    known = model.fit.parameters
    amplitudes = [known.parameters[known.names.index(name)] for name in names]
    return posture_parameters(amplitudes, model.evaluator.model.bodies, size)


def _size(model: Hypothesis, added: Candidate) -> float:
    """Return how large the amplitudes of a fitted effect are, in usual sizes; 1 of a place."""
    if not added.effect.has_tangent:
        return 1.0
    places = [model.fit.parameters.names.index(name) for name in added.names]
    return float(np.linalg.norm(model.fit.coordinates[places] / added.scales))


def freeing_request(model: Hypothesis, least_fraction: float = 0.0) -> RefitRequest:
    """Return the refit of a model whose effects are free where they want to be.

    Args:
        model: judged.
        least_fraction: by how much of itself each may be of another form at least.
    """
    return RefitRequest(
        model.added,
        model.fit.values_by_name(),
        MOST_EVALUATIONS,
        freed=(*model.freed, *freed_parts(model, least_fraction)),
    )


def with_refits(
    pool: RefitPool, model: Hypothesis, requests: Sequence[RefitRequest], basis: FormBasis
) -> list[Hypothesis]:
    """Return a model and its refits, those that can be simulated, judged on what all see."""
    return judged([model, *refitted(pool, requests)], basis, is_brief=True)
