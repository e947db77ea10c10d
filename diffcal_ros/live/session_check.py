# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Refuse settings that contradict a scene, before anything is begun with them."""

from diffcal_ros.errors import InputError
from diffcal_ros.live.frames.release import require_release_time
from diffcal_ros.live.inputs import LiveInputs
from diffcal_ros.live.session_settings import SessionSettings
from diffcal_ros.scene.fit_names import fit_problems
from diffcal_ros.scene.model import MotionSetup, Scene


def motion_in_view(scene: Scene, settings: SessionSettings) -> MotionSetup | None:
    """Return how the body in view moves; None: it is at rest.

    Raises:
        InputError: when the scene has no such observation.
    """
    inputs = LiveInputs(scene, settings.pose_source, settings.observation)
    return scene.observations[inputs.setup_index].motion


def check_settings(scene: Scene, settings: SessionSettings) -> None:
    """Refuse settings that contradict a scene.

    Raises:
        InputError: naming what is wrong.
    """
    motion = motion_in_view(scene, settings)
    regions = [region.name for region in scene.regions]
    names = settings.fit.fit or scene.fit
    cables = [cable.name for cable in scene.cables]
    problems = fit_problems(names, regions, scene.observations, cables)
    if problems:
        raise InputError('; '.join(f'fit {problem}' for problem in problems))
    if motion is not None:
        require_release_time(names)
