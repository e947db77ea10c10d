# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What every page draws: the world, a camera, a cloud of points, a body and what holds it."""

from typing import Any

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.report.scene_picture.scene_legend import HELD_COLOR
from diffcal_ros.rigid_transform import quaternion_xyzw, rotation_matrix
from diffcal_ros.web.held_box import HeldBox
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]
ByteArray = NDArray[np.uint8]

_AXES, _FRUSTUM = 0.03, 0.03  # [m]
_HELD_OPACITY = 0.25
# Who opens a page stands beside the camera: so much nearer, turned and raised by so much [rad].
_NEARER, _TURN, _RISE = 0.7, np.deg2rad(30.0), np.deg2rad(12.0)


def rgb(color: str) -> tuple[int, int, int]:
    """Turn '#rrggbb' into three numbers up to 255."""
    return int(color[1:3], 16), int(color[3:5], 16), int(color[5:7], 16)


def pose(target_from_source: FloatArray) -> dict[str, Any]:
    """Return a rigid transform, shape (4, 4), as viser has it: `wxyz` and `position`."""
    x, y, z, w = quaternion_xyzw(target_from_source[:3, :3])
    return {'wxyz': np.array([w, x, y, z]), 'position': target_from_source[:3, 3].copy()}


def set_the_stage(
    server: Any, gravity: FloatArray, world_from_depth: FloatArray, middle: FloatArray
) -> None:
    """Draw the world's axes, and look at the body from beside the camera.

    Args:
        server: of viser.
        gravity: [m/s^2], shape (3,).
        world_from_depth: where the camera was, shape (4, 4).
        middle: of the body, world frame [m], shape (3,).
    """
    up = -_unit(gravity)
    server.scene.set_up_direction(tuple(up))
    server.scene.world_axes.visible = True
    server.scene.world_axes.axes_length = _AXES
    server.scene.world_axes.axes_radius = 0.02 * _AXES
    server.scene.world_axes.origin_radius = 0.04 * _AXES
    back = _NEARER * (world_from_depth[:3, 3] - middle)
    back = rotation_matrix(_TURN * up) @ back
    back = rotation_matrix(_RISE * _unit(np.cross(back, up))) @ back
    server.initial_camera.position = tuple(middle + back)
    server.initial_camera.look_at = tuple(middle)
    server.initial_camera.up = tuple(up)
    server.initial_camera.near = 0.005


def _unit(vector: FloatArray) -> FloatArray:
    """Return a vector of length one; zero stays as it is."""
    unit: FloatArray = vector / max(float(np.linalg.norm(vector)), 1e-9)
    return unit


def draw_camera(
    scene: Any, camera: PinholeCamera, world_from_depth: FloatArray, name: str = '/camera'
) -> Any:
    """Draw the frustum of the depth camera."""
    return scene.add_camera_frustum(
        name,
        fov=2.0 * float(np.arctan(0.5 * camera.height / camera.fy)),
        aspect=camera.width / camera.height * camera.fy / camera.fx,
        scale=_FRUSTUM,
        thickness=0.02 * _FRUSTUM,
        color=(80, 80, 80),
        **pose(world_from_depth),
    )


def draw_points(scene: Any, points: FloatArray, colors: ByteArray, size: float) -> Any:
    """Draw points of a size [m], world frame [m], shape (N, 3), in RGB, shape (N, 3)."""
    # Half precision would move points by half a millimetre at a metre.
    return scene.add_point_cloud(
        '/points',
        points.astype(np.float32),
        colors,
        point_size=size,
        precision='float32',
        point_shading='flat',
        point_shape='circle',
    )


def draw_surface(
    scene: Any,
    name: str,
    vertices: FloatArray,
    triangles: IntArray,
    color: str,
    opacity: float | None = None,
) -> Any:
    """Draw a part of a body's surface: vertices [m], shape (N, 3), triangles, shape (F, 3)."""
    used, own = np.unique(triangles, return_inverse=True)
    if not len(used):  # Where one was drawn before, it goes.
        scene.remove_by_name(name)
        return None
    return scene.add_mesh_simple(
        name,
        vertices[used].astype(np.float32),
        own.reshape(-1, 3).astype(np.uint32),
        color=rgb(color),
        opacity=opacity,
        flat_shading=False,
        side='double',
    )


def draw_held_box(scene: Any, name: str, box: HeldBox, target_from_object: FloatArray) -> Any:
    """Draw the box around what is held.

    Args:
        scene: of viser.
        name: of the node.
        box: in the body's frame.
        target_from_object: into the frame of the node's parent, shape (4, 4).
    """
    return scene.add_box(
        name,
        rgb(HELD_COLOR),
        tuple(float(side) for side in box.sides),
        opacity=_HELD_OPACITY,
        side='double',
        cast_shadow=False,
        **pose(target_from_object @ box.object_from_box),
    )
