# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A result in a few lines of plain text, for a terminal."""

from collections.abc import Sequence
import math
import textwrap

from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.calibration.results.result import CalibrationResult, FittedParameter
from diffcal_ros.report.naming import is_material, shown, title

_WIDTH = 96
# A smaller correction for the mesh gets no line of its own.
_WORTH_TELLING = 0.002


def result_text(scene_name: str, result: CalibrationResult) -> str:
    """Write what was fitted, the gap, the outcome with its remedy, and the warnings."""
    asked = [p for p in result.parameters if not p.is_nuisance]
    rows = [('parameter', 'in this model', 'of the body, 95 %', 'start')]
    rows += [
        (title(p.name), _fitted(p), _range(p), shown(p.start, 0.0, p.unit).text()) for p in asked
    ]
    first, second, third = (max(len(row[column]) for row in rows) for column in range(3))
    lines = [f'{scene_name}: {result.outcome.value.replace("_", " ")}', '']
    lines += [f'{a:<{first}}  {b:<{second}}  {c:<{third}}  {d}' for a, b, c, d in rows]
    lines += ['', *_mesh_lines(asked), *_figures(result)]
    lines += [*alternative_lines(result), *profile_lines(result), '']
    lines += textwrap.wrap(result.outcome.remedy, _WIDTH)
    for warning in result.warnings:
        lines += textwrap.wrap(f'warning: {warning}', _WIDTH, subsequent_indent='  ')
    return '\n'.join(line.rstrip() for line in lines) + '\n'


def profile_lines(result: CalibrationResult) -> list[str]:
    """Write the interval of each profile beside the one by curvature."""
    return [
        f'profile     {title(own.name)}: 95 % {_interval(own.low, own.high, own.unit)}; '
        f'by curvature {_interval(*own.laplace, own.unit)}; the mesh aside'
        for own in result.profiles
    ]


def _mesh_lines(parameters: Sequence[FittedParameter]) -> list[str]:
    """Write how far a material's own value lies from what makes this mesh right."""
    lines = []
    for own in parameters:
        if own.has_mesh_correction and abs(own.fine_value / own.value - 1.0) >= _WORTH_TELLING:
            here, of_body = (shown(v, 0.0, own.unit).text() for v in (own.value, own.fine_value))
            lines.append(
                f'mesh        {title(own.name)}: {here} makes this mesh right, '
                f'the body itself has {of_body}'
            )
    return lines


def _interval(low: float, high: float, unit: str) -> str:
    ends = [shown(end, 0.0, unit) for end in (low, high)]
    if math.isinf(low) and math.isinf(high):
        return 'no limit'
    if math.isinf(high):
        return f'above {ends[0].text()}'
    if math.isinf(low):
        return f'below {ends[1].text()}'
    return f'{ends[0].value:.4g} to {ends[1].text()}'


def _fitted(parameter: FittedParameter) -> str:
    text = shown(parameter.value, parameter.error_in_model, parameter.unit).text()
    return f'{text} (at its bound)' if parameter.at_bound else text


def _range(parameter: FittedParameter) -> str:
    if not all(math.isfinite(end) for end in parameter.interval_95):
        return '-'
    return _interval(*parameter.interval_95, parameter.unit)


def _figures(result: CalibrationResult) -> list[str]:
    start, end, held_out = result.gap_start, result.gap_end, result.gap_held_out
    kept = []
    if held_out is not None:
        kept = [
            f'held out    median {_millimetres(held_out.median)} mm, '
            f'RMS {_millimetres(held_out.rms)} mm on frames kept from the fit'
        ]
    return [
        f'gap         median {_millimetres(start.median)} -> {_millimetres(end.median)} mm, '
        f'RMS {_millimetres(start.rms)} -> {_millimetres(end.rms)} mm',
        f'coverage    {start.coverage:.1%} -> {end.coverage:.1%} of the body in view '
        f'({end.pixels} pixels)',
        *_explained(end),
        *kept,
        f'iterations  {result.iterations} in {result.seconds:.2f} s',
    ]


def _explained(gap: Gap) -> list[str]:
    if not math.isfinite(gap.explained):
        return []
    hidden = f'; {gap.hidden:.0%} of the simulated one is hidden' if gap.hidden > 0.02 else ''
    return [f'explained   {gap.explained:.1%} of the measured body{hidden}']


def alternative_lines(result: CalibrationResult) -> list[str]:
    """Write what else explains the data: values that are asked for, and what they leave."""
    asked = [p for p in result.parameters if not p.is_nuisance and is_material(p.name)]
    lines = []
    for own in result.alternatives:
        values = ', '.join(
            f'{title(p.name)} {shown(own.values[p.name], own.std_errors[p.name], p.unit).text()}'
            for p in asked
        )
        word = 'about as well' if own.is_as_good else 'worse'
        lines.append(
            f'another     {word}: {values}; median {_millimetres(own.gap.median)} mm, coverage '
            f'{own.gap.coverage:.1%}, explained {own.gap.explained:.1%}'
        )
    return lines


def _millimetres(length: float) -> str:
    return f'{1e3 * length:.3g}' if math.isfinite(length) else '-'
