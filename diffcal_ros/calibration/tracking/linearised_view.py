# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One view of a model that stands still: what a new frame says costs no simulation.

Frames of a live camera come faster than a body changes. Rendered depth, outline and their
Jacobians stay what they are while the coordinates stay; a frame is looked up in them.
"""

from dataclasses import dataclass

from diffcal_ros.calibration.residuals.gap import Gap, measure_gap
from diffcal_ros.calibration.residuals.objective import (
    robust_cost,
    robust_weights,
    RobustObjective,
)
from diffcal_ros.calibration.residuals.residual_scales import Scale
from diffcal_ros.calibration.residuals.robust_residual import Comparison, Residuals
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class FrameEquations:
    """What one frame says, to second order, without priors.

    Attributes:
        cost: half chi-square.
        descent: minus the gradient, shape (k,).
        curvature: Gauss-Newton matrix, shape (k, k).
        coverage: share of the pixels to compare where the body was seen.
    """

    cost: float
    descent: FloatArray
    curvature: FloatArray
    coverage: float


@dataclass(frozen=True)
class FrameInformation:
    """How sure one frame is; see `Linearisation`.

    Attributes:
        information: true curvature of the robust cost, shape (k, k).
        scatter: covariance of the descent, shape (k, k).
    """

    information: FloatArray
    scatter: FloatArray


class HeldView:
    """A view held at some coordinates, to be compared with any number of frames."""

    def __init__(
        self, objective: RobustObjective, coordinates: FloatArray, number: int = 0
    ) -> None:
        """Render once.

        Args:
            objective: gives the model and how residuals are weighed.
            coordinates: where to hold it, shape (k,).
            number: of the view.

        Raises:
            EquilibriumError: when the body has no equilibrium there.
            OutOfViewError: when the camera does not see it.
        """
        model = objective.model
        self._comparer = objective.comparers[number]
        self._reach, self._truncation = objective.scales.reach, objective.truncation
        self.coordinates = coordinates.copy()
        self.view = model.views(coordinates)[number]
        # The tracer may see other views meanwhile: nothing is asked of it later.
        self._trace = trace = self.view.trace
        self._outline = outline = trace.outline
        self._read = self._comparer.read(trace, model.sensor(coordinates))
        self._counted, comparable = self._comparer.pixels(self.view)
        self._simulated = self._comparer.simulated(trace, self._read, self._counted)
        self._places = np.flatnonzero(comparable.ravel()).astype(np.int32)
        self._read_there = self._read.ravel()[self._places]
        rows, columns = np.divmod(self._places, trace.shape[1])
        pixels = np.stack([columns + trace.columns.start, rows + trace.rows.start], axis=1)
        self._pixels = pixels[:, 1] * trace.buffers.camera.width + pixels[:, 0]
        everything = Comparison(
            depth=_unread(pixels, self._places),
            edge=_unread(np.zeros((len(outline.pieces), 2), np.int32), outline.pieces),
            edge_scale=self._comparer.metres_per_pixel(outline),
            difference=self._read,
            counted=self._counted,
        )
        tangent = model.tangents(coordinates)[number]
        blocks = objective.blocks(number, everything, self.view, tangent, coordinates)
        (_, self._by_depth, self._depth_scale), (edge, self._by_edge, self._edge_scale) = blocks
        # With no residual there, what is left is what the sensor's bias of edges adds.
        self._edge_bias = edge.values

    def look(self, depth: NDArray[np.float32]) -> FrameEquations:
        """Compare with a frame.

        Args:
            depth: z [m], shape (H, W), NaN where invalid.
        """
        self._comparer.show(depth)
        descent, curvature, cost = np.zeros(self._size), np.zeros((self._size, self._size)), 0.0
        parts = self._parts(depth)
        for residuals, jacobian, scale, dimension, limit in parts:
            weights = robust_weights(residuals, scale, dimension)
            descent += jacobian.T @ (weights.gradient * residuals.values)
            curvature += jacobian.T @ (jacobian * weights.curvature[:, None])
            cost += robust_cost(residuals, scale, limit, dimension)
        seen = float(parts[0][0].weights.sum())
        return FrameEquations(cost, descent, curvature, seen / max(1, len(self._places)))

    def inform(self, depth: NDArray[np.float32]) -> FrameInformation:
        """Return how sure a frame is, the last one that was looked at."""
        information, scatter = (np.zeros((self._size, self._size)) for _ in range(2))
        for residuals, jacobian, scale, dimension, _ in self._parts(depth):
            weights = robust_weights(residuals, scale, dimension)
            information += jacobian.T @ (jacobian * weights.true_curvature[:, None])
            patch = scale.patch(dimension) / np.maximum(residuals.weights, 1e-12)
            pull = (weights.gradient * residuals.values) ** 2 * patch
            scatter += jacobian.T @ (jacobian * pull[:, None])
        return FrameInformation(information, scatter)

    def gap(self, depth: NDArray[np.float32], *, is_both_ways: bool = True) -> Gap:
        """Return how far a frame is from the view, in both directions or, faster, in one."""
        window = depth[self._trace.rows, self._trace.columns]
        observed = window.astype(np.float64)
        shares = [self._comparer.shares_of(depth, self._simulated)] if is_both_ways else None
        return measure_gap([observed - self._read], [self._counted], self._truncation, shares)

    def read_depth(self) -> FloatArray:
        """Return the depth that the sensor would read [m], shape (H, W), NaN beside the body."""
        return self._trace.in_image(self._read)

    @property
    def _size(self) -> int:
        return len(self.coordinates)

    def _parts(
        self, depth: NDArray[np.float32]
    ) -> list[tuple[Residuals, FloatArray, Scale, int, float]]:
        """Return residuals, Jacobian, scale, dimension and how far was looked, of both kinds."""
        reach = self._reach
        edge, found = self._edges()
        return [
            (self._depths(depth), self._by_depth, self._depth_scale, 2, reach.depth),
            (edge, self._by_edge[found], self._edge_scale, 1, reach.edge_depth),
        ]

    def _depths(self, depth: NDArray[np.float32]) -> Residuals:
        """Return residuals at all pixels to compare; where there is none it weighs nothing."""
        values = depth.ravel()[self._pixels] - self._read_there
        is_near = np.abs(values) < self._reach.depth
        missing = np.count_nonzero(~is_near) - np.count_nonzero(np.isnan(values))
        values[~is_near] = 0.0
        return Residuals(
            values, is_near.astype(np.float64), _NO_PIXELS, self._places, float(missing)
        )

    def _edges(self) -> tuple[Residuals, NDArray[np.intp]]:
        """Return residuals of the outline's pieces, and which pieces they are of."""
        edge, _ = self._comparer.edges(self._outline, self._reach)
        found = np.searchsorted(self._outline.pieces, edge.places)
        values = edge.values + self._edge_bias[found]
        return Residuals(values, edge.weights, edge.pixels, edge.places, edge.missing), found


_NO_PIXELS = np.zeros((0, 2), dtype=np.int32)


def _unread(pixels: NDArray[np.int32], places: NDArray[np.int32]) -> Residuals:
    """Return residuals that are zero, of equal weight."""
    count = len(places)
    return Residuals(np.zeros(count), np.ones(count), pixels, places, 0.0)
