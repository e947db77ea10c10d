# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which simulated bodies a list of observations needs, and which of their states each shows."""

from collections.abc import Sequence
from typing import Any

from diffcal_ros.calibration.forward.held_load import HeldLoadPosture
from diffcal_ros.calibration.forward.moving_posture import MovingPosture
from diffcal_ros.calibration.forward.posture import Posture, RestingPosture
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.scene.model import Scene


def make_bodies(
    scene: Scene, observations: Sequence[Observation], solver: str, device: str
) -> dict[int, Posture[Any]]:
    """Return the bodies, by number of the scene's observation."""
    used = sorted({observation.setup_index for observation in observations})
    return {index: _posture(scene, observations, index, solver, device) for index in used}


def _posture(
    scene: Scene, observations: Sequence[Observation], index: int, solver: str, device: str
) -> Posture[Any]:
    setup, times = scene.observations[index], instants(observations, index)
    if setup.motion is None:
        return RestingPosture(scene, setup, solver, device)
    if setup.motion.is_slow:
        return HeldLoadPosture(scene, setup, times, solver, device)
    return MovingPosture(scene, setup, times, solver, device)


def state_indices(observations: Sequence[Observation]) -> tuple[int, ...]:
    """Return which state of its body each observation shows: 0 at rest, else that of its time."""
    times = {
        index: instants(observations, index) for index in {o.setup_index for o in observations}
    }
    return tuple(
        0 if seen.instant is None else times[seen.setup_index].index(seen.instant.time)
        for seen in observations
    )


def instants(observations: Sequence[Observation], index: int) -> list[float]:
    """Return the times at which one body is seen moving [s], ascending."""
    own = [seen.instant for seen in observations if seen.setup_index == index]
    return sorted({instant.time for instant in own if instant is not None})
