# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Cost, gradient and curvature of the robust comparison over all views, with priors.

Costs are in units of half a chi-square of *independent* residuals: a residual that is worth only
1/n of an independent one, because its neighbours say the same, weighs 1/n.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diffcal_ros.calibration.forward.effect_model import SensorModel
from diffcal_ros.calibration.forward.forward_model import ForwardModel, View
from diffcal_ros.calibration.parameters.parameters import Kind
from diffcal_ros.calibration.residuals.correlation import correlation_lengths
from diffcal_ros.calibration.residuals.gap import Gap, measure_gap
from diffcal_ros.calibration.residuals.measured_body import MeasuredShares
from diffcal_ros.calibration.residuals.residual_scales import (
    FINAL_WIDTH,
    Scale,
    Scales,
    spread,
    WIDE_REACH,
)
from diffcal_ros.calibration.residuals.robust_residual import (
    Comparison,
    make_comparers,
    Reach,
    Residuals,
    ViewComparer,
)
from diffcal_ros.calibration.residuals.time_correlation import (
    part_means,
    repeated_frames,
    surface_parts,
)
from diffcal_ros.least_squares.linearisation import Linearisation
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_FINEST_NOISE = 0.0002
# Of a residual's weight, this share at least stays in the curvature.
_LEAST_CURVATURE = 0.5
_EDGE_REACH = 30
# Scales under which every state of every fit is measured alike.
_YARDSTICK = Scales(Scale(FINAL_WIDTH, FINAL_WIDTH), Scale(FINAL_WIDTH, FINAL_WIDTH))


@dataclass(frozen=True)
class _Group:
    """Residuals of several views."""

    depth: Residuals
    edge: Residuals

    @classmethod
    def of(cls, compared: Sequence[Comparison]) -> '_Group':
        """Put views together."""
        return cls(_joined([c.depth for c in compared]), _joined([c.edge for c in compared]))


