# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The page of `diffcal reproduce`: our table beside the paper's, and how the fits went."""

from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

from diffcal_ros import __version__
from diffcal_ros.atomic_file import write_text_atomically
from diffcal_ros.report.figures.figure_png import data_uri, png_bytes
from diffcal_ros.report.figures.spread_figure import spread_figure
from diffcal_ros.report.naming import shown, title
from diffcal_ros.report.pages.page_style import document
from diffcal_ros.report.tables.page_tables import number_text, plain, table
from diffcal_ros.reproduction.row import Row
from diffcal_ros.reproduction.run_row import PICTURE
from diffcal_ros.reproduction.summary import Found, Summary
import numpy as np

_HEAD = (
    'experiment',
    'parameter',
    'ours, mean ± deviation over the starts',
    'standard error',
    "the paper's",
    'starts fitted',
    'iterations',
    'gap before',
    'gap after: median / RMS',
    'coverage',
    'loss before → after',
    'seconds',
)
_SIZES = ('median_mm', 'rms_mm')
_ROUNDING = 1e-9
_TITLE = "The paper's experiments"
_ABOUT = (
    'Every fit starts from random values, the same in every run. The gap is |measured − '
    'simulated| on the pixels of the body, in the middle over the starts. Losses can be compared '
    'with the paper where the variant says so; ours has other units. Deviation says whether all '
    'starts end at the same place, the standard error how well one fit knows its answer.'
)


def write_reproduction_page(path: Path, rows: Sequence[tuple[Row, list[Summary]]]) -> None:
    """Write the page, whole or not at all.

    Args:
        path: HTML file.
        rows: experiments with what was found.

    Raises:
        InputError: when the file cannot be written.
    """
    body = ''.join(_section(row, summaries) for row, summaries in rows)
    head = (
        f'<h1>{_TITLE}</h1>\n<p class="soft">diffcal {escape(__version__)}. {_ABOUT}</p>\n'
        f'{_overview(rows)}\n'
    )
    write_text_atomically(path, document(_TITLE, head + body))


def _overview(rows: Sequence[tuple[Row, list[Summary]]]) -> str:
    cells = []
    for row, summaries in rows:
        for summary in summaries:
            link = f'<a href="#{escape(row.name)}">{escape(row.name)}</a>: '
            cells += _lines(summary, link + escape(summary.variant.title))
    return table(_HEAD, cells, first_number=2)


def _section(row: Row, summaries: Sequence[Summary]) -> str:
    text = f'<h2 id="{escape(row.name)}">{escape(row.name)}: {escape(row.title)}</h2>\n'
    for words in (row.question, row.finding):
        text += f'<p>{escape(words)}</p>\n' if words else ''
    cells = [line for summary in summaries for line in _lines(summary, summary.variant.title)]
    text += table(_HEAD, cells, first_number=2)
    for summary in summaries:
        text += _variant(summary)
    return text


def _variant(summary: Summary) -> str:
    text = f'<h3>{escape(summary.variant.title)}</h3>\n'
    failures = ''.join(f'<li>{escape(failure)}</li>' for failure in summary.failures)
    if failures:
        text += f'<ul class="warnings">{failures}</ul>\n'
    if summary.variant.members and summary.results:
        text += _members(summary)
    picture = summary.folder / PICTURE
    if picture.is_file():
        text += _figure(picture.read_bytes(), 'Depth before and after, from one start')
    if summary.results:
        figure = png_bytes(spread_figure(summary))
        text += _figure(
            figure, 'Mean and one standard deviation over the starts, and each of them'
        )
    return text


def _members(summary: Summary) -> str:
    """Write the gap of each body that was fitted with others."""
    rows = [
        [
            escape(own.name),
            *(f'{summary.middle("members", own.name, key):.2f} mm' for key in _SIZES),
            f'{summary.middle("members", own.name, "coverage"):.0%}',
        ]
        for own in summary.variant.members
    ]
    return table(('body', 'gap, median', 'gap, RMS', 'coverage'), rows)


def _figure(png: bytes, caption: str) -> str:
    return (
        f'<figure><img src="{data_uri(png)}" alt="{caption}">'
        f'<figcaption>{caption}.</figcaption></figure>\n'
    )


def _lines(summary: Summary, name: str) -> list[list[str]]:
    """Write one line a parameter; what belongs to the fit stands in the first."""
    tail = _fit_cells(summary)
    found = summary.parameters()
    if not found:
        return [[name, '–', '–', '–', '–', *tail]]
    lines = []
    for number, parameter in enumerate(found):
        own = [escape(title(parameter.name)), *_value_cells(parameter, summary)]
        lines.append([name if number == 0 else '', *own, *(tail if number == 0 else [''] * 7)])
    return lines


def _value_cells(parameter: Found, summary: Summary) -> list[str]:
    # What is left of a value at its bound is rounding.
    is_rounding = parameter.deviation < _ROUNDING * abs(parameter.mean)
    deviation = 0.0 if is_rounding else parameter.deviation
    own = shown(parameter.mean, deviation, parameter.unit)
    error = shown(parameter.std_error, 0.0, parameter.unit)
    return [
        number_text(own.text('±')),
        plain(error.value, error.unit),
        _paper(summary.variant.paper.get(parameter.name), parameter.unit),
    ]


def _paper(value: Any, unit: str) -> str:
    if value is None:
        return '–'
    ends = value if isinstance(value, list) else [value]
    parts = [shown(float(end), 0.0, unit) for end in ends]
    return f'{" to ".join(plain(part.value) for part in parts)} {escape(parts[0].unit)}'


def _fit_cells(summary: Summary) -> list[str]:
    paper = summary.variant.paper
    total = len(summary.results) + len(summary.failures) + summary.missing
    iterations = plain(summary.middle('iterations'))
    if 'iterations' in paper:
        iterations += f' (paper: {plain(float(paper["iterations"]))})'
    loss = ' → '.join(plain(summary.middle('loss', end)) for end in ('start', 'end'))
    if 'loss' in paper:
        loss += f' (paper: {" → ".join(plain(float(end)) for end in paper["loss"])})'
    after = [summary.middle('gap', 'end', key) for key in _SIZES]
    coverage = summary.middle('gap', 'end', 'coverage')
    return [
        f'{len(summary.fitted)} of {total}',
        iterations,
        f'{plain(summary.middle("gap", "start", "median_mm"))} mm',
        f'{after[0]:.2f} / {after[1]:.2f} mm' if np.isfinite(after).all() else '–',
        f'{coverage:.0%}' if np.isfinite(coverage) else '–',
        loss,
        plain(summary.middle('seconds')),
    ]
