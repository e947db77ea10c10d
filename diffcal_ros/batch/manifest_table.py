# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A manifest as a table, one body a line."""

import csv
from pathlib import Path
from typing import Any

from diffcal_ros.errors import SceneError
from diffcal_ros.scene.reading.yaml_document import read_text, YamlDocument

_COLUMNS = ('body', 'scene', 'recordings', 'material', 'options')
_BETWEEN_RECORDINGS = ';'


def read_manifest_table(path: Path) -> YamlDocument:
    """Read a table as if its lines stood under `bodies` of a manifest in YAML.

    Its first line names the columns: body, and any of scene, recordings (with semicolons between
    them), material and options. What a cell leaves empty is not given.

    Raises:
        SceneError: when it cannot be read, has no such line, or a line has other cells.
    """
    lines = csv.reader(read_text(path, 'manifest').lstrip('\ufeff').splitlines(), strict=True)
    rows: list[tuple[int, list[str]]] = []
    try:
        for row in lines:
            if any(cell.strip() for cell in row):
                rows.append((lines.line_num, [cell.strip() for cell in row]))
    except csv.Error as error:
        raise SceneError(
            f'{path}, line {lines.line_num}: not readable as CSV ({error}): check quotes'
        ) from error
    if not rows:
        raise SceneError(f'{path} is empty: its first line names columns, {", ".join(_COLUMNS)}')
    (line, header), *bodies = rows
    _check_header(path, line, header)
    content: list[dict[str, Any]] = []
    places = {'bodies': line}
    for index, (line, cells) in enumerate(bodies):
        if len(cells) != len(header):
            raise SceneError(
                f'{path}, line {line}: it has {len(cells)} cells, and {len(header)} columns are '
                'named: put cells that hold commas in double quotes'
            )
        content.append(_body(dict(zip(header, cells, strict=True))))
        keys = (f'bodies[{index}]', *(f'bodies[{index}].{column}' for column in header))
        places.update(dict.fromkeys(keys, line))
    return YamlDocument({'format': 1, 'bodies': content}, places)


def _check_header(path: Path, line: int, header: list[str]) -> None:
    unknown = [name for name in header if name not in _COLUMNS]
    repeated = [name for name in header if header.count(name) > 1]
    if unknown or repeated or 'body' not in header:
        what = (
            f'has the column {unknown[0]!r}'
            if unknown
            else f'has the column {repeated[0]!r} twice'
            if repeated
            else 'has no column `body`'
        )
        raise SceneError(f'{path}, line {line}: it {what}: use {", ".join(_COLUMNS)}, once each')


def _body(cells: dict[str, str]) -> dict[str, Any]:
    given: dict[str, Any] = {name: cell for name, cell in cells.items() if cell}
    if 'recordings' in given:
        parts = given['recordings'].split(_BETWEEN_RECORDINGS)
        given['recordings'] = [part.strip() for part in parts]
    return given
