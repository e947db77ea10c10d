# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fits from many starts: mean and one standard deviation of gap and parameters by iteration."""

from collections.abc import Callable
from typing import Any

from diffcal_ros.report import palette
from diffcal_ros.report.figures.figure_png import new_figure
from diffcal_ros.report.naming import is_material, shown, title
from diffcal_ros.reproduction.summary import Summary
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_WIDTH, _HEIGHT = 5.0, 3.0  # Of a panel [inch].
_MOST_PARAMETERS = 3
_GAP = 'gap on the body, median [mm]'


def spread_figure(summary: Summary) -> Any:
    """Draw the gap, and the first parameters of the material, over the iterations."""
    results = summary.fitted or summary.results
    parameters = [p for p in summary.parameters() if is_material(p.name)][:_MOST_PARAMETERS]
    figure = new_figure(_WIDTH * (1 + len(parameters)), _HEIGHT)
    panels = figure.subplots(1, 1 + len(parameters), squeeze=False)[0]
    _draw(panels[0], _paths(results, lambda step: step['gap']['median_mm']), _GAP)
    panels[0].set_ylim(bottom=0.0)
    for panel, parameter in zip(panels[1:], parameters, strict=True):
        name, unit = parameter.name, parameter.unit

        def value(step: dict[str, Any], name: str = name, unit: str = unit) -> float:
            return shown(step['parameters'][name], 0.0, unit).value

        words = f'{title(name)} [{shown(0.0, 0.0, unit).unit}]'
        _draw(panel, _paths(results, value), words)
        paper = summary.variant.paper.get(name)
        if isinstance(paper, (int, float)):
            panel.axhline(shown(float(paper), 0.0, unit).value, color=palette.START, linestyle=':')
    for panel in panels:
        panel.grid(color='#e5e7eb', linewidth=0.7)
        panel.set_xlabel('iteration')
        panel.xaxis.get_major_locator().set_params(integer=True)
    return figure


def _paths(results: Any, value: Callable[[dict[str, Any]], float | None]) -> FloatArray:
    """Return one row a start; who is done stays where he is while others go on."""
    paths = [
        [np.nan if value(step) is None else float(value(step) or 0.0) for step in r['history']]
        for r in results
    ]
    longest = max(len(path) for path in paths)
    return np.array([path + [path[-1]] * (longest - len(path)) for path in paths])


def _draw(panel: Any, paths: FloatArray, words: str) -> None:
    steps = np.arange(paths.shape[1])
    mean, deviation = np.nanmean(paths, axis=0), np.nanstd(paths, axis=0)
    panel.plot(steps, paths.T, color=palette.MEASURED, linewidth=0.5, alpha=0.35)
    panel.fill_between(
        steps, mean - deviation, mean + deviation, color=palette.FITTED, alpha=0.25, linewidth=0
    )
    panel.plot(steps, mean, color=palette.FITTED, linewidth=2.0)
    panel.set_title(words, fontsize=11)
