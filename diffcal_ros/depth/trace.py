# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One traced view: depth, outline and the forward derivative of both."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from diffcal_ros.depth import (
    adjoint_kernels,
    derivative_kernels,
    raster_kernels,
    silhouette_kernels,
)
from diffcal_ros.depth.area_image import AreaImage
from diffcal_ros.depth.buffers import TracerBuffers
from diffcal_ros.depth.corner_weights import corner_pairs, corner_weights
from diffcal_ros.depth.facing import facing_cosines
from diffcal_ros.depth.silhouette_segments import make_segments, Segments
from diffcal_ros.warp_runtime.device_array import (
    download,
    float_array,
    int_array,
    point_array,
    zero_floats,
    zero_ints,
)
import numpy as np
from numpy.typing import NDArray
import warp as wp

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]


@dataclass(frozen=True)
class Outline:
    """The visible outline, cut at pixel borders.

    Attributes:
        segments: number of each segment in the walk, shape (P,).
        points: column and row [px] and z [m] in the middle of each segment, shape (P, 3).
        normals: unit, out of the body, shape (P, 2).
        lengths: [px], shape (P,).
        behind: z of the body behind [m], NaN for none, shape (P,).
        edges: surface edge of each segment, shape (P,).
    """

    segments: IntArray
    points: FloatArray
    normals: FloatArray
    lengths: FloatArray
    behind: FloatArray
    edges: IntArray


