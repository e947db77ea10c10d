# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One small picture of a result: measured beside simulated depth."""

from pathlib import Path

from diffcal_ros.atomic_file import write_bytes_atomically
from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.result import CalibrationResult
from diffcal_ros.report import palette
from diffcal_ros.report.depth_figure import depth_range, RESIDUAL_LIMIT
from diffcal_ros.report.depth_panel import hatch_mask, scale_bar, show_image
from diffcal_ros.report.figure_png import new_figure, png_bytes
from diffcal_ros.report.observed_view import observed_views
import numpy as np

_WIDTH = 10.4  # [inch]
_HEIGHTS = (2.4, 4.6)


def save_picture(path: Path, calibration: Calibration, result: CalibrationResult) -> None:
    """Draw the first observation: measured, simulated, and what is left between them.

    Args:
        path: PNG file.
        calibration: that made the result.
        result: what it found.

    Raises:
        InputError: when the file cannot be written.
    """
    view = observed_views(calibration, result)[0]
    limits = depth_range([view])
    rows, columns = view.rows, view.columns
    aspect = (rows.stop - rows.start) / (columns.stop - columns.start)
    height = float(np.clip(0.3 * _WIDTH * aspect, *_HEIGHTS))
    figure = new_figure(_WIDTH, height + 0.9)
    panels = figure.subplots(1, 3)
    measured = 1e3 * view.observation.depth.astype(np.float64)
    depth = show_image(panels[0], view, measured, palette.depth_map(), limits)
    show_image(panels[1], view, 1e3 * view.fitted.depth, palette.depth_map(), limits)
    residual = np.where(view.fitted.counted, 1e3 * view.fitted.residual, np.nan)
    span = (-RESIDUAL_LIMIT, RESIDUAL_LIMIT)
    left = show_image(panels[2], view, residual, palette.residual_map(), span)
    scale_bar(panels[0], view)
    hatch_mask(panels[2], view, view.fitted.masked)
    for panel, title in zip(
        panels, ('measured depth', 'simulated depth, fitted', 'difference'), strict=True
    ):
        panel.set_title(title, fontsize=11)
    for image, ends in ((depth, panels[:2]), (left, panels[2:])):
        figure.colorbar(
            image,
            ax=list(ends),
            extend='both',
            orientation='horizontal',
            label='mm',
            pad=0.02,
            aspect=40 if len(ends) > 1 else 20,
        )
    write_bytes_atomically(path, png_bytes(figure))
