# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A map of spots on a body's surface, unrolled: along the body, and around it side by side."""

from typing import Any

from diffcal_ros.effects.spots import OF_SIDE, ROUND, Spots
from diffcal_ros.report.figures.figure_png import new_figure

_SIZE = (8.0, 3.0)  # [inch]
# Sides in the order of cells, by the body's axis that each faces along.
_SIDES = ('a', 'b', '-a', '-b')


def spot_figure(spots: Spots) -> Any:
    """Draw which parts of the surface are in spots."""
    figure = new_figure(*_SIZE)
    panel = figure.subplots()
    panel.imshow(
        spots.cells.T,
        cmap='Greys',
        vmin=0.0,
        vmax=1.3,
        origin='lower',
        extent=(0.0, 1.0, 0.0, float(ROUND)),
        aspect='auto',
        interpolation='nearest',
    )
    for border in range(OF_SIDE, ROUND, OF_SIDE):
        panel.axhline(border, color='#b45309', linewidth=1.0)
    panel.set_yticks([(number + 0.5) * OF_SIDE for number in range(len(_SIDES))], _SIDES)
    panel.set_xlabel('share of the free length, from the clamp on')
    panel.set_ylabel('side, by the axis it faces')
    return figure
