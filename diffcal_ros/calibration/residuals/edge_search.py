# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Find the observed edge of the body near each segment of the rendered outline.

A truncated depth residual cannot say how far an outline is off: it is constant beyond the edge.
The distance along the outline's normal to where the observed depth leaves the body can, and
Gauss-Newton converges on it in a few steps.
"""

from typing import Any

from diffcal_ros.calibration.residuals.edge_search_kernels import search_edges
from diffcal_ros.depth.trace import Outline
from diffcal_ros.warp_runtime.device_array import (
    download,
    float_array,
    point_array,
    upload,
    zero_floats,
)
import numpy as np
from numpy.typing import NDArray
import warp as wp

FloatArray = NDArray[np.float64]


class ObservedImage:
    """One observed depth image on a device."""

    def __init__(self, depth: NDArray[np.float32], masked: NDArray[np.bool_], device: str) -> None:
        """Upload an image.

        Args:
            depth: z [m], shape (H, W), NaN where invalid.
            masked: True where nothing may be judged, shape (H, W).
            device: Warp device.
        """
        self._device = device
        self._depth: Any = wp.array(depth, dtype=wp.float32, device=device)
        self._masked: Any = wp.array(masked.astype(np.uint8), dtype=wp.uint8, device=device)

    def replace(self, depth: NDArray[np.float32]) -> None:
        """Upload another image of the same size [m], NaN where invalid."""
        upload(self._depth, depth)

    def edge_distances(self, outline: Outline, tolerances: FloatArray, reach: int) -> FloatArray:
        """Return the signed distance from each outline segment to the observed edge.

        Args:
            outline: the rendered outline with P segments.
            tolerances: how far observed depth may be from the outline's to count as the body
                [m], shape (P,); 0 skips a segment.
            reach: how far to look [px].

        Returns:
            Outward distance [px], shape (P,); NaN where no edge was found.
        """
        count = len(outline.lengths)
        distances = zero_floats(count, self._device)
        wp.launch(
            search_edges,
            dim=count,
            inputs=[
                self._depth,
                self._masked,
                point_array(outline.points, self._device),
                wp.array(outline.normals, dtype=wp.vec2d, device=self._device),
                float_array(tolerances, self._device),
                reach,
            ],
            outputs=[distances],
            device=self._device,
        )
        return download(distances)
