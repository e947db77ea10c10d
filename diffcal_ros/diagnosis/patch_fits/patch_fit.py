# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A fit of patches on its way: Gauss-Newton with Levenberg and Marquardt's damping."""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.calibration.forward.led_there import lead_to
from diffcal_ros.calibration.parameters.longest_steps import longest_steps
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.patches.patch_gap import residual_size
from diffcal_ros.diagnosis.patches.patch_group import PatchGroup
from diffcal_ros.diagnosis.patches.regularised_prior import regularised_prior
from diffcal_ros.diagnosis.patches.whitened import chosen_patches, Part, whiten, Whitened
from diffcal_ros.errors import NotSimulatedError
from diffcal_ros.least_squares.boxed_step import boxed_step
from diffcal_ros.least_squares.gauss_newton import gauss_newton_step
from diffcal_ros.least_squares.normal_equations import Prior
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_MAX_REJECTIONS = 4
# A step that promises less than this (half chi-square, in units of what is left of each patch) is
# a third of a standard error.
_SMALL_GAIN = 0.05
_SMALL_FRACTION = 1e-4
# Share of the present residual that is allowed for while a fit is on its way.
_SLACK = 0.3
# Where it shrinks by less, costs before and after can be compared.
_MUCH_LESS = 0.9
# A step that failed is not tried once more as hardly another one.
_FIRST_DAMPING, _LEAST_DAMPING = 0.1, 1e-3
# Patches join and leave: a step is not refused for less than this share.
_ROUGHNESS = 0.01
# So many evaluations on end that win less than a share of the cost lead nowhere. While it is
# on its way a fit may go round in circles of the size of that roughness.
_MOST_IDLE = 3
_PROGRESS, _PROGRESS_AT_LAST = _ROUGHNESS, 0.002
# So many steps on end that led nowhere, and promise less than that roughness, are enough.
_REJECTED_ENOUGH = 2
# A fit is lost when so many times what a step promises does not reach its rivals, after so many
# evaluations.
HOPE, _FEWEST_LOOKS = 4.0, 3


def prior_of(evaluator: PatchEvaluator) -> Prior:
    """Return what is known of a model's coordinates before its patches are looked at."""
    parameters = evaluator.model.parameters
    mean, precision = regularised_prior(parameters)
    # What is known of a parameter is known of the body, not of its mesh and time step.
    return Prior(mean - evaluator.discretisation_error.shifts_of(parameters), precision)


@dataclass(frozen=True)
class Pace:
    """How a fit got on when it stopped: what goes on from there need not find that out anew.

    Attributes:
        damping: of Levenberg and Marquardt.
        rejections: steps on end that led nowhere.
        is_close: whether it began where a fitted model is, and is held to the full precision of
            the patches from there on.
    """

    damping: float = 0.0
    rejections: int = 0
    is_close: bool = False


# Of a fit that begins, and of one that begins where a fitted model is: with an allowance for what
# is far off it would walk away from there, and ended after four evaluations where it had left by
# hundreds in log evidence.
AT_FIRST, FROM_A_FIT = Pace(), Pace(is_close=True)


