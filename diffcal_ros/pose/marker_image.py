# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Draw a marker as a camera sees it: perspective, lens distortion, anti-aliased."""

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import PoseError
from diffcal_ros.pose.dictionary import marker_cells
from diffcal_ros.pose.lens import distort, undistort
from diffcal_ros.rigid_transform import apply, check_rigid
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
ByteArray = NDArray[np.uint8]


def draw_marker(
    background: ByteArray,
    *,
    camera: PinholeCamera,
    camera_from_marker: FloatArray,
    dictionary: str,
    marker_id: int,
    side: float,
    quiet_zone: float = 1.0,
    black: int = 20,
    white: int = 225,
    samples: int = 8,
) -> ByteArray:
    """Draw one marker print onto a copy of an image; seen from behind, it is a white sheet.

    Args:
        background: BGR, shape (H, W, 3), of the camera's size.
        camera: intrinsics, distortion included.
        camera_from_marker: pose of the marker, shape (4, 4).
        dictionary: OpenCV's name.
        marker_id: number in it.
        side: edge of the black square [m].
        quiet_zone: width of the white rim, in squares of the marker.
        black: grey level of the ink.
        white: grey level of the paper.
        samples: rays along each side of a pixel.

    Returns:
        BGR, shape (H, W, 3).

    Raises:
        PoseError: when the marker lies behind the camera, or the image has another size.
    """
    check_rigid('camera_from_marker', camera_from_marker)
    if background.shape != (camera.height, camera.width, 3):
        raise PoseError(
            f'background is {background.shape}: the camera needs '
            f'{(camera.height, camera.width, 3)}'
        )
    cells = marker_cells(dictionary, marker_id)
    reach = side / 2.0 + quiet_zone * side / len(cells)
    left, top, right, bottom = _window(camera, camera_from_marker, reach)
    image: ByteArray = background.copy()
    if left >= right or top >= bottom:
        return image
    offsets = (np.arange(samples) + 0.5) / samples - 0.5
    columns = (np.arange(left, right)[:, None] + offsets).ravel()
    rows = (np.arange(top, bottom)[:, None] + offsets).ravel()
    points = _on_marker(camera, camera_from_marker, columns, rows)
    on_print = np.asarray((np.abs(points) <= reach).all(axis=-1), dtype=np.float64)
    index = np.floor((points * [1.0, -1.0] / side + 0.5) * len(cells))
    on_square = ((index >= 0) & (index < len(cells))).all(axis=-1) & _is_front(camera_from_marker)
    column, row = np.clip(index, 0, len(cells) - 1).astype(int).transpose(2, 0, 1)
    is_ink = on_square & ~cells[row, column]
    shade = (white - (white - black) * is_ink) * on_print
    coverage = _mean_of_blocks(on_print, samples)
    ink = _mean_of_blocks(shade, samples)
    under = image[top:bottom, left:right]
    mixed = ink[..., None] + (1.0 - coverage[..., None]) * under
    image[top:bottom, left:right] = np.clip(np.rint(mixed), 0, 255).astype(np.uint8)
    return image


def _is_front(camera_from_marker: FloatArray) -> bool:
    """Tell whether the printed side faces the camera."""
    return bool(camera_from_marker[:3, 2] @ camera_from_marker[:3, 3] < 0.0)


def _window(
    camera: PinholeCamera, camera_from_marker: FloatArray, reach: float
) -> tuple[int, int, int, int]:
    """Return the pixels that the print may cover: left, top, right and bottom, exclusive."""
    # Distortion bends the sides: points along them bound the print better than its corners.
    side = np.linspace(-reach, reach, 9)
    rim = np.concatenate(
        [np.stack([side, np.full(9, end)], axis=1) for end in (-reach, reach)]
        + [np.stack([np.full(9, end), side], axis=1) for end in (-reach, reach)]
    )
    points = apply(camera_from_marker, np.hstack([rim, np.zeros((len(rim), 1))]))
    if points[:, 2].min() <= 0.0:
        raise PoseError('the marker lies behind the camera: place it at positive z')
    pixels = distort(camera.project(points), camera)
    low = np.floor(pixels.min(axis=0)).astype(int) - 1
    high = np.ceil(pixels.max(axis=0)).astype(int) + 2
    left, top = np.maximum(low, 0)
    right, bottom = np.minimum(high, [camera.width, camera.height])
    return int(left), int(top), int(right), int(bottom)


def _on_marker(
    camera: PinholeCamera, camera_from_marker: FloatArray, columns: FloatArray, rows: FloatArray
) -> FloatArray:
    """Intersect pixel rays with the marker's plane: (x, y) [m], shape (rows, columns, 2)."""
    pixels = undistort(np.stack(np.meshgrid(columns, rows), axis=-1), camera)
    # A point (x, y) of the plane lands on pixel ~ homography @ (x, y, 1).
    homography = camera.K @ camera_from_marker[:3][:, [0, 1, 3]]
    lifted = np.concatenate([pixels, np.ones((*pixels.shape[:2], 1))], axis=-1)
    plane = lifted @ np.linalg.inv(homography).T
    points: FloatArray = plane[..., :2] / plane[..., 2:]
    return points


def _mean_of_blocks(values: FloatArray, size: int) -> FloatArray:
    rows, columns = values.shape[0] // size, values.shape[1] // size
    means: FloatArray = values.reshape(rows, size, columns, size).mean(axis=(1, 3))
    return means
