# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which parts of a view may be compared: not the clamp, not what the user left out."""

from dataclasses import dataclass

from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.scene.model import Masks
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

BoolArray = NDArray[np.bool_]
FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class ViewMask:
    """What of one view is left out.

    Attributes:
        image: pixels left out, shape (H, W).
        triangles: surface triangles left out, shape (F,).
        edges: surface edges left out, shape (E,).
    """

    image: BoolArray
    triangles: BoolArray
    edges: BoolArray


def make_view_mask(
    observation: Observation, body: StaticBody, tracer: DepthTracer, masks: Masks
) -> ViewMask:
    """Find what the scene's masks leave out of one observation."""
    hidden = np.zeros(body.discretisation.node_count, dtype=bool)
    if masks.held:
        hidden[body.held_nodes] = True
        if masks.held_margin > 0.0:
            rest = body.discretisation.rest_nodes
            distance, _ = cKDTree(rest[body.held_nodes]).query(rest)
            hidden |= distance <= masks.held_margin
    return ViewMask(
        image=pixels_left_out(observation, masks),
        triangles=np.any(hidden[tracer.triangles], axis=1),
        edges=np.any(hidden[tracer.edge_vertices], axis=1),
    )


def pixels_left_out(observation: Observation, masks: Masks) -> BoolArray:
    """Return the pixels that the user or the recording leaves out, shape (H, W)."""
    camera = observation.camera
    image = np.zeros((camera.height, camera.width), dtype=bool)
    for u0, v0, u1, v1 in masks.boxes:
        image[max(v0, 0) : v1 + 1, max(u0, 0) : u1 + 1] = True
    if observation.left_out is not None:
        image |= observation.left_out
    return image
