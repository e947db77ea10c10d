# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A model with one or more effects added, refitted."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diffcal_ros.calibration.parameters.parameters import (
    make_parameters,
    Parameter,
    ParameterSet,
)
from diffcal_ros.chi_square import chance_beyond
from diffcal_ros.diagnosis.model_comparison.any_form import Tolerated, tolerated
from diffcal_ros.diagnosis.model_comparison.form_basis import FormBasis
from diffcal_ros.diagnosis.model_comparison.form_ways import ways_of
from diffcal_ros.diagnosis.patch_fits.fewer_parameters import fitted_with_fewer
from diffcal_ros.diagnosis.patch_fits.refit import Refit, refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.patches.patch_group import names_of, strange_patches
from diffcal_ros.diagnosis.screening.candidates import Candidate, parameters_of
from diffcal_ros.diagnosis.screening.starts import more_starts
from diffcal_ros.effects.effect import Component
from diffcal_ros.errors import NotSimulatedError
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Of a start that tangents propose, where the whole cannot be simulated.
_FRACTIONS = (1.0, 0.3, 0.0)
# What a model owes to forms other than the library's rests on what is believed of forms; so much
# of it is in doubt.
FORM_DOUBT = 0.1
# What is off from the library's form by more of what it does is another thing.
FARTHEST_FORM = 0.5
# What is left is small beside its noise where noise leaves as much with this chance.
_AS_NOISE = 0.05
# An effect whose usual size moves no patch by more than this is idle [m].
_NOTHING = 1e-7


@dataclass(frozen=True)
class Amplitude:
    """A fitted amplitude, in the unit that people use.

    Attributes:
        name: of the component.
        value: amplitude.
        std_error: its standard error.
        unit: of both.
        at_bound: whether it stopped at a bound.
        is_absent: whether that is zero.
    """

    name: str
    value: float
    std_error: float
    unit: str
    at_bound: bool
    is_absent: bool


