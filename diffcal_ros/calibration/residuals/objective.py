# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Cost, gradient and curvature of the robust comparison over all views, with priors."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.forward.led_there import lead_to
from diffcal_ros.calibration.forward.solution import View
from diffcal_ros.calibration.parameters.parameters import Kind, ParameterSet
from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.calibration.residuals.residual_scales import FINAL_WIDTH, Scale, Scales
from diffcal_ros.calibration.residuals.robust_loss import robust_channel, robust_cost
from diffcal_ros.calibration.residuals.robust_residual import (
    Comparison,
    make_comparers,
    Residuals,
    ViewComparer,
)
from diffcal_ros.calibration.residuals.scale_estimate import annealed, refined, SeenView
from diffcal_ros.calibration.residuals.two_way_comparison import Misfit, TwoWayComparison
from diffcal_ros.depth.trace import Trace
from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.least_squares.normal_equations import Linearisation, Prior
from diffcal_ros.least_squares.residual_channel import linearise, ResidualChannel
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Scales under which every state of every fit is measured alike.
_YARDSTICK = Scales(Scale(FINAL_WIDTH, FINAL_WIDTH), Scale(FINAL_WIDTH, FINAL_WIDTH))


class RobustObjective:
    """The default objective of a calibration."""

    def __init__(
        self,
        model: ForwardModel,
        *,
        device: str = 'cpu',
        comparers: list[ViewComparer] | None = None,
        scales: Scales | None = None,
    ) -> None:
        """Prepare the comparison of a model's views.

        Args:
            model: simulates and traces.
            device: Warp device.
            comparers: of a model with the same bodies and observations; default: new ones.
            scales: by which residuals are weighed; default: wide ones, to be annealed.
        """
        self.model = model
        self.truncation = model.scene.masks.truncation
        self.comparers = comparers or make_comparers(model, device=device)
        self.scales = scales or Scales()
        self._priors: dict[float, Prior] = {}
        self._bias_indices = model.parameters.find(Kind.EDGE_BIAS)
        self._effect_indices = model.parameters.find(Kind.EFFECT)

    def of(self, model: ForwardModel) -> 'RobustObjective':
        """Return the same comparison of another model of the same bodies and observations."""
        return RobustObjective(model, comparers=self.comparers, scales=self.scales)

    def under(self, scales: Scales) -> 'RobustObjective':
        """Return the same comparison by other scales."""
        return RobustObjective(self.model, comparers=self.comparers, scales=scales)

    @property
    def parameters(self) -> ParameterSet:
        """What is fitted."""
        return self.model.parameters

    @property
    def is_annealed(self) -> bool:
        """Tell whether the robust widths have shrunk to the end."""
        return self.scales.are_final

    def comparisons(self, coordinates: FloatArray) -> list[Comparison]:
        """Compare every view with its observation."""
        return [
            self.comparers[number].compare(
                view, self.scales.reach, self.model.sensor(coordinates, number)
            )
            for number, view in enumerate(self.model.views(coordinates))
        ]

    def counted(self, number: int, view: View) -> NDArray[np.bool_]:
        """Tell which pixels of a view's window are unmasked body."""
        return self.comparers[number].pixels(view)[0]

    def read_depth(self, number: int, view: View, coordinates: FloatArray) -> FloatArray:
        """Return the depth in a view's window that the sensor would read [m], NaN elsewhere."""
        return self.comparers[number].read(view.trace, self.model.sensor(coordinates, number))

    def cost(self, coordinates: FloatArray) -> float:
        """Return half chi-square, priors included."""
        compared = (self.unbiased(one, coordinates) for one in self.comparisons(coordinates))
        data = sum(robust_cost(own, self.scales) for one in compared for own in one.both)
        return data + self._prior(self.scales).cost(coordinates)

    def gap(self, coordinates: FloatArray) -> Gap:
        """Measure the gap at some coordinates, in both directions."""
        return self._both_ways(coordinates, self.scales).gap(self.truncation)

    def standing(self, coordinates: FloatArray) -> tuple[Gap, float]:
        """Return the gap, and the misfit to the data under scales that never change.

        The objective's own cost is in units of a noise that is estimated as the fit goes on, and
        weighs priors against it, so it jumps from step to step; this one tells a person whether
        the data are met better.
        """
        both = self._both_ways(coordinates, _YARDSTICK)
        return both.gap(self.truncation), both.misfit(_YARDSTICK)

    def misfit(self, coordinates: FloatArray) -> Misfit:
        """Return the figures by which fits from other starts are compared, under the same scales.

        Args:
            coordinates: shape (k,).
        """
        return self.gap_and_misfit(coordinates)[1]

    def misfit_at_start(self, coordinates: FloatArray) -> Misfit:
        """Return the same under scales that never change, before any fit."""
        both = self._both_ways(coordinates, _YARDSTICK)
        return self._misfit_of(both, coordinates, _YARDSTICK)

    def gap_and_misfit(self, coordinates: FloatArray) -> tuple[Gap, Misfit]:
        """Return `gap` and `misfit` of the same comparison.

        Where a fit came to by small steps a body may not be found at once: it is led there.
        """
        lead_to(self.model, coordinates)
        both = self._both_ways(coordinates, self.scales)
        return both.gap(self.truncation), self._misfit_of(both, coordinates, self.scales)

    def _misfit_of(
        self, both: TwoWayComparison, coordinates: FloatArray, scales: Scales
    ) -> Misfit:
        prior = self._prior(scales).cost(coordinates)
        return Misfit(prior - both.gain(scales), prior + both.misfit(scales))

    def _both_ways(self, coordinates: FloatArray, scales: Scales) -> TwoWayComparison:
        """Compare every view, and look beside it for what of the measured body it leaves."""
        compared, fractions = [], []
        for number, view in enumerate(self.model.views(coordinates)):
            comparer, sensor = self.comparers[number], self.model.sensor(coordinates, number)
            comparison = comparer.compare(view, scales.reach, sensor)
            compared.append(self.unbiased(comparison, coordinates))
            fractions.append(comparer.measured_fractions(view, sensor))
        return TwoWayComparison(compared, fractions)

    def linearise(self, coordinates: FloatArray) -> Linearisation:
        """Expand the cost around some coordinates."""
        data = linearise(self._channels(coordinates), len(coordinates))
        return data.under(self._prior(self.scales), coordinates)

    def mesh_shift(self, coordinates: FloatArray, *, solver: str = 'auto') -> FloatArray:
        """Return how far a better mesh would shift the minimum, to first order, shape (k,)."""
        linear = self.linearise(coordinates)
        pull = self.mesh_pull(coordinates, solver=solver)
        return linear.minimum_shift(pull, self._prior(self.scales))

    def mesh_pull(self, coordinates: FloatArray, *, solver: str = 'auto') -> FloatArray:
        """Return how a better mesh would change the gradient, to first order, shape (k,)."""
        # One more column: the mesh error as if it were a parameter of size one.
        moves = self.model.mesh_moves(coordinates, solver=solver)
        wide = linearise(self._channels(coordinates, moves), len(coordinates) + 1)
        return wide.information[:-1, -1]

    def _channels(
        self, coordinates: FloatArray, moves: Sequence[FloatArray] | None = None
    ) -> Iterator[ResidualChannel]:
        """Yield depths and edges of every view in turn.

        Args:
            coordinates: shape (k,).
            moves: one more way that the points of each view may move, shape (N, 3) each.
        """
        tangents = self.model.tangents(coordinates)
        for number, view in enumerate(self.model.views(coordinates)):
            tangent, sensor = tangents[number], self.model.sensor(coordinates, number)
            wide = tangent if moves is None else np.concatenate([tangent, moves[number][None]])
            comparison = self.comparers[number].compare(view, self.scales.reach, sensor)
            for residuals, jacobian in self.with_jacobians(
                number, comparison, view, wide, coordinates
            ):
                yield robust_channel(residuals, jacobian, self.scales)

    def anneal(self, coordinates: FloatArray) -> None:
        """Let the robust widths follow the residuals down to their final value."""
        if not self.scales.are_final:
            self.scales = annealed(self.scales, self._seen(coordinates), self.truncation)

    def refine(self, coordinates: FloatArray) -> bool:
        """Weigh by the noise and correlation that the residuals show, where they are finer.

        Returns:
            True when the scales changed, so that the fit should go on.
        """
        before, self.scales = self.scales, refined(self.scales, self._seen(coordinates))
        return self.scales is not before

    def _prior(self, scales: Scales) -> Prior:
        known = self._priors.get(scales.leeway)
        if known is None:
            known = self._priors[scales.leeway] = self.model.parameters.prior(scales.leeway)
        return known

    def _seen(self, coordinates: FloatArray) -> list[SeenView]:
        views, seen = self.model.views(coordinates), self.model.observations
        compared = self.comparisons(coordinates)
        return [
            SeenView(view, one.instant, self.unbiased(comparison, coordinates))
            for view, one, comparison in zip(views, seen, compared, strict=True)
        ]

    def unbiased(self, comparison: Comparison, coordinates: FloatArray) -> Comparison:
        """Take the sensor's edge bias off the edge residuals."""
        bias = float(sum(coordinates[index] for index in self._bias_indices))
        values = comparison.edge.values - bias * comparison.edge_scale
        return replace(comparison, edge=replace(comparison.edge, values=values))

    def with_jacobians(
        self,
        number: int,
        comparison: Comparison,
        view: View,
        tangent: FloatArray,
        coordinates: FloatArray,
    ) -> tuple[tuple[Residuals, FloatArray], tuple[Residuals, FloatArray]]:
        """Return depths and edges without the sensor's bias, each with their Jacobian.

        Args:
            number: of the view.
            comparison: of it.
            view: the rendered body.
            tangent: how its points follow the coordinates, and what else may move them,
                shape (k, N, 3) with at least as many rows as coordinates.
            coordinates: shape (c,).

        Returns:
            For depth and edge: M residuals, and the Jacobian of the rendered side, shape (M, k).
        """
        unbiased = self.unbiased(comparison, coordinates)
        by_depth, by_edge = _pushed(view.trace, unbiased, tangent)
        by_edge *= comparison.edge_scale[:, None]
        for index in self._bias_indices:
            by_edge[:, index] = comparison.edge_scale
        if not self._effect_indices:
            return (unbiased.depth, by_depth), (unbiased.edge, by_edge)
        seen = self.comparers[number].seen(view, unbiased.depth.indices)
        observation = self.model.observations[number]
        for index in self._effect_indices:
            own = self.parameters.parameters[index]
            column = EFFECTS[own.effect].depth_error_mode(own.amplitude, seen)
            weight = own.weight_in(observation.setup_index, observation.time)
            if column is not None and weight:
                by_depth[:, index] = weight * column
        return (unbiased.depth, by_depth), (unbiased.edge, by_edge)


def _pushed(
    trace: Trace, comparison: Comparison, tangent: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Push tangents, shape (k, N, 3), to the depths and edges of a comparison, (M, k) each.

    Most parameters of many poses are of other cameras, and move nothing in this one.
    """
    moving = np.flatnonzero(tangent.any(axis=(1, 2)))
    depths, edges = comparison.depth.indices, comparison.edge.indices
    by_depth, by_edge = (np.zeros((len(own), len(tangent))) for own in (depths, edges))
    by_depth[:, moving] = trace.push_depth(depths, tangent[moving])
    by_edge[:, moving] = trace.push_outline(edges, tangent[moving])
    return by_depth, by_edge
