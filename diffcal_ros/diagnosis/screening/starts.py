# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where to start amplitudes of which tangents at zero say little."""

from collections.abc import Mapping, Sequence

from diffcal_ros.diagnosis.model_comparison.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.screening.candidates import Candidate
from diffcal_ros.effects.site import SeenPixels
from diffcal_ros.errors import NotSimulatedError
from diffcal_ros.rigid_motion import upwards
from diffcal_ros.rigid_transform import apply, inverse
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Starts = dict[str, float]

# What is measured this far from the simulated body is not its surface [m].
_NEAR = 0.03


def more_starts(nominal: PatchEvaluator, base: Refit, added: Sequence[Candidate]) -> list[Starts]:
    """Return starts to be tried on top of what tangents propose, SI units by name.

    Args:
        nominal: evaluates the patches of the nominal model.
        base: its fit.
        added: effects that are added to it.
    """
    seen = _NominalFit(nominal, base)
    found: list[Starts] = [{}]
    for effect in dict.fromkeys(candidate.effect for candidate in added):
        found = [{**start, **more} for start in found for more in effect.starts(seen)]
    return found


class _NominalFit:
    """See `FitsSeen`."""

    def __init__(self, nominal: PatchEvaluator, base: Refit) -> None:
        self._nominal = nominal
        names, first = nominal.model.parameters.names, nominal.model.parameters.start()
        self.begin: Mapping[str, float] = dict(zip(names, first.tolist(), strict=True))
        self.end: Mapping[str, float] = dict(zip(names, base.coordinates.tolist(), strict=True))

    def residuals(self, values: Mapping[str, float]) -> list[SeenPixels]:
        """Return what each view leaves at some parameters; none where they are not simulated."""
        nominal, coordinates = self._nominal, np.array(list(values.values()))
        try:
            compared = nominal.comparisons(coordinates)
        except NotSimulatedError:
            return []
        found = []
        views = nominal.model.views(coordinates)
        for comparer, view, comparison in zip(nominal.comparers, views, compared, strict=True):
            counted = np.isfinite(comparison.difference) & comparison.counted
            is_second = comparer.is_second(view.trace)[counted]
            found.append(SeenPixels(comparison.difference[counted], is_second))
        return found

    def heights(self) -> list[FloatArray]:
        """Return how high the body's surface is in each view, in the world [m], (n,) each."""
        model, found = self._nominal.model, []
        views = model.views(np.array(list(self.end.values())))
        for observation, view in zip(model.observations, views, strict=True):
            rows, columns = np.nonzero(np.isfinite(view.trace.depth))
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
