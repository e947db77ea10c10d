# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where the parts of a scene's drawing go: viewpoints, arrows, frustum and marker, in metres."""

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.marker import Marker
from diffcal_ros.report.scene_picture.view import View
from diffcal_ros.rigid_transform import apply, looking_at, rotation_matrix, transform
from diffcal_ros.scene.model import Scene, Turn
from diffcal_ros.scene.posing import turn_motion
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]

_PAGE_CAMERA = PinholeCamera(width=1000, height=1000, fx=1000.0, fy=1000.0, cx=500.0, cy=500.0)
_VIEW_DISTANCE = 3.0  # Over the radius of everything that is drawn.
_ELEVATION = np.deg2rad(24.0)
# Turned off the camera's own direction, so that body and frustum stand side by side.
_AZIMUTH_FROM_CAMERA = np.deg2rad(58.0)
_AZIMUTH_FROM_SIDE = np.deg2rad(28.0)
_FRUSTUM_LENGTH = 0.2  # Over the distance from camera to body.
_QUIET_ZONE = 0.3  # White paper beside a marker, both rims together, over its side.
# Half-angles' tangents drawn for a camera whose intrinsics are not known yet.
_UNKNOWN_FIELD = (0.6, 0.45)


def up_direction(gravity: FloatArray) -> FloatArray:
    """Return the direction against gravity, or the world's y without gravity."""
    strength = float(np.linalg.norm(gravity))
    return -gravity / strength if strength > 0.0 else np.array([0.0, 1.0, 0.0])


def body_size(rest: FloatArray) -> float:
    """Return the longest side of the bounding box [m]."""
    return float(np.ptp(rest, axis=0).max())


def overview(
    points: FloatArray,
    rest: FloatArray,
    gravity: FloatArray,
    world_from_depth: FloatArray | None,
) -> View:
    """Choose a perspective view of the whole scene.

    Args:
        points: everything drawn, world frame [m], shape (P, 3).
        rest: the body's vertices [m], shape (V, 3).
        gravity: points down on the page, shape (3,).
        world_from_depth: camera pose, shape (4, 4), or None.
    """
    up = up_direction(gravity)
    level = _level_direction(rest, up, world_from_depth)
    corners = np.stack([points.min(axis=0), points.max(axis=0)])
    radius = 0.5 * float(np.linalg.norm(corners[1] - corners[0]))
    direction = np.cos(_ELEVATION) * level + np.sin(_ELEVATION) * up
    view_from_world = looking_at(corners.mean(axis=0), _VIEW_DISTANCE * radius * direction, up)
    return View(view_from_world, _PAGE_CAMERA)


def _level_direction(
    rest: FloatArray, up: FloatArray, world_from_depth: FloatArray | None
) -> FloatArray:
    """Return the level direction to look from, shape (3,), unit length."""
    along = _side_direction(rest, up)
    toward, azimuth = np.cross(along, up), _AZIMUTH_FROM_SIDE
    if world_from_depth is not None:
        to_camera = world_from_depth[:3, 3] - rest.mean(axis=0)
        level = to_camera - (to_camera @ up) * up
        length = float(np.linalg.norm(level))
        if length > 0.1 * float(np.linalg.norm(to_camera)):  # Else it looks straight down.
            toward, azimuth = level / length, _AZIMUTH_FROM_CAMERA
    both = [rotation_matrix(sign * azimuth * up) @ toward for sign in (1.0, -1.0)]
    # Of the two sides, the one that sees less of the body end-on.
    return min(both, key=lambda direction: abs(float(direction @ along)))


def side_view(rest: FloatArray, gravity: FloatArray) -> View:
    """Choose a parallel view across gravity in which page coordinates are the world's."""
    up = up_direction(gravity)
    right = _side_direction(rest, up)
    rotation = np.stack([right, -up, np.cross(right, -up)])
    return View(transform(rotation, np.zeros(3)))


def side_axes(view: View) -> tuple[str, str]:
    """Name the directions that point right and up on the page."""
    rotation = view.view_from_world[:3, :3]
    return _direction_name(rotation[0]), _direction_name(-rotation[1])


def _side_direction(rest: FloatArray, up: FloatArray) -> FloatArray:
    """Return the world axis, made level, along which the body is longest."""
    spans = np.ptp(rest, axis=0)
    levels = np.eye(3) - np.outer(up, up)
    lengths = np.linalg.norm(levels, axis=1)
    axis = int(np.argmax(np.where(lengths > 0.5, spans, -1.0)))
    direction: FloatArray = levels[axis] / lengths[axis]
    return direction


def _direction_name(direction: FloatArray) -> str:
    axis = int(np.argmax(np.abs(direction)))
    if abs(direction[axis]) > 1.0 - 1e-6:
        return f'world {"-" if direction[axis] < 0 else ""}{"xyz"[axis]}'
    return 'world (' + ', '.join(f'{part:.2f}' for part in direction) + ')'


