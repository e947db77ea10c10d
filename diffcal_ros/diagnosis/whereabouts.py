# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where on the body the gap is largest, in words."""

from diffcal_ros.calibration.forward_model import ForwardModel
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.diagnosis.evidence import Block
from diffcal_ros.diagnosis.refit import Refit
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_PARTS = ((1.0 / 3.0, 'near the clamp'), (2.0 / 3.0, 'in the middle'), (np.inf, 'at the tip'))


def where_largest(model: ForwardModel, fit: Refit) -> str:
    """Say where the mean square residual is largest: part of the body, kind, pose.

    Args:
        model: the model of the fit.
        fit: with all patches.
    """
    views = model.views(fit.coordinates)
    best, words = -1.0, 'nowhere: nothing was compared'
    for block in fit.blocks:
        observation = model.observations[block.view]
        axes = model.effects.axes(observation.setup_index)
        body = model.body(observation)
        along = axes.share(body.discretisation.rest_nodes)
        shares = _shares(block, views[block.view].points, along, observation.camera)
        squares = block.patches.values**2
        low = 0.0
        for high, part in _PARTS:
            inside = (shares >= low) & (shares < high)
            low = high
            if inside.sum() < 2 or squares[inside].mean() <= best:
                continue
            best = float(squares[inside].mean())
            what = 'in depth' if block.kind == 'depth' else 'at the outline'
            words = f'{part}, {what}'
            if len(model.observations) > 1:
                words += f', {observation.name}'
            words += f' ({1e3 * np.sqrt(best):.2f} mm)'
    return words


def _shares(
    block: Block, points: FloatArray, node_shares: FloatArray, camera: PinholeCamera
) -> FloatArray:
    """Return how far along the body each patch is: of the node that is seen nearest to it."""
    u = camera.fx * points[:, 0] / points[:, 2] + camera.cx
    v = camera.fy * points[:, 1] / points[:, 2] + camera.cy
    columns, rows = block.patches.centers.T
    apart = (columns[:, None] - u) ** 2 + (rows[:, None] - v) ** 2
    return node_shares[apart.argmin(axis=1)] if apart.size else np.zeros(0)
