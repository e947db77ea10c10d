# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A depth image whose outline pixels are area averages, and its derivative both ways."""

from functools import cached_property
from typing import Any, TYPE_CHECKING

from diffcal_ros.depth import area_derivative_kernels, area_kernels
from diffcal_ros.warp_runtime.device_array import (
    download,
    float_array,
    int_array,
    shared,
    zero_ints,
    zero_points,
)
import numpy as np
from numpy.typing import NDArray
import warp as wp

if TYPE_CHECKING:
    from diffcal_ros.depth.trace import Trace

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


class _Parts:
    """Outline pixels and the triangles seen in each."""

    def __init__(self, pixels: NDArray[np.integer[Any]], size: int, device: str) -> None:
        self.count = len(pixels)
        self.pixels = int_array(pixels, device)
        self.faces = zero_ints((self.count, size), device)
        self.sums = zero_points((self.count, size), device)


class AreaImage:
    """A depth image whose outline pixels are area averages: the one that has a derivative.

    A pixel that one straight segment of outline crosses, with one triangle on each side, is cut
    exactly; the others on the outline are sampled.
    """

    def __init__(self, trace: 'Trace', side: int, background: float) -> None:
        self._trace = trace
        self._background = float(background)
        marked, is_straight, last_segment = self._start()
        straight = marked[is_straight]
        is_cut = self._cut_straight(straight, last_segment)
        self._sample(np.concatenate([marked[~is_straight], straight[~is_cut]]), side)

    def _start(self) -> tuple[IntArray, BoolArray, Any]:
        """Take depth at pixel centres, NaN beside the body, and find the pixels on the outline.

        Returns:
            The pixels; which of them one segment crosses; and the last segment that crosses each
            pixel of the window, on the device.
        """
        trace, buffers, segments = self._trace, self._trace.buffers, self._trace.segments
        count, device = trace.pixel_count, buffers.device
        self._image = wp.clone(trace.device_depth)
        self._marks, crossings = (zero_ints(count, device) for _ in range(2))
        last_segment = wp.empty(count, dtype=wp.int32, device=device)
        buffers.launch(
            area_kernels.list_crossings,
            segments.count,
            [segments, trace.window],
            [self._marks, crossings, last_segment],
        )
        marked = np.flatnonzero(self._marks.numpy() != 0)  # Of booleans: five times as fast.
        return marked, crossings.numpy()[marked] == 1, last_segment

    def _cut_straight(self, pixels: IntArray, last_segment: Any) -> BoolArray:
        """Cut pixels that one segment crosses; tell which could be, shape (n,)."""
        buffers, segments = self._trace.buffers, self._trace.segments
        self._cut = _Parts(pixels, 2, buffers.device)
        is_cut = zero_ints(len(pixels), buffers.device)
        buffers.launch(
            area_kernels.cut_pixels,
            len(pixels),
            [
                self._trace.planes,
                self._trace.window,
                self._cut.pixels,
                last_segment,
                segments,
                wp.float64(self._background),
            ],
            [self._cut.faces, self._cut.sums, self._image, is_cut],
        )
        found: BoolArray = is_cut.numpy() != 0
        return found

    def _sample(self, pixels: IntArray, side: int) -> None:
        """Average the rest of the outline's pixels over `side` squared rays each."""
        buffers = self._trace.buffers
        self._sampled = _Parts(pixels, int(area_kernels.PARTS), buffers.device)
        buffers.launch(
            area_kernels.sample_pixels,
            self._sampled.count,
            [
                buffers.triangles,
                self._trace.screen,
                self._trace.tiles,
                self._sampled.pixels,
                side,
                wp.float64(self._background),
            ],
            [self._sampled.faces, self._sampled.sums, self._image],
        )

    @cached_property
    def image(self) -> FloatArray:
        """Mean depth of each pixel of the window [m], shape `Trace.shape`."""
        image = download(self._image).reshape(self._trace.shape)
        np.copyto(image, self._background, where=np.isnan(image))
        return image

    def pull_back(self, by_image: FloatArray) -> FloatArray:
        """Pull a derivative by the window's pixels back to the vertices.

        Args:
            by_image: derivative of a scalar by each pixel [1/m], shape `Trace.shape`.

        Returns:
            Derivative by the camera-frame positions [1/m], shape (N, 3). The derivative by a
            rigid motion of the camera is its sum, see `pose_gradient`.
        """
        trace, buffers = self._trace, self._trace.buffers
        weights = shared(np.asarray(by_image, np.float64).ravel(), wp.float64, buffers.device)
        gradient = buffers.gradient
        gradient.zero_()
        surface = [buffers.triangles, trace.points, trace.screen, trace.planes]
        buffers.launch(
            area_derivative_kernels.pull_back_centres,
            buffers.face_count,
            [*surface, trace.window, trace.device_faces, self._marks, weights],
            [gradient],
        )
        for parts in (self._cut, self._sampled):
            buffers.launch(
                area_derivative_kernels.pull_back_parts,
                parts.count,
                [*surface, parts.pixels, parts.faces, parts.sums, weights],
                [gradient],
            )
        buffers.launch(
            area_derivative_kernels.pull_back_outline,
            trace.segments.count,
            [*self._outline_arguments(), weights],
            [gradient],
        )
        return download(gradient)

    def push_forward(self, tangents: FloatArray) -> FloatArray:
        """Push tangents to every pixel of the window.

        Args:
            tangents: camera-frame displacement per unit of each parameter, shape (k, N, 3).

        Returns:
            Change of the image [m], shape (h, w, k).
        """
        trace, buffers = self._trace, self._trace.buffers
        seen = np.flatnonzero((trace.faces.ravel() >= 0) & (self._marks.numpy() == 0))
        inside = trace.push_depth(seen.astype(np.int32), tangents)
        rates = np.zeros((trace.pixel_count, len(tangents)))
        rates[seen] = inside
        device_rates = float_array(rates, buffers.device)
        by_vertex = trace.by_vertex(tangents)
        for parts in (self._cut, self._sampled):
            buffers.launch(
                area_derivative_kernels.push_parts,
                parts.count,
                [
                    buffers.triangles,
                    trace.points,
                    trace.screen,
                    trace.planes,
                    parts.pixels,
                    parts.faces,
                    parts.sums,
                    by_vertex,
                ],
                [device_rates],
            )
        buffers.launch(
            area_derivative_kernels.push_outline_area,
            trace.segments.count,
            [*self._outline_arguments(), by_vertex],
            [device_rates],
        )
        return download(device_rates).reshape(*trace.shape, len(tangents))

    def _outline_arguments(self) -> list[Any]:
        trace, buffers = self._trace, self._trace.buffers
        return [
            trace.points,
            buffers.pinhole,
            trace.window,
            buffers.edges,
            trace.segments,
            wp.float64(self._background),
        ]