class Trace:
    """One traced view: a value, whatever its tracer traces later."""

    def __init__(
        self, buffers: TracerBuffers, points: Any, screen: Any, window: Any, depth_steps: float
    ) -> None:
        """Rasterise the front faces.

        Args:
            buffers: of the tracer.
            points: vertices in the camera frame [m], on the device, shape (N,).
            screen: their columns, rows [px] and 1/z [1/m], likewise.
            window: of the image, which holds them all.
            depth_steps: z-buffer steps per 1/z [m].
        """
        self.buffers = buffers
        self.points, self.screen, self.window = points, screen, window
        self.pixel_count: int = window.width * window.height
        self.shape = (int(window.height), int(window.width))
        self.rows = slice(int(window.top), int(window.top) + self.shape[0])
        self.columns = slice(int(window.left), int(window.left) + self.shape[1])
        face_count, device = buffers.face_count, buffers.device
        self.planes = wp.empty(face_count, dtype=raster_kernels.Plane, device=device)
        self.device_faces = wp.empty(self.pixel_count, dtype=wp.int32, device=device)
        self.device_depth = wp.empty(self.pixel_count, dtype=wp.float64, device=device)
        surface = [buffers.triangles, screen]
        buffers.launch(raster_kernels.make_planes, face_count, surface, [self.planes])
        buffers.launch(
            raster_kernels.rasterise,
            face_count,
            [*surface, self.planes, window, wp.float64(depth_steps)],
            [buffers.keys],
        )
        buffers.launch(
            raster_kernels.resolve,
            self.pixel_count,
            [self.planes, window, buffers.keys],
            [self.device_faces, self.device_depth],
        )

    @cached_property
    def depth(self) -> FloatArray:
        """Z at pixel centres within the window [m], shape `shape`; NaN beside the body."""
        return download(self.device_depth).reshape(self.shape)

    @cached_property
    def faces(self) -> IntArray:
        """Triangle seen at each pixel of the window, -1 beside the body."""
        return download(self.device_faces).reshape(self.shape)

    @cached_property
    def facing(self) -> FloatArray:
        """Cosine between each triangle's normal and its line of sight, shape (F,)."""
        return facing_cosines(download(self.points), download(self.buffers.triangles))

    def corner_weights(self, faces: IntArray, directions: FloatArray) -> FloatArray:
        """Return where on triangles pixels see them, see `corner_weights`, shape (n, 3).

        Args:
            faces: triangle that each shows, shape (n,).
            directions: in which each is seen, x / z and y / z, shape (n, 2).
        """
        return corner_weights(self._corner_pairs[faces], directions)

    @cached_property
    def _corner_pairs(self) -> FloatArray:
        return corner_pairs(download(self.points), download(self.buffers.triangles))

    def full_depth(self) -> FloatArray:
        """Return z over the whole image [m], shape (H, W); NaN beside the body."""
        return self.in_image(self.depth)

    def in_image(self, values: FloatArray) -> FloatArray:
        """Put values of the window's pixels in their place in the image, NaN elsewhere.

        Args:
            values: shape `shape`.

        Returns:
            The same over the whole image, shape (H, W).
        """
        camera = self.buffers.camera
        image = np.full((camera.height, camera.width), np.nan)
        image[self.rows, self.columns] = values
        return image

    @cached_property
    def outline(self) -> Outline:
        """The visible outline."""
        segments = self.segments
        lengths = download(segments.lengths)
        seen = np.flatnonzero(lengths > 0.0).astype(np.int32)
        return Outline(
            segments=seen,
            points=segments.points.numpy()[seen],
            normals=segments.normals.numpy()[seen],
            lengths=lengths[seen],
            behind=segments.behind.numpy()[seen],
            edges=segments.edges.numpy()[seen],
        )

    def outline_band(self, reach: int) -> NDArray[np.bool_]:
        """Mark the window's pixels within `reach` of the visible outline, shape `shape`."""
        marks = self.mark(reach)
        band: NDArray[np.bool_] = marks.numpy().reshape(self.shape) != 0
        return band

    def push_depth(self, pixels: IntArray, tangents: FloatArray) -> FloatArray:
        """Push tangents to z at pixel centres that see the body.

        Args:
            pixels: flat indices into the window, shape (M,).
            tangents: camera-frame displacement per unit of each parameter, shape (k, N, 3).

        Returns:
            Change of z [m], shape (M, k).
        """
        buffers = self.buffers
        rates = zero_floats((len(pixels), len(tangents)), buffers.device)
        buffers.launch(
            derivative_kernels.push_centres,
            len(pixels),
            [*self._centres(pixels), self.by_vertex(tangents)],
            [rates],
        )
        return download(rates)

    def push_outline(self, segments: IntArray, tangents: FloatArray) -> FloatArray:
        """Push tangents to the outward motion of outline segments [px], shape (M, k).

        Args:
            segments: entries of `Outline.segments`, shape (M,).
            tangents: camera-frame displacement per unit of each parameter, shape (k, N, 3).
        """
        buffers = self.buffers
        rates = zero_floats((len(segments), len(tangents)), buffers.device)
        buffers.launch(
            derivative_kernels.push_outline,
            len(segments),
            [*self._segments_of(segments), self.by_vertex(tangents)],
            [rates],
        )
        return download(rates)

    def pull_depth(self, pixels: IntArray, by_depth: FloatArray) -> FloatArray:
        """Pull weights of z at pixel centres back to the nodes: `push_depth`'s transpose.

        Args:
            pixels: flat indices into the window, shape (M,).
            by_depth: derivative of a scalar by the depth of each [1/m], shape (M,).
        """
        buffers = self.buffers
        buffers.gradient.zero_()
        buffers.launch(
            adjoint_kernels.pull_centres,
            len(pixels),
            [*self._centres(pixels), float_array(by_depth, buffers.device)],
            [buffers.gradient],
        )
        return download(buffers.gradient)

    def pull_outline(self, segments: IntArray, by_motion: FloatArray) -> FloatArray:
        """Pull weights of the outline's motion back to the nodes: `push_outline`'s transpose.

        Args:
            segments: entries of `Outline.segments`, shape (M,).
            by_motion: derivative of a scalar by the outward motion of each [1/px], shape (M,).
        """
        buffers = self.buffers
        buffers.gradient.zero_()
        buffers.launch(
            adjoint_kernels.pull_outline,
            len(segments),
            [*self._segments_of(segments), float_array(by_motion, buffers.device)],
            [buffers.gradient],
        )
        return download(buffers.gradient)

    def _centres(self, pixels: IntArray) -> list[Any]:
        """Return what kernels of pixel centres read."""
        buffers = self.buffers
        return [
            buffers.triangles,
            self.points,
            self.screen,
            self.planes,
            self.window,
            self.device_faces,
            self.device_depth,
            int_array(pixels, buffers.device),
        ]

    def _segments_of(self, segments: IntArray) -> list[Any]:
        """Return what kernels of outline segments read."""
        buffers = self.buffers
        chosen = int_array(segments, buffers.device)
        return [self.points, buffers.pinhole, buffers.edges, self.segments, chosen]

    def area_image(self, *, side: int = 8, background: float = 0.0) -> AreaImage:
        """Average the pixels on the outline over their area.

        Args:
            side: samples along each side of such a pixel.
            background: value [m] where nothing is seen.
        """
        return AreaImage(self, side, background)

    @cached_property
    def tiles(self) -> Any:
        """The window in squares, each with a list of the front faces in it."""
        buffers, window = self.buffers, self.window
        size = int(raster_kernels.TILE)
        count = -(-int(window.width) // size) * -(-int(window.height) // size)
        tiles: Any = raster_kernels.Tiles()
        tiles.window, tiles.planes = window, self.planes
        counts, ends = (zero_ints(count, buffers.device) for _ in range(2))
        surface = [buffers.triangles, self.screen, self.planes, window]
        face_count = buffers.face_count
        buffers.launch(raster_kernels.count_tiles, face_count, surface, [counts])
        wp.utils.array_scan(counts, ends, inclusive=True)
        total = int(ends[count - 1 : count].numpy()[0])
        members = zero_ints(max(total, 1), buffers.device)
        buffers.launch(raster_kernels.fill_tiles, face_count, [*surface, ends, counts], [members])
        tiles.ends, tiles.members = ends, members
        return tiles

    @cached_property
    def segments(self) -> Segments:
        """The walk along every silhouette edge, hidden segments included."""
        buffers = self.buffers
        edge_count = buffers.edge_count
        buffers.launch(
            silhouette_kernels.count_segments,
            edge_count,
            [self.screen, self.planes, buffers.edges, buffers.edge_faces, self.window],
            [buffers.segment_counts],
        )
        wp.utils.array_scan(buffers.segment_counts, buffers.segment_ends, inclusive=True)
        total = int(buffers.segment_ends[edge_count - 1 : edge_count].numpy()[0])
        segments = make_segments(total, buffers.device)
        buffers.launch(
            silhouette_kernels.walk_edges,
            edge_count,
            [
                buffers.triangles,
                self.screen,
                buffers.edges,
                buffers.edge_faces,
                buffers.segment_ends,
                self.tiles,
            ],
            [segments],
        )
        return segments

    def mark(self, reach: int) -> Any:
        """Return device marks of the pixels within `reach` of the visible outline."""
        buffers, segments = self.buffers, self.segments
        marks = zero_ints(self.pixel_count, buffers.device)
        buffers.launch(
            silhouette_kernels.mark_outline,
            segments.count,
            [segments, self.window, reach],
            [marks],
        )
        return marks

    def by_vertex(self, tangents: FloatArray) -> Any:
        """Return tangents, shape (k, N, 3), on the device as (N, k) vectors."""
        ordered = np.ascontiguousarray(tangents.transpose(1, 0, 2))
        return point_array(ordered, self.buffers.device)
