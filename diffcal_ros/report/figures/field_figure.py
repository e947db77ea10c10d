# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A fitted field, drawn on the body."""

from typing import Any

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.field.fit import FieldFit
from diffcal_ros.report import palette
from diffcal_ros.report.figures.along_body import BIN_COUNT, distance_from_clamp
from diffcal_ros.report.figures.figure_png import new_figure
from diffcal_ros.report.scene_picture.view import paint, View
from diffcal_ros.rigid_transform import looking_at
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_DISTANCE = 2.2  # Of the viewer, over the body's size.
_ELEVATION = np.deg2rad(25.0)


def field_figure(calibration: Calibration, field: FieldFit) -> Any:
    """Draw the modulus on the deformed body and on both sides at rest, its error, and a profile.

    Args:
        calibration: with the field in its model.
        field: that was fitted.
    """
    figure = new_figure(11.0, 7.0)
    top, bottom = figure.add_gridspec(2, 1, height_ratios=(1.0, 1.0))
    first, second = (grid.subgridspec(1, 2) for grid in (top, bottom))
    panels = [figure.add_subplot(place) for place in (first[0], first[1], second[0])]
    kilopascals = 1e-3 * field.youngs_modulus
    limits = _limits(kilopascals)
    painted = None
    for panel, side, title in (
        (panels[0], 1.0, "at rest, from the camera's side"),
        (panels[1], -1.0, 'at rest, from behind'),
    ):
        painted = _draw(panel, calibration, kilopascals, side, palette.field_map(), limits, True)
        panel.set_title(title, fontsize=11)
    bar = figure.colorbar(painted, ax=panels[:2], label="Young's modulus [kPa]", shrink=0.8)
    _plain_numbers(bar.ax.yaxis)
    ends = 0.0, max(float(field.log_std.max()), 1e-3)
    errors = _draw(panels[2], calibration, field.log_std, 1.0, palette.error_map(), ends, False)
    panels[2].set_title('standard error, given the smoothness', fontsize=11)
    figure.colorbar(errors, ax=panels[2], label='of the natural logarithm', shrink=0.8)
    _draw_profile(figure.add_subplot(second[1]), calibration, field)
    return figure


def _draw(
    panel: Any,
    calibration: Calibration,
    values: FloatArray,
    side: float,
    colors: Any,
    limits: tuple[float, float],
    is_logarithmic: bool,
) -> Any:
    """Paint one value a tetrahedron on the body at rest; return what a colour bar needs."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import LogNorm, Normalize

    mesh = calibration.scene.mesh
    scale = ScalarMappable((LogNorm if is_logarithmic else Normalize)(*limits), colors)
    painted = paint(_view(calibration, side), mesh.rest_positions, mesh.surface_triangles)
    shades = scale.to_rgba(values[mesh.surface_tets[painted.faces]])
    # Less shading than of bare surfaces: colours must be found again in the bar.
    shades[:, :3] *= (0.75 + 0.25 * painted.brightness)[:, None]
    panel.add_collection(
        PolyCollection(list(painted.corners), facecolors=shades, edgecolors=shades, linewidths=0.3)
    )
    panel.update_datalim(painted.corners.reshape(-1, 2))
    panel.autoscale_view()
    panel.set_aspect('equal')
    panel.invert_yaxis()
    panel.axis('off')
    return scale


def _view(calibration: Calibration, side: float) -> View:
    """Look at the body across its long axis, from the first camera's side or the other."""
    mesh, observation = calibration.scene.mesh, calibration.model.observations[0]
    setup = calibration.scene.observations[observation.setup_index]
    depth_from_object = observation.depth_from_world @ setup.world_from_object
    middle = mesh.extent.mean(axis=0)
    size = float(np.ptp(mesh.extent, axis=0).max())
    eye = -depth_from_object[:3, :3].T @ depth_from_object[:3, 3] - middle
    # The image's up, made square to the line of sight.
    up = -depth_from_object[1, :3]
    toward = eye - (eye @ up) * up
    toward /= np.linalg.norm(toward)
    direction = side * np.cos(_ELEVATION) * toward + np.sin(_ELEVATION) * up
    return View(looking_at(middle, _DISTANCE * size * direction, up))


def _draw_profile(panel: Any, calibration: Calibration, field: FieldFit) -> None:
    mesh = calibration.scene.mesh
    held = calibration.scene.observations[0].held[0].vertices
    distances = 1e3 * distance_from_clamp(mesh.centroids, mesh.rest_positions[held])
    borders = np.linspace(distances.min(), distances.max(), 2 * BIN_COUNT + 1)
    bins = np.digitize(distances, borders[1:-1])
    middles = 0.5 * (borders[1:] + borders[:-1])
    ends, medians, errors = [], [], []
    for number in range(len(middles)):
        own = bins == number
        values = 1e-3 * field.youngs_modulus[own] if own.any() else np.array([np.nan])
        ends.append(np.percentile(values, [5.0, 95.0]))
        medians.append(float(np.median(values)))
        errors.append(float(np.median(field.log_std[own])) if own.any() else np.nan)
    low, high = np.array(ends).T
    middle, error = np.array(medians), np.array(errors)
    panel.fill_between(
        middles,
        middle * np.exp(-error),
        middle * np.exp(error),
        color=palette.FITTED,
        alpha=0.12,
        linewidth=0.0,
        label='one standard error',
    )
    panel.fill_between(
        middles, low, high, color=palette.FITTED, alpha=0.3, linewidth=0.0, label='middle 90 %'
    )
    panel.plot(middles, middle, color=palette.FITTED, label='median of the tetrahedra')
    panel.set_yscale('log')
    _plain_numbers(panel.yaxis)
    panel.set_xlabel('distance from the clamp along the body at rest [mm]')
    panel.set_ylabel("Young's modulus [kPa]")
    panel.set_title('along the body', fontsize=11)
    panel.grid(color='#e5e7eb', linewidth=0.7)
    panel.legend(fontsize=9)


def _limits(values: FloatArray) -> tuple[float, float]:
    """Return the ends of a logarithmic scale, at least a tenth apart."""
    low, high = float(values.min()), float(values.max())
    return (low, high) if high > 1.1 * low else (low / 1.05, high * 1.05)


def _plain_numbers(axis: Any) -> None:
    """Write 100, 150, 200, 300, 500 and 700, not powers of ten."""
    from matplotlib.ticker import LogLocator, NullLocator

    axis.set_major_locator(LogLocator(subs=(1.0, 1.5, 2.0, 3.0, 5.0, 7.0)))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter('{x:.4g}')
