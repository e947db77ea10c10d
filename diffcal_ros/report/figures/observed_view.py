# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What one observation measured beside what the simulator shows, at start and fitted values."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.forward.sensor_model import SensorModel
from diffcal_ros.calibration.forward.solution import View
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.observations.pixel_masks import ViewMask
from diffcal_ros.calibration.residuals.robust_residual import make_comparers, Reach
from diffcal_ros.calibration.results.result import CalibrationResult
import numpy as np
from numpy.typing import NDArray

BoolArray = NDArray[np.bool_]
FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]

_EDGE_REACH = 30  # How far from the simulated outline the measured one is looked for [px].
_MARGIN = 0.10  # Around the body, over the longer side of its window.
_LEAST_MARGIN = 12  # [px]
_FRAMES_SHOWN = 4  # Of a motion.


@dataclass(frozen=True)
class Picture:
    """The simulated body in one view, over the whole image.

    Attributes:
        depth: simulated z as the sensor would read it [m], shape (H, W); NaN beside the body.
        residual: observed less simulated depth [m], shape (H, W); NaN where either is missing.
        counted: simulated pixels that no mask leaves out, shape (H, W).
        masked: simulated pixels that a mask leaves out, shape (H, W).
        faces: surface triangle of each pixel, -1 beside the body, shape (H, W).
        outline: column and row [px] of points on the simulated outline, shape (P, 2).
        edge_points: the measured outline where it was found, shape (Q, 2).
        edge_residuals: how far it lies outside the simulated one [m], shape (Q,).
        edge_vertices: a surface vertex beside each, shape (Q,).
        beside: measured body that no simulated pixel covers, shape (H, W).
        cables: column and row [px] of each cable's via points, shape (n, 2) each.
    """

    depth: FloatArray
    residual: FloatArray
    counted: BoolArray
    masked: BoolArray
    faces: IntArray
    outline: FloatArray
    edge_points: FloatArray
    edge_residuals: FloatArray
    edge_vertices: IntArray
    beside: BoolArray
    cables: tuple[FloatArray, ...] = ()


@dataclass(frozen=True)
class ObservedView:
    """One observation.

    Attributes:
        observation: what was measured.
        number: of the observation.
        start: at the start values.
        fitted: at the fitted values.
        left_out: pixels that the scene's boxes leave out, shape (H, W).
        rows: window around the body.
        columns: window around the body.
    """

    observation: Observation
    number: int
    start: Picture
    fitted: Picture
    left_out: BoolArray
    rows: slice
    columns: slice


def observed_views(calibration: Calibration, result: CalibrationResult) -> list[ObservedView]:
    """Draw observations at the start and at the fitted values; of a motion, a few frames.

    Args:
        calibration: its model remembers where its last fit began and ended; else it simulates.
        result: gives the values.
    """
    fitted = {p.name: p.value for p in result.parameters}
    return _views(calibration, result.history[0].values if result.history else fitted, fitted)


def _views(
    calibration: Calibration, start: Mapping[str, float], fitted: Mapping[str, float]
) -> list[ObservedView]:
    shown = shown_numbers(calibration.model.observations)
    comparers = _Comparers(calibration)
    starts, ends = (
        comparers.pictures(
            np.array([p.coordinate(values[p.name]) for p in calibration.parameters]), shown
        )
        for values in (start, fitted)
    )
    views = []
    for number in shown:
        rows, columns = _window(starts[number].depth, ends[number].depth)
        views.append(
            ObservedView(
                observation=calibration.model.observations[number],
                number=number,
                start=starts[number],
                fitted=ends[number],
                left_out=comparers.mask(number).image,
                rows=rows,
                columns=columns,
            )
        )
    return views


def views_at(calibration: Calibration, values: Mapping[str, float]) -> list[ObservedView]:
    """Simulate observations at other values, which stand as start and end.

    Args:
        calibration: gives model and observations.
        values: of all parameters in SI units by name.
    """
    at = dict(values)
    return _views(calibration, at, at)


