# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A material's number over all bodies of a batch, material by material."""

from collections.abc import Sequence
from typing import Any

from diffcal_ros.batch.materials import MaterialFit
from diffcal_ros.report import palette
from diffcal_ros.report.figures.figure_png import new_figure
from diffcal_ros.report.naming import shown, title
import numpy as np

_WIDTH, _LEAST_HEIGHT, _HEIGHT_OF_BODY = 10.0, 2.6, 0.17  # [inch]
# Beyond so many bodies names would cover one another.
_MOST_NAMES = 60
_Z_95 = 1.96


def moduli_figure(fits: Sequence[MaterialFit]) -> Any:
    """Draw every body with its 95 % error, and each material's mean and spread.

    Args:
        fits: of one quantity.
    """
    count = sum(len(fit.bodies) for fit in fits)
    lines = min(count, _MOST_NAMES)
    figure = new_figure(_WIDTH, max(_LEAST_HEIGHT, 1.2 + _HEIGHT_OF_BODY * lines))
    panel = figure.subplots()
    names: list[str] = []
    for number, fit in enumerate(fits):
        _draw(panel, fit, len(names), palette.LINES[number % len(palette.LINES)])
        names += [fit.bodies[place] for place in np.argsort(fit.values)]
    unit = shown(1.0, 0.0, fits[0].unit).unit
    panel.set_xlabel(f'{title(fits[0].quantity)} [{unit}]' if unit else title(fits[0].quantity))
    panel.set_ylim(len(names) - 0.3, -0.7)
    if count <= _MOST_NAMES:
        panel.set_yticks(range(len(names)), names, fontsize=8)
    else:
        panel.set_ylabel('bodies, by material and value')
    panel.grid(axis='x', color='#e5e7eb', linewidth=0.7)
    panel.legend(fontsize=8, loc='best')
    return figure


def _draw(panel: Any, fit: MaterialFit, first: int, colour: str) -> None:
    order = np.argsort(fit.values)
    rows = first + np.arange(len(order))
    scale = shown(1.0, 0.0, fit.unit).value
    low, high = (scale * fit.in_unit(end) for end in fit.effects.interval_95)
    between = (rows[0] - 0.4, rows[-1] + 0.4)
    if np.isfinite(fit.effects.prediction_95).all():
        ends = [scale * fit.in_unit(end) for end in fit.effects.prediction_95]
        panel.fill_betweenx(between, *ends, color=colour, alpha=0.10, linewidth=0)
    panel.fill_betweenx(between, low, high, color=colour, alpha=0.30, linewidth=0)
    mean = scale * fit.in_unit(fit.effects.mean)
    panel.plot([mean, mean], between, color=colour, linewidth=1.5, label=fit.material)
    for is_outlier, marker in ((False, 'o'), (True, 'X')):
        own = fit.is_outlier[order] == is_outlier
        panel.errorbar(
            scale * fit.values[order][own],
            rows[own],
            xerr=_Z_95 * scale * fit.errors[order][own],
            fmt=marker,
            markersize=7 if is_outlier else 4,
            color=palette.UNEXPLAINED if is_outlier else colour,
            linewidth=1.0,
        )
