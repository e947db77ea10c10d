# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Models whose effects are other ones in each pose: cameras that are moved, clamps set anew.

As long as such an effect is fitted as the same one in all poses, what differs draws the other
parameters: a clamp that was elsewhere in each pose drew a modulus by 40 %. To judge that fit with
a tolerance for it says so, and does not lead back: it is too far for one step. So each amplitude
gets a part of its own in each posture, a nuisance, normal about zero and as large as the data
favour, and all is fitted from there.
"""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.calibration.parameters.parameters import Parameter
from diffcal_ros.diagnosis.model_comparison.form_basis import FormBasis
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.judged_models import judged
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.model_comparison.refit_requests import RefitRequest
from diffcal_ros.diagnosis.model_comparison.refit_rounds import best_of_each, by_evidence
from diffcal_ros.diagnosis.screening.candidates import Candidate
from diffcal_ros.scene.model import Quantity
import numpy as np

# Of what an effect does: what data say that differs by less is as well judged as fitted.
_LEAST_SHARE = 0.25
_MOST_MODELS, _MOST_EVALUATIONS = 2, 8


def with_those_set_anew(
    pool: RefitPool,
    models: Sequence[Hypothesis],
    basis: FormBasis | None,
    rivals: Sequence[Hypothesis] = (),
) -> list[Hypothesis]:
    """Return models, those that may win by it fitted with effects that are others in each pose.

    Args:
        pool: who refitted them, and what the nominal model is.
        models: judged, with as many effects each.
        basis: by which forms are told; None: models are judged as they are, and stay so.
        rivals: other models, judged.
    """
    if basis is None or not models:
        return list(models)
    best = max(model.level for model in (*models, *rivals))
    ordered = sorted(models, key=by_evidence)
    asked = [model for model in best_of_each(ordered) if _may_win(model, best)][:_MOST_MODELS]
    better: dict[int, Hypothesis] = {}
    for model in asked:
        # Where the one before it left noise, another one seldom may.
        found = pool.refit_all([_request(model)]) if _may_win(model, best) else []
        before, *fitted = judged([model, *found], basis, is_brief=True)
        for new in fitted:
            if new.level > before.level:
                better[id(model)], best = new, max(best, new.level)
    return sorted((better.get(id(model), model) for model in models), key=by_evidence)


def _request(model: Hypothesis) -> RefitRequest:
    """Return the refit of a model whose effects may be other ones in each pose."""
    return RefitRequest(
        model.added,
        model.fit.values_by_name(),
        _MOST_EVALUATIONS,
        by_posture=tuple(part for own in model.added for part in _by_posture(model, own)),
    )


def _may_win(model: Hypothesis, best: float) -> bool:
    """Tell whether a model's effects differ from pose to pose, and would win if that left noise.

    Args:
        model: judged, its effects the same in all poses.
        best: level of the best of all.
    """
    judged = model.judged
    if judged is None or model.by_posture or judged.by_pose < _LEAST_SHARE:
        return False
    if not any(own.effect.most_by_pose >= 1.0 for own in model.added):
        return False
    left = max(judged.chi_square - judged.freedom, 0.0)
    return model.level + 0.5 * left + model.leaning >= best


def _by_posture(model: Hypothesis, added: Candidate) -> list[Parameter]:
    """Return what amplitudes of an effect may be more in each posture."""
    effect = added.effect
    if effect.most_by_pose < 1.0 or model.judged is None:
        return []
    parts = [effect.component(name) for name in added.components]
    scales = np.array([part.scale for part in parts])
    names = model.fit.parameters.names
    places = [names.index(name) for name in added.names]
    size = float(np.linalg.norm(model.fit.coordinates[places] / scales)) * model.judged.by_pose
    found = []
    for place, part in zip(places, parts, strict=True):
        reach = part.upper - part.lower
        quantity = Quantity(0.0, -reach, reach, 0.0, size * part.scale)
        found += [
            replace(
                model.fit.parameters.parameters[place],
                name=f'{names[place]}@{posture}',
                quantity=quantity,
                is_nuisance=True,
                posture=posture,
            )
            for posture in sorted(model.evaluator.model.bodies)
        ]
    return found
