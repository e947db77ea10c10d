# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The default comparison: depth inside the body, distance at its outline, both robust.

Inside the outline the residual is observed less rendered depth. On the outline it is how far the
observed edge lies outside the rendered one, in metres at the body. A beam that sags across the
view moves its outline and hardly any depth; a beam that sags along it does the opposite.
Background, clamp and whatever stands in front weigh nothing.
"""

from dataclasses import dataclass, replace
from enum import Enum

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.forward.sensor_model import EXACT_SENSOR, SensorModel, SurfacePlaces
from diffcal_ros.calibration.forward.solution import View
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.observations.pixel_masks import (
    make_view_mask,
    ViewMask,
)
from diffcal_ros.calibration.residuals.edge_search import ObservedImage
from diffcal_ros.calibration.residuals.measured_body import (
    measured_fractions,
    MeasuredShares,
    SimulatedView,
)
from diffcal_ros.depth.trace import Outline, Trace
from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.effects.site import SeenPixels
from diffcal_ros.scene.model import Masks
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

BoolArray = NDArray[np.bool_]
FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]

# Behind a self-occluding outline the step in depth must be clear: none counts below the first
# figure [m], all above the second.
_STEP_FAINT = 0.010
_STEP_CLEAR = 0.030
# How to look beside an outline for a surface that is seen too flat [px].
_BESIDE_STEP, _BESIDE_REACH = 0.5, 4.0
# A surface that is thinner than a pixel here may be thicker so far on [px].
_NEARBY = 5.0
# What a sensor loses at a step from one part of the body to another [px].
_LOST_AT_STEP = 1.5


class ResidualKind(Enum):
    """What residuals compare."""

    DEPTH = 'depth'
    EDGE = 'edge'

    @property
    def dimension(self) -> int:
        """2 for pixels of depth, which fill an area, 1 for segments of outline."""
        return 2 if self is ResidualKind.DEPTH else 1


@dataclass(frozen=True)
class Reach:
    """How far a comparison looks.

    Attributes:
        depth: depth residuals beyond this are not the body [m].
        edge_depth: observed depth this close to the outline's is the body [m].
        edge_pixels: how far to look for the observed edge [px].
    """

    depth: float
    edge_depth: float
    edge_pixels: int

    def of(self, kind: ResidualKind) -> float:
        """Return what residuals of one kind stay below [m]."""
        return self.depth if kind is ResidualKind.DEPTH else self.edge_depth


@dataclass(frozen=True)
class Residuals:
    """Residuals of one kind in one view.

    Attributes:
        kind: what they compare.
        values: [m], shape (M,).
        weights: share of an independent pixel or of a pixel of outline, shape (M,).
        pixels: column and row of each in the image, shape (M, 2).
        indices: pixel of the window (depth) or segment of the outline (edge), shape (M,).
        missing: summed weight of what was rendered and not found.
    """

    kind: ResidualKind
    values: FloatArray
    weights: FloatArray
    pixels: IntArray
    indices: IntArray
    missing: float

    def chosen(self, kept: BoolArray) -> 'Residuals':
        """Return some of them; what is missing stays."""
        return replace(
            self,
            values=self.values[kept],
            weights=self.weights[kept],
            pixels=self.pixels[kept],
            indices=self.indices[kept],
        )


@dataclass(frozen=True)
class Comparison:
    """One view compared with its observation.

    Attributes:
        depth: inside the outline.
        edge: on the outline.
        edge_scale: metres at the body per pixel for each edge residual, shape (M,).
        difference: observed less rendered depth over the window [m], NaN where either is missing.
        counted: rendered and unmasked pixels of the window.
    """

    depth: Residuals
    edge: Residuals
    edge_scale: FloatArray
    difference: FloatArray
    counted: BoolArray

    def of(self, kind: ResidualKind) -> Residuals:
        """Return residuals of one kind."""
        return self.depth if kind is ResidualKind.DEPTH else self.edge

    @property
    def both(self) -> tuple[Residuals, Residuals]:
        """Residuals inside the outline and on it."""
        return self.depth, self.edge


class ViewComparer:
    """Compares views with one observation.

    Attributes:
        mask: what is left out.
        surface: of what is before the camera.
    """

    def __init__(
        self,
        observation: Observation,
        tracer: DepthTracer,
        mask: ViewMask,
        masks: Masks,
        device: str,
        surface: SurfacePlaces,
    ) -> None:
        """Prepare one observation.

        Args:
            observation: what was seen.
            tracer: of the body.
            mask: what is left out.
            masks: the scene's.
            device: Warp device.
            surface: of what is before the camera.
        """
        self.mask = mask
        self.surface = surface
        self._observation = observation
        self._tracer = tracer
        self._masks = masks
        self._image = ObservedImage(observation.depth, mask.image, device)
        self._last: tuple[View, Reach, Comparison] | None = None

    def show(self, depth: NDArray[np.float32]) -> None:
        """Compare with another image of the same camera from now on [m], shape (H, W)."""
        self._observation = replace(self._observation, depth=depth)
        self._image.replace(depth)
        self._last = None

    def compare(self, view: View, reach: Reach, sensor: SensorModel = EXACT_SENSOR) -> Comparison:
        """Compare one view, as the sensor would read it.

        A step of a fit asks for a view's cost, its scale and its slope: the last comparison with
        an exact sensor is kept.
        """
        if not sensor.is_exact:
            return self._compare(view, reach, sensor)
        if self._last is None or self._last[0] is not view or self._last[1] != reach:
            self._last = view, reach, self._compare(view, reach, sensor)
        return self._last[2]

    def _compare(self, view: View, reach: Reach, sensor: SensorModel) -> Comparison:
        trace = view.trace
        difference = self.observed(trace) - self.read(trace, sensor)
        counted, comparable = self.pixels(view)
        edge, edge_scale = self.edges(trace.outline, reach)
        return Comparison(
            depth=self._depths(trace, difference, comparable, reach),
            edge=edge,
            edge_scale=edge_scale,
            difference=difference,
            counted=counted,
        )

    def observed(self, trace: Trace) -> FloatArray:
        """Return the observed depth in the window of a view [m], NaN where invalid."""
        return self._observation.depth[trace.rows, trace.columns].astype(np.float64)

    def read(self, trace: Trace, sensor: SensorModel) -> FloatArray:
        """Return the rendered depth as the sensor would read it [m], NaN beside the body."""
        if sensor.is_exact:
            return trace.depth
        return sensor.reading(self.surface.seen(trace, self._directions(trace)))

    def pixels(self, view: View) -> tuple[BoolArray, BoolArray]:
        """Tell which pixels of the window are unmasked body, and which of them are compared.

        Those that are seen too flat, or lie too close to the outline, are not.
        """
        trace = view.trace
        faces = np.maximum(trace.faces, 0)
        counted = (trace.faces >= 0) & ~self.mask.triangles[faces]
        counted &= ~self.mask.image[trace.rows, trace.columns]
        comparable = counted & ~self._seen_too_flat(view, faces)
        band = int(np.ceil(self._masks.silhouette_band))
        if band > 0:
            comparable &= ~trace.outline_band(band)
        return counted, comparable

    def simulated(self, trace: Trace, read: FloatArray, counted: BoolArray) -> SimulatedView:
        """Put what is read and counted in a window in its place in the image."""
        image = np.zeros(self._observation.depth.shape, dtype=bool)
        image[trace.rows, trace.columns] = counted
        return SimulatedView(trace.in_image(read), image, self.mask.image)

    def measured_fractions(self, view: View, sensor: SensorModel = EXACT_SENSOR) -> MeasuredShares:
        """Find what of the measured body the view leaves unexplained, and what hides it."""
        counted, _ = self.pixels(view)
        simulated = self.simulated(view.trace, self.read(view.trace, sensor), counted)
        return self.fractions_of(self._observation.depth, simulated)

    def fractions_of(self, depth: NDArray[np.float32], simulated: SimulatedView) -> MeasuredShares:
        """Find the same for an image of this camera [m], shape (H, W)."""
        return measured_fractions(
            depth,
            simulated,
            self._observation.camera,
            truncation=self._masks.truncation,
            band=self._masks.silhouette_band,
            steepest=self._masks.grazing_angle,
        )

    def is_second(self, trace: Trace) -> BoolArray:
        """Tell which pixels of the window show another material than the first."""
        return self.surface.seen(trace, self._directions(trace)).is_second

    def places(self, trace: Trace, pixels: IntArray) -> FloatArray:
        """Return where some pixels of the window see the body, see `BodyAxes.on_surface`."""
        directions = self._directions(trace).reshape(-1, 2)[pixels]
        return self.surface.places_at(trace, trace.faces.ravel()[pixels], directions)

    def shares(self, trace: Trace, pixels: IntArray) -> FloatArray:
        """Return how far along the body some pixels of the window see it, (M,)."""
        return self.places(trace, pixels)[:, 0]

    def seen(self, view: View, indices: IntArray) -> SeenPixels:
        """Return what errors of the sensor may know of some pixels of the window, (M,) each."""
        return self.surface.seen(view.trace, self._directions(view.trace), indices)

    def _directions(self, trace: Trace) -> FloatArray:
        return self._tracer.camera.directions(trace.rows, trace.columns)

    def _depths(
        self,
        trace: Trace,
        difference: FloatArray,
        comparable: BoolArray,
        reach: Reach,
    ) -> Residuals:
        usable = comparable & np.isfinite(difference)
        near = np.abs(difference) < reach.depth
        kept = usable & near
        indices = np.flatnonzero(kept.ravel()).astype(np.int32)
        rows, columns = np.divmod(indices, trace.shape[1])
        return Residuals(
            kind=ResidualKind.DEPTH,
            values=difference.ravel()[indices],
            weights=np.ones(len(indices)),
            pixels=np.stack([columns + trace.columns.start, rows + trace.rows.start], axis=1),
            indices=indices,
            missing=float((usable & ~near).sum()),
        )

    def _seen_too_flat(self, view: View, faces: IntArray) -> BoolArray:
        """Tell which pixels of the window show a surface that is too flat for a good depth."""
        flat: BoolArray = view.trace.facing[faces] <= np.cos(self._masks.grazing_angle)
        return flat & (view.trace.faces >= 0)

    def edge_doubt(self, view: View, indices: IntArray) -> FloatArray:
        """Return how far segments of the outline may seem to lie inside [px], shape (M,).

        A sensor loses a surface that it sees too flat, and the edge that it shows is then not
        the body's. On a round body such a surface is thinner than a pixel.

        Args:
            view: the rendered body.
            indices: segments of the outline, as in `Residuals.indices`, shape (M,).
        """
        trace = view.trace
        flat = self._seen_too_flat(view, np.maximum(trace.faces, 0))
        outline = trace.outline
        chosen = np.searchsorted(outline.segments, indices)
        points, normals = outline.points[chosen, :2], outline.normals[chosen]
        thickness = np.zeros(len(indices))
        height, width = flat.shape
        for distance in np.arange(0.5 * _BESIDE_STEP, _BESIDE_REACH, _BESIDE_STEP):
            columns, rows = np.floor(points - distance * normals + 0.5).astype(np.int64).T
            columns = np.clip(columns - trace.columns.start, 0, width - 1)
            rows = np.clip(rows - trace.rows.start, 0, height - 1)
            thickness += _BESIDE_STEP * flat[rows, columns]
        # Where it sees two surfaces at once, it loses pixels of both.
        thickness += np.where(np.isfinite(outline.behind[chosen]), _LOST_AT_STEP, 0.0)
        return _largest_nearby(points, thickness)

    def edges(self, outline: Outline, reach: Reach) -> tuple[Residuals, FloatArray]:
        """Return how far the observed edge lies outside the outline, and metres per pixel."""
        step = outline.behind - outline.points[:, 2]
        clarity = np.where(
            np.isnan(step),
            1.0,
            np.clip((step - _STEP_FAINT) / (_STEP_CLEAR - _STEP_FAINT), 0.0, 1.0),
        )
        clarity[self.mask.edges[outline.edges]] = 0.0
        tolerances = np.where(
            np.isnan(step), reach.edge_depth, np.minimum(reach.edge_depth, 0.5 * step)
        )
        tolerances[clarity == 0.0] = 0.0
        distances = self._image.edge_distances(outline, tolerances, reach.edge_pixels)
        found = np.isfinite(distances)
        weights = clarity * outline.lengths
        scale = self.metres_per_pixel(outline)[found]
        residuals = Residuals(
            kind=ResidualKind.EDGE,
            values=distances[found] * scale,
            weights=weights[found],
            pixels=np.floor(outline.points[found, :2] + 0.5).astype(np.int32),
            indices=outline.segments[found],
            missing=float(weights[~found].sum()),
        )
        return residuals, scale

    def metres_per_pixel(self, outline: Outline) -> FloatArray:
        """Return how far a pixel along its normal is at each segment's depth [m], shape (P,)."""
        camera = self._observation.camera
        across, down = outline.normals[:, 0] / camera.fx, outline.normals[:, 1] / camera.fy
        metres: FloatArray = outline.points[:, 2] * np.hypot(across, down)
        return metres


def _largest_nearby(points: FloatArray, values: FloatArray) -> FloatArray:
    """Return the largest value around each point, shape (M,)."""
    largest = values.copy()
    if len(points) > 1:
        first, second = cKDTree(points).query_pairs(_NEARBY, output_type='ndarray').T
        np.maximum.at(largest, first, values[second])
        np.maximum.at(largest, second, values[first])
    return largest


def make_comparers(model: ForwardModel, *, device: str = 'cpu') -> list[ViewComparer]:
    """Prepare the comparison of every observation of a model."""
    masks = model.scene.masks
    return [
        ViewComparer(
            observation,
            tracer,
            make_view_mask(observation, model.body(observation), tracer, masks),
            masks,
            device,
            model.effects.surface(
                observation.setup_index,
                model.body(observation).discretisation,
                tracer.triangles,
            ),
        )
        for observation, tracer in zip(model.observations, model.tracers, strict=True)
    ]
