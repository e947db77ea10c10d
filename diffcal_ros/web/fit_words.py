# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The figures of a fit in a few lines of Markdown."""

from collections.abc import Mapping
import math
from typing import Any

from diffcal_ros.report.naming import shown, title


def fit_words(name: str, document: Mapping[str, Any]) -> str:
    """Say what a fit found.

    Args:
        name: of the scene.
        document: its result.json.
    """
    outcome = str(document['outcome']).replace('_', ' ')
    lines = [f'**{_plain(name)}**', f'{outcome}: {document["remedy"]}']
    rows = [
        f'| {title(key)} | {_value(own)} |'
        for key, own in document['parameters'].items()
        if not own['nuisance']
    ]
    if rows:
        lines.append('\n'.join(['| | |', '|---|---|', *rows]))
    lines.append(gap_words(document['gap']['end']))
    return '\n\n'.join(lines)


def gap_words(gap: Mapping[str, Any]) -> str:
    """Say how far measured and simulated surface are apart; see `Gap.as_dict`."""
    median, rms = _number(gap['median_mm']), _number(gap['rms_mm'])
    if not math.isfinite(median):
        return 'gap: nothing measured lies on the simulated body'
    words = f'gap: median {median:.3g} mm, RMS {rms:.3g} mm on {gap["coverage"]:.0%} of the body'
    explained = _number(gap.get('explained'))
    if math.isfinite(explained):
        words += f', {explained:.0%} of the measured body explained'
    return words


def _value(parameter: Mapping[str, Any]) -> str:
    value, error = _number(parameter['value']), _number(parameter['std_error'])
    return shown(value, error, parameter['unit']).text('±')


def _number(value: float | None) -> float:
    """Return a number of JSON, which has null for NaN."""
    return math.nan if value is None else float(value)


def _plain(text: str) -> str:
    """Escape what Markdown would take for its own."""
    return ''.join(f'\\{own}' if own in r'\`*_[]<>|#' else own for own in text)
