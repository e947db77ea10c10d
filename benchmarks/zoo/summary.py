# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What came out of all cases, body by body.

A case is tellable when a fit from the truth converges to a right answer. It holds when that answer
is right, whatever the outcome: a fit may refuse what it got right, as where much is hidden.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

_COLUMNS = (
    'n',
    'right',
    'refused',
    'with truth',
    'wrong',
    'crashed',
    'tellable',
    'right of those',
    'wrong of those',
    'held',
    'seconds',
)


def summarise(cases: Sequence[dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """Return counts by body, and of all."""
    bodies = list(dict.fromkeys(case['body'] for case in cases))
    rows = {body: _row([case for case in cases if case['body'] == body]) for body in bodies}
    return {**rows, 'all': _row(cases)}


def table(rows: dict[str, dict[str, Any]]) -> str:
    """Return the counts as text."""
    width = max(len(body) for body in rows)
    lines = [' ' * width + ''.join(f'  {name:>14}' for name in _COLUMNS)]
    for body, row in rows.items():
        lines.append(f'{body:{width}}' + ''.join(f'  {row[name]:>14}' for name in _COLUMNS))
    return '\n'.join(lines)


def _row(cases: Sequence[dict[str, Any]]) -> dict[str, Any]:
    verdicts = [case['verdict'] for case in cases]
    tellable = [case['verdict'] for case in cases if case['is_tellable']]
    refused = [case for case in cases if case['verdict'] == 'refused']
    outcomes = [case['far']['outcome'] for case in cases]
    return {
        'n': len(cases),
        'right': verdicts.count('right'),
        'refused': len(refused),
        'with truth': sum(bool(case['far']['has_truth']) for case in refused),
        'wrong': verdicts.count('wrong'),
        'crashed': verdicts.count('crashed'),
        'tellable': len(tellable),
        'right of those': tellable.count('right'),
        'wrong of those': tellable.count('wrong'),
        'held': sum(bool(case['near'].get('is_right')) for case in cases),
        'seconds': round(float(np.median([case['far']['seconds'] for case in cases])), 2),
        'outcomes': {name: outcomes.count(name) for name in sorted(set(outcomes))},
    }
