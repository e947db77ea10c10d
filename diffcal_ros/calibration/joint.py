# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Several bodies fitted together, each in a scene of its own, with some parameters in common."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
import time

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.parameters.joint_parameters import (
    joint_parameters,
    JointParameters,
    Shared,
)
from diffcal_ros.calibration.parameters.longest_steps import longest_steps
from diffcal_ros.calibration.residuals.gap import Gap, measure_gap
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.results.result import CalibrationResult, IterationRecord
from diffcal_ros.calibration.results.result_at import result_at
from diffcal_ros.calibration.uncertainty.uncertainty import estimate_uncertainty
from diffcal_ros.errors import InputError, NotSimulatedError
from diffcal_ros.least_squares.levenberg_marquardt import Iteration, minimise, Minimum
from diffcal_ros.least_squares.normal_equations import Linearisation
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class JointObjective:
    """The sum of the members' robust costs."""

    def __init__(self, objectives: Sequence[RobustObjective], parameters: JointParameters) -> None:
        self._objectives = tuple(objectives)
        self._parameters = parameters

    @property
    def is_annealed(self) -> bool:
        """Tell whether every member's cost has its final form."""
        return all(objective.is_annealed for objective in self._objectives)

    def own(self, coordinates: FloatArray) -> list[tuple[RobustObjective, FloatArray]]:
        """Return each member's objective and coordinates."""
        return [
            (objective, coordinates[indices])
            for objective, indices in zip(self._objectives, self._parameters.indices, strict=True)
        ]

    def cost(self, coordinates: FloatArray) -> float:
        """Return half chi-square, priors included."""
        return sum(objective.cost(own) for objective, own in self.own(coordinates))

    def linearise(self, coordinates: FloatArray) -> Linearisation:
        """Expand the cost to second order."""
        whole = Linearisation.nothing(len(coordinates))
        for (objective, own), indices in zip(
            self.own(coordinates), self._parameters.indices, strict=True
        ):
            whole += objective.linearise(own).placed(indices, len(coordinates))
        return whole

    def anneal(self, coordinates: FloatArray) -> None:
        """Sharpen every member's cost after an accepted step."""
        for objective, own in self.own(coordinates):
            objective.anneal(own)

    def refine(self, coordinates: FloatArray) -> bool:
        """Sharpen the costs at a minimum; True when one changed."""
        refined = [objective.refine(own) for objective, own in self.own(coordinates)]
        return any(refined)

    def mesh_shift(self, coordinates: FloatArray, linear: Linearisation) -> FloatArray:
        """Return how far better meshes would shift the minimum, to first order, shape (k,)."""
        pull = np.zeros(len(coordinates))
        for (objective, own), indices in zip(
            self.own(coordinates), self._parameters.indices, strict=True
        ):
            pull[indices] += objective.mesh_pull(own)
        return linear.minimum_shift(pull, self._parameters.prior())

    def gaps(self, coordinates: FloatArray) -> list[Gap]:
        """Measure each member's gap."""
        return [objective.gap(own) for objective, own in self.own(coordinates)]

    def gap(self, coordinates: FloatArray) -> Gap:
        """Measure the gap over all members."""
        residuals, counted, truncations = [], [], []
        for objective, own in self.own(coordinates):
            for comparison in objective.comparisons(own):
                residuals.append(comparison.difference)
                counted.append(comparison.counted)
            truncations.append(objective.truncation)
        return measure_gap(residuals, counted, max(truncations))


class JointCalibration:
    """One fit of several bodies.

    Attributes:
        members: calibrations by name; after a fit they stand at its end.
        parameters: of all of them.
        coordinates: where the fit starts, and where it ended, shape (k,).
    """

    def __init__(self, members: Mapping[str, Calibration], shared: Shared) -> None:
        """Put calibrations together.

        Args:
            members: calibrations with the robust loss, by name.
            shared: for the name of each parameter in common, what it is called in which member.

        Raises:
            InputError: when they do not fit together.
        """
        objectives = [
            member.likelihood(f'the joint fit of {name}') for name, member in members.items()
        ]
        self.members = dict(members)
        self.parameters = joint_parameters(
            {name: member.parameters for name, member in members.items()}, shared
        )
        self.objective = JointObjective(objectives, self.parameters)
        self.coordinates = self.parameters.start()

    def go_to(self, coordinates: FloatArray) -> None:
        """Stand where the fit shall start, shape (k,)."""
        self.coordinates = coordinates

    def run(self) -> CalibrationResult:
        """Fit; the result's details hold each member's gap.

        Raises:
            InputError: when the start cannot be simulated or is out of view.
        """
        begun = time.perf_counter()
        history: list[IterationRecord] = []

        def report(iteration: Iteration) -> bool:
            history.append(
                IterationRecord(
                    number=iteration.number,
                    loss=iteration.cost,
                    gap=self.objective.gap(iteration.coordinates),
                    values=self.parameters.values(iteration.coordinates),
                    seconds=time.perf_counter() - begun,
                )
            )
            return True

        first = next(iter(self.members.values()))
        try:
            minimum = minimise(
                self.objective,
                self.coordinates,
                self.parameters.bounds(),
                longest_steps(self.parameters),
                max_iterations=first.settings.max_iterations or 30,
                on_iteration=report,
            )
        except NotSimulatedError as error:
            raise InputError(f'the start values cannot be simulated: {error}') from error
        self.coordinates = minimum.coordinates
        for member, indices in zip(self.members.values(), self.parameters.indices, strict=True):
            member.go_to(minimum.coordinates[indices])
        return self._result(minimum, history, time.perf_counter() - begun)

    def _result(
        self, minimum: Minimum, history: list[IterationRecord], seconds: float
    ) -> CalibrationResult:
        at = minimum.coordinates
        shift = np.zeros_like(at)
        if all(member.settings.with_mesh_error for member in self.members.values()):
            shift = self.objective.mesh_shift(at, minimum.linearisation)
        uncertainty = estimate_uncertainty(minimum.linearisation, self.parameters, shift)
        result = result_at(
            minimum,
            self.parameters,
            uncertainty,
            (history[0].gap, self.objective.gap(at)),
            history,
            loss='robust',
            seconds=seconds,
        )
        gaps = zip(self.members, self.objective.gaps(at), strict=True)
        return replace(result, details={'members': {name: own.as_dict() for name, own in gaps}})
