# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What to record next, in words and numbers."""

import json

from diffcal_ros.planning.suggest import ASSUMED_LENGTH, ASSUMED_NOISE, Expected, Suggestion
from diffcal_ros.report.naming import shown, title
from diffcal_ros.report.tables.scene_table import format_rows


def suggestion_text(suggestion: Suggestion) -> str:
    """Write the ranking, the best candidate in a sentence before it."""
    rows = [('now', _errors(suggestion, suggestion.now))]
    rows += [
        (f'{rank}.', f'{one.words}: {_errors(suggestion, one)}; {one.bits:.2f} bit')
        for rank, one in enumerate(suggestion.ranked, start=1)
    ]
    rows += [('left out', f'{one.words}: {one.reason}') for one in suggestion.refused]
    rows.append(
        (
            'assumed',
            f'a structured depth error of {1e3 * ASSUMED_NOISE:g} mm over {ASSUMED_LENGTH:g} px; '
            'other sizes move the errors together and hardly the order',
        )
    )
    return '\n'.join([_best(suggestion), format_rows(rows)])


def _best(suggestion: Suggestion) -> str:
    if not suggestion.ranked:
        return 'No other recording can be made here.'
    best = suggestion.ranked[0]
    falls = [
        f'that of {title(name)} from {_error(suggestion, name, suggestion.now)} to '
        f'{_error(suggestion, name, best)} '
        f'({100.0 * (error / suggestion.now.errors[name] - 1.0):+.0f} %)'
        for name, error in best.errors.items()
    ]
    return f'{best.words[0].upper()}{best.words[1:]}: of standard errors, {", ".join(falls)}.'


def _errors(suggestion: Suggestion, one: Expected) -> str:
    return ', '.join(
        f'{title(name)} {shown(suggestion.values[name], error, suggestion.units[name]).text()}'
        for name, error in one.errors.items()
    )


def _error(suggestion: Suggestion, name: str, one: Expected) -> str:
    own = shown(one.errors[name], 0.0, suggestion.units[name])
    return f'{own.value:.2g} {own.unit}'.rstrip()


def suggestion_json(suggestion: Suggestion) -> str:
    """Write the same for programs; SI units."""
    content = {
        'format': 1,
        'values': suggestion.values,
        'units': suggestion.units,
        'now': suggestion.now.errors,
        'candidates': [
            {'name': one.name, 'words': one.words, 'std_errors': one.errors, 'bits': one.bits}
            for one in suggestion.ranked
        ],
        'left_out': [{'words': one.words, 'reason': one.reason} for one in suggestion.refused],
    }
    return json.dumps(content, indent=2) + '\n'
