# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Collect everything that is wrong with a scene, so that one reading tells it all."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
import difflib
from typing import Any

from diffcal_ros.errors import SceneError

_LONGEST_VALUE = 100
_MOST_LISTED = 30


@dataclass(frozen=True)
class _Problem:
    key: str
    sentence: str
    line: int | None


class Problems:
    """What is wrong with one scene file.

    Args:
        source: the file, as the user named it.
        lines: line of each dotted key.
    """

    def __init__(self, source: str, lines: Mapping[str, int] | None = None) -> None:
        self._source = source
        self._lines = lines or {}
        self._found: list[_Problem] = []

    def add(self, key: str, rest: str) -> None:
        """Note one mistake; `rest` goes on where the dotted key starts the sentence."""
        self._found.append(_Problem(key, f'{key} {rest}', self._line(key)))

    def touch(self, key: str) -> bool:
        """Tell whether anything is wrong at this key or below it."""
        return any(_is_within(problem.key, key) for problem in self._found)

    def raise_if_any(self) -> None:
        """Raise all mistakes as one error, one line each.

        Raises:
            SceneError: when any was noted.
        """
        if not self._found:
            return
        # In the order of the file; sorting is stable, so one line keeps the order of finding.
        found = sorted(self._found, key=lambda problem: problem.line or 0)
        if len(found) == 1:
            where = f', line {found[0].line}' if found[0].line else ''
            raise SceneError(f'{self._source}{where}: {found[0].sentence}')
        listed = [
            f'  line {problem.line}: {problem.sentence}'
            if problem.line
            else f'  {problem.sentence}'
            for problem in found[:_MOST_LISTED]
        ]
        if len(found) > _MOST_LISTED:
            listed.append(f'  and {len(found) - _MOST_LISTED} more')
        raise SceneError('\n'.join([f'{self._source}: {len(found)} mistakes', *listed]))

    def _line(self, key: str) -> int | None:
        """Line of a key, or of the nearest section around it that stands in the file."""
        while key:
            if key in self._lines:
                return self._lines[key]
            key = key[: max(key.rfind('.'), key.rfind('['), 0)]
        return None


def _is_within(key: str, section: str) -> bool:
    return key == section or key.startswith((f'{section}.', f'{section}['))


def shown(value: Any) -> str:
    """Write a value for a message: short, numbers as people write them."""
    if isinstance(value, float):
        return f'{value:g}'
    try:
        text = repr(value)
    except ValueError:  # Python refuses to write whole numbers of thousands of digits.
        return 'a number of thousands of digits'
    return text if len(text) <= _LONGEST_VALUE else text[: _LONGEST_VALUE - 3] + '...'


def listed(names: Iterable[str]) -> str:
    """Join names for a message."""
    return ', '.join(names)


def suggestion(given: str, known: Iterable[str]) -> str:
    """Return `; did you mean X?` for the nearest known name, or nothing."""
    names = list(known)
    by_lower_case = {name.lower(): name for name in names}
    near = difflib.get_close_matches(given.lower(), by_lower_case, n=1, cutoff=0.6)
    return f'; did you mean `{by_lower_case[near[0]]}`?' if near else ''
