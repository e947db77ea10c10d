# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A beam that lies on a ledge with its free end until the ledge lets go."""

from dataclasses import replace
from typing import Any

from diffcal_ros.scene.model import HeldPart, MotionSetup, Scene
import numpy as np

from support.scenes import beam_scene, quantity, SIZE

DAMPING = 20.0
RELEASE_TIME = 0.05


def moving_scene(
    *args: Any, damping: float = DAMPING, motion: MotionSetup | None = None, **kwargs: Any
) -> Scene:
    """Make the beam of `beam_scene` move; `motion` replaces the usual one."""
    scene = beam_scene(*args, **kwargs)
    (setup,) = scene.observations
    far = np.flatnonzero(scene.mesh.rest_positions[:, 0] > SIZE[0] - 1e-9).astype(np.int32)
    released = HeldPart('ledge', far)
    usual = MotionSetup(('ledge',), quantity(RELEASE_TIME, 0.0, 0.2))
    setup = replace(setup, held=(*setup.held, released), motion=motion or usual)
    regions = tuple(
        replace(region, damping=quantity(damping, 0.1, 1e4)) for region in scene.regions
    )
    return replace(scene, regions=regions, observations=(setup,))
