# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A beam that lies on a ledge with its free end until the ledge lets go, and frames of it."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.observations.observation import Instant, Observation
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.scene.model import HeldPart, MotionSetup, Quantity, Scene
import numpy as np

from support.scenes import beam_scene, CAMERA, DEPTH_FROM_WORLD, quantity, SIZE

DAMPING = 20.0
RELEASE_TIME = 0.05


def moving_scene(
    *args: Any,
    damping: float = DAMPING,
    density: Quantity | None = None,
    release_time: float = RELEASE_TIME,
    integrator: str = 'implicit',
    time_step: float | None = None,
    tolerance: float | None = None,
    **kwargs: Any,
) -> Scene:
    """Make the beam of `beam_scene` move."""
    scene = beam_scene(*args, **kwargs)
    (setup,) = scene.observations
    far = np.flatnonzero(scene.mesh.rest_positions[:, 0] > SIZE[0] - 1e-9).astype(np.int32)
    motion = MotionSetup(
        ('ledge',),
        quantity(release_time, 0.0, 0.2),
        integrator,
        time_step,
        tolerance=tolerance,
    )
    setup = replace(setup, held=(*setup.held, HeldPart('ledge', far)), motion=motion)
    regions = tuple(
        replace(region, damping=quantity(damping, 0.1, 1e4), density=density or region.density)
        for region in scene.regions
    )
    return replace(scene, regions=regions, observations=(setup,))


def instants(times: Sequence[float], depths: Sequence[np.ndarray]) -> list[Observation]:
    """Wrap depth images of one recording."""
    return [
        Observation(
            f'{time:.3f} s',
            0,
            depth.astype(np.float32),
            CAMERA,
            DEPTH_FROM_WORLD,
            instant=Instant(float(time), 0),
        )
        for time, depth in zip(times, depths, strict=True)
    ]


def moving_model(scene: Scene, times: Sequence[float]) -> ForwardModel:
    """Return the model of a scene that is to be seen at some times; it has seen nothing."""
    nothing = np.full((CAMERA.height, CAMERA.width), np.nan)
    parameters = make_parameters(scene, with_edge_bias=False)
    return ForwardModel(scene, instants(times, [nothing] * len(times)), parameters)


def slope_errors(
    model: ForwardModel, start: np.ndarray, place: int, steps: Sequence[float] = (1e-3, 1e-4, 1e-5)
) -> list[float]:
    """Return by what share tangents of all frames differ from slopes, by size of the step.

    Args:
        model: of a motion.
        start: coordinates, shape (k,).
        place: of the parameter among them.
        steps: of central differences.
    """
    tangents, errors = np.stack(model.tangents(start))[:, place], []
    for step in steps:
        change = step * np.eye(len(start))[place]
        ahead = np.stack([view.points for view in model.views(start + change)])
        behind = np.stack([view.points for view in model.views(start - change)])
        slope = (ahead - behind) / (2.0 * step)
        errors.append(float(np.linalg.norm(slope - tangents) / np.linalg.norm(slope)))
    return errors


def true_depths(scene: Scene, times: Sequence[float]) -> list[np.ndarray]:
    """Depth [m] at some times under the scene's start values; NaN beside the body."""
    model = moving_model(scene, times)
    return [view.trace.full_depth() for view in model.views(model.parameters.start())]
