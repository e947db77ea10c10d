# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A rigid part compared with a depth image at some pose: depth and outline, with derivatives."""

from dataclasses import dataclass

from diffcal_ros.calibration.forward.sensor_model import SurfacePlaces
from diffcal_ros.calibration.forward.solution import View
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.observations.pixel_masks import pixels_left_out, ViewMask
from diffcal_ros.calibration.residuals.robust_residual import Comparison, Reach, ViewComparer
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth.trace import Trace
from diffcal_ros.depth.tracer import DepthTracer, OutOfViewError
from diffcal_ros.rigid_motion import moved_by
from diffcal_ros.rigid_transform import apply
from diffcal_ros.scene.model import Fixture, Masks
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation

BoolArray = NDArray[np.bool_]
FloatArray = NDArray[np.float64]

# So near to the body a pixel may be the body's, and an edge is not found [px].
_BESIDE, _BESIDE_EDGE = 4, 10
# Of more pixels than that every second, third, .. is taken.
_MOST_PIXELS, _MOST_FINALLY = 6000, 40_000


@dataclass(frozen=True)
class Sights:
    """What is compared at one pose; M values of depth, L of outline.

    Attributes:
        values: measured less rendered [m], shape (M,) and (L,).
        weights: pixels, or pixels of outline, that each stands for, likewise.
        pixels: column and row, shape (M, 2) and (L, 2).
        jacobian: of the rendered side by a shift and a turn about the pivot, (M, 6) and (L, 6).
        normals: of the outline, shape (L, 2).
        scale: metres per pixel on the outline, shape (L,).
        missing: pixels of depth and of outline that were rendered and not found.
        pixel_size: metres per pixel in the middle of the part.
    """

    values: tuple[FloatArray, FloatArray]
    weights: tuple[FloatArray, FloatArray]
    pixels: tuple[FloatArray, FloatArray]
    jacobian: tuple[FloatArray, FloatArray]
    normals: FloatArray
    scale: FloatArray
    missing: tuple[float, float]
    pixel_size: float


class RigidImage:
    """One rigid part before one camera.

    Attributes:
        depth: z [m], shape (H, W).
        left: the same, NaN where it is left out.
        pivot: middle of the part in the object frame [m], shape (3,).
        radius: of the part about it, root mean square [m].
    """

    def __init__(
        self,
        fixture: Fixture,
        depth: NDArray[np.float32],
        camera: PinholeCamera,
        masks: Masks,
        body: tuple[FloatArray, NDArray[np.int32]] | None = None,
    ) -> None:
        """Prepare tracers.

        Args:
            fixture: the part.
            depth: z [m], shape (H, W), NaN where invalid.
            camera: of the image.
            masks: what is left out of it.
            body: vertices [m] and triangles of the body at rest in the same frame, which may
                stand before the part; None: it is not known.
        """
        observation = Observation('', 0, depth, camera, np.eye(4))
        self.depth = depth
        self.left = np.where(pixels_left_out(observation, masks), np.float32(np.nan), depth)
        self.positions = fixture.positions
        self.pivot: FloatArray = 0.5 * (
            fixture.positions.min(axis=0) + fixture.positions.max(axis=0)
        )
        self.radius = float(np.sqrt(((self.positions - self.pivot) ** 2).sum(axis=1).mean()))
        self._tracer = DepthTracer(fixture.triangles, len(fixture.positions), camera)
        nothing = np.zeros(len(fixture.triangles), dtype=bool)
        no_edge = np.zeros(len(self._tracer.edge_vertices), dtype=bool)
        mask = ViewMask(pixels_left_out(observation, masks), nothing, no_edge)
        self._comparer = ViewComparer(
            observation, self._tracer, mask, masks, 'cpu', SurfacePlaces(nothing)
        )
        self._body = body
        self._body_tracer = None if body is None else DepthTracer(body[1], len(body[0]), camera)

    def view(self, depth_from_object: FloatArray) -> View:
        """Return the part at a pose.

        Raises:
            OutOfViewError: when the camera does not see it.
        """
        view = View(apply(depth_from_object, self.positions), self._tracer)
        view.trace  # noqa: B018  It is traced when it is first asked for.
        return view

    def body_trace(
        self, depth_from_object: FloatArray, positions: FloatArray | None = None
    ) -> Trace | None:
        """Return the body as the camera sees it; None: there is none in view.

        Args:
            depth_from_object: pose, shape (4, 4).
            positions: of its vertices in the object frame [m]; None: at rest.
        """
        if self._body is None or self._body_tracer is None:
            return None
        try:
            return self._body_tracer.trace(
                apply(depth_from_object, self._body[0] if positions is None else positions)
            )
        except OutOfViewError:
            return None

    def compare(self, view: View, reach: Reach) -> Comparison:
        """Compare the part with what was seen of it."""
        return self._comparer.compare(view, reach)

    def sights(self, depth_from_object: FloatArray, reach: Reach, *, is_final: bool) -> Sights:
        """Compare and differentiate.

        Args:
            depth_from_object: pose, shape (4, 4).
            reach: how far to look.
            is_final: take all pixels but those that the body at rest stands before.

        Raises:
            OutOfViewError: when the camera does not see the part.
        """
        view = self.view(depth_from_object)
        compared = self.compare(view, reach)
        tangents = self.tangents(view.points, apply(depth_from_object, self.pivot))
        depth, edge = compared.depth, compared.edge
        inside = np.arange(len(depth.values))
        outline = np.arange(len(edge.values))
        shown = self._body_pixels(view, depth_from_object) if is_final else None
        if shown is not None:
            body, covered = shown
            near = binary_dilation(covered, iterations=_BESIDE)
            inside = inside[~near[depth.pixels[:, 1], depth.pixels[:, 0]]]
            near = binary_dilation(body, iterations=_BESIDE_EDGE)
            height, width = near.shape
            columns, rows = edge.pixels.T
            outline = outline[~near[np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1)]]
        step = max(1, -(-len(inside) // (_MOST_FINALLY if is_final else _MOST_PIXELS)))
        inside = inside[::step]
        trace = view.trace
        chosen = edge.indices[outline]
        places = np.searchsorted(trace.outline.segments, chosen)
        scale = compared.edge_scale[outline]
        return Sights(
            (depth.values[inside], edge.values[outline]),
            (step * depth.weights[inside], edge.weights[outline]),
            (
                depth.pixels[inside].astype(np.float64),
                trace.outline.points[places, :2],
            ),
            (
                trace.push_depth(depth.indices[inside], tangents),
                trace.push_outline(chosen, tangents) * scale[:, None],
            ),
            trace.outline.normals[places],
            scale,
            (depth.missing, edge.missing),
            float(np.median(view.points[:, 2])) / self._tracer.camera.fx,
        )

    @staticmethod
    def tangents(points: FloatArray, pivot: FloatArray) -> FloatArray:
        """Return how points follow a shift and a turn about a pivot, shape (6, N, 3)."""
        return np.stack([moved_by(points, np.zeros(6), pivot, axis) for axis in range(6)])

    def _body_pixels(
        self, view: View, depth_from_object: FloatArray
    ) -> tuple[BoolArray, BoolArray] | None:
        """Tell where the body at rest is, hidden or not, and where it stands before the part.

        An edge of the part near the body may be taken for the body's, also where that lies behind.

        Returns:
            Shape (H, W) each; None: there is no body.
        """
        body = self.body_trace(depth_from_object)
        if body is None:
            return None
        depth = body.full_depth()
        far = np.nan_to_num(view.trace.full_depth(), nan=np.inf)
        return np.isfinite(depth), np.nan_to_num(depth, nan=np.inf) < far
