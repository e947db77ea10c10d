# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Likelihood profiles, drawn beside the parabola that the curvature at the best value gives."""

from typing import Any

from diffcal_ros.calibration.results.result import CalibrationResult
from diffcal_ros.calibration.uncertainty.profile import Profile
from diffcal_ros.report import palette
from diffcal_ros.report.figures.figure_png import new_figure
from diffcal_ros.report.naming import shown, title
import numpy as np

_PANEL = (4.6, 3.2)  # [inch]
_TOP = 1.6  # Of the rise that ends the 95 % interval.


def profile_figure(result: CalibrationResult) -> Any:
    """Draw one panel a profile."""
    count = len(result.profiles)
    figure = new_figure(_PANEL[0] * count, _PANEL[1])
    panels = figure.subplots(1, count, squeeze=False)[0]
    for panel, own in zip(panels, result.profiles, strict=True):
        _draw(panel, own)
    return figure


def _draw(panel: Any, own: Profile) -> None:
    scale = shown(1.0, 0.0, own.unit)
    low, high = own.laplace
    middle, reach = 0.5 * (low + high), 0.5 * (high - low)
    # Curvature is that of the coordinate, which for small errors is the value's.
    across = np.linspace(middle - 1.25 * reach, middle + 1.25 * reach, 80)
    parabola = ((across - middle) / reach) ** 2 if reach > 0.0 else np.zeros_like(across)
    panel.plot(scale.value * across, parabola, color=palette.START, linestyle='--')
    panel.plot(scale.value * own.values, own.rises, color=palette.FITTED, marker='.')
    panel.axhline(1.0, color='#6b7280', linewidth=0.8)
    for end in (own.low, own.high):
        if np.isfinite(end):
            panel.axvline(scale.value * end, color=palette.FITTED, linewidth=0.8, linestyle=':')
    panel.set_ylim(-0.05, _TOP)
    panel.set_xlabel(f'{title(own.name)} [{scale.unit or "1"}]')
    panel.set_ylabel('rise over that of 95 %')
    panel.grid(color='#e5e7eb', linewidth=0.7)
