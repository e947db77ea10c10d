# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Material and effective moduli side by side, for a terminal and for the report."""

from collections.abc import Iterator, Mapping
from html import escape
import math
import textwrap
from typing import Any

from diffcal_ros.calibration.results.result import CalibrationResult
from diffcal_ros.report.naming import shown
from diffcal_ros.report.tables.page_tables import number_text, table

# Of the details of a result.
EFFECTIVE = 'effective'
_HEAD = (
    'simulator',
    'numbers',
    'modulus',
    "Poisson's ratio",
    'gap median / RMS',
    'coverage',
    'off',
)
_ABOUT = (
    'What other simulators need on this mesh, and what they leave on the recording. "Off" is how '
    'far the farthest vertex is from the calibrated body.'
)


def effective_lines(result: CalibrationResult) -> list[str]:
    """Write the table in plain text; empty where no simulator was asked for."""
    fits = result.details.get(EFFECTIVE, {})
    if not fits:
        return []
    rows = [_HEAD, *_rows(result, fits)]
    widths = [max(len(row[column]) for row in rows) for column in range(len(_HEAD))]
    lines = [
        '  '.join(f'{text:<{width}}' for text, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]
    for note in _notes(fits):
        lines += textwrap.wrap(note, 96, subsequent_indent='  ')
    return ['', *lines]


def effective_section(result: CalibrationResult) -> str:
    """Write the report's section; empty where no simulator was asked for."""
    fits = result.details.get(EFFECTIVE, {})
    if not fits:
        return ''
    rows = [[number_text(cell) for cell in row] for row in _rows(result, fits)]
    notes = ''.join(f'<p class="soft">{escape(note)}</p>\n' for note in _notes(fits))
    return (
        f'<h2>In other simulators</h2>\n<p class="soft">{escape(_ABOUT)}</p>\n'
        f'{table([escape(word) for word in _HEAD], rows, first_number=2)}\n{notes}'
    )


def _rows(result: CalibrationResult, fits: Mapping[str, Any]) -> Iterator[tuple[str, ...]]:
    for simulator, fit in fits.items():
        for which, word in (('material', "the material's"), ('effective', 'effective')):
            yield (
                simulator,
                word,
                ', '.join(_modulus(name, own[which]) for name, own in fit['moduli'].items()),
                ', '.join(f'{own[which]:.3g}' for own in fit['poissons_ratios'].values()),
                *_gap(fit[f'gap_with_{which}']),
                _millimetres(fit[f'largest_offset_with_{which}_mm']),
            )
    yield ('diffcal', 'fitted', '', '', *_gap(result.gap_end.as_dict()), '')


def _modulus(name: str, own: Mapping[str, float]) -> str:
    _, _, region = name.partition('.')
    text = shown(own['value'], own['std_error'], 'Pa').text()
    return f'{region} {text}' if region else text


def _gap(gap: Mapping[str, float]) -> tuple[str, str]:
    sizes = f'{gap["median_mm"]:.3g} / {gap["rms_mm"]:.3g} mm'
    known = gap['pixels'] > 0
    return (sizes, f'{gap["coverage"]:.0%}') if known else ('no equilibrium', '-')


def _millimetres(length: float) -> str:
    return f'{length:.3g} mm' if math.isfinite(length) else '-'


def _notes(fits: Mapping[str, Any]) -> Iterator[str]:
    for simulator, fit in fits.items():
        yield f'{simulator}: by {fit["simulated_with"]}; {fit["outcome"].replace("_", " ")}'
        for own in fit.get('dampings', {}).values():
            needed, has = (
                shown(own[which]['value'], own[which]['std_error'], own['unit']).text()
                for which in ('effective', 'material')
            )
            yield f'{simulator}: damping {needed} for its swings, the material has {has}'
        yield from (f'note: {note}' for note in fit['notes'])