class RobustObjective:
    """The default objective of a calibration."""

    def __init__(
        self,
        model: ForwardModel,
        *,
        device: str = 'cpu',
        comparers: list[ViewComparer] | None = None,
    ) -> None:
        """Prepare the comparison of a model's views.

        Args:
            model: simulates and traces.
            device: Warp device.
            comparers: of a model with the same bodies and observations; default: new ones.
        """
        self.model = model
        self.truncation = model.scene.masks.truncation
        self.comparers = comparers or make_comparers(model, device=device)
        self.scales = Scales()
        self._prior_mean, self._prior_precision = model.parameters.prior()
        self._bias_places = model.parameters.find(Kind.EDGE_BIAS)
        self._effect_places = model.parameters.find(Kind.EFFECT)

    @property
    def is_sharp(self) -> bool:
        """Tell whether the robust widths have shrunk to the end."""
        return self.scales.are_final

    def comparisons(self, coordinates: FloatArray) -> list[Comparison]:
        """Compare every view with its observation."""
        views, sensor = self.model.views(coordinates), self.model.sensor(coordinates)
        return [self._compare(number, view, sensor) for number, view in enumerate(views)]

    def _compare(self, number: int, view: View, sensor: SensorModel) -> Comparison:
        return self.comparers[number].compare(view, self.scales.reach, sensor)

    def counted(self, number: int, view: View) -> NDArray[np.bool_]:
        """Tell which pixels of a view's window are unmasked body."""
        return self.comparers[number].pixels(view)[0]

    def read_depth(self, number: int, view: View, coordinates: FloatArray) -> FloatArray:
        """Return the depth in a view's window that the sensor would read [m], NaN elsewhere."""
        return self.comparers[number].read(view.trace, self.model.sensor(coordinates))

    def cost(self, coordinates: FloatArray) -> float:
        """Return half chi-square, priors included."""
        return self._cost(self.comparisons(coordinates), coordinates)

    def gap(self, coordinates: FloatArray) -> Gap:
        """Measure the gap at some coordinates, in both directions."""
        return self._gap(*self._compared_both_ways(coordinates))

    def _gap(self, compared: list[Comparison], shares: list[MeasuredShares]) -> Gap:
        return measure_gap(
            [c.difference for c in compared],
            [c.counted for c in compared],
            self.truncation,
            shares,
        )

    def _compared_both_ways(
        self, coordinates: FloatArray
    ) -> tuple[list[Comparison], list[MeasuredShares]]:
        """Compare every view, and look beside it for what of the measured body it leaves."""
        views, sensor = self.model.views(coordinates), self.model.sensor(coordinates)
        compared, shares = [], []
        for number, view in enumerate(views):
            compared.append(self._compare(number, view, sensor))
            shares.append(self.comparers[number].measured_shares(view, sensor))
        return compared, shares

    def standing(self, coordinates: FloatArray) -> tuple[Gap, float]:
        """Return the gap, and the misfit to the data under scales that never change.

        The objective's own cost is in units of a noise that is estimated as the fit goes on, and
        weighs priors against it, so it jumps from step to step; this one tells a person whether
        the data are met better.
        """
        scales, self.scales = self.scales, _YARDSTICK
        try:
            compared, shares = self._compared_both_ways(coordinates)
            misfit = self._data_misfit(compared, shares, coordinates)
        finally:
            self.scales = scales
        return self._gap(compared, shares), misfit

    def misfit(self, coordinates: FloatArray) -> float:
        """Return the cost, and that of the measured body which the model leaves unexplained.

        The figure by which fits from other starts are compared, under the same scales: half
        chi-square, priors included. A measured pixel that nothing covers costs as much as a
        rendered one that was not measured.
        """
        both = self._compared_both_ways(coordinates)
        return self._data_misfit(*both, coordinates) + self._prior_cost(coordinates)

    def _data_misfit(
        self, compared: list[Comparison], shares: list[MeasuredShares], coordinates: FloatArray
    ) -> float:
        depth = self.scales.depth
        square = depth.width**2
        worst = 0.5 * square * np.log1p(self.scales.reach.depth**2 / square)
        beside = sum(share.unexplained for share in shares)
        left = beside * worst / (depth.noise**2 * depth.patch(2))
        cost = self._cost(compared, coordinates) - self._prior_cost(coordinates)
        return float(cost + left)

    def linearise(self, coordinates: FloatArray) -> Linearisation:
        """Expand the cost around some coordinates."""
        tangents = self.model.tangents(coordinates)
        views, sensor = self.model.views(coordinates), self.model.sensor(coordinates)
        count = len(coordinates)
        descent = np.zeros(count)
        curvature, information, scatter = (np.zeros((count, count)) for _ in range(3))
        compared = []
        for number, (view, tangent) in enumerate(zip(views, tangents, strict=True)):
            comparison = self._compare(number, view, sensor)
            compared.append(comparison)
            blocks = self.blocks(number, comparison, view, tangent, coordinates)
            for (residuals, jacobian, scale), dimension in zip(blocks, (2, 1), strict=True):
                weights = robust_weights(residuals, scale, dimension)
                pull = weights.gradient * residuals.values
                descent += jacobian.T @ pull
                curvature += _squared(jacobian, weights.curvature)
                information += _squared(jacobian, weights.true_curvature)
                patch = scale.patch(dimension) / np.maximum(residuals.weights, 1e-12)
                scatter += _squared(jacobian, pull**2 * patch)
        offset = coordinates - self._prior_mean
        return Linearisation(
            cost=self._cost(compared, coordinates),
            descent=descent - self._prior_precision @ offset,
            curvature=curvature + self._prior_precision,
            information=information,
            scatter=scatter,
        )

    def mesh_shift(self, coordinates: FloatArray, *, solver: str = 'auto') -> FloatArray:
        """Return how far a better mesh would shift the minimum, to first order, shape (k,)."""
        stiff = self.linearise(coordinates).information + self._prior_precision
        pull = self.mesh_pull(coordinates, solver=solver)
        shift, *_ = np.linalg.lstsq(stiff, -pull, rcond=1e-10)
        return np.asarray(shift, dtype=np.float64)

    def mesh_pull(self, coordinates: FloatArray, *, solver: str = 'auto') -> FloatArray:
        """Return how a better mesh would change the gradient, to first order, shape (k,)."""
        moves = self.model.mesh_moves(coordinates, solver=solver)
        tangents = self.model.tangents(coordinates)
        views, sensor = self.model.views(coordinates), self.model.sensor(coordinates)
        pull = np.zeros(len(coordinates))
        for number, (view, tangent, move) in enumerate(zip(views, tangents, moves, strict=True)):
            comparison = self._compare(number, view, sensor)
            # One more column: the mesh error as if it were a parameter of size one.
            wide = np.concatenate([tangent, move[None]])
            blocks = self.blocks(number, comparison, view, wide, coordinates)
            for (residuals, jacobian, scale), dimension in zip(blocks, (2, 1), strict=True):
                weights = robust_weights(residuals, scale, dimension)
                pull += (jacobian[:, :-1] * weights.true_curvature[:, None]).T @ jacobian[:, -1]
        return pull

    def narrow(self, coordinates: FloatArray) -> None:
        """Let the robust widths follow the residuals down to their final value."""
        if self.scales.are_final:
            return
        groups = self._groups(self.comparisons(coordinates), coordinates)
        depth = self.scales.depth.narrowed([group.depth for group in groups])
        edge = self.scales.edge.narrowed([group.edge for group in groups])
        reach = WIDE_REACH
        if max(depth.width, edge.width) < self.truncation / 2.0:
            reach = Reach(self.truncation, 1.5 * self.truncation, _EDGE_REACH)
        self.scales = Scales(depth, edge, reach)

    def refine(self, coordinates: FloatArray) -> bool:
        """Weigh by the noise and correlation that the residuals show, where they are finer.

        Returns:
            True when the scales changed, so that the fit should go on.
        """
        compared = self.comparisons(coordinates)
        finer: dict[str, Scale] = {}
        for name, residuals in zip(
            ('depth', 'edge'), self._gathered(compared, coordinates), strict=True
        ):
            noise = max(spread(residuals), _FINEST_NOISE)
            scale: Scale = getattr(self.scales, name)
            if len(residuals.values) == 0 or noise > 0.7 * scale.noise:
                continue
            length = self._correlation(compared, coordinates, name, 3.0 * noise)
            repeats = self._repeats(coordinates, name, 3.0 * noise)
            finer[name] = scale.refined(noise, length, repeats)
        if not finer:
            return False
        self.scales = Scales(
            depth=finer.get('depth', self.scales.depth),
            edge=finer.get('edge', self.scales.edge),
            reach=self.scales.reach,
        )
        return True

    def _correlation(
        self, compared: list[Comparison], coordinates: FloatArray, name: str, limit: float
    ) -> float:
        """Return the longest correlation length over the views [px]."""
        lengths = [1.0]
        for comparison in compared:
            residuals: Residuals = getattr(self.unbiased(comparison, coordinates), name)
            if len(residuals.values) == 0:
                continue
            low = residuals.pixels.min(axis=0)
            columns, rows = (residuals.pixels - low).T
            shape = (int(rows.max()) + 1, int(columns.max()) + 1)
            image, mask = np.zeros(shape), np.zeros(shape, dtype=bool)
            image[rows, columns] = np.clip(residuals.values, -limit, limit)
            mask[rows, columns] = True
            square, line = correlation_lengths(image, mask)
            lengths.append(square if name == 'depth' else line)
        return max(lengths)

    def _repeats(self, coordinates: FloatArray, name: str, limit: float) -> float:
        """Return how many frames of a recording say the same; 1 without a motion."""
        recordings: dict[int, list[tuple[float, FloatArray]]] = {}
        sensor = self.model.sensor(coordinates)
        for number, view in enumerate(self.model.views(coordinates)):
            instant = self.model.observations[number].instant
            if instant is None:
                continue
            comparison = self.unbiased(self._compare(number, view, sensor), coordinates)
            residuals: Residuals = getattr(comparison, name)
            parts, count = surface_parts(view.trace, residuals, name)
            values = np.clip(residuals.values, -limit, limit)
            means = part_means(values, parts, count)
            recordings.setdefault(instant.recording, []).append((instant.time, means))
        alike = [
            repeated_frames([means for _, means in sorted(frames, key=lambda frame: frame[0])])
            for frames in recordings.values()
        ]
        return max(alike, default=1.0)

    def _groups(self, compared: Sequence[Comparison], coordinates: FloatArray) -> list[_Group]:
        """Put residuals together: of all bodies at rest, and of each frame of a motion."""
        unbiased = [self.unbiased(comparison, coordinates) for comparison in compared]
        moves = [observation.instant is not None for observation in self.model.observations]
        still = [c for c, is_moving in zip(unbiased, moves, strict=True) if not is_moving]
        groups = [[c] for c, is_moving in zip(unbiased, moves, strict=True) if is_moving]
        return [_Group.of(group) for group in ([still, *groups] if still else groups)]

    def _gathered(
        self, compared: Sequence[Comparison], coordinates: FloatArray
    ) -> tuple[Residuals, Residuals]:
        """Put all views' residuals of each kind together."""
        both = _Group.of([self.unbiased(comparison, coordinates) for comparison in compared])
        return both.depth, both.edge

    def unbiased(self, comparison: Comparison, coordinates: FloatArray) -> Comparison:
        """Take the sensor's edge bias off the edge residuals."""
        bias = float(sum(coordinates[place] for place in self._bias_places))
        values = comparison.edge.values - bias * comparison.edge_scale
        return replace(comparison, edge=replace(comparison.edge, values=values))

    def blocks(
        self,
        number: int,
        comparison: Comparison,
        view: View,
        tangent: FloatArray,
        coordinates: FloatArray,
    ) -> list[tuple[Residuals, FloatArray, Scale]]:
        """Return residuals, their Jacobian and scale, for both kinds.

        Args:
            number: of the view.
            comparison: of it.
            view: the rendered body.
            tangent: how its points follow the coordinates, and what else may move them,
                shape (k, N, 3) with at least as many rows as coordinates.
            coordinates: shape (c,).

        Returns:
            For depth and edge: residuals, Jacobian of the rendered side, shape (M, k), scale.
        """
        unbiased = self.unbiased(comparison, coordinates)
        by_depth = view.trace.push_depth(unbiased.depth.places, tangent)
        by_edge = view.trace.push_outline(unbiased.edge.places, tangent)
        by_edge *= comparison.edge_scale[:, None]
        for place in self._bias_places:
            by_edge[:, place] = comparison.edge_scale
        columns = self.comparers[number].sensor_columns(view, unbiased.depth.places)
        for place in self._effect_places:
            column = columns.get(self.model.parameters.names[place])
            if column is not None:
                by_depth[:, place] = column
        return [
            (unbiased.depth, by_depth, self.scales.depth),
            (unbiased.edge, by_edge, self.scales.edge),
        ]

    def _cost(self, compared: list[Comparison], coordinates: FloatArray) -> float:
        total = 0.0
        for comparison in compared:
            unbiased = self.unbiased(comparison, coordinates)
            scales, reach = self.scales, self.scales.reach
            total += robust_cost(unbiased.depth, scales.depth, reach.depth, 2)
            total += robust_cost(unbiased.edge, scales.edge, reach.edge_depth, 1)
        return total + self._prior_cost(coordinates)

    def _prior_cost(self, coordinates: FloatArray) -> float:
        offset = coordinates - self._prior_mean
        return 0.5 * float(offset @ self._prior_precision @ offset)


