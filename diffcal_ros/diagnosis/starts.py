# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where to start amplitudes of which tangents at zero say little."""

from collections.abc import Callable, Sequence

from diffcal_ros.calibration.effect_model import upwards
from diffcal_ros.calibration.forward_model import NOT_SIMULATED
from diffcal_ros.diagnosis.candidates import Candidate
from diffcal_ros.diagnosis.evidence import Evidence
from diffcal_ros.diagnosis.refit import Refit
from diffcal_ros.rigid_transform import apply, inverse
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Starts = dict[str, float]

_STEP = 'depth_bias_by_region.bias'

# A plane is first tried at the lowest point seen, and so much above it [m].
_PLANE_RISES = (0.0, 0.003)
_LOWEST_SHARE = 0.01
_NEAR = 0.03
# Steps of depth that lead to the same fit [m].
_SAME_STEP = 0.003
# Less is no part of a view [px].
_LEAST_PIXELS = 50


def more_starts(nominal: Evidence, base: Refit, added: Sequence[Candidate]) -> list[Starts]:
    """Return starts to be tried on top of what tangents propose, SI units by name.

    Args:
        nominal: evidence of the nominal model.
        base: its fit.
        added: effects that are added to it.
    """
    found: list[Starts] = [{}]
    for identifier, propose in _PROPOSALS.items():
        if any(candidate.identifier == identifier for candidate in added):
            found = [{**start, **more} for start in found for more in propose(nominal, base)]
    return found


def _planes(nominal: Evidence, base: Refit) -> list[Starts]:
    lowest = min(_lowest_points(nominal, base))
    return [{'contact_plane.height': lowest + rise} for rise in _PLANE_RISES]


def _steps(nominal: Evidence, base: Refit) -> list[Starts]:
    """Propose the step of depth between the materials: it may be beyond a robust fit's reach.

    Read at the nominal fit, and where that fit began: it may have turned the body, or bent it to
    a wrong stiffness, to follow the step.
    """
    found: list[Starts] = [{}]
    first = nominal.model.parameters.start()
    for coordinates, before in ((base.coordinates, {}), (first, _places_of(nominal, first))):
        try:
            step = _step_at(nominal, coordinates)
        except NOT_SIMULATED:
            continue
        if step is not None and not any(_is_alike(step, other) for other in found):
            found.append({**before, **step})
    return found


def _is_alike(one: Starts, other: Starts) -> bool:
    return abs(one[_STEP] - other.get(_STEP, np.inf)) < _SAME_STEP


def _places_of(nominal: Evidence, coordinates: FloatArray) -> Starts:
    return dict(zip(nominal.model.parameters.names, coordinates.tolist(), strict=True))


def _step_at(nominal: Evidence, coordinates: FloatArray) -> Starts | None:
    steps, firsts = [], []
    compared = nominal.comparisons(coordinates)
    views = nominal.model.views(coordinates)
    for comparer, view, comparison in zip(nominal.comparers, views, compared, strict=True):
        own = comparison.difference
        counted = np.isfinite(own) & comparison.counted
        is_second = comparer.is_second(view.trace)
        first, second = own[counted & ~is_second], own[counted & is_second]
        if min(len(first), len(second)) > _LEAST_PIXELS:
            steps.append(float(np.median(second) - np.median(first)))
            firsts.append(float(np.median(first)))
    if not steps:
        return None
    start = {_STEP: float(np.median(steps))}
    names = nominal.model.parameters.names
    if 'rigid_offset.z' in names:
        # The offset had followed the larger part; the step is between the two.
        offset = float(coordinates[names.index('rigid_offset.z')])
        start['rigid_offset.z'] = offset + float(np.median(firsts))
    return start


_PROPOSALS: dict[str, Callable[[Evidence, Refit], list[Starts]]] = {
    'contact_plane': _planes,
    'depth_bias_by_region': _steps,
}


def _lowest_points(nominal: Evidence, base: Refit) -> list[float]:
    """Return how low the observed body reaches in each view, in the world [m]."""
    model, found = nominal.model, []
    views = model.views(base.coordinates)
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
            heights = apply(inverse(observation.depth_from_world), points) @ up
            found.append(float(np.quantile(heights, _LOWEST_SHARE)))
    return found
