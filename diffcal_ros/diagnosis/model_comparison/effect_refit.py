# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects added to the nominal model, and everything refitted."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial

from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.parameters.parameters import Parameter, ParameterSet
from diffcal_ros.diagnosis.model_comparison.guessed_floor import ranked
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.patch_fits.fewer_parameters import fitted_with_fewer
from diffcal_ros.diagnosis.patch_fits.patch_fit import AT_FIRST, Pace
from diffcal_ros.diagnosis.patch_fits.refit import Refit, refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.patches.patch_group import names_of, strange_patches
from diffcal_ros.diagnosis.screening.candidates import Candidate
from diffcal_ros.diagnosis.screening.starts import more_starts
from diffcal_ros.errors import NotSimulatedError
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Of a start that tangents propose, where the whole cannot be simulated.
_FRACTIONS = (1.0, 0.3, 0.0)


def with_effects(
    nominal: PatchEvaluator,
    base: Refit,
    added: Sequence[Candidate],
    freed: Sequence[Parameter] = (),
) -> tuple[Scene, PatchEvaluator]:
    """Return the scene with effects, and the patches of a model of it, not yet fitted.

    Args:
        nominal: evaluates the patches of the nominal model.
        base: its fit.
        added: effects to add.
        freed: what they may be besides in single postures and other forms, see `freed_effects`.
    """
    scene = _with_settings(nominal.model.scene, added)
    parameters = _with_amplitudes(scene, nominal, base.parameters, added)
    parameters = replace(parameters, parameters=(*parameters.parameters, *freed))
    return scene, nominal.of(nominal.model.with_parameters(scene, parameters))


def try_effects(
    nominal: PatchEvaluator,
    base: Refit,
    added: Sequence[Candidate],
    starts: dict[str, float],
    *,
    max_iterations: int = 12,
    least_log_evidence: float = -np.inf,
    freed: Sequence[Parameter] = (),
    pace: Pace = AT_FIRST,
) -> Hypothesis | None:
    """Add effects to the nominal model and refit everything.

    Args:
        nominal: evaluates the patches of the nominal model.
        base: its fit.
        added: effects to add.
        starts: where amplitudes start, SI units by name among the parameters; others at zero. With
            all nominal parameters among them they are where a fitted model is, and effects that it
            has go on from there.
        max_iterations: evaluations of the model at most.
        least_log_evidence: log evidence below which the model is of no use.
        freed: see `with_effects`.
        pace: of a fit that begins there.

    Returns:
        The refitted model, or None where it cannot be simulated.
    """
    scene, evaluator = with_effects(nominal, base, added, freed)
    far = {c.effect.amplitude_name(n) for c in added for n in c.effect.beyond_robust_fit}
    found: list[Hypothesis] = []
    for more in _all_starts(nominal, base, [c for c in added if not _stands(c, base, starts)]):
        is_robust = not evaluator.is_measured and not far & more.keys()
        # Of several starts the best is kept.
        least = max([least_log_evidence, *(own.fit.log_evidence for own in found)])
        begin = {**starts, **more}
        fitted: Callable[[FloatArray], Refit] = partial(_robust_refit, evaluator, base)
        if not is_robust:
            fitted = partial(
                refit,
                evaluator,
                max_iterations=max_iterations,
                least_log_evidence=least,
                pace=pace,
            )
        fit = _refit_from(evaluator, base, begin, fitted)
        if fit is not None:
            found.append(Hypothesis(tuple(added), scene, evaluator, fit))
    # Squares in units of a floor that is a guess would tell of the few worst patches.
    judged = found if evaluator.is_measured else ranked(found)
    best = max(range(len(found)), key=lambda number: judged[number].log_evidence, default=None)
    return None if best is None else found[best]


def try_beside(
    nominal: PatchEvaluator,
    base: Refit,
    added: Candidate,
    model: Hypothesis | None,
    *,
    max_iterations: int,
    freed: Sequence[Parameter] = (),
) -> Hypothesis | None:
    """Add an effect to a fitted model, from where that stands, and refit everything.

    Args:
        nominal: evaluates the patches of the nominal model.
        base: its fit.
        added: effect to add.
        model: with what else is missing; None: the nominal one.
        max_iterations: see `try_effects`.
        freed: what the added effect may be besides.

    Returns:
        See `try_effects`.
    """
    if model is None:
        return try_effects(nominal, base, [added], {}, max_iterations=max_iterations, freed=freed)
    own = {name for one in model.added for name in one.names} | {f.name for f in model.freed}
    return try_effects(
        nominal,
        base,
        [*model.added, added],
        {name: value for name, value in model.fit.values_by_name().items() if name in own},
        max_iterations=max_iterations,
        freed=(*model.freed, *freed),
    )


