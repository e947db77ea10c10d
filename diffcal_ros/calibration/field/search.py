# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Gauss-Newton for a field and the ordinary parameters together, under one weight of roughness.

Weights are shares of how well the data see the pattern that they see best: under a share of 1
that pattern is drawn half way from smooth to what the data ask for, and finer ones much less.
"""

from dataclasses import dataclass, replace

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.field.krylov import krylov_space, KrylovSpace
from diffcal_ros.calibration.field.layout import FieldKind, tets_from_unknowns
from diffcal_ros.calibration.field.linear_system import FieldSystem
from diffcal_ros.calibration.field.merit import measure_merit, Merit
from diffcal_ros.calibration.field.smoothness import Smoothness
from diffcal_ros.calibration.parameters.longest_steps import longest_steps
from diffcal_ros.calibration.parameters.parameters import Kind
from diffcal_ros.calibration.residuals.residual_scales import spread
from diffcal_ros.errors import NotSimulatedError
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# No step may change a modulus by more than about a factor of two.
_LONGEST_STEP = 0.7
_MOST_HALVINGS = 5
# The cost is rough by this share, as pixels join and leave; a step may lose that of a view.
_ROUGHNESS = 0.03
_MOST_LOST = 0.15
# A round that gains less than this share of the cost ends a weight's search.
_SMALL_GAIN = 0.01


@dataclass(frozen=True)
class FieldState:
    """Where a search stands.

    Attributes:
        coordinates: of the ordinary parameters, shape (k,).
        unknowns: of the field, shape (n,).
    """

    coordinates: FloatArray
    unknowns: FloatArray


@dataclass(frozen=True)
class Posterior:
    """What is known at the end, under the roughness as a prior.

    Attributes:
        log_std: of each tetrahedron's log modulus, shape (T,).
        covariance: of the ordinary coordinates, shape (k, k).
    """

    log_std: FloatArray
    covariance: FloatArray


class FieldSearch:
    """The search; its state and the field of its objective's model go together.

    Attributes:
        calibration: from whose end it starts.
        objective: with the field in its model's scene.
        state: where the search stands.
        unknown_count: of the field.
    """

    def __init__(self, calibration: Calibration, kind: FieldKind) -> None:
        """Start where a calibration ended, without a field.

        Args:
            calibration: with the robust loss.
            kind: what the field is made of.
        """
        self.calibration, self.objective = calibration, calibration.likelihood('a field')
        mesh = calibration.scene.mesh
        self._spread = tets_from_unknowns(mesh, kind)
        self._smoothness = Smoothness(mesh, self._spread, _fitted_regions(calibration))
        self.unknown_count = int(self._spread.shape[1])
        self._unit: float | None = None
        self.state = FieldState(calibration.coordinates.copy(), np.zeros(self.unknown_count))
        self.go_to(self.state)
        self._first = measure_merit(self.objective, self.state.coordinates)

    def go_to(self, state: FieldState) -> None:
        """Put search and model there."""
        self.state = state
        scene, model = self.calibration.scene, self.objective.model
        stated = 1.0 if scene.relative_modulus is None else scene.relative_modulus
        field = stated * np.exp(self._spread @ state.unknowns)
        scene = replace(scene, relative_modulus=field)
        self.objective = self.objective.of(model.with_parameters(scene, model.parameters))

    def fix_unit(self, fraction: float) -> None:
        """Keep the weights' unit from now on; the cost must have its final form."""
        self._unit = self._expand(fraction)[1].strongest

    def refine(self) -> None:
        """Weigh by the noise and correlation that the residuals show."""
        if self.objective.refine(self.state.coordinates):
            self._unit = None

    def descend(self, fraction: float, most_rounds: int) -> int:
        """Minimise under a weight; return the rounds."""
        for number in range(most_rounds):
            if self._round(fraction) < _SMALL_GAIN:
                return number + 1
        return most_rounds

    def misfit(self) -> float:
        """Return chi-square of data and ordinary priors, see `merit`."""
        return 2.0 * self._merit().cost(self._first)

    def roughness(self) -> float:
        """Return the field's roughness."""
        return self._smoothness.roughness(self.state.unknowns)

    def residual_spread(self) -> float:
        """Return the robust standard deviation of the depth residuals [m]."""
        compared = self.objective.comparisons(self.state.coordinates)
        return max(spread(comparison.depth) for comparison in compared)

    def posterior(self, fraction: float) -> Posterior:
        """Return the errors at the present state, taken as a minimum."""
        system, space = self._expand(fraction)
        weight = fraction * (self._unit or space.strongest)
        patterns = space.ritz_vectors()
        fractions = space.values / (space.values + weight)
        mixed, along = system.mixed, patterns @ system.mixed
        # Of the field with each ordinary parameter's part in it.
        carried = (self._smoothness.solve(mixed) - (patterns.T * fractions) @ along) / weight
        covariance = system.covariance(mixed.T @ carried)
        seen = (self._spread @ patterns.T) ** 2 @ fractions
        field = (self._smoothness.variances() - seen) / weight
        shared = self._spread @ system.against_field(carried).T
        return Posterior(self._log_std(field, shared, covariance), covariance)

    def _log_std(
        self, field: FloatArray, shared: FloatArray, covariance: FloatArray
    ) -> FloatArray:
        """Put the errors of the field and of the moduli that it is added to together."""
        variances = field.copy()
        regions = self.calibration.scene.regions
        for index, parameter in enumerate(self.calibration.parameters):
            if parameter.kind is Kind.YOUNGS_MODULUS:
                tets = regions[parameter.target].tets
                variances[tets] += covariance[index, index] + 2.0 * shared[tets, index]
        return np.sqrt(np.maximum(variances, 0.0))

    def _expand(self, fraction: float) -> tuple[FieldSystem, KrylovSpace]:
        """Linearise here and build the space for weights down to a share."""
        state = self.state
        system = FieldSystem(self.objective, state.coordinates, self._spread)
        right_side = system.reduced_negative_gradient() + system.known(state.unknowns)
        return system, krylov_space(system.known, self._smoothness, right_side, fraction)

    def _round(self, fraction: float) -> float:
        """Take one step; return by which share the cost fell."""
        system, space = self._expand(fraction)
        weight = fraction * (self._unit or space.strongest)
        start, here = self.state, self._merit()
        before = here.cost(self._first) + 0.5 * weight * self.roughness()
        step = space.solve(weight) - start.unknowns
        own = system.follow(step)
        length = min(1.0, _LONGEST_STEP / max(float(np.abs(self._spread @ step).max()), 1e-12))
        for _ in range(_MOST_HALVINGS):
            self._try(start, length * step, length * own)
            after = self._total(weight, here)
            if after < before * (1.0 + _ROUGHNESS):
                return 1.0 - after / before
            length *= 0.5
        self.go_to(start)
        return 0.0

    def _try(self, start: FieldState, step: FloatArray, own: FloatArray) -> None:
        longest = longest_steps(self.calibration.parameters)
        moved = start.coordinates + np.clip(own, -longest, longest)
        coordinates = np.clip(moved, *self.calibration.parameters.bounds())
        self.go_to(FieldState(coordinates, start.unknowns + step))

    def _merit(self) -> Merit:
        return measure_merit(self.objective, self.state.coordinates)

    def _total(self, weight: float, start: Merit) -> float:
        """Return cost and penalty here, infinite where the model cannot follow or loses sight."""
        try:
            merit = self._merit()
        except NotSimulatedError:
            return float('inf')
        if merit.lost(start) > _MOST_LOST:
            return float('inf')
        return merit.cost(self._first) + 0.5 * weight * self.roughness()


def _fitted_regions(calibration: Calibration) -> list[NDArray[np.int32]]:
    """Return the tetrahedra of each region whose modulus is fitted."""
    return [
        calibration.scene.regions[parameter.target].tets
        for parameter in calibration.parameters
        if parameter.kind is Kind.YOUNGS_MODULUS
    ]
