# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The set-up page of a proposed scene, over what was measured."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.offline.calibrate_recordings import OfflineInputs
from diffcal_ros.proposal.draft import Draft
from diffcal_ros.proposal.save_draft import save_draft
from diffcal_ros.recording.color_on_depth import color_on_depth
from diffcal_ros.recording.recording import Recording
from diffcal_ros.rigid_transform import apply, inverse
from diffcal_ros.web.arrangement import Arrangement, arrangement_of
from diffcal_ros.web.point_cloud import point_cloud
from diffcal_ros.web.setup_page import SetupPage
from diffcal_ros.web.stage import draw_camera, draw_points, set_the_stage
from diffcal_ros.web.trial import Trial
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Around the body at rest every pixel is drawn, this many of its lengths away.
_AROUND = 0.5
# Points are drawn this much larger than they are apart.
_POINT = 1.1


def open_setup_page(server: Any, inputs: OfflineInputs, draft: Draft, path: Path) -> SetupPage:
    """Draw what was measured first, and the proposed body in it.

    Args:
        server: of viser.
        inputs: of one posture, in a scene of one region.
        draft: that is proposed.
        path: scene file that the page writes.
    """
    scene, observations = inputs.scene, inputs.observations
    setups = tuple(replace(setup, gravity=draft.gravity) for setup in scene.observations)
    trial = Trial(replace(scene, observations=setups), observations)
    body = apply(draft.world_from_object, scene.mesh.rest_positions)
    _draw_measured(server, observations[0], inputs.recordings[0], draft.gravity, body)
    start = arrangement_of(draft)

    def save(arrangement: Arrangement) -> Path:
        return save_draft(arrangement.draft(draft, scene.mesh), path)

    return SetupPage(server, trial, start, save)


def _draw_measured(
    server: Any,
    observation: Observation,
    recording: Recording,
    gravity: FloatArray,
    body: FloatArray,
) -> None:
    world_from_depth = inverse(observation.depth_from_world)
    set_the_stage(server, gravity, world_from_depth, body.mean(axis=0))
    draw_camera(server.scene, observation.camera, world_from_depth)
    points = apply(observation.depth_from_world, body)
    cloud = point_cloud(observation, *_window(observation, points))
    seen = color_on_depth(recording, observation.depth, observation.camera)
    if seen is None:
        nothing = np.zeros(observation.depth.shape, dtype=bool)
        seen = np.zeros((*observation.depth.shape, 3), dtype=np.uint8), nothing
    spacing = float(np.median(points[:, 2])) / observation.camera.fx
    draw_points(server.scene, cloud.points, cloud.colors(*seen), _POINT * spacing)


def _window(observation: Observation, points: FloatArray) -> tuple[slice, slice]:
    """Return rows and columns around a body in the camera's frame, shape (V, 3)."""
    ahead = points[points[:, 2] > 0.0]
    if not len(ahead):
        return slice(0), slice(0)
    pixels = observation.camera.project(ahead)
    margin = _AROUND * float(np.ptp(pixels, axis=0).max())
    low = np.maximum(pixels.min(axis=0) - margin, 0).astype(int)
    high = np.maximum(pixels.max(axis=0) + margin, 0).astype(int)
    return slice(low[1], high[1]), slice(low[0], high[0])