def _stands(candidate: Candidate, base: Refit, starts: Mapping[str, float]) -> bool:
    """Tell whether it is said where an effect is that was fitted: it goes on from there."""
    is_told = _is_fitted(base, starts) or not candidate.effect.has_tangent
    return is_told and set(candidate.names) <= starts.keys()


def _is_fitted(base: Refit, starts: Mapping[str, float]) -> bool:
    """Tell whether starts are where a fitted model is: they say so of all nominal parameters."""
    return set(base.parameters.names) <= starts.keys()


def _all_starts(
    nominal: PatchEvaluator, base: Refit, added: Sequence[Candidate]
) -> list[dict[str, float]]:
    """Return starts to be tried, SI units by name.

    Where robust fits end depends on where they begin if an effect is beyond their reach: from
    where it is absent, too, then.
    """
    listed = more_starts(nominal, base, added)
    if len(listed) < 2 or nominal.is_measured:
        return listed
    return [*listed, {name: 0.0 for own in added for name in own.names}]


def with_fewer_effects(
    nominal: PatchEvaluator, base: Refit, whole: Hypothesis, kept: Sequence[Candidate]
) -> Hypothesis:
    """Return a model without some effects or amplitudes of a fitted one, to first order.

    Args:
        nominal: evaluates the patches of the nominal model.
        base: its fit.
        whole: the fitted model.
        kept: effects that stay, with the amplitudes that stay.
    """
    scene, evaluator = with_effects(nominal, base, kept)
    return Hypothesis(tuple(kept), scene, evaluator, fitted_with_fewer(whole.fit, evaluator))


def _refit_from(
    evaluator: PatchEvaluator,
    base: Refit,
    starts: dict[str, float],
    fitted: Callable[[FloatArray], Refit],
) -> Refit | None:
    """Refit from a start; tangents may have promised more than the body can bear."""
    amplitudes = {
        p.name
        for p in evaluator.model.parameters.parameters[len(base.parameters) :]
        if p.quantity.prior_std is not None
    }
    for fraction in _FRACTIONS:
        fewer = {n: fraction * v if n in amplitudes else v for n, v in starts.items()}
        with suppress(NotSimulatedError):
            return fitted(_start(evaluator.model.parameters, base, fewer))
    return None


def _robust_refit(evaluator: PatchEvaluator, base: Refit, begin: FloatArray) -> Refit:
    """Fit as a calibration does, and judge by what shows the body.

    What noise to fit patches by is a guess: the robust fit stands as it is.

    A model that reaches farther than the nominal one has patches that this one never saw. Those
    that are not the body, such as a fixture before it, are told as they were in the nominal fit.
    """
    ended = evaluator.robust_fit(begin)
    fit = refit(evaluator, ended, max_iterations=1)
    new = strange_patches(fit.groups).difference(names_of(base.groups))
    if not new:
        return fit
    return refit(evaluator.without(evaluator.left_out | new), ended, max_iterations=1)


def _with_settings(scene: Scene, added: Sequence[Candidate]) -> Scene:
    effects = dict(scene.effects)
    for candidate in added:
        if candidate.settings:
            known = scene.effects.get(candidate.identifier, {})
            effects[candidate.identifier] = {**known, **candidate.settings}
    return replace(scene, effects=effects)


def _with_amplitudes(
    scene: Scene, nominal: PatchEvaluator, known: ParameterSet, added: Sequence[Candidate]
) -> ParameterSet:
    names: list[str] = []
    for candidate in added:
        names.extend(candidate.effect.fit_names(candidate.components))
    more = make_parameters(scene, tuple(names), with_edge_bias=False).parameters
    wanted = {name for candidate in added for name in candidate.names}
    usual = {
        name: candidate.size * part.usual_size
        for candidate in added
        for name, part in zip(candidate.names, candidate.parts, strict=True)
    }
    about = _expected(nominal, added)
    chosen = tuple(
        replace(p, quantity=replace(p.quantity, prior_mean=0.0, prior_std=usual[p.name]))
        if p.quantity.prior_std is not None
        else replace(p, quantity=replace(p.quantity, start=about.get(p.name, p.quantity.start)))
        for p in more
        if p.name in wanted
    )
    return ParameterSet((*known.parameters, *chosen), known.pose_covariances)


def _expected(nominal: PatchEvaluator, added: Sequence[Candidate]) -> dict[str, float]:
    """Return about where amplitudes are of which nothing is known, SI units by name."""
    site = nominal.model.effects.site(nominal.model.observations[0].setup_index)
    return {
        own.effect.amplitude_name(name): value
        for own in added
        for name, value in own.effect.expected(site).items()
    }


def _start(parameters: ParameterSet, base: Refit, starts: dict[str, float]) -> FloatArray:
    begin = parameters.start()
    begin[: len(base.coordinates)] = base.coordinates
    for index, parameter in enumerate(parameters):
        if parameter.name in starts:
            begin[index] = starts[parameter.name]
    return np.clip(begin, *parameters.bounds())
