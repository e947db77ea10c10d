# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Draw a marker or a board as a camera sees it: perspective, lens distortion, anti-aliased."""

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import PoseError
from diffcal_ros.pose.dictionary import marker_cells
from diffcal_ros.pose.lens import distort, undistort
from diffcal_ros.pose.marker_print import MarkerPrint, Print
from diffcal_ros.rigid_transform import apply, check_rigid
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
ByteArray = NDArray[np.uint8]

_SAMPLES = 8  # Rays along each side of a pixel.
_RAYS_AT_ONCE = 200_000  # So that a print that fills the image stays in the cache.


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
) -> ByteArray:
    """Draw one marker; see `draw_print`.

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
    """
    return draw_print(
        background,
        MarkerPrint(marker_cells(dictionary, marker_id), side, quiet_zone),
        camera=camera,
        camera_from_marker=camera_from_marker,
        black=black,
        white=white,
    )


def draw_print(
    background: ByteArray,
    sheet: Print,
    *,
    camera: PinholeCamera,
    camera_from_marker: FloatArray,
    black: int = 20,
    white: int = 225,
) -> ByteArray:
    """Draw a print onto a copy of an image; seen from behind, it is a white sheet.

    Args:
        background: BGR, shape (H, W, 3), of the camera's size.
        sheet: what is printed.
        camera: intrinsics, distortion included.
        camera_from_marker: pose of the print, shape (4, 4).
        black: grey level of the ink.
        white: grey level of the paper.

    Returns:
        BGR, shape (H, W, 3).

    Raises:
        PoseError: when the print lies behind the camera, or the image has another size.
    """
    check_rigid('camera_from_marker', camera_from_marker)
    if background.shape != (camera.height, camera.width, 3):
        raise PoseError(
            f'background is {background.shape}: the camera needs '
            f'{(camera.height, camera.width, 3)}'
        )
    left, top, right, bottom = _window(camera, camera_from_marker, sheet.reach)
    image: ByteArray = background.copy()
    if left >= right or top >= bottom:
        return image
    height = max(1, _RAYS_AT_ONCE // (_SAMPLES**2 * (right - left)))
    for first in range(top, bottom, height):
        lines = np.arange(first, min(first + height, bottom))
        points = _on_marker(camera, camera_from_marker, _rays(camera, left, right, lines))
        on_print = np.asarray((np.abs(points) <= sheet.reach).all(axis=-1), dtype=np.float64)
        is_ink = sheet.has_ink(points) & _is_front(camera_from_marker)
        coverage = _mean_of_blocks(on_print, _SAMPLES)
        ink = _mean_of_blocks((white - (white - black) * is_ink) * on_print, _SAMPLES)
        under = image[lines, left:right]
        mixed = ink[..., None] + (1.0 - coverage[..., None]) * under
        image[lines, left:right] = np.clip(np.rint(mixed), 0, 255).astype(np.uint8)
    return image


def _is_front(camera_from_marker: FloatArray) -> bool:
    """Tell whether the printed side faces the camera."""
    return bool(camera_from_marker[:3, 2] @ camera_from_marker[:3, 3] < 0.0)


def _window(
    camera: PinholeCamera, camera_from_marker: FloatArray, reach: FloatArray
) -> tuple[int, int, int, int]:
    """Return the pixels that the print may cover: left, top, right and bottom, exclusive."""
    # Distortion bends the sides: points along them bound the print better than its corners.
    side = np.linspace(-1.0, 1.0, 9)
    rim = reach * np.concatenate(
        [np.stack([side, np.full(9, end)], axis=1) for end in (-1.0, 1.0)]
        + [np.stack([np.full(9, end), side], axis=1) for end in (-1.0, 1.0)]
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


def _rays(camera: PinholeCamera, left: int, right: int, lines: NDArray[np.int64]) -> FloatArray:
    """Return where a pinhole would see samples of pixels [px], shape (rows, columns, 2).

    Within a pixel a lens is straight: only the pixels' corners are freed of its distortion.
    """
    edges = np.meshgrid(np.arange(left, right + 1) - 0.5, np.arange(lines[0], lines[-1] + 2) - 0.5)
    corners = undistort(np.stack(edges, axis=-1), camera)
    return _between(_between(corners).swapaxes(0, 1)).swapaxes(0, 1)


def _between(values: FloatArray) -> FloatArray:
    """Put samples between neighbours along the first axis."""
    fraction = ((np.arange(_SAMPLES) + 0.5) / _SAMPLES).reshape(-1, *[1] * (values.ndim - 1))
    steps = values[1:] - values[:-1]
    return (values[:-1, None] + fraction * steps[:, None]).reshape(-1, *values.shape[1:])


def _on_marker(
    camera: PinholeCamera, camera_from_marker: FloatArray, pixels: FloatArray
) -> FloatArray:
    """Intersect rays with the marker's plane: (x, y) [m], shape (rows, columns, 2)."""
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
