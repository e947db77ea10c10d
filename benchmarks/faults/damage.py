# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Damage a file in ways that disks, cables and power cuts do, and keep account of what was hit."""

from dataclasses import dataclass

import numpy as np

from benchmarks.faults.layouts import Written

KINDS = ('cut', 'bit', 'bit in a head', 'three bits', 'zeros', 'noise', 'removed', 'repeated')
_HEAD = 48  # Bytes of a record that say what and how long it is.
_LONGEST = 40_000


@dataclass(frozen=True)
class Damage:
    """What happened to a file.

    Attributes:
        kind: one of `KINDS`.
        content: of the damaged file.
        spoilt: places that changed or went away, in the whole file.
    """

    kind: str
    content: bytes
    spoilt: tuple[tuple[int, int], ...]

    def hits(self, start: int, end: int) -> bool:
        """Tell whether any byte between two places changed."""
        return any(first < end and start < last for first, last in self.spoilt)


def draw_damage(written: Written, kind: str, random: np.random.Generator) -> Damage:
    """Damage a file in one way at a random place."""
    size = len(written.content)
    content = bytearray(written.content)
    if kind == 'cut':
        place = int(random.integers(1, size))
        return Damage(kind, bytes(content[:place]), ((place, size),))
    if kind == 'bit':
        return _flipped(kind, content, [int(random.integers(size))], random)
    if kind == 'bit in a head':
        place = written.places[int(random.integers(len(written.places)))]
        reach = min(_HEAD, place.end - place.start)
        return _flipped(kind, content, [place.start + int(random.integers(reach))], random)
    if kind == 'three bits':
        places = sorted({int(one) for one in random.integers(size, size=3)})
        return _flipped(kind, content, places, random)
    length = int(random.integers(1, min(_LONGEST, size // 2)))
    start = int(random.integers(size - length))
    end = start + length
    if kind == 'removed':
        return Damage(kind, bytes(content[:start] + content[end:]), ((start, end),))
    if kind == 'repeated':
        # A place where bytes were put in between, and none is changed.
        return Damage(kind, bytes(content[:end] + content[start:]), ((end, end),))
    fill = bytes(length) if kind == 'zeros' else random.bytes(length)
    content[start:end] = fill
    changed = start + np.flatnonzero(_array(fill) != _array(written.content[start:end]))
    spoilt = ((int(changed[0]), int(changed[-1]) + 1),) if changed.size else ()
    return Damage(kind, bytes(content), spoilt)


def _flipped(
    kind: str, content: bytearray, places: list[int], random: np.random.Generator
) -> Damage:
    for place in places:
        content[place] ^= 1 << int(random.integers(8))
    return Damage(kind, bytes(content), tuple((place, place + 1) for place in places))


def _array(content: bytes) -> np.ndarray:
    return np.frombuffer(content, np.uint8)
