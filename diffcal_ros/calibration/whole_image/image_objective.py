# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The paper's comparison: the whole depth image, background and all.

`paper` is the loss of Arnavaz et al. 2023 as their code computes it, 1000 times the Euclidean
norm of rendered less observed depth over every pixel; `l1` is the sum of absolute differences.
Both take 0 for a pixel without depth, rendered or observed. Most of their value lies outside the
body, so they say little about the fit; they are here to reproduce and to compare.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.forward.solution import View
from diffcal_ros.calibration.observations.pixel_masks import make_view_mask
from diffcal_ros.calibration.residuals.gap import Gap, measure_gap
from diffcal_ros.depth.area_image import AreaImage
from diffcal_ros.least_squares.fixed_form import FixedForm
from diffcal_ros.least_squares.normal_equations import Linearisation
from diffcal_ros.least_squares.residual_channel import linearise, ResidualChannel, Weights
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

IMAGE_LOSSES = ('paper', 'l1')
# Absolute differences are smoothed below this [m], for a gradient at 0.
_L1_CORNER = 1e-4


@dataclass(frozen=True)
class _ImageView:
    """One view's area-averaged image against its observation, within the window."""

    view: View
    area: AreaImage
    difference: FloatArray
    outside: float


class ImageObjective(FixedForm):
    """Whole-image losses and their derivatives."""

    def __init__(self, model: ForwardModel, loss: str, *, samples: int = 8) -> None:
        """Prepare.

        Args:
            model: simulates and traces.
            loss: one of `IMAGE_LOSSES`.
            samples: along each side of a pixel in which the outline turns.
        """
        if loss not in IMAGE_LOSSES:
            raise ValueError(f'image loss is {loss!r}: use one of {", ".join(IMAGE_LOSSES)}')
        self.model = model
        self.loss = loss
        self._samples = samples
        self._targets = [
            np.nan_to_num(observation.depth.astype(np.float64), nan=0.0)
            for observation in model.observations
        ]
        masks = model.scene.masks
        self.truncation = masks.truncation
        self._masks = [
            make_view_mask(observation, model.body(observation), tracer, masks)
            for observation, tracer in zip(model.observations, model.tracers, strict=True)
        ]
        self._noise = 0.0

    def value(self, coordinates: FloatArray) -> float:
        """Return the loss as the paper reports it."""
        return self._value(self._views(coordinates))

    def cost(self, coordinates: FloatArray) -> float:
        """Return the loss as half a chi-square of its start."""
        return self._half_chi_square(self._views(coordinates))

    def gradient(self, coordinates: FloatArray) -> tuple[float, FloatArray]:
        """Return the loss and its gradient by the coordinates, by adjoints, shape (k,)."""
        views = self._views(coordinates)
        value = self._value(views)
        by_points = [view.area.pull_back(self._by_image(view.difference, value)) for view in views]
        return value, self.model.pull_back(by_points, coordinates)

    def linearise(self, coordinates: FloatArray) -> Linearisation:
        """Expand the cost around some coordinates (forward tangents)."""
        views = self._views(coordinates)
        if self._noise == 0.0:
            self._noise = self._mean_square(views)
        data = linearise(self._channels(views, coordinates), len(coordinates))
        return replace(data, cost=self._half_chi_square(views))

    def _channels(
        self, views: Sequence[_ImageView], coordinates: FloatArray
    ) -> Iterator[ResidualChannel]:
        """Yield every view's pixels within its window, each independent of all others."""
        for view, tangent in zip(views, self.model.tangents(coordinates), strict=True):
            jacobian = view.area.push_forward(tangent).reshape(-1, len(coordinates))
            values = -view.difference.ravel()
            weights = Weights.of_squares(self._weights(values) / self._noise)
            yield ResidualChannel(values, jacobian, weights, cost=0.0)

    def gap(self, coordinates: FloatArray) -> Gap:
        """Measure the gap on the body."""
        residuals, counted = [], []
        for number, view in enumerate(self.model.views(coordinates)):
            trace = view.trace
            observed = self.model.observations[number].depth[trace.rows, trace.columns]
            residuals.append(observed.astype(np.float64) - trace.depth)
            counted.append(self.counted(number, view))
        return measure_gap(residuals, counted, self.truncation)

    def standing(self, coordinates: FloatArray) -> tuple[Gap, float]:
        """Return the gap, and the loss as the paper reports it."""
        return self.gap(coordinates), self.value(coordinates)

    def counted(self, number: int, view: View) -> NDArray[np.bool_]:
        """Tell which pixels of a view's window are unmasked body."""
        trace, mask = view.trace, self._masks[number]
        seen = (trace.faces >= 0) & ~mask.triangles[np.maximum(trace.faces, 0)]
        counted: NDArray[np.bool_] = seen & ~mask.image[trace.rows, trace.columns]
        return counted

    def read_depth(self, number: int, view: View, coordinates: FloatArray) -> FloatArray:
        """Return the rendered depth in a view's window [m]: these losses know no effects."""
        return view.trace.depth

    def _views(self, coordinates: FloatArray) -> list[_ImageView]:
        result = []
        for view, target in zip(self.model.views(coordinates), self._targets, strict=True):
            trace = view.trace
            area = trace.area_image(side=self._samples, background=0.0)
            inside = target[trace.rows, trace.columns]
            outside = self._sum(target) - self._sum(inside)
            result.append(_ImageView(view, area, area.image - inside, outside))
        return result

    def _sum(self, difference: FloatArray) -> float:
        if self.loss == 'l1':
            return float(np.abs(difference).sum())
        return float((difference**2).sum())

    def _total(self, views: list[_ImageView]) -> float:
        return sum(self._sum(view.difference) + view.outside for view in views)

    def _value(self, views: list[_ImageView]) -> float:
        total = self._total(views)
        return 1e3 * float(np.sqrt(total)) if self.loss == 'paper' else total

    def _mean_square(self, views: list[_ImageView]) -> float:
        pixels = sum(target.size for target in self._targets)
        return max(self._total(views) / pixels, 1e-12)

    def _half_chi_square(self, views: list[_ImageView]) -> float:
        if self._noise == 0.0:
            self._noise = self._mean_square(views)
        fraction = 0.5 if self.loss == 'paper' else 1.0
        return fraction * self._total(views) / self._noise

    def _weights(self, difference: FloatArray) -> FloatArray:
        if self.loss == 'paper':
            return np.ones_like(difference)
        return 1.0 / np.maximum(np.abs(difference), _L1_CORNER)

    def _by_image(self, difference: FloatArray, value: float) -> FloatArray:
        if self.loss == 'paper':
            return 1e6 * difference / max(value, 1e-12)
        return np.clip(difference / _L1_CORNER, -1.0, 1.0)