def world_triad(rest: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the world's origin, or a corner of the body when it is far, and three axis ends."""
    size = body_size(rest)
    length = _round_length(0.25 * size)
    origin = np.zeros(3)
    if np.linalg.norm(rest.mean(axis=0)) > 2.0 * size:
        origin = rest.min(axis=0) - 0.2 * size
    return origin, origin + length * np.eye(3)


def _round_length(length: float) -> float:
    """Round down to 1, 2 or 5 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(length))
    return float(max(step * power for step in (1.0, 2.0, 5.0) if step * power <= length))


def gravity_arrow(rest: FloatArray, gravity: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return start and end of an arrow above the body that points down."""
    up = up_direction(gravity)
    size = body_size(rest)
    middle = 0.5 * (rest.min(axis=0) + rest.max(axis=0))
    top = float(np.max((rest - middle) @ up))
    end = middle + (top + 0.06 * size) * up
    return end + 0.22 * size * up, end


def turn_arc(turn: Turn, rest: FloatArray) -> FloatArray:
    """Return the path of a point beside a held part during its turn [m], shape (n, 3).

    Args:
        turn: the part's motion.
        rest: the part's vertices [m], shape (h, 3).
    """
    middle = 0.5 * (rest.min(axis=0) + rest.max(axis=0))
    center = middle if turn.center is None else turn.center
    center = center + ((middle - center) @ turn.axis) * turn.axis
    offsets = rest - center
    across = offsets - np.outer(offsets @ turn.axis, turn.axis)
    reach = np.linalg.norm(across, axis=1)
    farthest = int(np.argmax(reach))
    start = center + 1.25 * across[farthest]
    fractions = np.linspace(0.0, 1.0, 60)
    return np.stack([apply(turn_motion(turn, rest, fraction), start) for fraction in fractions])


def marker_squares(marker: Marker) -> tuple[FloatArray, FloatArray]:
    """Return the corners of the paper [m], shape (4, 3), and of black squares, shape (n, 4, 3)."""
    corners = 0.5 * np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]])
    middles = np.zeros((1, 3))
    if marker.board is not None:
        row, column = np.nonzero(~marker.board.squares)
        across = (column + 0.5) * marker.square - 0.5 * marker.size[0]
        up = 0.5 * marker.size[1] - (row + 0.5) * marker.square
        middles = np.stack([across, up, np.zeros(len(row))], axis=1)
    paper = corners * [*(marker.size + _QUIET_ZONE * marker.square), 0.0]
    return (
        apply(marker.world_from_marker, paper),
        apply(marker.world_from_marker, middles[:, None] + marker.square * corners),
    )


def camera_lines(
    world_from_depth: FloatArray, camera: PinholeCamera | None, rest: FloatArray
) -> list[FloatArray]:
    """Return the frustum's edges and its axis as lines [m], shape (n, 3) each."""
    distance = float(np.linalg.norm(rest.mean(axis=0) - world_from_depth[:3, 3]))
    if camera is None:
        left, top = (-tangent for tangent in _UNKNOWN_FIELD)
        right, bottom = _UNKNOWN_FIELD
    else:
        left, right = -camera.cx / camera.fx, (camera.width - 1 - camera.cx) / camera.fx
        top, bottom = -camera.cy / camera.fy, (camera.height - 1 - camera.cy) / camera.fy
    rectangle = np.array([[left, top, 1], [right, top, 1], [right, bottom, 1], [left, bottom, 1]])
    corners = apply(world_from_depth, _FRUSTUM_LENGTH * distance * rectangle)
    eye = world_from_depth[:3, 3]
    axis = apply(world_from_depth, np.array([[0.0, 0.0, 0.0], [0.0, 0.0, distance]]))
    return [*(np.stack([eye, corner]) for corner in corners), corners[[0, 1, 2, 3, 0]], axis]


def points_around(
    marker: Marker | None,
    rest: FloatArray,
    gravity: FloatArray,
    world_from_depth: FloatArray | None,
) -> FloatArray:
    """Return the body and everything else that a view should take in [m], shape (n, 3)."""
    points = [rest]
    if marker is not None:
        points.append(marker_squares(marker)[0])
    if world_from_depth is not None:
        points.append(world_from_depth[None, :3, 3])
    origin, ends = world_triad(rest)
    points += [origin[None], ends, np.stack(gravity_arrow(rest, gravity))]
    return np.vstack(points)


def surface_regions(scene: Scene) -> IntArray:
    """Return the region number of each surface triangle, shape (F,)."""
    region = np.zeros(scene.mesh.tet_count, dtype=np.int32)
    for number, part in enumerate(scene.regions):
        region[part.tets] = number
    return region[scene.mesh.surface_tets]
