# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Judged models whose effects may be free to be others, and refits that make them likelier."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

from diffcal_ros.calibration.parameters.parameters import Parameter
from diffcal_ros.diagnosis.model_comparison.any_form import tolerated
from diffcal_ros.diagnosis.model_comparison.form_basis import FormBasis
from diffcal_ros.diagnosis.model_comparison.form_ways import ways_of
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.refit_requests import RefitRequest
import numpy as np

from support.judged_models import refitted_with


def judged_model(
    screened: tuple,
    basis: FormBasis,
    name: str,
    by_pose: float,
    fraction: float = 0.0,
    leaning: float = 80.0,
) -> Hypothesis:
    """Return a model with an effect, judged, of which data say by how much it differs."""
    model = refitted_with(screened, name)
    ways = ways_of(model.evaluator.model, model.fit, basis, model.added)
    found = tolerated(model.fit, ways)
    exact = found.log_evidence - leaning
    return replace(model, judged=replace(found, by_pose=by_pose, fraction=fraction, exact=exact))


def with_parts(model: Hypothesis, parts: Sequence[Parameter]) -> Hypothesis:
    """Return a model that knows of further parameters, all of them zero."""
    before = model.fit
    fit = replace(
        before,
        parameters=replace(before.parameters, parameters=(*before.parameters.parameters, *parts)),
        coordinates=np.append(before.coordinates, np.zeros(len(parts))),
    )
    return replace(model, fit=fit)


class Refits:
    """Refits that leave what a model is, each a given amount likelier."""

    def __init__(self, gains: Iterable[float], model: Hypothesis | None = None) -> None:
        self._gains, self.asked, self.ended, self.left = iter(gains), list[int](), 0, 0.9
        self.model = model

    def refit_all(self, requests: Sequence[RefitRequest]) -> list[Hypothesis]:
        (request,) = requests
        self.asked.append(len(request.freed))
        gain = next(self._gains)
        known = self.model.fit.parameters.names
        better = with_parts(self.model, [part for part in request.freed if part.name not in known])
        self.model = likelier(better, gain)
        return [self.model]

    def finish(self, models: Sequence[Hypothesis], least: Sequence[float]) -> list[Hypothesis]:
        self.ended += 1
        chi_square = self.left * models[0].fit.chi_square
        return [replace(models[0], fit=replace(models[0].fit, chi_square=chi_square))]


class RefitsOf:
    """Refits of several models by the effect of each, that are likelier by a given amount."""

    def __init__(self, known: dict[str, tuple[Hypothesis, float]]) -> None:
        self._known, self.asked = known, list[str]()

    def refit_all(self, requests: Sequence[RefitRequest]) -> list[Hypothesis]:
        (request,) = requests
        name = request.added[0].identifier
        self.asked.append(name)
        model, gain = self._known[name]
        return [likelier(with_parts(model, request.freed), gain)]


def likelier(model: Hypothesis, gain: float) -> Hypothesis:
    """Return a judged model whose log evidence is so much more, in whatever form."""
    judged = model.judged
    judged = replace(
        judged, log_evidence=judged.log_evidence + gain, exact=judged.exact + gain, by_pose=0.2
    )
    return replace(model, judged=judged)
