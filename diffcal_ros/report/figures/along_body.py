# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where on the body the gap is left: from the clamp to the tip, and region by region."""

from dataclasses import dataclass
from itertools import pairwise

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.report.figures.observed_view import ObservedView, Picture
from diffcal_ros.report.scene_picture.scene_layout import surface_regions
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

BIN_COUNT = 10


@dataclass(frozen=True)
class Share:
    """The gap on a part of the body.

    Attributes:
        label: of the part.
        pixels: simulated, unmasked pixels.
        coverage: share of them with an observed depth within the truncation.
        median: signed residual, observed less simulated depth [m].
        low: 16th percentile of the same [m].
        high: 84th percentile [m].
        size: median of its absolute value [m].
        edge: median distance between the outlines, without sign [m].
    """

    label: str
    pixels: int
    coverage: float
    median: float
    low: float
    high: float
    size: float
    edge: float


@dataclass(frozen=True)
class AlongBody:
    """The gap along the body's long axis.

    Attributes:
        borders: of the bins, distance from the clamp [m], shape (BIN_COUNT + 1,).
        start: one share a bin at the start values.
        fitted: likewise at the fitted values.
        regions: one share a region at the fitted values.
    """

    borders: FloatArray
    start: tuple[Share, ...]
    fitted: tuple[Share, ...]
    regions: tuple[Share, ...]


def along_body(calibration: Calibration, view: ObservedView) -> AlongBody:
    """Sort one view's residuals by where on the body they lie."""
    scene, model = calibration.scene, calibration.model
    body = model.body(view.observation)
    rest, triangles = body.discretisation.rest_nodes, body.discretisation.surface_triangles
    first = scene.observations[view.observation.setup_index].held[0].vertices
    distances = distance_from_clamp(rest, rest[first])
    borders = np.linspace(0.0, float(distances.max()), BIN_COUNT + 1)
    by_face = np.digitize(distances[triangles].mean(axis=1), borders[1:-1])
    by_vertex = np.digitize(distances, borders[1:-1])
    labels = [f'{1e3 * a:.0f} to {1e3 * b:.0f} mm' for a, b in pairwise(borders)]
    limit = scene.masks.truncation
    # A face of the mesh is one triangle of the linear, four of the quadratic element.
    owner = surface_regions(scene)
    faces_of_region = np.repeat(owner, len(triangles) // len(owner))
    vertex_region = np.zeros(len(rest), dtype=np.int64)
    vertex_region[triangles] = faces_of_region[:, None]
    names = [region.name for region in scene.regions]
    return AlongBody(
        borders=borders,
        start=_shares(view.start, by_face, by_vertex, labels, limit),
        fitted=_shares(view.fitted, by_face, by_vertex, labels, limit),
        regions=_shares(view.fitted, faces_of_region, vertex_region, names, limit),
    )


def distance_from_clamp(rest: FloatArray, held: FloatArray) -> FloatArray:
    """Return how far points lie from the held part along the body's long axis [m], shape (N,).

    Args:
        rest: the body at rest [m], shape (N, 3).
        held: points of the clamped part [m], shape (h, 3).
    """
    middle = rest.mean(axis=0)
    _, _, axes = np.linalg.svd(rest - middle, full_matrices=False)
    axis = axes[0] if axes[0] @ (middle - held.mean(axis=0)) >= 0.0 else -axes[0]
    return (rest - held[np.argmax(held @ axis)]) @ axis


def _shares(
    picture: Picture,
    part_of_face: NDArray[np.integer],
    part_of_vertex: NDArray[np.integer],
    labels: list[str],
    limit: float,
) -> tuple[Share, ...]:
    counted = picture.counted
    parts = part_of_face[picture.faces[counted]]
    residuals = picture.residual[counted]
    edge_parts = part_of_vertex[picture.edge_vertices]
    return tuple(
        _share(
            label,
            residuals[parts == number],
            picture.edge_residuals[edge_parts == number],
            limit,
        )
        for number, label in enumerate(labels)
    )


def _share(label: str, residuals: FloatArray, edges: FloatArray, limit: float) -> Share:
    kept = residuals[np.abs(residuals) < limit]
    low, median, high = np.percentile(kept, [16, 50, 84]) if len(kept) else (np.nan,) * 3
    return Share(
        label=label,
        pixels=len(residuals),
        coverage=len(kept) / len(residuals) if len(residuals) else 0.0,
        median=float(median),
        low=float(low),
        high=float(high),
        size=float(np.median(np.abs(kept))) if len(kept) else float('nan'),
        edge=float(np.median(np.abs(edges))) if len(edges) else float('nan'),
    )