def shown_numbers(observations: Sequence[Observation]) -> list[int]:
    """Return which observations are drawn: those at rest, and a few frames of each motion."""
    shown = [number for number, seen in enumerate(observations) if seen.instant is None]
    recordings: dict[int, list[int]] = {}
    for number, seen in enumerate(observations):
        if seen.instant is not None:
            recordings.setdefault(seen.instant.recording, []).append(number)
    for own in recordings.values():
        indices = np.linspace(0, len(own) - 1, min(_FRAMES_SHOWN, len(own))).round()
        shown += [own[int(index)] for index in indices]
    return sorted(shown)


class _Comparers:
    """Compares every view, whatever the loss of the fit."""

    def __init__(self, calibration: Calibration) -> None:
        self._model = calibration.model
        settings = calibration.scene.masks
        self._reach = Reach(settings.truncation, 1.5 * settings.truncation, _EDGE_REACH)
        self._comparers = make_comparers(self._model, device=calibration.settings.device)

    def mask(self, number: int) -> ViewMask:
        """Return what is left out of a view."""
        return self._comparers[number].mask

    def pictures(self, coordinates: FloatArray, shown: Sequence[int]) -> dict[int, Picture]:
        """Return what some of the views show, by their numbers."""
        views: Sequence[View] = self._model.views(coordinates)
        sensors = {number: self._model.sensor(coordinates, number) for number in shown}
        return {n: self._picture(n, views[n], sensor) for n, sensor in sensors.items()}

    def _picture(self, number: int, view: View, sensor: SensorModel) -> Picture:
        comparison = self._comparers[number].compare(view, self._reach, sensor)
        trace, camera = view.trace, self._model.observations[number].camera
        shape = (camera.height, camera.width)
        window = (trace.rows, trace.columns)
        depth, residual = np.full(shape, np.nan), np.full(shape, np.nan)
        faces = np.full(shape, -1, dtype=np.int32)
        counted = np.zeros(shape, dtype=bool)
        depth[window] = self._comparers[number].read(trace, sensor)
        residual[window] = comparison.difference
        faces[window], counted[window] = trace.faces, comparison.counted
        fractions = self._comparers[number].measured_fractions(view, sensor)
        beside = fractions.beside.repeat(fractions.stride, 0).repeat(fractions.stride, 1)
        beside = beside[: shape[0], : shape[1]]
        outline = trace.outline
        edge = comparison.edge
        found = np.searchsorted(outline.segments, edge.indices)
        pixels = edge.values / comparison.edge_scale
        points = outline.points[found, :2] + pixels[:, None] * outline.normals[found]
        edges = self._model.tracers[number].edge_vertices
        body = self._model.body(self._model.observations[number])
        return Picture(
            depth=depth,
            residual=residual,
            counted=counted,
            masked=(faces >= 0) & ~counted,
            faces=faces,
            outline=outline.points[:, :2].copy(),
            edge_points=points,
            edge_residuals=edge.values,
            edge_vertices=edges[outline.edges[found], 0],
            beside=beside,
            cables=tuple(camera.project(c.via_positions(view.points)) for c in body.cables),
        )


def _window(*depths: FloatArray) -> tuple[slice, slice]:
    """Return rows and columns around what any image shows."""
    seen = np.any([np.isfinite(depth) for depth in depths], axis=0)
    rows, columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
    if len(rows) == 0:
        return slice(0, seen.shape[0]), slice(0, seen.shape[1])
    longer = max(rows[-1] - rows[0], columns[-1] - columns[0])
    margin = max(_LEAST_MARGIN, round(_MARGIN * longer))
    return (
        slice(max(int(rows[0]) - margin, 0), min(int(rows[-1]) + margin + 1, seen.shape[0])),
        slice(max(int(columns[0]) - margin, 0), min(int(columns[-1]) + margin + 1, seen.shape[1])),
    )
