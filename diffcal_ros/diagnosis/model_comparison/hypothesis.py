# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A model with one or more effects added, refitted."""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace

from diffcal_ros.calibration.parameters.parameters import Parameter
from diffcal_ros.chi_square import chance_beyond
from diffcal_ros.diagnosis.detection.disagreement import ALPHA
from diffcal_ros.diagnosis.model_comparison.any_form import Tolerated, tolerated
from diffcal_ros.diagnosis.model_comparison.form_basis import FormBasis
from diffcal_ros.diagnosis.model_comparison.form_ways import ways_of
from diffcal_ros.diagnosis.patch_fits.refit import AS_NOISE, Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.patches.patch_group import full_names
from diffcal_ros.diagnosis.screening.candidates import Candidate, identifiers_of, parameters_of
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# What a model owes to forms other than the library's rests on what is believed of forms; so much
# of it is in doubt.
FORM_DOUBT = 0.1
# Models this close in log evidence, per unit of noise scale, explain the data as well.
AS_WELL = 5.0
# What owes less log evidence to other forms is as good as in the library's: what of that is in
# doubt decides nothing.
LEAST_LEANING = 50.0
# What is off from the library's form by more of what it does is another thing.
FARTHEST_FORM = 0.5
# A tenth is usual. What is expected off by more, between the shares that are tried, is in doubt.
USUAL_FORM = 0.125
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
        larger: by what factor the sensor's smooth error is larger than is believed, as is to be
            expected beside it (`second_effect`); 1 where that was not asked for.
    """

    added: tuple[Candidate, ...]
    scene: Scene
    evaluator: PatchEvaluator
    fit: Refit
    judged: Tolerated | None = None
    guessed: float | None = None
    larger: float = 1.0

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
        return self.chance_of_noise > AS_NOISE

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
    def freed(self) -> tuple[Parameter, ...]:
        """Return what effects are more in single postures, or in other forms."""
        return tuple(own for own in self.fit.parameters if own.is_freed)

    @property
    def is_free_in_form(self) -> bool:
        """Tell whether an effect is in a form of its own."""
        return any(own.is_in_all for own in self.freed)

    @property
    def is_free_in_time(self) -> bool:
        """Tell whether an effect is another one in the course of a recording."""
        return any(own.knot is not None for own in self.freed)

    @property
    def is_free_in_everything(self) -> bool:
        """Tell whether an effect is in a form of its own, and another one in each pose."""
        for added in self.added:
            postures = [own.posture for own in self.freed if own.effect == added.identifier]
            if None in postures and any(posture is not None for posture in postures):
                return True
        return False

    @property
    def identifiers(self) -> tuple[str, ...]:
        """Identifiers of the effects, in alphabetical order."""
        return identifiers_of(self.added)

    @property
    def is_unlike_itself(self) -> bool:
        """Tell whether it asks for what stays to be another one in each pose, by far.

        A material, a shape or a load may differ by its usual tolerance. One that has to by more,
        and leaves more than noise all the same, is hardly it.
        """
        if self.judged is None or self.fit.chance_of_noise >= ALPHA:
            return False
        stays = any(own.effect.most_by_pose < 1.0 for own in self.added)
        return stays and self.judged.by_pose > FARTHEST_FORM

    @property
    def amplitude_count(self) -> int:
        """Amplitudes of all effects together."""
        return sum(len(candidate.components) for candidate in self.added)

    @property
    def is_at_bound(self) -> bool:
        """Tell whether an effect stopped at a bound, where it is as good as absent.

        One of several amplitudes may be absent alone, as where a clamp gives way about one axis.
        """
        listed = [self.amplitudes(candidate) for candidate in self.added]
        return self.would_be_more or any(all(one.is_absent for one in own) for own in listed)

    @property
    def would_be_more(self) -> bool:
        """Tell whether an effect stopped at a bound where it is not absent: there may be more."""
        every = [own for candidate in self.added for own in self.amplitudes(candidate)]
        return any(own.at_bound and not own.is_absent for own in every)

    @property
    def has_absent_amplitude(self) -> bool:
        """Tell whether an amplitude is zero, and the others are sure as if that were known."""
        return any(a.is_absent for c in self.added for a in self.amplitudes(c))

    @property
    def has_idle_effect(self) -> bool:
        """Tell whether one of the effects does nothing, as a plane that touches nowhere."""
        return any(self._reach(candidate) < _NOTHING for candidate in self.added)

    def chance_of_zero(
        self, candidate: Candidate, noise_scale: float = 1.0, *, in_common: bool = False
    ) -> float:
        """Return the chance of amplitudes as large as fitted if all were zero, by Wald's test.

        What they are more in single postures belongs to them.

        Args:
            candidate: the effect.
            noise_scale: by how much the variance of the patches exceeds what they state.
            in_common: of what all postures have in common alone.
        """
        names = self.fit.parameters.names
        own = candidate.names if in_common else parameters_of(self.fit.parameters, [candidate])
        indices = [names.index(name) for name in own]
        values = self.fit.coordinates[indices]
        covariance = self.fit.covariance[np.ix_(indices, indices)]
        wald = float(values @ np.linalg.pinv(covariance) @ values) / max(1.0, noise_scale)
        return float(chance_beyond(wald, self.freedom_of(own)))

    def freedom_of(self, names: Sequence[str]) -> float:
        """Return how many parameters the data tell, of some: no less than are not freed.

        A way of a free form that the data do not ask for is believed to be next to nothing: it can
        be nothing else, and explains nothing. Each is counted by the share of its variance that
        the data took away (MacKay, *Bayesian interpolation*, Neural Computation 4, 1992).
        """
        parameters = self.fit.parameters
        _, precision = parameters.prior()
        count = 0.0
        for name in names:
            index = parameters.names.index(name)
            is_freed = parameters.parameters[index].is_freed
            left = precision[index, index] * self.fit.covariance[index, index] if is_freed else 0.0
            count += 1.0 - min(float(left), 1.0)
        return max(count, 1.0)

    def _reach(self, candidate: Candidate) -> float:
        """Return how far usual sizes of an effect move the patch that they move most [m]."""
        names = self.fit.parameters.names
        farthest = 0.0
        for name, component in zip(candidate.names, candidate.components, strict=True):
            index = names.index(name)
            slopes = [b.patches.jacobian[:, index] for b in self.fit.groups]
            largest = max((float(np.abs(s).max(initial=0.0)) for s in slopes), default=0.0)
            farthest = max(farthest, largest * candidate.part(component).scale)
        return farthest

    def amplitudes(self, candidate: Candidate) -> list[Amplitude]:
        """Return the fitted amplitudes of one of the effects."""
        fit = self.fit
        lower, upper = fit.parameters.bounds()
        names = fit.parameters.names
        found = []
        for name, component in zip(candidate.names, candidate.components, strict=True):
            index = names.index(name)
            part = candidate.part(component)
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
    fit, known = hypothesis.fit, basis.known
    key = _key(hypothesis)
    found = known.get((key, False)) or (known.get((key, True)) if is_brief else None)
    if found is None:
        ways = ways_of(hypothesis.evaluator.model, fit, basis, hypothesis.added)
        found = known[key, is_brief] = tolerated(fit, ways, is_brief=is_brief)
    return replace(hypothesis, judged=found)


def _key(hypothesis: Hypothesis) -> Hashable:
    """Return what tells fitted models of one basis apart: where each stands, and what it sees."""
    fit = hypothesis.fit
    return (
        tuple((own, own.size) for own in hypothesis.added),
        fit.parameters.names,
        fit.coordinates.tobytes(),
        fit.log_evidence,
        tuple(full_names(fit.groups)),
    )
