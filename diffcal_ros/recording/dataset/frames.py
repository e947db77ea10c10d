# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Frames and poses of the public data set, from their NumPy files."""

from pathlib import Path
from typing import Any

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth_frame import DepthArray, DepthFrame
from diffcal_ros.errors import RecordingError
from diffcal_ros.recording.topics.color_frame import ByteArray, ColorFrame
from diffcal_ros.recording.topics.names import COLOR_FRAME, DEPTH_FRAME
from diffcal_ros.rigid_transform import check_rigid, FloatArray
import numpy as np
from numpy.typing import NDArray


def load_depth(path: Path, stamp_ns: int, camera: PinholeCamera) -> DepthFrame:
    """Read a depth image; zero means invalid.

    Raises:
        RecordingError: when the file holds no depth image of the camera's size.
    """
    values = _load(path)
    if values.shape != (camera.height, camera.width) or values.dtype.kind != 'f':
        raise RecordingError(
            f'{path} holds {values.dtype} of shape {values.shape}: depth in metres of shape '
            f'{(camera.height, camera.width)} is needed'
        )
    depth: DepthArray = values.astype(np.float32)
    depth[~(np.isfinite(depth) & (depth > 0.0))] = np.nan
    return DepthFrame(depth, stamp_ns, DEPTH_FRAME)


def load_color(path: Path, stamp_ns: int, camera: PinholeCamera) -> ColorFrame:
    """Read a colour image, BGR.

    Raises:
        RecordingError: when the file holds no colour image of the camera's size.
    """
    values = _load(path)
    if values.shape != (camera.height, camera.width, 3) or values.dtype != np.uint8:
        raise RecordingError(
            f'{path} holds {values.dtype} of shape {values.shape}: bytes of shape '
            f'{(camera.height, camera.width, 3)} are needed'
        )
    image: ByteArray = values
    return ColorFrame(image, stamp_ns, COLOR_FRAME)


def load_pose(path: Path) -> FloatArray:
    """Read one of the authors' color_from_marker, shape (4, 4).

    Raises:
        RecordingError: when the file holds no rigid transform.
    """
    try:
        return check_rigid(path.name, _load(path))
    except ValueError as error:
        raise RecordingError(f'{path}: {error}') from error


def _load(path: Path) -> NDArray[Any]:
    try:
        values = np.load(path, allow_pickle=False)
    except (OSError, ValueError, EOFError) as error:
        raise RecordingError(
            f'{path} cannot be read as a NumPy array ({error}): complete the clone of the data '
            'set (large files may be pointers that git-lfs has to fetch)'
        ) from error
    if not isinstance(values, np.ndarray):
        raise RecordingError(f'{path} holds several arrays: one is needed')
    return values
