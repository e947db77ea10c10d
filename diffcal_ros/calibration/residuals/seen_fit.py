# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A fit as effects see it that propose where they start."""

from collections.abc import Mapping, Sequence
from typing import Protocol

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.residuals.robust_residual import Comparison, ViewComparer
from diffcal_ros.effects.site import SeenPixels
from diffcal_ros.errors import NotSimulatedError
from diffcal_ros.rigid_motion import upwards
from diffcal_ros.rigid_transform import apply, inverse
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# What is measured this far from the simulated body is not its surface [m].
_NEAR = 0.03
# What is around a place, as a share of the free length.
_AROUND = 0.06


class ComparesViews(Protocol):
    """What compares a model's views with their observations."""

    @property
    def model(self) -> ForwardModel:
        """Simulates and traces."""

    @property
    def comparers(self) -> Sequence[ViewComparer]:
        """One a view."""

    def comparisons(self, coordinates: FloatArray) -> Sequence[Comparison]:
        """Compare every view at some coordinates, shape (k,)."""


class SeenFit:
    """See `FitsSeen`."""

    def __init__(self, compares: ComparesViews, end: FloatArray) -> None:
        """Look at a fit.

        Args:
            compares: of its model.
            end: coordinates where it ended, shape (k,).
        """
        self._compares = compares
        names, first = compares.model.parameters.names, compares.model.parameters.start()
        self.begin: Mapping[str, float] = dict(zip(names, first.tolist(), strict=True))
        self.end: Mapping[str, float] = dict(zip(names, end.tolist(), strict=True))

    def residuals(self, values: Mapping[str, float]) -> list[SeenPixels]:
        """Return what each view leaves at some parameters; none where they are not simulated."""
        compares, coordinates = self._compares, np.array(list(values.values()))
        try:
            compared = compares.comparisons(coordinates)
        except NotSimulatedError:
            return []
        found = []
        views = compares.model.views(coordinates)
        for comparer, view, comparison in zip(compares.comparers, views, compared, strict=True):
            counted = np.isfinite(comparison.difference) & comparison.counted
            is_second = comparer.is_second(view.trace)[counted]
            found.append(SeenPixels(comparison.difference[counted], is_second))
        return found

    def heights(self, at: float | None) -> list[FloatArray]:
        """Return how high the body's surface is in each view, see `FitsSeen.heights`."""
        model, found = self._compares.model, []
        views = model.views(np.array(list(self.end.values())))
        for comparer, observation, view in zip(
            self._compares.comparers, model.observations, views, strict=True
        ):
            is_shown = np.isfinite(view.trace.depth)
            places = comparer.surface.places
            if at is not None and places is not None:
                shares = places[view.trace.faces][..., 0]
                is_shown &= np.abs(shares - at) < _AROUND
            rows, columns = np.nonzero(is_shown)
            rendered = view.trace.depth[rows, columns]
            rows, columns = rows + view.trace.rows.start, columns + view.trace.columns.start
            depth = observation.depth[rows, columns].astype(np.float64)
            near = np.abs(depth - rendered) < _NEAR
            camera = observation.camera
            across, down = (columns - camera.cx) / camera.fx, (rows - camera.cy) / camera.fy
            points = np.stack([across * depth, down * depth, depth], axis=1)[near]
            if len(points):
                up = upwards(model.scene.observations[observation.setup_index].gravity)
                found.append(apply(inverse(observation.depth_from_world), points) @ up)
        return found
