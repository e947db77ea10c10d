# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The page of `diffcal batch`: every body, and what they say together of their materials."""

from collections import Counter
from collections.abc import Sequence
from html import escape
import math
from pathlib import Path
from urllib.parse import quote

from diffcal_ros import __version__
from diffcal_ros.atomic_file import write_text_atomically
from diffcal_ros.batch.body_result import BodyResult
from diffcal_ros.batch.materials import FoundMaterials, MaterialFit
from diffcal_ros.batch.run import FOLDER
from diffcal_ros.batch.summary import PAGE_FILE, Summary
from diffcal_ros.report.figures.figure_png import figure_html
from diffcal_ros.report.figures.moduli_figure import moduli_figure
from diffcal_ros.report.naming import shown, title
from diffcal_ros.report.pages.page_style import document
from diffcal_ros.report.tables.batch_text import comparison_sentence, parameter_words
from diffcal_ros.report.tables.page_tables import number_text, plain, table

_PAGES = {'calibrate': 'report.html', 'diagnose': 'diagnosis.html'}
_CAPTION = (
    'Bars: 95 % of each fit by itself. Line and dark band: mean of the material and its 95 % '
    'interval; pale band: where 95 % of other bodies of it are expected. Crosses: outliers, which '
    'are in neither.'
)
_MODEL = (
    'Of every body the fitted value counts with the error that bodies do not share. It is the '
    "material's mean, and an offset of the body's own, normal with a spread that restricted "
    'likelihood finds; what the mesh may be off is common to all and is in the interval of the '
    'mean. Only fits that converged are used.'
)


def write_batch_page(out: Path, name: str, summary: Summary) -> None:
    """Write the page, whole or not at all.

    Args:
        out: folder of the batch.
        name: of the batch.
        summary: what was found.

    Raises:
        InputError: when the file cannot be written.
    """
    body = (
        f'<h1>{escape(name)}</h1>\n<p class="soft">A batch with diffcal {escape(__version__)}.</p>'
        f'\n{_cards(summary)}{_failures(summary)}{_materials(summary)}{_found(summary)}'
        f'{_bodies(summary)}'
    )
    write_text_atomically(out / PAGE_FILE, document(f'{name}: batch', body))


def _cards(summary: Summary) -> str:
    counts = Counter(result.ending for result in summary.results)
    cards = [_card('bodies', str(len(summary.results)))]
    cards += [
        _card(ending.replace('_', ' '), str(count)) for ending, count in counts.most_common()
    ]
    if summary.materials:
        cards.append(_card('outliers', str(len(summary.outliers))))
    return f'<div class="cards">{"".join(cards)}</div>\n'


def _card(label: str, value: str) -> str:
    return (
        f'<div class="card"><div class="label">{escape(label)}</div>'
        f'<div class="value">{escape(value)}</div></div>'
    )


def _failures(summary: Summary) -> str:
    items = ''.join(
        f'<li>{escape(result.body.name)}: {escape(result.words)}</li>'
        for result in summary.results
        if not result.content
    )
    return f'<ul class="warnings">{items}</ul>\n' if items else ''


def _materials(summary: Summary) -> str:
    if not summary.materials:
        return ''
    text = f'<h2>Materials</h2>\n<p class="soft">{_MODEL}</p>\n'
    header = (
        *('material', 'number', 'bodies', 'mean', 'mean, 95 %', 'between bodies'),
        *('between bodies, 95 %', 'another body, 95 %', 'alike, p', 'outliers'),
    )
    text += table(header, [_material_row(fit) for fit in summary.materials], first_number=2)
    sentences = ''.join(f'<li>{escape(comparison_sentence(c))}</li>' for c in summary.comparisons)
    text += f'<ul class="soft">{sentences}</ul>\n' if sentences else ''
    for quantity in dict.fromkeys(fit.quantity for fit in summary.materials):
        own = [fit for fit in summary.materials if fit.quantity == quantity]
        text += figure_html(moduli_figure(own), f'{title(quantity)} over the bodies', _CAPTION)
    return text


def _material_row(fit: MaterialFit) -> list[str]:
    own = fit.effects
    factor = fit.in_unit(own.mean) if fit.is_logarithmic else 1.0
    outliers = [name for name, out in zip(fit.bodies, fit.is_outlier, strict=True) if out]
    return [
        escape(fit.material),
        escape(title(fit.quantity)),
        str(own.count),
        _value(fit.in_unit(own.mean), fit.unit),
        _range([fit.in_unit(end) for end in own.interval_95], fit.unit),
        _value(fit.spread, fit.unit),
        _range([factor * end for end in own.spread_95], fit.unit),
        _range([fit.in_unit(end) for end in own.prediction_95], fit.unit),
        plain(own.homogeneity_p),
        escape(', '.join(outliers)) or '–',
    ]


def _value(value: float, unit: str) -> str:
    own = shown(value, math.nan, unit)
    return plain(own.value, own.unit)


def _range(ends: Sequence[float], unit: str) -> str:
    if not all(math.isfinite(end) for end in ends):
        return '–'
    low, high = (shown(end, math.nan, unit) for end in ends)
    return f'{plain(low.value)} … {plain(high.value, high.unit)}'


def _found(summary: Summary) -> str:
    text = ''
    for found in summary.found:
        if len(found.places) < 2:
            continue
        text += f'<h3>Which bodies share a material, by {escape(title(found.quantity))}</h3>\n'
        text += '<p class="soft">Told from the values alone, whatever the manifest says: parted '
        text += 'where a gap is too wide for one material.</p>\n'
        rows = [
            [_value(mean, found.unit), escape(', '.join(_members(found, number)))]
            for number, mean in enumerate(found.means)
        ]
        unsure = _members(found, None)
        rows += [['unsure', escape(', '.join(unsure))]] if unsure else []
        text += table(('mean', 'bodies'), rows, first_number=2)
    return text


def _members(found: FoundMaterials, number: int | None) -> list[str]:
    return [name for name, place in found.places.items() if place == number]


def _bodies(summary: Summary) -> str:
    header = ('body', 'material', 'ending', 'found', 'gap, median', 'coverage', 'seconds', '')
    rows = [_body_row(result, summary) for result in summary.results]
    return '<h2>Bodies</h2>\n' + table(header, rows, first_number=4)


def _body_row(result: BodyResult, summary: Summary) -> list[str]:
    body, end = result.body, result.content.get('gap', {}).get('end', {})
    found = [parameter_words(name, own) for name, own in result.parameters().items()]
    found += [effect['identifier'] for effect in result.content.get('effects', [])]
    name = escape(body.name)
    if result.content:
        link = quote(f'{FOLDER}/{body.name}/{_PAGES[body.command]}')
        name = f'<a href="{link}">{name}</a>'
    median, coverage = end.get('median_mm'), end.get('coverage')
    return [
        name,
        escape(', '.join(dict.fromkeys(body.material.values()))) or '–',
        escape(result.ending.replace('_', ' ')),
        number_text(', '.join(word for word in found if word)) or '–',
        f'{median:.3g} mm' if median is not None else '–',
        f'{coverage:.0%}' if coverage is not None else '–',
        f'{result.account.seconds:.1f}' if result.account else '–',
        'outlier' if body.name in summary.outliers else '',
    ]
