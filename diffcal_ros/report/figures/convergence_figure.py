# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How a fit went: loss, gap and parameters after every step."""

from collections.abc import Sequence
from typing import Any

from diffcal_ros.calibration.results.result import CalibrationResult, FittedParameter
from diffcal_ros.report import palette
from diffcal_ros.report.figures.figure_png import new_figure
from diffcal_ros.report.naming import is_material, shown, title
import numpy as np


def convergence_figure(result: CalibrationResult) -> Any:
    """Draw loss, gap, material and, where they were fitted, offsets."""
    asked = [p for p in result.parameters if not p.is_nuisance]
    material = [p for p in asked if is_material(p.name)]
    rest = [p for p in asked if not is_material(p.name)]
    groups = [group for group in (material, rest) if group]
    figure = new_figure(11.0, 3.7 * (1 + (len(groups) > 0)))
    rows = figure.subplots(1 + (len(groups) > 0), 2, squeeze=False)
    steps = [record.number for record in result.history]
    _draw_loss(rows[0, 0], steps, result)
    _draw_gap(rows[0, 1], steps, result)
    for panel, group in zip(rows[-1], groups, strict=False):
        _draw_parameters(panel, steps, result, group)
    for panel in rows[-1, len(groups) :]:
        panel.axis('off')
    for panel in rows.ravel():
        panel.grid(color='#e5e7eb', linewidth=0.7)
        panel.set_xlabel('iteration')
        panel.xaxis.get_major_locator().set_params(integer=True)
    return figure


def _draw_loss(panel: Any, steps: Sequence[int], result: CalibrationResult) -> None:
    losses = [record.loss for record in result.history]
    # A line between robust losses would compare what has no common unit.
    line = 'none' if result.loss == 'robust' else '-'
    panel.plot(steps, losses, color=palette.MEASURED, marker='o', linestyle=line)
    if min(losses, default=0.0) > 0.0 and max(losses) > 20.0 * min(losses):
        panel.set_yscale('log')
    unit = 'half a chi-square' if result.loss == 'robust' else result.loss
    panel.set_title(f'loss ({unit})', fontsize=11)


def _draw_gap(panel: Any, steps: Sequence[int], result: CalibrationResult) -> None:
    for name, style in (('median', '-'), ('rms', '--')):
        values = [1e3 * getattr(record.gap, name) for record in result.history]
        panel.plot(steps, values, color=palette.FITTED, linestyle=style, marker='o', label=name)
    panel.set_ylim(bottom=0.0)
    panel.set_ylabel('mm')
    panel.set_title('gap on the body', fontsize=11)
    covered = panel.twinx()
    fractions = [100.0 * record.gap.coverage for record in result.history]
    covered.plot(
        steps, fractions, color=palette.START, linestyle=':', marker='.', label='coverage'
    )
    covered.set_ylim(0.0, 102.0)
    covered.set_ylabel('coverage [%]', color=palette.START)
    handles = [*panel.get_lines(), *covered.get_lines()]
    _legend_below(panel, handles)


def _draw_parameters(
    panel: Any,
    steps: Sequence[int],
    result: CalibrationResult,
    group: Sequence[FittedParameter],
) -> None:
    """Draw one group; shifts in mm and turns in degrees share a panel."""
    units = sorted({shown(0.0, 0.0, p.unit).unit for p in group})
    lines = []
    for number, parameter in enumerate(group):
        unit = shown(0.0, 0.0, parameter.unit).unit
        values = [
            shown(record.values[parameter.name], 0.0, parameter.unit).value
            for record in result.history
        ]
        (line,) = panel.plot(
            steps,
            values,
            color=palette.LINES[number % len(palette.LINES)],
            linestyle=palette.DASHES[units.index(unit) % len(palette.DASHES)],
            marker='o',
            markersize=4,
            label=title(parameter.name),
        )
        lines.append(line)
        last = shown(parameter.value, parameter.std_error, parameter.unit)
        if is_material(parameter.name) and np.isfinite(last.error):
            panel.errorbar(steps[-1], last.value, yerr=last.error, color=line.get_color())
    panel.set_ylabel(', '.join(unit for unit in units if unit))
    panel.set_title('parameters', fontsize=11)
    _legend_below(panel, lines)


def _legend_below(panel: Any, lines: Sequence[Any]) -> None:
    """Name the lines under the panel: inside it they would hide a part of some curve."""
    panel.legend(
        lines,
        [line.get_label() for line in lines],
        fontsize=8,
        ncol=2 if len(lines) > 3 else len(lines),
        loc='upper center',
        bbox_to_anchor=(0.5, -0.18),
        frameon=False,
    )