class PatchFit:
    """A fit on its way.

    Attributes:
        here: coordinates, shape (k,).
        groups: all patches there.
        seen: those that are fitted, whitened.
        cost: half chi-square with that of the prior, and what being uneven costs.
        evaluations: of the model.
        rejections: steps on end that led nowhere.
        is_done: it came to rest, held to the full precision of the patches.
    """

    def __init__(
        self,
        evaluator: PatchEvaluator,
        start: FloatArray,
        part: Part,
        known: Sequence[PatchGroup] | None = None,
        pace: Pace = AT_FIRST,
    ) -> None:
        """Begin.

        Args:
            evaluator: of the model.
            start: coordinates, shape (k,).
            part: patches that are fitted.
            known: all patches there, where they were evaluated before.
            pace: of the fit that stopped there.

        Raises:
            NotSimulatedError: where the start cannot be simulated, or no patch shows the body.
        """
        parameters = evaluator.model.parameters
        self._evidence, self._part = evaluator, part
        self._bounds = parameters.bounds()
        self._limits = longest_steps(parameters)
        self._prior = prior_of(evaluator)
        self.here = np.clip(start, *self._bounds)
        self._was_here = known is None
        if known is None and pace.is_close:
            lead_to(evaluator.model, self.here)
        self.groups = self._groups(self.here) if known is None else list(known)
        self.evaluations, self.rejections, self.is_done = 1, pace.rejections, False
        self._damping, self._idle, self._least = pace.damping, 0, np.inf
        self._is_close = pace.is_close
        # A model that is far off is not held to the last tenth of a millimetre on its way.
        self._weigh(0.0 if pace.is_close else _SLACK * residual_size(self.groups, part))

    @property
    def pace(self) -> Pace:
        """How it gets on."""
        return Pace(self._damping, self.rejections, self._is_close)

    @property
    def is_exhausted(self) -> bool:
        """Tell whether too many steps on end led nowhere."""
        return self.rejections > _MAX_REJECTIONS

    def run(self, max_iterations: int, most_cost: float = np.inf) -> None:
        """Step until it comes to rest, or evaluations, patience or hope run out.

        Args:
            max_iterations: evaluations of the model at most.
            most_cost: at which the fit is of use.
        """
        while not self.is_done and self.evaluations < max_iterations and not self.is_exhausted:
            step, gain = self._step(self._damping)
            if self._is_lost(gain, most_cost):
                break
            if gain < self._least_gain or self._idle >= _MOST_IDLE or self._is_stuck(gain):
                self._come_to_rest()
            else:
                self._try(np.clip(self.here + step, *self._bounds))
        if self._slack:
            self._weigh(0.0)

    @property
    def _least_gain(self) -> float:
        """What a step must promise. While patches weigh less the fit is only on its way."""
        return _ROUGHNESS * self.cost if self._slack else self._small_gain

    @property
    def _small_gain(self) -> float:
        """What is not worth a step: where no noise alone is left, errors are larger."""
        return _SMALL_GAIN * max(1.0, 2.0 * _per_patch(self.cost, self.seen))

    def _is_stuck(self, gain: float) -> bool:
        """Tell whether steps led nowhere that promised no more than the roughness."""
        return self.rejections >= _REJECTED_ENOUGH and gain < _ROUGHNESS * self.cost

    def promise(self) -> float:
        """Return the gain of a whole step, of half chi-square with that of the prior."""
        return self._step(damping=0.0)[1]

    def _is_lost(self, gain: float, most_cost: float) -> bool:
        """Tell whether a fit will hardly be of use. On its way it costs less than at its end."""
        return self.evaluations >= _FEWEST_LOOKS and self.cost - HOPE * gain > most_cost

    def _weigh(self, slack: float) -> None:
        """Weigh the patches with another allowance for a model that is far off [m]."""
        self._slack = slack
        self.seen = whiten(self.groups, self._part, slack)
        self.cost = self._cost(self.seen, self.here)
        self._idle, self._least = 0, _per_patch(self.cost, self.seen)

    def _come_to_rest(self) -> None:
        if self._slack == 0.0:
            self.is_done = True
        else:
            self._weigh(0.0)
            self.rejections = 0

    def _groups(self, coordinates: FloatArray) -> list[PatchGroup]:
        """Return all patches at some coordinates.

        Raises:
            NotSimulatedError: as the evaluator says, or when none of them shows the body.
        """
        groups = self._evidence.groups(coordinates)
        if not any(len(chosen_patches(group, self._part)) for group in groups):
            raise NotSimulatedError('no patch shows the body where the model has it')
        return groups

    def _groups_from_here(self, trial: FloatArray) -> list[PatchGroup]:
        """Return all patches a step away, see `_groups`.

        A fit that goes on from where another process stood has not been there itself: where the
        step is not found at once, it goes there first.
        """
        try:
            return self._groups(trial)
        except NotSimulatedError:
            if self._was_here:
                raise
        self._was_here = True
        lead_to(self._evidence.model, self.here)
        return self._groups(trial)

    def _try(self, trial: FloatArray) -> None:
        self.evaluations += 1
        try:
            groups = self._groups_from_here(trial)
        except NotSimulatedError:
            self._reject()
            return
        seen = whiten(groups, self._part, self._slack)
        cost = self._cost(seen, trial)
        allowed = (1.0 + _ROUGHNESS) * _per_patch(self.cost, self.seen)
        if not _per_patch(cost, seen) < allowed:
            self._reject()
            return
        is_small = abs(cost - self.cost) < max(self._small_gain, _SMALL_FRACTION * cost)
        self.here, self.groups, self.seen, self.cost = trial, groups, seen, cost
        self._damping = 0.1 * self._damping if self._damping > _LEAST_DAMPING else 0.0
        self.rejections = 0
        self._count_idle()
        if is_small:
            self._come_to_rest()
            return
        smaller = _SLACK * residual_size(groups, self._part)
        if smaller < self._slack:
            idle = self._idle if smaller > _MUCH_LESS * self._slack else 0
            self._weigh(smaller)
            self._idle = idle

    def _reject(self) -> None:
        self._damping = max(_FIRST_DAMPING, 10.0 * self._damping)
        self.rejections += 1

    def _count_idle(self) -> None:
        progress = _PROGRESS if self._slack else _PROGRESS_AT_LAST
        now = _per_patch(self.cost, self.seen)
        if now < (1.0 - progress) * self._least:
            self._least, self._idle = now, 0
        else:
            self._idle += 1

    def _cost(self, seen: Whitened, coordinates: FloatArray) -> float:
        return 0.5 * (seen.chi_square + seen.volume) + self._prior.cost(coordinates)

    def _step(self, damping: float) -> tuple[FloatArray, float]:
        """Return the damped step among what no bound stops, and the gain that it promises."""
        whole = self.seen.equations().under(self._prior, self.here)
        step = gauss_newton_step(whole, self.here, *self._bounds, damping)
        gain = whole.gain(step)
        return boxed_step(whole, self.here, self._bounds, step, self._limits, damping), gain


def _per_patch(cost: float, seen: Whitened) -> float:
    return cost / max(len(seen), 1)
