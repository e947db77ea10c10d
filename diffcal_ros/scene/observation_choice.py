# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which of a scene's observations a name means."""

from diffcal_ros.errors import InputError
from diffcal_ros.scene.model import Scene


def observation_index(scene: Scene, name: str) -> int:
    """Return the number of an observation; of an empty name, that of the first.

    Raises:
        InputError: when the scene has none of that name.
    """
    names = [setup.name for setup in scene.observations]
    if not name:
        return 0
    if name not in names:
        raise InputError(
            f'observation is {name!r}: the scene has {", ".join(names)}; choose one of them'
        )
    return names.index(name)
