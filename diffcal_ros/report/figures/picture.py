# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One small picture of a result: measured beside simulated depth, before and after the fit."""

from pathlib import Path
from typing import Any

from diffcal_ros.atomic_file import write_bytes_atomically
from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.calibration.results.result import CalibrationResult
from diffcal_ros.report import palette
from diffcal_ros.report.figure_text import as_text
from diffcal_ros.report.figures.depth_figure import depth_range
from diffcal_ros.report.figures.depth_panel import scale_bar, show_image
from diffcal_ros.report.figures.figure_png import new_figure, png_bytes
from diffcal_ros.report.figures.observed_view import observed_views, ObservedView
from diffcal_ros.report.naming import is_material, shown, title
import numpy as np

_WIDTH = 10.4  # [inch]
_HEIGHTS = (1.8, 4.6)


def save_picture(path: Path, calibration: Calibration, result: CalibrationResult) -> None:
    """Draw the first observation: measured, and simulated at start and fitted values.

    Args:
        path: PNG file.
        calibration: that made the result.
        result: what it found.

    Raises:
        InputError: when the file cannot be written.
    """
    write_bytes_atomically(path, png_bytes(picture_figure(calibration, result)))


def picture_figure(calibration: Calibration, result: CalibrationResult) -> Any:
    """Draw what `save_picture` writes; all three images share one scale in millimetres."""
    view = observed_views(calibration, result)[0]
    limits = depth_range([view])
    figure = new_figure(_WIDTH, _panel_height(view) + 0.9)
    panels = figure.subplots(1, 3)
    source = f'{view.observation.frame_count} depth frames\n{as_text(calibration.scene.name)}'
    columns = (
        (view.observation.depth.astype(np.float64), 'measured', source),
        (view.start.depth, 'simulated, before', _words(result, result.gap_start, is_fitted=False)),
        (view.fitted.depth, 'simulated, fitted', _words(result, result.gap_end, is_fitted=True)),
    )
    for panel, (depth, heading, below) in zip(panels, columns, strict=True):
        image = show_image(panel, view, 1e3 * depth, palette.depth_map(), limits)
        panel.set_title(heading, fontsize=13)
        panel.set_xlabel(below, fontsize=11)
    scale_bar(panels[0], view)
    bar = figure.colorbar(image, ax=list(panels), extend='both', pad=0.01, aspect=16)
    bar.set_label('depth [mm]', fontsize=11)
    return figure


def _panel_height(view: ObservedView) -> float:
    rows, columns = view.rows, view.columns
    aspect = (rows.stop - rows.start) / (columns.stop - columns.start)
    return float(np.clip(0.3 * _WIDTH * aspect, *_HEIGHTS))


def _words(result: CalibrationResult, gap: Gap, *, is_fitted: bool) -> str:
    """Say the material values and how far the simulated surface is off."""
    values = []
    for p in result.parameters:
        if not p.is_nuisance and is_material(p.name):
            pair = (p.value, p.std_error) if is_fitted else (p.start, 0.0)
            values.append(f'{title(p.name)} {shown(*pair, p.unit).text("±")}')
    return '\n'.join([*values, f'RMS gap {1e3 * gap.rms:.2g} mm'])
