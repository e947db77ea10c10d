# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Tables of the report page."""

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from diffcal_ros.calibration.parameters.parameters import Parameter, ParameterSet
from diffcal_ros.calibration.results.result import CalibrationResult, FittedParameter
from diffcal_ros.report.figures.along_body import Share
from diffcal_ros.report.naming import Shown, shown, title, two_digits
from diffcal_ros.report.palette import correlation_color
import numpy as np

_MINUS = '\N{MINUS SIGN}'


def number_text(text: str) -> str:
    """Escape a number and give it a proper minus sign."""
    return escape(text).replace('-', _MINUS)


def plain(value: float, unit: str = '') -> str:
    """Write a number in four digits, or a dash."""
    return number_text(f'{value:.4g} {unit}'.rstrip()) if np.isfinite(value) else '–'


def table(header: Sequence[str], rows: Sequence[Sequence[str]], *, first_number: int = 1) -> str:
    """Write a table of ready HTML cells; columns from `first_number` on hold numbers."""
    head = ''.join(_cell('th', cell, index >= first_number) for index, cell in enumerate(header))
    body = ''.join(
        '<tr>'
        + ''.join(_cell('td', cell, index >= first_number) for index, cell in enumerate(row))
        + '</tr>'
        for row in rows
    )
    return f'<div class="wide"><table><tr>{head}</tr>{body}</table></div>'


def _cell(tag: str, content: str, is_number: bool) -> str:
    return f'<{tag}{" class=number" if is_number else ""}>{content}</{tag}>'


def parameter_table(
    parameters: ParameterSet, fitted: Sequence[FittedParameter], *, nuisances: bool
) -> str:
    """Write value, error, its parts, start, bounds and prior of each parameter."""
    by_name = {parameter.name: parameter for parameter in parameters}
    header = [
        'parameter',
        'in this model',
        'mesh error',
        'of the body, 95 %',
        'start',
        'bounds',
        'prior',
    ]
    rows = [_parameter_row(p, by_name[p.name]) for p in fitted if p.is_nuisance == nuisances]
    return table(header, rows)


def _parameter_row(fitted: FittedParameter, parameter: Parameter) -> list[str]:
    unit = fitted.unit
    own = shown(fitted.value, fitted.error_in_model, unit)
    value = number_text(own.text('±')) + (' <b>at its bound</b>' if fitted.at_bound else '')
    quantity = parameter.quantity
    lower, upper = shown(quantity.lower, 0.0, unit), shown(quantity.upper, 0.0, unit)
    mesh = shown(fitted.mesh_error, 0.0, unit)
    return [
        escape(title(fitted.name)),
        value,
        f'± {two_digits(mesh.value)} {mesh.unit}'.rstrip() if mesh.value > 0.0 else '–',
        _interval(fitted),
        plain(shown(fitted.start, 0.0, unit).value, own.unit),
        f'{plain(lower.value)} … {plain(upper.value, upper.unit)}',
        _prior(parameter),
    ]


def _interval(fitted: FittedParameter) -> str:
    if not np.isfinite(fitted.interval_95).all():
        return '–'
    return ' … '.join(interval_ends(fitted))


def interval_ends(fitted: FittedParameter) -> list[str]:
    """Return both ends of a finite 95 % interval for people, to two digits of the error."""
    ends = [shown(end, fitted.std_error, fitted.unit) for end in fitted.interval_95]
    return [_rounded(end) for end in ends]


def _rounded(end: Shown) -> str:
    return number_text(end.text('|').partition('|')[0].strip())


def _prior(parameter: Parameter) -> str:
    mean, std = parameter.quantity.prior_mean, parameter.quantity.prior_std
    if mean is None or std is None:
        return 'from the pose' if parameter.name.startswith('camera_pose') else '–'
    prior = shown(mean, std, parameter.unit)
    return f'{plain(prior.value)} ± {plain(prior.error, prior.unit)}'


def correlation_table(result: CalibrationResult) -> str:
    """Write the correlations of the asked-for parameters as a heat map with numbers."""
    indices = [index for index, p in enumerate(result.parameters) if not p.is_nuisance]
    if len(indices) < 2 or result.correlation.size == 0:
        return ''
    names = [escape(title(result.parameters[index].name)) for index in indices]
    head = '<tr><th></th>' + ''.join(f'<th class=number>{k + 1}</th>' for k in range(len(names)))
    rows = []
    for number, index in enumerate(indices):
        cells = ''.join(_heat(float(result.correlation[index, other])) for other in indices)
        rows.append(f'<tr><th>{number + 1}&ensp;{names[number]}</th>{cells}</tr>')
    return f'<div class="wide"><table class="heat">{head}</tr>{"".join(rows)}</table></div>'


def _heat(value: float) -> str:
    background, ink = correlation_color(value)
    text = number_text(f'{value + 0.0:+.2f}')
    return f'<td style="background:{background};color:{ink}">{text}</td>'


def share_table(shares: Sequence[Share], heading: str) -> str:
    """Write the gap on parts of the body."""
    header = [heading, 'pixels', 'coverage', 'median', 'median size', 'middle 68 %', 'outline']
    rows = [
        [
            escape(share.label),
            str(share.pixels),
            f'{share.coverage:.0%}' if share.pixels else '–',
            _millimetres(share.median, signed=True),
            _millimetres(share.size),
            f'{_millimetres(share.low, signed=True)} … {_millimetres(share.high, signed=True)}',
            _millimetres(share.edge),
        ]
        for share in shares
    ]
    return table(header, rows)


def _millimetres(length: float, *, signed: bool = False) -> str:
    if not np.isfinite(length):
        return '–'
    text = f'{1e3 * length + 0.0:+.2f}' if signed else f'{1e3 * length:.2f}'
    return f'{number_text(text)} mm'


def details_table(details: Mapping[str, Any]) -> str:
    """Write nested details as rows of key and value."""
    rows = [[escape(key), f'<code>{escape(value)}</code>'] for key, value in _flat(details, '')]
    return table(['key', 'value'], rows, first_number=2)


def _flat(value: Any, key: str) -> list[tuple[str, str]]:
    if isinstance(value, Mapping):
        pairs = [
            _flat(item, f'{key}.{name}' if key else str(name)) for name, item in value.items()
        ]
        return [pair for group in pairs for pair in group]
    if isinstance(value, (list, tuple)) and any(isinstance(item, Mapping) for item in value):
        pairs = [_flat(item, f'{key}[{index}]') for index, item in enumerate(value)]
        return [pair for group in pairs for pair in group]
    if isinstance(value, (list, tuple)):
        return [(key, ', '.join(str(item) for item in value))]
    return [(key, '–' if value is None else str(value))]
