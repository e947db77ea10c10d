# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where a flat marker allows two camera poses, let the body decide between them."""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.observations.observation import Observation, pose_covariances
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.search.global_search import can_search, GlobalSearch
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.errors import NotSimulatedError
from diffcal_ros.scene.model import Scene

# One pose is believed where the other leaves so many times as much on the coarse image.
_CLEAR = 1.5


def choose_mirrored(
    scene: Scene, observations: Sequence[Observation], settings: CalibrationSettings
) -> tuple[list[Observation], tuple[str, ...]]:
    """Take for each observation that has two camera poses the one under which the body is found.

    Args:
        scene: body, clamp, material.
        observations: with their poses, and mirrored ones where the marker does not tell.
        settings: of the fit.

    Returns:
        The observations, each with one pose, and notes for a person.
    """
    kept, notes = [], []
    for seen in observations:
        if seen.mirrored is None or seen.instant is not None:
            kept.append(seen)
            continue
        other = replace(seen, depth_from_world=seen.mirrored, mirrored=None)
        own_misfit, other_misfit = (_misfit(scene, one, settings) for one in (seen, other))
        is_other = other_misfit * _CLEAR < own_misfit
        kept.append(other if is_other else seen)
        if is_other:
            notes.append(f"{seen.name}: the body lies where the marker's mirrored pose has it")
        elif own_misfit * _CLEAR >= other_misfit:
            notes.append(
                f"{seen.name}: neither the marker's pose nor its mirrored one stands out by the "
                'body; turn the camera or use a larger marker'
            )
    return kept, tuple(notes)


def _misfit(scene: Scene, seen: Observation, settings: CalibrationSettings) -> float:
    """Return the lowest misfit on a coarse image, infinite where the body is not in view."""
    parameters = make_parameters(scene, settings.fit, pose_covariances=pose_covariances([seen]))
    model = ForwardModel(scene, [seen], parameters, solver=settings.solver, device=settings.device)
    if not can_search(model):
        return float('inf')
    try:
        basins = GlobalSearch(model, parameters.start(), solver=settings.solver).basins()
    except NotSimulatedError:
        return float('inf')
    return min((basin.misfit.left for basin in basins), default=float('inf'))
