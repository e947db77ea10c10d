# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where on the body the gap is largest, in words."""

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_group import of_the_body, PatchGroup
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

PART_NAMES = ('near the clamp', 'in the middle', 'at the tip')
_BORDERS = (1.0 / 3.0, 2.0 / 3.0)


def where_largest(model: ForwardModel, fit: Refit) -> str:
    """Say where the mean square residual is largest: part of the body, kind, pose.

    Args:
        model: the model of the fit.
        fit: with all patches.
    """
    views = model.views(fit.coordinates)
    best, words = -1.0, 'nowhere: nothing was compared'
    for group in of_the_body(fit.groups):
        observation = model.observations[group.view]
        parts = part_numbers(group, model, views[group.view].points)
        squares = group.patches.values**2
        for number, part in enumerate(PART_NAMES):
            inside = parts == number
            if inside.sum() < 2 or squares[inside].mean() <= best:
                continue
            best = float(squares[inside].mean())
            what = 'in depth' if group.kind == 'depth' else 'at the outline'
            words = f'{part}, {what}'
            if len(model.observations) > 1:
                words += f', {observation.name}'
            words += f' ({1e3 * np.sqrt(best):.2f} mm)'
    return words


def part_numbers(group: PatchGroup, model: ForwardModel, points: FloatArray) -> NDArray[np.int64]:
    """Return on which of `PART_NAMES` each patch of a group lies, shape (n,).

    Args:
        group: patches.
        model: of the body.
        points: its nodes in the camera frame [m], shape (N, 3).
    """
    observation = model.observations[group.view]
    parts = parts_of_nodes(model, group.view)
    return parts[nearest_nodes(group, points, observation.camera)]


def parts_of_nodes(model: ForwardModel, view: int) -> NDArray[np.int64]:
    """Return on which of `PART_NAMES` each node of a view's body lies, shape (N,)."""
    observation = model.observations[view]
    axes = model.effects.axes(observation.setup_index)
    along = axes.fraction(model.body(observation).discretisation.rest_nodes)
    return np.searchsorted(_BORDERS, along, side='right').astype(np.int64)


def nearest_nodes(
    group: PatchGroup, points: FloatArray, camera: PinholeCamera
) -> NDArray[np.int64]:
    """Return the node that is seen nearest to each patch of a group, shape (n,)."""
    u = camera.fx * points[:, 0] / points[:, 2] + camera.cx
    v = camera.fy * points[:, 1] / points[:, 2] + camera.cy
    columns, rows = group.patches.centers.T
    apart = (columns[:, None] - u) ** 2 + (rows[:, None] - v) ** 2
    return apart.argmin(axis=1) if apart.size else np.zeros(0, dtype=np.int64)
