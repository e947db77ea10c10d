# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rows of a table of metrics."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from benchmarks.blind.answers import Answer


def row(name: str, value: float, count: int, ship: str, reach: str) -> dict[str, Any]:
    """Return a metric with its number of cases, and what ships and what is reached for."""
    given = None if np.isnan(value) else value
    return {'metric': name, 'value': given, 'count': count, 'ship': ship, 'reach': reach}


def share(
    name: str, cases: Sequence[Answer], holds: Callable[[Answer], bool], ship: str, reach: str
) -> dict[str, Any]:
    """Return the share of cases of which something holds [%]."""
    hits = sum(holds(case) for case in cases)
    value = 100.0 * hits / len(cases) if cases else float('nan')
    return {**row(f'{name} [%]', value, len(cases), ship, reach), 'hits': hits}


def median(name: str, values: Sequence[float], ship: str, reach: str) -> dict[str, Any]:
    """Return a median."""
    value = float(np.median(values)) if len(values) else float('nan')
    return row(name, value, len(values), ship, reach)


def metric_lines(rows: Sequence[dict[str, Any]]) -> list[str]:
    """Write rows as a Markdown table, line by line."""
    lines = ['| metric | value | cases | ship | reach |', '|---|---|---|---|---|']
    for one in rows:
        value = '-' if one['value'] is None else f'{one["value"]:.3g}'
        hits = f' ({one["hits"]})' if 'hits' in one else ''
        cells = (one['metric'], f'{value}{hits}', one['count'], one['ship'], one['reach'])
        lines.append('| ' + ' | '.join(map(str, cells)) + ' |')
    return lines
