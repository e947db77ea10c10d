# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where a fit puts the scene's world and the body's own frame."""

from dataclasses import dataclass

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class BodyFrames:
    """Frames of the last observation, as the fit has them.

    Attributes:
        depth_from_world: of the scene, corrections of the pose and the rigid offset included,
            shape (4, 4).
        depth_from_object: of the mesh file's own axes, as they are clamped, shape (4, 4).
    """

    depth_from_world: FloatArray
    depth_from_object: FloatArray


def body_frames(scene: Scene, model: ForwardModel, coordinates: FloatArray) -> BodyFrames:
    """Return the frames at some coordinates, shape (k,)."""
    number = len(model.observations) - 1
    setup = scene.observations[model.observations[number].setup_index]
    depth_from_world = model.cameras.pose(number, coordinates)
    return BodyFrames(depth_from_world, depth_from_world @ setup.world_from_object)
