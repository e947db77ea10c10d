# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""All bodies of a batch in one table, and what they say together."""

from collections.abc import Iterator, Sequence
import csv
from dataclasses import asdict, dataclass
from io import StringIO
from pathlib import Path
from typing import Any

from diffcal_ros import __version__
from diffcal_ros.atomic_file import write_json_atomically, write_text_atomically
from diffcal_ros.batch.body_result import BodyResult
from diffcal_ros.batch.materials import (
    compare_materials,
    Comparison,
    find_materials,
    fit_materials,
    FoundMaterials,
    MaterialFit,
)

JSON_FILE, TABLE_FILE, PAGE_FILE = 'batch.json', 'batch.csv', 'batch.html'


@dataclass(frozen=True)
class Summary:
    """A batch that is over.

    Attributes:
        results: of all bodies, in the manifest's order.
        materials: fitted over the bodies that may be used.
        comparisons: of every two of them.
        found: which bodies share a material.
    """

    results: tuple[BodyResult, ...]
    materials: tuple[MaterialFit, ...]
    comparisons: tuple[Comparison, ...]
    found: tuple[FoundMaterials, ...]

    @property
    def outliers(self) -> set[str]:
        """Bodies that are not of the material of the others."""
        return {
            name
            for fit in self.materials
            for name, is_outlier in zip(fit.bodies, fit.is_outlier, strict=True)
            if is_outlier
        }


def summarise(results: Sequence[BodyResult]) -> Summary:
    """Put the bodies of a batch together."""
    materials = fit_materials(results)
    return Summary(
        tuple(results),
        tuple(materials),
        tuple(compare_materials(materials)),
        tuple(find_materials(results)),
    )


def write_summary(summary: Summary, out: Path) -> None:
    """Write batch.json and batch.csv, each whole or not at all.

    Raises:
        InputError: when they cannot be written.
    """
    content = {
        'format': 1,
        'version': __version__,
        'bodies': [_body(result) for result in summary.results],
        'materials': [fit.as_dict() for fit in summary.materials],
        'comparisons': [asdict(own) for own in summary.comparisons],
        'found_materials': [asdict(own) for own in summary.found],
    }
    write_json_atomically(out / JSON_FILE, content)
    table = StringIO()
    writer = csv.writer(table, lineterminator='\n')
    writer.writerows(_lines(summary))
    write_text_atomically(out / TABLE_FILE, table.getvalue())


def _body(result: BodyResult) -> dict[str, Any]:
    return {
        'body': result.body.name,
        'material': dict(result.body.material),
        'ending': result.ending,
        'words': result.words,
        'account': asdict(result.account) if result.account else None,
        'parameters': result.parameters(),
        'gap': result.content.get('gap', {}),
        'effects': [effect['identifier'] for effect in result.content.get('effects', [])],
    }


def _lines(summary: Summary) -> Iterator[list[Any]]:
    """Yield the table: one line a body, SI units, empty where nothing is known."""
    names = list(dict.fromkeys(name for own in summary.results for name in own.parameters()))
    sizes = ('fine_mesh_value', 'std_error', 'low_95', 'high_95')
    yield [
        *('body', 'material', 'command', 'ending', 'exit_code'),
        *(f'{name}.{size}' for name in names for size in sizes),
        *('gap_median_mm', 'gap_rms_mm', 'coverage', 'effects', 'is_outlier', 'seconds', 'words'),
    ]
    for result in summary.results:
        account, end = result.account, result.content.get('gap', {}).get('end', {})
        yield [
            result.body.name,
            ' '.join(dict.fromkeys(result.body.material.values())),
            result.body.command,
            result.ending,
            account.exit_code if account else '',
            *(cell for name in names for cell in _parameter_cells(result.parameters().get(name))),
            *(end.get(key, '') for key in ('median_mm', 'rms_mm', 'coverage')),
            ' '.join(effect['identifier'] for effect in result.content.get('effects', [])),
            result.body.name in summary.outliers,
            f'{account.seconds:.3f}' if account else '',
            result.words,
        ]


def _parameter_cells(own: dict[str, Any] | None) -> list[Any]:
    if own is None:
        return [''] * 4
    cells = [own['fine_mesh_value'], own['std_error'], *own['interval_95']]
    return ['' if cell is None else cell for cell in cells]
