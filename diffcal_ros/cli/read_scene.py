# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Reading a scene file, with a sign of life while a surface is cut into tetrahedra."""

from pathlib import Path
from typing import TYPE_CHECKING

from diffcal_ros.cli.heartbeat import Heartbeat

if TYPE_CHECKING:
    from diffcal_ros.scene.model import Scene


def read_scene(path: Path) -> 'Scene':
    """Read a scene; see `load_scene`."""
    from diffcal_ros.scene.load import load_scene

    with Heartbeat('reading the scene and its mesh'):
        return load_scene(path)
