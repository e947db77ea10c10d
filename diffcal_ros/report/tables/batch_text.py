# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A batch in some lines for the terminal."""

from collections import Counter
from collections.abc import Iterator
import math
from pathlib import Path
from typing import Any

from diffcal_ros.batch.body_result import BodyResult
from diffcal_ros.batch.materials import Comparison, MaterialFit
from diffcal_ros.batch.summary import JSON_FILE, PAGE_FILE, Summary, TABLE_FILE
from diffcal_ros.report.naming import is_material, shown, title
from diffcal_ros.report.tables.scene_table import format_rows

_TELLS_APART = 0.05


def body_words(result: BodyResult) -> str:
    """Say in a few words what became of a body."""
    words = [result.ending.replace('_', ' ')]
    words += [parameter_words(name, own) for name, own in result.parameters().items()]
    words += [effect['identifier'] for effect in result.content.get('effects', [])]
    return ', '.join(word for word in (*words, result.words) if word)


def parameter_words(name: str, own: dict[str, Any]) -> str:
    """Say a material's number with its error; nothing of others."""
    if not is_material(name):
        return ''
    value = own['value'] if own['fine_mesh_value'] is None else own['fine_mesh_value']
    error = math.nan if own['std_error'] is None else own['std_error']
    return f'{title(name)} {shown(value, error, own["unit"]).text()}'


def batch_lines(summary: Summary, out: Path, done_now: int) -> list[str]:
    """Say what became of the bodies and what they say together.

    Args:
        summary: of the batch.
        out: its folder.
        done_now: bodies that this run did.
    """
    counts = Counter(result.ending.replace('_', ' ') for result in summary.results)
    total = len(summary.results)
    endings = ', '.join(f'{count} {name}' for name, count in counts.most_common())
    lines = [f'{total} bodies: {endings} ({total - done_now} were done before)']
    lines += [
        f'failed    {result.body.name}: {result.words}'
        for result in summary.results
        if not result.content
    ]
    lines += ['', *(material_sentence(fit) for fit in summary.materials)]
    lines += [comparison_sentence(own) for own in summary.comparisons]
    files = (('page', PAGE_FILE), ('table', TABLE_FILE), ('all', JSON_FILE))
    return [*lines, '', format_rows([(name, str(out / file)) for name, file in files])]


def material_sentence(fit: MaterialFit) -> str:
    """Say what the bodies of a material have in common."""
    return '; '.join(_material_parts(fit))


def _material_parts(fit: MaterialFit) -> Iterator[str]:
    own, unit = fit.effects, fit.unit
    low, high = (shown(fit.in_unit(end), math.nan, unit) for end in own.interval_95)
    mean = shown(fit.in_unit(own.mean), math.nan, unit)
    bodies = 'one body' if own.count == 1 else f'{own.count} bodies'
    yield (
        f'{fit.material}: {title(fit.quantity)} {mean.text()}, 95 % {low.value:.4g} to '
        f'{high.text()} ({bodies})'
    )
    if own.count > 1:
        spread = shown(fit.spread, math.nan, unit).text()
        share = f' ({own.spread:.1%})' if fit.is_logarithmic else ''
        yield f'bodies differ by {spread}{share} beyond their errors'
    outliers = [name for name, out in zip(fit.bodies, fit.is_outlier, strict=True) if out]
    if outliers:
        yield f'left out as outliers: {", ".join(outliers)}'


def comparison_sentence(own: Comparison) -> str:
    """Say whether two materials can be told apart."""
    first, second = own.materials
    verdict = 'differ' if own.p < _TELLS_APART else 'cannot be told apart'
    return f'{first} and {second} {verdict} in {title(own.quantity)} (p = {own.p:.2g})'
