# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One picture of an observation: an image, and what is drawn over it."""

from collections.abc import Sequence
from typing import Any

from diffcal_ros.report import palette
from diffcal_ros.report.figures.observed_view import ObservedView
import numpy as np
from numpy.typing import NDArray

BoolArray = NDArray[np.bool_]
FloatArray = NDArray[np.float64]

_BARS = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0)  # Lengths of a scale bar [mm].


def show_image(
    panel: Any, view: ObservedView, image: FloatArray, colors: Any, limits: tuple[float, float]
) -> Any:
    """Show an image's window.

    Args:
        panel: matplotlib axes.
        view: gives the window.
        image: of any unit, shape (H, W); NaN for none.
        colors: colour map.
        limits: ends of its scale.
    """
    rows, columns = view.rows, view.columns
    extent = (columns.start - 0.5, columns.stop - 0.5, rows.stop - 0.5, rows.start - 0.5)
    panel.set_xticks([])
    panel.set_yticks([])
    for spine in panel.spines.values():
        spine.set_edgecolor('#9ca3af')
    return panel.imshow(
        image[rows, columns],
        cmap=colors,
        vmin=limits[0],
        vmax=limits[1],
        extent=extent,
        interpolation='nearest',
    )


def shade_mask(
    panel: Any, view: ObservedView, mask: BoolArray, colour: str = palette.MISSING
) -> None:
    """Shade the pixels of a mask, shape (H, W)."""
    colours = palette.one_colour_map(colour)
    show_image(panel, view, np.where(mask, 0.0, np.nan), colours, (0.0, 1.0))


def hatch_mask(panel: Any, view: ObservedView, mask: BoolArray) -> None:
    """Hatch the pixels of a mask, shape (H, W)."""
    part = mask[view.rows, view.columns]
    if not part.any():
        return
    rows, columns = (
        np.arange(view.rows.start, view.rows.stop),
        np.arange(view.columns.start, view.columns.stop),
    )
    panel.contourf(
        columns,
        rows,
        part.astype(np.float64),
        levels=[0.5, 1.5],
        colors='none',
        hatches=['////'],
    )


def draw_cables(panel: Any, cables: Sequence[FloatArray]) -> None:
    """Draw cables with their via points, column and row [px], shape (n, 2) each."""
    for points in cables:
        panel.plot(
            points[:, 0],
            points[:, 1],
            color=palette.CABLE,
            linewidth=1.4,
            marker='o',
            markersize=3.0,
        )


def scale_bar(panel: Any, view: ObservedView) -> None:
    """Draw a length at the body's depth."""
    depth = float(np.nanmedian(view.fitted.depth))
    pixels_per_millimetre = 1e-3 * view.observation.camera.fx / depth
    width = view.columns.stop - view.columns.start
    fitting = [bar for bar in _BARS if bar * pixels_per_millimetre < 0.3 * width]
    length = fitting[-1] if fitting else _BARS[0]
    left = view.columns.start + 0.04 * width
    base = view.rows.stop - 0.06 * (view.rows.stop - view.rows.start)
    right = left + length * pixels_per_millimetre
    panel.plot([left, right], [base, base], color='black', linewidth=2.5, solid_capstyle='butt')
    panel.text(0.5 * (left + right), base, f'{length:g} mm', ha='center', va='bottom', fontsize=9)
