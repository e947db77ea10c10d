# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One view of a model that stands still: what a new frame says costs no simulation.

Frames of a live camera come faster than a body changes. Rendered depth, outline and their
Jacobians stay what they are while the coordinates stay; a frame is looked up in them.
"""

from dataclasses import dataclass, replace

from diffcal_ros.calibration.residuals.gap import Gap, measure_gap
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.residuals.robust_loss import robust_channel
from diffcal_ros.calibration.residuals.robust_residual import (
    Comparison,
    ResidualKind,
    Residuals,
)
from diffcal_ros.least_squares.normal_equations import Linearisation, NormalEquations
from diffcal_ros.least_squares.residual_channel import equations, linearise, ResidualChannel
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class FrameEquations:
    """What one frame says.

    Attributes:
        equations: of the frame alone, without priors.
        coverage: share of the pixels to compare where the body was seen.
    """

    equations: NormalEquations
    coverage: float


class LinearisedView:
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
        self._scales, self._truncation = objective.scales, objective.truncation
        self.coordinates = coordinates.copy()
        self.rendered = model.views(coordinates)[number]
        # The tracer may see other views meanwhile: nothing is asked of it later.
        self._trace = trace = self.rendered.trace
        self._outline = outline = trace.outline
        self._read = self._comparer.read(trace, model.sensor(coordinates, number))
        self._counted, comparable = self._comparer.pixels(self.rendered)
        self._simulated = self._comparer.simulated(trace, self._read, self._counted)
        self._indices = np.flatnonzero(comparable.ravel()).astype(np.int32)
        self._read_there = self._read.ravel()[self._indices]
        rows, columns = np.divmod(self._indices, trace.shape[1])
        pixels = np.stack([columns + trace.columns.start, rows + trace.rows.start], axis=1)
        self._pixels = pixels[:, 1] * trace.buffers.camera.width + pixels[:, 0]
        everything = Comparison(
            depth=_unread(ResidualKind.DEPTH, self._indices),
            edge=_unread(ResidualKind.EDGE, outline.segments),
            edge_scale=self._comparer.metres_per_pixel(outline),
            difference=self._read,
            counted=self._counted,
        )
        tangent = model.tangents(coordinates)[number]
        both = objective.with_jacobians(number, everything, self.rendered, tangent, coordinates)
        (_, self._by_depth), (edge, self._by_edge) = both
        # With no residual there, what is left is what the sensor's bias of edges adds.
        self._edge_bias = edge.values

    def look(self, depth: NDArray[np.float32]) -> FrameEquations:
        """Compare with a frame.

        Args:
            depth: z [m], shape (H, W), NaN where invalid.
        """
        self._comparer.show(depth)
        inside = self._depths(depth)
        said = equations(self._channels(inside), len(self.coordinates))
        seen = float(inside.weights.sum())
        return FrameEquations(said, seen / max(1, len(self._indices)))

    def inform(self, depth: NDArray[np.float32]) -> Linearisation:
        """Return how sure a frame is, the last one that was looked at, without priors."""
        return linearise(self._channels(self._depths(depth)), len(self.coordinates))

    def gap(self, depth: NDArray[np.float32], *, is_both_ways: bool = True) -> Gap:
        """Return how far a frame is from the view, in both directions or, faster, in one."""
        window = depth[self._trace.rows, self._trace.columns]
        observed = window.astype(np.float64)
        fractions = [self._comparer.fractions_of(depth, self._simulated)] if is_both_ways else None
        return measure_gap([observed - self._read], [self._counted], self._truncation, fractions)

    def read_depth(self) -> FloatArray:
        """Return the depth that the sensor would read [m], shape (H, W), NaN beside the body."""
        return self._trace.in_image(self._read)

    def _channels(self, inside: Residuals) -> list[ResidualChannel]:
        """Return both channels of the frame that is shown, given its residuals of depth."""
        edge, found = self._edges()
        return [
            robust_channel(inside, self._by_depth, self._scales),
            robust_channel(edge, self._by_edge[found], self._scales),
        ]

    def _depths(self, depth: NDArray[np.float32]) -> Residuals:
        """Return residuals at all pixels to compare; where there is none it weighs nothing."""
        values = depth.ravel()[self._pixels] - self._read_there
        is_near = np.abs(values) < self._scales.reach.depth
        missing = np.count_nonzero(~is_near) - np.count_nonzero(np.isnan(values))
        values[~is_near] = 0.0
        return Residuals(
            kind=ResidualKind.DEPTH,
            values=values,
            weights=is_near.astype(np.float64),
            pixels=_NO_PIXELS,
            indices=self._indices,
            missing=float(missing),
        )

    def _edges(self) -> tuple[Residuals, NDArray[np.intp]]:
        """Return residuals of the outline's segments, and which segments they are of."""
        edge, _ = self._comparer.edges(self._outline, self._scales.reach)
        found = np.searchsorted(self._outline.segments, edge.indices)
        return replace(edge, values=edge.values + self._edge_bias[found]), found


_NO_PIXELS = np.zeros((0, 2), dtype=np.int32)


def _unread(kind: ResidualKind, indices: NDArray[np.int32]) -> Residuals:
    """Return residuals that are zero, of equal weight."""
    count = len(indices)
    return Residuals(kind, np.zeros(count), np.ones(count), _NO_PIXELS, indices, 0.0)
