# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The robust cost to second order around a field: exact products with thousands of unknowns.

The curvature is never built. A field's direction is pushed through the equilibrium and the image
(one solve), weighed, and pulled back by the adjoint (one solve). The ordinary parameters, few and
dense, are eliminated: what is left is what the data know of the field whatever those are.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.calibration.forward.solution import View
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.residuals.robust_loss import robust_channel
from diffcal_ros.calibration.residuals.robust_residual import Comparison
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.least_squares.residual_channel import equations, ResidualChannel
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]


@dataclass(frozen=True)
class _Seen:
    """One view's residuals, depth first and then edges.

    Attributes:
        view: the rendered body.
        pixels: places of the depth residuals, shape (M,).
        segments: places of the edge residuals, shape (E,).
        edge_scale: metres at the body per pixel, shape (E,).
        channels: both, with the derivative by the ordinary parameters.
    """

    view: View
    pixels: IntArray
    segments: IntArray
    edge_scale: FloatArray
    channels: tuple[ResidualChannel, ...]

    @property
    def pull(self) -> FloatArray:
        """Minus the derivative of the cost by each rendered value [1/m], shape (M + E,)."""
        return np.concatenate([channel.pull for channel in self.channels])

    def weighed(self, values: FloatArray) -> FloatArray:
        """Return rendered values times the second derivative for steps [1/m^2], (M + E,)."""
        weighed: FloatArray = values * np.concatenate(
            [channel.weights.curvature for channel in self.channels]
        )
        return weighed

    def by_parameter(self, index: int) -> FloatArray:
        """Return how rendered values follow one of the ordinary parameters, shape (M + E,)."""
        return np.concatenate([channel.jacobian[:, index] for channel in self.channels])

    def push(self, motion: FloatArray) -> FloatArray:
        """Return how rendered values follow a motion of the points, (N, 3) to (M + E,)."""
        depth = self.view.trace.push_depth(self.pixels, motion[None])[:, 0]
        edge = self.view.trace.push_outline(self.segments, motion[None])[:, 0]
        return np.concatenate([depth, edge * self.edge_scale])

    def pull_back(self, by_values: FloatArray) -> FloatArray:
        """Pull a derivative by rendered values back to the points, (M + E,) to (N, 3)."""
        count = len(self.pixels)
        depth = self.view.trace.pull_depth(self.pixels, by_values[:count])
        edge = self.view.trace.pull_outline(self.segments, by_values[count:] * self.edge_scale)
        return depth + edge


class FieldSystem:
    """The cost to second order around some coordinates and the field that the model has.

    Attributes:
        negative_gradient: of the cost, ordinary priors included, by the ordinary coordinates,
            shape (k,).
        curvature: by them, priors included, shape (k, k).
        field_negative_gradient: minus its gradient by the unknowns of the field, shape (n,).
        mixed: second derivative by both, shape (n, k).
    """

    def __init__(
        self, objective: RobustObjective, coordinates: FloatArray, tets_from_unknowns: csr_matrix
    ) -> None:
        """Linearise.

        Args:
            objective: the scene of its model holds the field.
            coordinates: of the ordinary parameters, shape (k,).
            tets_from_unknowns: shape (T, n).

        Raises:
            EquilibriumError: when a posture has no equilibrium.
            OutOfViewError: when a camera does not see the body.
        """
        self._objective, self._model = objective, objective.model
        self._coordinates = coordinates
        self._spread = tets_from_unknowns
        self._seen = self._look()
        for posture in self._model.bodies.values():
            posture.body.factor()  # Many single solves follow.
        self._modulus = self._model.material(coordinates).youngs_modulus
        data = equations((c for seen in self._seen for c in seen.channels), len(coordinates))
        whole = data.under(self._model.parameters.prior(), coordinates)
        self.negative_gradient, self.curvature = whole.negative_gradient, whole.curvature
        self.field_negative_gradient = self._to_unknowns([seen.pull for seen in self._seen])
        self.mixed = np.stack(
            [
                self._to_unknowns([s.weighed(s.by_parameter(index)) for s in self._seen])
                for index in range(len(coordinates))
            ],
            axis=1,
        )
        # Metres, radians and logarithms differ by powers of ten: scaled first.
        scale = 1.0 / np.sqrt(np.maximum(np.diag(self.curvature), 1e-300))
        scaled = np.linalg.pinv(self.curvature * np.outer(scale, scale), 1e-12, hermitian=True)
        self._inverse = scaled * np.outer(scale, scale)

    def reduced_negative_gradient(self) -> FloatArray:
        """Return the field's when the ordinary parameters follow, shape (n,)."""
        reduced: FloatArray = self.field_negative_gradient - self.mixed @ (
            self._inverse @ self.negative_gradient
        )
        return reduced

    def known(self, unknowns: FloatArray) -> FloatArray:
        """Apply what the data know of the field, ordinary parameters eliminated, shape (n,)."""
        pushed = self._push(self._spread @ unknowns)
        weighed = [s.weighed(values) for s, values in zip(self._seen, pushed, strict=True)]
        reduced: FloatArray = self._to_unknowns(weighed) - self.mixed @ (
            self._inverse @ (self.mixed.T @ unknowns)
        )
        return reduced

    def follow(self, step: FloatArray) -> FloatArray:
        """Return the ordinary parameters' step beside a step of the field, shape (k,)."""
        answer: FloatArray = self._inverse @ (self.negative_gradient - self.mixed.T @ step)
        return answer

    def covariance(self, carried: FloatArray) -> FloatArray:
        """Return that of the ordinary coordinates, shape (k, k).

        Args:
            carried: `mixed`.T times the field's covariance times `mixed`, shape (k, k).
        """
        total: FloatArray = self._inverse + self._inverse @ carried @ self._inverse
        return total

    def against_field(self, carried: FloatArray) -> FloatArray:
        """Return the covariance of ordinary coordinates and field, shape (k, n).

        Args:
            carried: the field's covariance times `mixed`, shape (n, k).
        """
        both: FloatArray = -self._inverse @ carried.T
        return both

    def _look(self) -> list[_Seen]:
        model, objective = self._model, self._objective
        tangents = model.tangents(self._coordinates)
        views = model.views(self._coordinates)
        compared = objective.comparisons(self._coordinates)
        return [
            self._see(number, view, tangent, compared[number])
            for number, (view, tangent) in enumerate(zip(views, tangents, strict=True))
        ]

    def _see(self, number: int, view: View, tangent: FloatArray, comparison: Comparison) -> _Seen:
        objective = self._objective
        both = objective.with_jacobians(number, comparison, view, tangent, self._coordinates)
        return _Seen(
            view=view,
            pixels=comparison.depth.indices,
            segments=comparison.edge.indices,
            edge_scale=comparison.edge_scale,
            channels=tuple(robust_channel(*own, objective.scales) for own in both),
        )

    def _push(self, log_modulus: FloatArray) -> list[FloatArray]:
        change = Change(youngs_modulus=log_modulus * self._modulus)
        moved = self._model.tangents_of(lambda *_: [change], self._coordinates)
        return [seen.push(motion[0]) for seen, motion in zip(self._seen, moved, strict=True)]

    def _to_unknowns(self, by_values: Sequence[FloatArray]) -> FloatArray:
        by_points = [s.pull_back(values) for s, values in zip(self._seen, by_values, strict=True)]
        by_tets = self._model.pull_back_to_tets(by_points, self._coordinates)
        pulled: FloatArray = self._spread.T @ by_tets
        return pulled
