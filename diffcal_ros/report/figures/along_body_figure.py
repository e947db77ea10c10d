# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The gap from the clamp to the tip, drawn."""

from collections.abc import Sequence
from typing import Any

from diffcal_ros.report import palette
from diffcal_ros.report.figures.along_body import AlongBody, Share
from diffcal_ros.report.figures.figure_png import new_figure
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_LEAST_REACH = 1.0  # [mm]


def along_body_figure(along: AlongBody) -> Any:
    """Draw the residual along the body, start and fitted, and the outline's distance."""
    figure = new_figure(11.0, 3.6)
    depth, edge = figure.subplots(1, 2, width_ratios=(1.6, 1.0))
    middles = 1e3 * 0.5 * (along.borders[1:] + along.borders[:-1])
    depth.axhline(0.0, color='#6b7280', linewidth=0.8)
    for shares, color, label, style in (
        (along.start, palette.START, 'start values', '--'),
        (along.fitted, palette.FITTED, 'fitted values', '-'),
    ):
        low, median, high = (_column(shares, name) for name in ('low', 'median', 'high'))
        depth.fill_between(middles, low, high, color=color, alpha=0.15, linewidth=0.0)
        depth.plot(middles, median, color=color, linestyle=style, marker='o', label=label)
        edge.plot(
            middles, _column(shares, 'edge'), color=color, linestyle=style, marker='o', label=label
        )
    # Starts may be far off: the fitted values are what the scale is for.
    ends = np.abs([_column(along.fitted, name) for name in ('low', 'high')])
    reach = max(1.3 * float(np.max(ends, where=np.isfinite(ends), initial=0.0)), _LEAST_REACH)
    depth.set_ylim(-reach, reach)
    depth.set_ylabel('measured − simulated [mm]')
    depth.set_title('depth: median and the middle 68 %', fontsize=11)
    edge.set_ylabel('distance [mm]')
    edge.set_ylim(bottom=0.0)
    edge.set_title('outline: median distance', fontsize=11)
    for panel in (depth, edge):
        panel.set_xlabel('distance from the clamp along the body at rest [mm]')
        panel.grid(color='#e5e7eb', linewidth=0.7)
        panel.legend(fontsize=9)
    return figure


def _column(shares: Sequence[Share], name: str) -> FloatArray:
    return 1e3 * np.array([getattr(share, name) for share in shares])
