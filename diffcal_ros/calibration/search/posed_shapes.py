# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A model whose bodies have a given shape: only what places it in the image moves it."""

from collections.abc import Sequence
from copy import copy
from dataclasses import replace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.forward.solution import View
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.residuals.residual_scales import LONGEST_CORRELATION, Scale, Scales
from diffcal_ros.calibration.residuals.robust_residual import Reach
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# How far a coarse comparison looks: three times the usual prior of a placement [m].
_REACH, _EDGE_REACH = 0.060, 0.090
# A coarse comparison does not tell less than this from nothing [m]; see `shapes`.
FLOOR = 0.004


class PosedShapes(ForwardModel):
    """Simulates a body, or shows a shape of it; made of few pixels and linear elements."""

    _shape: Sequence[FloatArray] | None = None

    def showing(self, shape: Sequence[FloatArray]) -> 'PosedShapes':
        """Return a model of the same bodies that have this shape: what `worlds` returned."""
        shown = PosedShapes(
            self.scene,
            self.observations,
            self.parameters,
            device=self.device,
            shared=self._shared,
        )
        shown._shape = shape
        return shown

    def views(self, coordinates: FloatArray) -> tuple[View, ...]:
        """Place the shape before the cameras; one view an observation."""
        if self._shape is None:
            return super().views(coordinates)
        return tuple(
            View(self.cameras.points(number, world, coordinates), self.tracers[number])
            for number, world in enumerate(self._shape)
        )

    def tangents(self, coordinates: FloatArray) -> list[FloatArray]:
        """Return how each view's points follow what places them [m], shape (k, N, 3) each."""
        if self._shape is None:
            return super().tangents(coordinates)
        found = []
        for number, world in enumerate(self._shape):
            tangents = np.zeros((len(self.parameters), *world.shape))
            for index, motion in self.cameras.motions(number, world, coordinates).items():
                tangents[index] = motion
            found.append(tangents)
        return found


class CoarseObjective(RobustObjective):
    """The robust comparison on a coarse image, with widths that end at `FLOOR`."""

    def __init__(self, model: PosedShapes, stride: int, *, device: str) -> None:
        """Prepare the comparison.

        Args:
            model: shows shapes.
            stride: of its images [px].
            device: Warp device.
        """
        super().__init__(model, device=device)
        camera = model.observations[0].camera
        self._correlation_px = max(1.0, LONGEST_CORRELATION / stride)
        reach = max(2, int(_EDGE_REACH * camera.fx / 0.5))
        self._reach = Reach(_REACH, _REACH, reach)
        self._shapes = model
        self.scales = self._begun(1.0)

    def of_shape(self, shape: Sequence[FloatArray], leeway: float = 1.0) -> 'CoarseObjective':
        """Return the comparison of a shape with the same images, to begin a fit with.

        Args:
            shape: what `PosedShapes.worlds` returned.
            leeway: standard deviations of placements count so many times.
        """
        begun = copy(self)
        begun.model = self._shapes.showing(shape)
        begun.scales = self._begun(leeway)
        return begun

    def at_the_end(self) -> 'CoarseObjective':
        """Return the same under the widths at which shapes are compared with one another."""
        ended, floor = copy(self), Scale(FLOOR, FLOOR, self._correlation_px)
        ended.scales = replace(self.scales, depth=floor, edge=floor)
        return ended

    @property
    def is_annealed(self) -> bool:
        """Tell whether the robust widths have shrunk to the end."""
        return max(self.scales.depth.noise, self.scales.edge.noise) <= FLOOR

    def anneal(self, coordinates: FloatArray) -> None:
        """Let the robust widths follow the residuals down to the floor."""
        if self.is_annealed:
            return
        super().anneal(coordinates)
        depth, edge = (self._floored(scale) for scale in (self.scales.depth, self.scales.edge))
        self.scales = replace(self.scales, depth=depth, edge=edge, reach=self._reach)

    def refine(self, coordinates: FloatArray) -> bool:
        """Leave the scales as they are: a coarse image says little of noise."""
        return False

    def _begun(self, leeway: float) -> Scales:
        usual = Scale(correlation=self._correlation_px)
        return Scales(usual, usual, self._reach, leeway)

    def _floored(self, scale: Scale) -> Scale:
        width = max(FLOOR, scale.width)
        return Scale(width, width, self._correlation_px)
