# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Colour images of a stage: plain shading, the marker's print, blur and noise."""

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.marker import Marker
from diffcal_ros.pose.lens import undistort
from diffcal_ros.pose.marker_image import draw_print
from diffcal_ros.pose.marker_print import print_of
from diffcal_ros.synthetic.scan import Scan, Thing
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

ByteArray = NDArray[np.uint8]
FloatArray = NDArray[np.float64]

# Blue, green and red of each thing where light falls on it squarely.
_COLORS = {
    Thing.NOTHING: (24, 22, 20),
    Thing.BODY: (176, 196, 226),
    Thing.PLATE: (205, 205, 205),
    Thing.BLOCK: (92, 84, 78),
    Thing.WALL: (128, 134, 132),
}
_AMBIENT = 0.35
_BLUR = 0.6  # Of a lens and a sensor's colour filter [px].
_NOISE = 1.2  # Grey levels.


def pixel_rays(camera: PinholeCamera) -> FloatArray:
    """Return viewing rays with z = 1, lens distortion undone, shape (H, W, 3)."""
    if not camera.is_distorted:
        return camera.rays()
    columns, rows = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    pixels = undistort(np.stack([columns, rows], axis=-1).astype(np.float64), camera)
    return np.dstack(
        [
            (pixels[..., 0] - camera.cx) / camera.fx,
            (pixels[..., 1] - camera.cy) / camera.fy,
            np.ones(pixels.shape[:2]),
        ]
    )


def paint_scan(
    scan: Scan,
    camera: PinholeCamera,
    camera_from_world: FloatArray,
    marker: Marker | None,
) -> FloatArray:
    """Paint what a colour camera sees, without noise.

    Args:
        scan: from its pose.
        camera: its intrinsics.
        camera_from_world: its pose, shape (4, 4).
        marker: printed on the plate (a single one or a board), or None.

    Returns:
        Grey levels of blue, green and red, shape (H, W, 3).
    """
    palette = np.array([_COLORS[thing] for thing in Thing], dtype=np.float64)
    light = _AMBIENT + (1.0 - _AMBIENT) * np.clip(scan.cosine, 0.0, 1.0)
    image = palette[scan.things] * light[..., None]
    if marker is not None:
        printed = draw_print(
            np.clip(np.rint(image), 0, 255).astype(np.uint8),
            print_of(marker),
            camera=camera,
            camera_from_marker=camera_from_world @ marker.world_from_marker,
        )
        image = np.where((scan.things == Thing.PLATE)[..., None], printed, image)
    blurred: FloatArray = ndimage.gaussian_filter(image, (_BLUR, _BLUR, 0.0))
    return blurred


def expose(image: FloatArray, random: np.random.Generator) -> ByteArray:
    """Take one noisy picture: BGR, shape (H, W, 3).

    The noise is that of a grey image: colour filters share their neighbours' noise.
    """
    noise = _NOISE * random.standard_normal(image.shape[:2])
    return np.clip(np.rint(image + noise[..., None]), 0, 255).astype(np.uint8)