@dataclass(frozen=True)
class Hypothesis:
    """Some effects, and the model with them refitted.

    Attributes:
        added: the effects.
        scene: with the settings of the effects.
        evaluator: of the model.
        fit: where it ended.
        judged: with a tolerance for the form of its effects; None: of just this form.
        guessed: log evidence where the size of the noise is the model's own; None: it is known.
    """

    added: tuple[Candidate, ...]
    scene: Scene
    evaluator: PatchEvaluator
    fit: Refit
    judged: Tolerated | None = None
    guessed: float | None = None

    @property
    def log_evidence(self) -> float:
        """Log evidence, with what its form may be off by."""
        if self.guessed is not None:
            return self.guessed
        return self.fit.log_evidence if self.judged is None else self.judged.log_evidence

    @property
    def level(self) -> float:
        """Log evidence less its doubtful part: by this models are held against one another."""
        return self.log_evidence - FORM_DOUBT * self.leaning

    @property
    def leaning(self) -> float:
        """Log evidence that it owes to forms other than the library's."""
        return 0.0 if self.judged is None else self.judged.log_evidence - self.judged.exact

    @property
    def chi_square(self) -> float:
        """What is left on the patches that were fitted, likewise."""
        return self.fit.chi_square if self.judged is None else self.judged.chi_square

    @property
    def chi_square_per_patch(self) -> float:
        """The same by degree of freedom: 1 where noise alone is left."""
        return self.chi_square / self._freedom

    @property
    def chance_of_noise(self) -> float:
        """Return the chance that noise alone leaves as much."""
        return float(chance_beyond(self.chi_square, self._freedom))

    @property
    def leaves_noise(self) -> bool:
        """Tell whether what is left is small beside its noise, in whatever form is allowed."""
        return self.chance_of_noise > _AS_NOISE

    @property
    def _freedom(self) -> int:
        if self.judged is not None:
            return max(round(self.judged.freedom), 1)
        return max(self.fit.patch_count - len(self.fit.coordinates), 1)

    @property
    def in_any_form(self) -> Refit:
        """Return the fit with parameters, and their errors, as by effects of whatever form.

        An effect that is off in form draws the other parameters, and these are no surer than that.
        """
        if self.judged is None:
            return self.fit
        judged = self.judged
        return replace(self.fit, coordinates=judged.coordinates, covariance=judged.covariance)

    @property
    def by_posture(self) -> tuple[Parameter, ...]:
        """Return what amplitudes are more in single postures; empty: they are the same in all."""
        return tuple(own for own in self.fit.parameters if own.posture is not None)

    @property
    def identifiers(self) -> tuple[str, ...]:
        """Identifiers of the effects, in alphabetical order."""
        return tuple(sorted(candidate.identifier for candidate in self.added))

    @property
    def amplitude_count(self) -> int:
        """Amplitudes of all effects together."""
        return sum(len(candidate.components) for candidate in self.added)

    @property
    def is_at_bound(self) -> bool:
        """Tell whether an effect stopped at a bound, where it is as good as absent.

        One of several amplitudes may be absent alone, as where a clamp gives way about one axis.
        """
        for candidate in self.added:
            there = [own for own in self.amplitudes(candidate) if not own.is_absent]
            if not there or any(own.at_bound for own in there):
                return True
        return False

    @property
    def has_absent_amplitude(self) -> bool:
        """Tell whether an amplitude is zero, and the others are sure as if that were known."""
        return any(a.is_absent for c in self.added for a in self.amplitudes(c))

    @property
    def has_idle_effect(self) -> bool:
        """Tell whether one of the effects does nothing, as a plane that touches nowhere."""
        return any(self._reach(candidate) < _NOTHING for candidate in self.added)

    def chance_of_zero(self, candidate: Candidate, noise_scale: float = 1.0) -> float:
        """Return the chance of amplitudes as large as fitted if all were zero, by Wald's test.

        What they are more in single postures belongs to them.

        Args:
            candidate: the effect.
            noise_scale: by how much the variance of the patches exceeds what they state.
        """
        names = self.fit.parameters.names
        indices = [names.index(n) for n in parameters_of(self.fit.parameters, [candidate])]
        values = self.fit.coordinates[indices]
        covariance = self.fit.covariance[np.ix_(indices, indices)]
        wald = float(values @ np.linalg.pinv(covariance) @ values) / max(1.0, noise_scale)
        return float(chance_beyond(wald, len(indices)))

    def _reach(self, candidate: Candidate) -> float:
        """Return how far usual sizes of an effect move the patch that they move most [m]."""
        names = self.fit.parameters.names
        farthest = 0.0
        for name, component in zip(candidate.names, candidate.components, strict=True):
            index = names.index(name)
            slopes = [b.patches.jacobian[:, index] for b in self.fit.groups]
            largest = max((float(np.abs(s).max(initial=0.0)) for s in slopes), default=0.0)
            farthest = max(farthest, largest * candidate.effect.component(component).scale)
        return farthest

    def amplitudes(self, candidate: Candidate) -> list[Amplitude]:
        """Return the fitted amplitudes of one of the effects."""
        fit = self.fit
        lower, upper = fit.parameters.bounds()
        names = fit.parameters.names
        found = []
        for name, component in zip(candidate.names, candidate.components, strict=True):
            index = names.index(name)
            part = candidate.effect.component(component)
            is_inside = lower[index] < fit.coordinates[index] < upper[index]
            value, std_error = fit.of_the_body(index)
            found.append(
                Amplitude(
                    name=component,
                    value=value * part.shown_factor,
                    std_error=std_error * part.shown_factor,
                    unit=part.shown_unit,
                    at_bound=not is_inside,
                    is_absent=not is_inside and fit.coordinates[index] == 0.0,
                )
            )
        return found


def with_effects(
    nominal: PatchEvaluator,
    base: Refit,
    added: Sequence[Candidate],
    by_posture: Sequence[Parameter] = (),
) -> tuple[Scene, PatchEvaluator]:
    """Return the scene with effects, and the patches of a model of it, not yet fitted.

    Args:
        nominal: evaluates the patches of the nominal model.
        base: its fit.
        added: effects to add.
        by_posture: what their amplitudes may be more in single postures, see `set_anew`.
    """
    scene = _with_settings(nominal.model.scene, added)
    parameters = _with_amplitudes(scene, base.parameters, added)
    parameters = replace(parameters, parameters=(*parameters.parameters, *by_posture))
    return scene, nominal.of(nominal.model.with_parameters(scene, parameters))


