# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Cameras in front of a posed body, and what they would see without noise."""

from contextlib import suppress
from dataclasses import dataclass

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth.tracer import OutOfViewError
from diffcal_ros.errors import SceneError
from diffcal_ros.scene.model import ObservationSetup, Scene
from diffcal_ros.synthetic.color_picture import paint_scan, pixel_rays
from diffcal_ros.synthetic.posed_body import PosedBody
from diffcal_ros.synthetic.scan import Scan
from diffcal_ros.synthetic.stage import make_stage, scan_body, Stage, wall_behind
from diffcal_ros.synthetic.viewpoint import (
    COLOR_CAMERA,
    color_from_world,
    default_view,
    DEPTH_CAMERA,
    sees,
    view_from,
)
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Rig:
    """One posture in front of the cameras.

    Attributes:
        name: of the observation.
        depth_camera: intrinsics.
        color_camera: intrinsics.
        depth_from_world: shape (4, 4).
        depth_scan: what the depth camera would see without error.
        around: the same without the body.
        color_image: what the colour camera would see without noise, shape (H, W, 3).
        sees_all: the body and the marker lie wholly inside both images.
    """

    name: str
    depth_camera: PinholeCamera
    color_camera: PinholeCamera
    depth_from_world: FloatArray
    depth_scan: Scan
    around: Scan
    color_image: FloatArray
    sees_all: bool

    def scan(self, body: PosedBody) -> Scan:
        """Return what the depth camera would see of a body elsewhere.

        Raises:
            OutOfViewError: when the body is behind the camera or beside the image.
        """
        return scan_body(body, self.depth_camera, self.depth_from_world).in_front_of(self.around)


def make_rig(
    scene: Scene,
    setup: ObservationSetup,
    body: PosedBody,
    camera_position: tuple[float, float, float] | None,
    path: FloatArray | None = None,
) -> Rig:
    """Put up cameras and look.

    Args:
        scene: gives the marker, if there is one, and both cameras.
        setup: gives the camera's pose where it stores one.
        body: at rest.
        camera_position: of the depth camera in the world [m], in place of the stored pose.
        path: where the nodes of a body that moves will be [m], shape (F, N, 3).

    Raises:
        InputError: when the camera does not see the body.
    """
    depth_camera = scene.depth_camera or DEPTH_CAMERA
    color_camera = scene.color_camera or COLOR_CAMERA
    stage = make_stage(scene, setup)
    places = body.positions if path is None else path.reshape(-1, 3)
    points = np.vstack([stage.points(), places])
    pose = setup.stored_depth_from_world
    if camera_position is not None:
        pose = view_from(np.array(camera_position), points, setup.gravity)
    if pose is None:
        pose = default_view(
            points, body.outward, setup.gravity, scene.marker, depth_camera, color_camera
        )
    around = _around(stage, depth_camera, pose, points)
    try:
        depth_scan = scan_body(body, depth_camera, pose).in_front_of(around)
    except OutOfViewError as error:
        raise SceneError(
            f'the synthetic camera of {setup.name} does not see the body: {error}, or leave '
            'the pose out for one that does'
        ) from error
    color_pose = color_from_world(pose)
    return Rig(
        name=setup.name,
        depth_camera=depth_camera,
        color_camera=color_camera,
        depth_from_world=pose,
        depth_scan=depth_scan,
        around=around,
        color_image=_color(scene, stage, body, color_camera, color_pose, points),
        sees_all=sees(depth_camera, pose, points) and sees(color_camera, color_pose, points),
    )


def _around(
    stage: Stage, camera: PinholeCamera, camera_from_world: FloatArray, points: FloatArray
) -> Scan:
    """See everything but the body; the wall is behind all points."""
    wall = wall_behind(points, camera_from_world)
    return stage.scan(pixel_rays(camera), camera_from_world, wall)


def _color(
    scene: Scene,
    stage: Stage,
    body: PosedBody,
    camera: PinholeCamera,
    camera_from_world: FloatArray,
    points: FloatArray,
) -> FloatArray:
    scan = _around(stage, camera, camera_from_world, points)
    # The marker may be seen without the body.
    with suppress(OutOfViewError):
        scan = scan_body(body, camera, camera_from_world).in_front_of(scan)
    return paint_scan(scan, camera, camera_from_world, scene.marker)
