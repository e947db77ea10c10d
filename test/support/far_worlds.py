# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The same set-up in another world frame: one that is shifted, or turned as well."""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.rigid_transform import apply, inverse, rotation_matrix, transform
from diffcal_ros.scene.model import HeldPart, ObservationSetup, Scene
import numpy as np

DISTANCES = (2.0, 10.0, 1000.0)
# Nothing lies along an axis, and the three shares differ.
_TOWARDS = np.array([0.6, -0.48, 0.64])
TURN = rotation_matrix(np.array([0.7, -1.1, 0.4]))


def shift_by(distance: float) -> np.ndarray:
    """Return the move of the world [m], shape (4, 4)."""
    return transform(np.eye(3), distance * _TOWARDS)


def moved_scene(scene: Scene, new_from_old: np.ndarray) -> Scene:
    """Write a scene down in another world frame."""
    setups = tuple(_moved_setup(setup, new_from_old) for setup in scene.observations)
    return replace(scene, observations=setups)


def moved_views(seen: Sequence[Observation], new_from_old: np.ndarray) -> list[Observation]:
    """Write the poses of cameras down in another world frame."""
    old_from_new = inverse(new_from_old)
    return [replace(one, depth_from_world=one.depth_from_world @ old_from_new) for one in seen]


def _moved_setup(setup: ObservationSetup, new_from_old: np.ndarray) -> ObservationSetup:
    stored = setup.stored_depth_from_world
    return replace(
        setup,
        world_from_object=new_from_old @ setup.world_from_object,
        gravity=new_from_old[:3, :3] @ setup.gravity,
        held=tuple(_moved_part(part, new_from_old) for part in setup.held),
        stored_depth_from_world=None if stored is None else stored @ inverse(new_from_old),
    )


def _moved_part(part: HeldPart, new_from_old: np.ndarray) -> HeldPart:
    if part.turn is None:
        return part
    turn, rotation = part.turn, new_from_old[:3, :3]
    turn = replace(
        turn,
        axis=rotation @ turn.axis,
        center=None if turn.center is None else apply(new_from_old, turn.center),
        translation=rotation @ turn.translation,
    )
    return replace(part, turn=turn)