def try_effects(
    nominal: PatchEvaluator,
    base: Refit,
    added: Sequence[Candidate],
    starts: dict[str, float],
    *,
    max_iterations: int = 12,
    least_log_evidence: float = -np.inf,
    by_posture: Sequence[Parameter] = (),
) -> Hypothesis | None:
    """Add effects to the nominal model and refit everything.

    Args:
        nominal: evaluates the patches of the nominal model.
        base: its fit.
        added: effects to add.
        starts: where amplitudes start, SI units by name among the parameters; others at zero.
        max_iterations: evaluations of the model at most.
        least_log_evidence: log evidence below which the model is of no use.
        by_posture: see `with_effects`.

    Returns:
        The refitted model, or None where it cannot be simulated.
    """
    scene, evaluator = with_effects(nominal, base, added, by_posture)
    far = {c.effect.amplitude_name(n) for c in added for n in c.effect.beyond_robust_fit}
    best: Refit | None = None
    for more in more_starts(nominal, base, added):
        is_robust = not evaluator.is_measured and not far & more.keys()
        # Of several starts the best is kept.
        least = least_log_evidence if best is None else max(least_log_evidence, best.log_evidence)
        begin = {**starts, **more}
        found = _refit_from(evaluator, base, begin, max_iterations, is_robust, least)
        if found is None:
            continue
        if best is None or found.log_evidence > best.log_evidence:
            best = found
    return None if best is None else Hypothesis(tuple(added), scene, evaluator, best)


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


def with_tolerance(
    hypothesis: Hypothesis, basis: FormBasis | None, *, is_brief: bool = False
) -> Hypothesis:
    """Judge a fitted model with a tolerance for the form of its effects.

    Where the floor is a guess so is what is left above it, and what a motion leaves is its mesh's
    and time step's more than a form's: these are judged as they are.

    Args:
        hypothesis: the model.
        basis: of the model without its effects; None: it is judged as it is.
        is_brief: see `tolerated`.
    """
    if basis is None:
        return hypothesis
    fit = hypothesis.fit
    ways = ways_of(hypothesis.evaluator.model, fit, basis, hypothesis.added)
    return replace(hypothesis, judged=tolerated(fit, ways, is_brief=is_brief))


def _refit_from(
    evaluator: PatchEvaluator,
    base: Refit,
    starts: dict[str, float],
    max_iterations: int,
    is_robust: bool,
    least_log_evidence: float,
) -> Refit | None:
    """Refit from a start; tangents may have promised more than the body can bear."""
    amplitudes = {
        p.name
        for p in evaluator.model.parameters.parameters[len(base.parameters) :]
        if p.quantity.prior_std is not None
    }
    for fraction in _FRACTIONS:
        fewer = {n: fraction * v if n in amplitudes else v for n, v in starts.items()}
        begin = _start(evaluator.model.parameters, base, fewer)
        try:
            if is_robust:
                # What noise to fit patches by is a guess: the robust fit stands as it is.
                return _robust_refit(evaluator, base, begin)
            return refit(
                evaluator,
                begin,
                max_iterations=max_iterations,
                least_log_evidence=least_log_evidence,
            )
        except NotSimulatedError:
            continue
    return None


def _robust_refit(evaluator: PatchEvaluator, base: Refit, begin: FloatArray) -> Refit:
    """Fit as a calibration does, and judge by what shows the body.

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
            effects[candidate.identifier] = candidate.settings
    return replace(scene, effects=effects)


def _with_amplitudes(
    scene: Scene, nominal: ParameterSet, added: Sequence[Candidate]
) -> ParameterSet:
    names: list[str] = []
    for candidate in added:
        names.extend(candidate.effect.fit_names(candidate.components))
    more = make_parameters(scene, tuple(names), with_edge_bias=False).parameters
    wanted = {name for candidate in added for name in candidate.names}
    usual = {
        name: _usual_size(candidate.effect.component(component))
        for candidate in added
        for name, component in zip(candidate.names, candidate.components, strict=True)
    }
    chosen = tuple(
        replace(p, quantity=replace(p.quantity, prior_mean=0.0, prior_std=usual[p.name]))
        if p.quantity.prior_std is not None
        else p
        for p in more
        if p.name in wanted
    )
    return ParameterSet((*nominal.parameters, *chosen), nominal.pose_covariances)


def _usual_size(part: Component) -> float:
    """Return how large an amplitude may well be that is looked for: no less than a fit allows."""
    return max(part.scale, part.nominal_std or 0.0)


def _start(parameters: ParameterSet, base: Refit, starts: dict[str, float]) -> FloatArray:
    begin = parameters.start()
    begin[: len(base.coordinates)] = base.coordinates
    for index, parameter in enumerate(parameters):
        if parameter.name in starts:
            begin[index] = starts[parameter.name]
    return np.clip(begin, *parameters.bounds())
