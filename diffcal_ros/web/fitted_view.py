# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A fitted body and what each camera measured of it, in the world frame: what a page draws."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import InputError, NotSimulatedError
from diffcal_ros.offline.calibrate_recordings import OfflineInputs
from diffcal_ros.recording.color_on_depth import color_on_depth
from diffcal_ros.recording.recording import Recording
from diffcal_ros.report.figures.observed_view import ObservedView, views_at
from diffcal_ros.rigid_transform import apply, inverse
from diffcal_ros.scene.model import ObservationSetup
from diffcal_ros.web.fit_folder import FitFolder
from diffcal_ros.web.held_box import box_around, HeldBox
from diffcal_ros.web.point_cloud import distance_colors, point_cloud
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]
ByteArray = NDArray[np.uint8]


@dataclass(frozen=True)
class SeenBody:
    """One observation, all in the world frame as the pose of the camera was measured.

    Attributes:
        name: of the observation.
        vertices: of the simulated body [m], shape (N, 3).
        triangles: of its free surface, outward, shape (F, 3).
        held_triangles: of its held surface, shape (G, 3).
        held: where its boxes are, shape (4, 4) each, and the boxes; none of parts that turn.
        points: measured [m], shape (P, 3).
        by_distance: their colours by distance to the simulated surface, RGB, shape (P, 3).
        scale: distance at the ends of these colours [m].
        by_camera: their colours in the camera's image, shape (P, 3), or None.
        spacing: of measured points on the body [m].
        camera: intrinsics.
        world_from_depth: where the camera was, shape (4, 4).
        gravity: [m/s^2], shape (3,).
    """

    name: str
    vertices: FloatArray
    triangles: IntArray
    held_triangles: IntArray
    held: tuple[tuple[FloatArray, HeldBox], ...]
    points: FloatArray
    by_distance: ByteArray
    scale: float
    by_camera: ByteArray | None
    spacing: float
    camera: PinholeCamera
    world_from_depth: FloatArray
    gravity: FloatArray


def seen_fit(fit: FitFolder, inputs: OfflineInputs) -> list[SeenBody]:
    """Simulate a fit and put every observation that is shown into the world frame.

    Args:
        fit: read again.
        inputs: its recordings.

    Raises:
        InputError: when scene and recordings are not what was fitted.
    """
    calibration = fit.calibration(inputs)
    recordings = {
        observation.name: recording
        for recording, take in zip(inputs.recordings, inputs.takes, strict=True)
        for observation in take
    }
    median = fit.document['gap']['end']['median_mm']
    try:
        return seen_bodies(calibration, recordings, np.nan if median is None else 1e-3 * median)
    except NotSimulatedError as error:
        raise InputError(
            f'{fit.path}: the fitted body cannot be simulated or seen ({error}): fit again'
        ) from error


def seen_bodies(
    calibration: Calibration, recordings: Mapping[str, Recording], median_gap: float
) -> list[SeenBody]:
    """Simulate a body and put every observation that is shown into the world frame.

    Args:
        calibration: standing at the values to show.
        recordings: by the name of the observation, for their colours; may miss some.
        median_gap: of the fit [m].
    """
    at = zip(calibration.parameters, calibration.coordinates, strict=True)
    seen = views_at(calibration, {own.name: own.value(there) for own, there in at})
    return [
        _seen_body(calibration, view, recordings.get(view.observation.name), median_gap)
        for view in seen
    ]


def _seen_body(
    calibration: Calibration, view: ObservedView, recording: Recording | None, median_gap: float
) -> SeenBody:
    observation, model = view.observation, calibration.model
    world_from_depth = inverse(observation.depth_from_world)
    points = model.views(calibration.coordinates)[view.number].points
    body = model.body(observation)
    surface = body.discretisation.surface_triangles
    is_held = np.zeros(len(points), dtype=bool)
    is_held[body.held_nodes] = True
    is_held_face = is_held[surface].all(axis=1)
    setup = calibration.scene.observations[observation.setup_index]
    pose = model.cameras.pose(view.number, calibration.coordinates)
    world_from_object = world_from_depth @ pose @ setup.world_from_object
    cloud = point_cloud(observation, view.rows, view.columns)
    by_distance, is_known, scale = distance_colors(view.fitted.residual, median_gap)
    seen = (
        None
        if recording is None or observation.instant is not None
        else color_on_depth(recording, observation.depth, observation.camera)
    )
    return SeenBody(
        observation.name,
        apply(world_from_depth, points),
        surface[~is_held_face],
        surface[is_held_face],
        tuple(
            (world_from_object, box)
            for box in _boxes(setup, calibration.scene.mesh.rest_positions)
        ),
        cloud.points,
        cloud.colors(by_distance, is_known),
        scale,
        None if seen is None else cloud.colors(*seen),
        float(np.median(points[:, 2])) / observation.camera.fx,
        observation.camera,
        world_from_depth,
        setup.gravity,
    )


def _boxes(setup: ObservationSetup, rest_positions: FloatArray) -> Sequence[HeldBox]:
    """Return a box around each held part that does not turn."""
    along = np.array([1.0, 0.0, 0.0])
    return [
        box_around(rest_positions[part.vertices], along)
        for part in setup.held
        if part.turn is None
    ]
