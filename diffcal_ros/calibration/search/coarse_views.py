# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Observations made coarse: one pixel in so many, and a camera to match."""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.scene.model import Masks, Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# The body's longer side in a coarse image [px]: its outline is known to a hundredth of it.
_SIDE = 90


def stride_for(points: Sequence[FloatArray], observations: Sequence[Observation]) -> int:
    """Return by how much images may be thinned.

    Args:
        points: of the body in each camera's frame [m], shape (N, 3) each.
        observations: of as many views.
    """
    sides = []
    for own, observation in zip(points, observations, strict=True):
        pixels = observation.camera.project(own[own[:, 2] > 0.0])
        if len(pixels):
            sides.append(float(np.ptp(pixels, axis=0).max()))
    return max(1, int(min(sides, default=1.0) / _SIDE))


def coarse_observation(observation: Observation, stride: int) -> Observation:
    """Return an observation with one pixel in so many, noise and pose as they were."""
    left_out = observation.left_out
    return replace(
        observation,
        depth=np.ascontiguousarray(observation.depth[::stride, ::stride]),
        camera=_coarse_camera(observation.camera, stride),
        left_out=None if left_out is None else left_out[::stride, ::stride],
    )


def coarse_masks(masks: Masks, stride: int) -> Masks:
    """Return masks for images that were thinned."""
    boxes = tuple(
        (u // stride, v // stride, -(-p // stride), -(-q // stride)) for u, v, p, q in masks.boxes
    )
    return replace(masks, boxes=boxes, silhouette_band=masks.silhouette_band / stride)


def coarse_scene(scene: Scene, stride: int) -> Scene:
    """Return the scene for images that were thinned, with its camera's intrinsics."""
    camera = scene.depth_camera
    return replace(
        scene,
        masks=coarse_masks(scene.masks, stride),
        depth_camera=None if camera is None else _coarse_camera(camera, stride),
    )


def _coarse_camera(camera: PinholeCamera, stride: int) -> PinholeCamera:
    return replace(
        camera,
        width=-(-camera.width // stride),
        height=-(-camera.height // stride),
        fx=camera.fx / stride,
        fy=camera.fy / stride,
        cx=camera.cx / stride,
        cy=camera.cy / stride,
    )
