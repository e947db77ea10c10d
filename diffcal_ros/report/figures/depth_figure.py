# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Measured beside simulated depth, and what is left between them, in one fixed scale."""

from typing import Any

from diffcal_ros.report import palette
from diffcal_ros.report.figures.depth_panel import (
    draw_cables,
    hatch_mask,
    scale_bar,
    shade_mask,
    show_image,
)
from diffcal_ros.report.figures.figure_png import new_figure
from diffcal_ros.report.figures.observed_view import ObservedView, Picture
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

RESIDUAL_LIMIT = 5.0  # [mm]; what is beyond is marked.
_PANEL_WIDTH = 4.6  # [inch]
_HEIGHTS = (2.2, 6.4)


def depth_range(views: list[ObservedView]) -> tuple[float, float]:
    """Return one range of depths for all views: that of the simulated bodies [mm]."""
    depths = [picture.depth for view in views for picture in (view.start, view.fitted)]
    seen = [depth[np.isfinite(depth)] for depth in depths]
    low, high = np.percentile(np.concatenate(seen), [0.2, 99.8])
    return 1e3 * float(low) - 3.0, 1e3 * float(high) + 3.0


def depth_figure(view: ObservedView, limits: tuple[float, float]) -> Any:
    """Draw one observation.

    Args:
        view: what to draw.
        limits: ends of the depth scale [mm].
    """
    rows, columns = view.rows, view.columns
    aspect = (rows.stop - rows.start) / (columns.stop - columns.start)
    height = float(np.clip(_PANEL_WIDTH * aspect, *_HEIGHTS))
    figure = new_figure(3 * _PANEL_WIDTH + 1.3, 2 * height + 1.1)
    axes = figure.subplots(2, 3)
    observed = view.observation.depth.astype(np.float64)
    depths = [observed, view.start.depth, view.fitted.depth]
    titles = ['measured depth', 'simulated, start values', 'simulated, fitted values']
    for panel, depth, title in zip(axes[0], depths, titles, strict=True):
        image = show_image(panel, view, 1e3 * depth, palette.depth_map(), limits)
        panel.set_title(title, fontsize=12)
    draw_cables(axes[0, 1], view.start.cables)
    draw_cables(axes[0, 2], view.fitted.cables)
    _bar(figure, image, axes[0], 'depth [mm]', 'grey: nearer or farther than the body')
    _outlines(axes[1, 0], view, observed, limits)
    span = (-RESIDUAL_LIMIT, RESIDUAL_LIMIT)
    pairs = (('start', view.start), ('fitted', view.fitted))
    for panel, (word, picture) in zip(axes[1, 1:], pairs, strict=True):
        image = show_image(panel, view, _residual(picture), palette.residual_map(), span)
        shade_mask(panel, view, picture.counted & np.isnan(picture.residual))
        shade_mask(panel, view, picture.beside, palette.UNEXPLAINED)
        hatch_mask(panel, view, picture.masked | (view.left_out & (picture.faces >= 0)))
        panel.set_title(f'measured − simulated, {word} values', fontsize=12)
    bar = _bar(figure, image, axes[1], 'residual [mm]', 'orange: the real body is farther away')
    bar.set_ticks(np.linspace(*span, 5))
    scale_bar(axes[0, 0], view)
    return figure


def alternative_figure(view: ObservedView) -> Any:
    """Draw the outline and the residual of one other answer, in the scale of the residuals."""
    rows, columns = view.rows, view.columns
    aspect = (rows.stop - rows.start) / (columns.stop - columns.start)
    figure = new_figure(1.4 * _PANEL_WIDTH, float(np.clip(_PANEL_WIDTH * aspect, *_HEIGHTS)) + 0.5)
    panel = figure.subplots(1, 1)
    picture = view.fitted
    span = (-RESIDUAL_LIMIT, RESIDUAL_LIMIT)
    image = show_image(panel, view, _residual(picture), palette.residual_map(), span)
    shade_mask(panel, view, picture.counted & np.isnan(picture.residual))
    shade_mask(panel, view, picture.beside, palette.UNEXPLAINED)
    hatch_mask(panel, view, picture.masked)
    scale_bar(panel, view)
    _bar(figure, image, [panel], 'residual [mm]', 'orange: the real body is farther away')
    return figure


def _residual(picture: Picture) -> FloatArray:
    """Return the residual [mm] where it counts, shape (H, W), NaN elsewhere."""
    return np.where(picture.counted, 1e3 * picture.residual, np.nan)


def _bar(figure: Any, image: Any, panels: Any, label: str, hint: str) -> Any:
    bar = figure.colorbar(image, ax=list(panels), extend='both', pad=0.01, aspect=24)
    bar.set_label(f'{label}\n{hint}', fontsize=10)
    return bar


def _outlines(
    panel: Any, view: ObservedView, observed: FloatArray, limits: tuple[float, float]
) -> None:
    """Draw the outlines over the measured depth in grey."""
    from matplotlib import colormaps

    grey = colormaps['Greys_r'].with_extremes(under='#f3f4f6', over='#f3f4f6', bad='#ffffff')
    wide = (limits[0] - 0.6 * (limits[1] - limits[0]), limits[1])
    show_image(panel, view, 1e3 * observed, grey, wide)
    # The measured outline lies broad under the fitted one, so that both are seen where they agree.
    for points, color, size, label in (
        (view.start.outline, palette.START, 2.0, 'start'),
        (view.fitted.edge_points, palette.MEASURED_EDGE, 6.0, 'measured'),
        (view.fitted.outline, palette.FITTED, 1.5, 'fitted'),
    ):
        panel.plot(points[:, 0], points[:, 1], '.', color=color, markersize=size, label=label)
    hatch_mask(panel, view, view.fitted.masked | view.left_out)
    panel.set_title('outlines over the measured depth', fontsize=12)
    # Below the picture: inside it would hide a part of the body sooner or later.
    legend = panel.legend(
        loc='upper center', bbox_to_anchor=(0.5, 0.0), ncol=3, fontsize=10, frameon=False
    )
    for handle in legend.legend_handles:
        handle.set_markersize(9.0)
