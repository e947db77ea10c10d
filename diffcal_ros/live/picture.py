# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the model sees, for those who look on."""

from dataclasses import dataclass

from diffcal_ros.calibration.forward.solution import View
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth_frame import DepthFrame
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
DepthArray = NDArray[np.float32]


@dataclass(frozen=True)
class Picture:
    """The shown observation as the model sees it.

    Attributes:
        rendered: depth that the sensor would read [m], shape (H, W), NaN beside the body.
        residual: observed less rendered depth [m], shape (H, W), NaN where either is missing.
        points: nodes of the deformed body in the depth camera's frame [m], shape (N, 3).
        triangles: its surface, shape (F, 3).
        camera: of both images.
        stamp_ns: of the newest frame used [ns].
        frame_id: of the depth camera.
    """

    rendered: DepthArray
    residual: DepthArray
    points: FloatArray
    triangles: NDArray[np.int32]
    camera: PinholeCamera
    stamp_ns: int
    frame_id: str


def draw_picture(
    view: View,
    read: FloatArray,
    observed: DepthArray,
    triangles: NDArray[np.int32],
    camera: PinholeCamera,
    newest: DepthFrame,
) -> Picture:
    """Draw a view beside what was observed.

    Args:
        view: of the model.
        read: depth that the sensor would read there [m], shape (H, W), NaN beside the body.
        observed: depth [m], shape (H, W), NaN where invalid.
        triangles: the body's surface, shape (F, 3).
        camera: of the depth images.
        newest: frame used; gives stamp and frame.
    """
    rendered = read.astype(np.float32)
    return Picture(
        rendered=rendered,
        residual=observed - rendered,
        points=view.points,
        triangles=triangles,
        camera=camera,
        stamp_ns=newest.stamp_ns,
        frame_id=newest.frame_id,
    )