def robust_cost(residuals: Residuals, scale: Scale, limit: float, dimension: int) -> float:
    """Return Cauchy's cost; what was not found counts as far as was looked.

    Args:
        residuals: with their shares.
        scale: width, noise and correlation.
        limit: how far was looked [m].
        dimension: 2 for pixels, 1 for pieces of outline.
    """
    square = scale.width**2
    costs = 0.5 * square * np.log1p(residuals.values**2 / square)
    worst = 0.5 * square * np.log1p(limit**2 / square)
    total = float(residuals.weights @ costs) + residuals.missing * worst
    return total / (scale.noise**2 * scale.patch(dimension))


@dataclass(frozen=True)
class RobustWeights:
    """Weights of residuals [1/m^2], shape (M,) each.

    Attributes:
        gradient: times a residual, its pull.
        curvature: for steps; never below a share of the former.
        true_curvature: second derivative of the cost where it is positive, else 0.
    """

    gradient: FloatArray
    curvature: FloatArray
    true_curvature: FloatArray


def robust_weights(residuals: Residuals, scale: Scale, dimension: int) -> RobustWeights:
    """Weigh residuals by Cauchy's cost.

    Args:
        residuals: with their shares.
        scale: width, noise and correlation.
        dimension: 2 for pixels, 1 for pieces of outline.
    """
    ratio = (residuals.values / scale.width) ** 2
    weight = residuals.weights / (scale.noise**2 * scale.patch(dimension)) / (1.0 + ratio)
    # The weights alone overstate the curvature, which falls below zero in the tails, and make
    # every step too short; the true one alone makes steps overshoot.
    true = weight * np.maximum((1.0 - ratio) / (1.0 + ratio), 0.0)
    return RobustWeights(weight, np.maximum(true, _LEAST_CURVATURE * weight), true)


def _squared(jacobian: FloatArray, weights: FloatArray) -> FloatArray:
    return (jacobian * weights[:, None]).T @ jacobian


def _joined(parts: list[Residuals]) -> Residuals:
    return Residuals(
        values=np.concatenate([part.values for part in parts]),
        weights=np.concatenate([part.weights for part in parts]),
        pixels=np.concatenate([part.pixels for part in parts]),
        places=np.concatenate([part.places for part in parts]),
        missing=sum(part.missing for part in parts),
    )
