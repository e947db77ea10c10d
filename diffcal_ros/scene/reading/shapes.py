# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What may stand under a key of the scene file, as data.

Each reader declares the shape of its section once. `Section` reads by it, and `scene.schema` makes
the JSON schema for editors of it, so that the two cannot disagree on a key. What depends on more
than one key, such as whether a box holds a vertex, only the reader can tell.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
import math
from typing import TypeAlias

import numpy as np

# What regions, held parts and cables may be called unless their section says otherwise.
ANY_NAME = r'.*'


# No quantity in SI units is larger, nor one that must be positive smaller: squares of others, and
# what is divided by them, are no numbers any more.
SMALLEST, LARGEST = 1e-15, 1e18


@dataclass(frozen=True)
class Interval:
    """Allowed numbers; infinite ones never are.

    Attributes:
        low: lower end.
        high: upper end.
        is_open: whether the ends themselves are left out.
    """

    low: float = -math.inf
    high: float = math.inf
    is_open: bool = False

    def holds(self, value: float) -> bool:
        """Tell whether the value is allowed."""
        if abs(value) > LARGEST or (self.is_open and self.low == 0.0 and value < SMALLEST):
            return False
        if self.is_open:
            return self.low < value < self.high
        return math.isfinite(value) and self.low <= value <= self.high

    def __str__(self) -> str:
        if self.is_open:
            ends = [f'above {self.low:g}', f'below {self.high:g}']
        else:
            ends = [f'at least {self.low:g}', f'at most {self.high:g}']
        finite = np.isfinite([self.low, self.high])
        return ' and '.join(end for end, keep in zip(ends, finite, strict=True) if keep)


FINITE = Interval(is_open=True)
POSITIVE = Interval(0.0, is_open=True)


@dataclass(frozen=True)
class Number:
    """A number, or a text that reads as one, such as `1e5`.

    Attributes:
        about: for whoever writes a scene, with the unit.
        allowed: values.
    """

    about: str = ''
    allowed: Interval = FINITE


@dataclass(frozen=True)
class Whole:
    """A whole number.

    Attributes:
        about: as of `Number`.
        low: smallest.
        high: largest, or None.
    """

    about: str = ''
    low: int | None = None
    high: int | None = None


@dataclass(frozen=True)
class Flag:
    """True or false."""

    about: str = ''


@dataclass(frozen=True)
class Text:
    """A text that is not empty."""

    about: str = ''


@dataclass(frozen=True)
class Constant:
    """One value and no other."""

    value: int | str | None
    about: str = ''


@dataclass(frozen=True)
class Choice:
    """One of some names."""

    names: tuple[str, ...]
    about: str = ''


@dataclass(frozen=True)
class ListOf:
    """A list.

    Attributes:
        item: each of its entries.
        about: as of `Number`.
        fewest: so many entries at least.
        most: so many at most, or None.
    """

    item: 'Shape'
    about: str = ''
    fewest: int = 0
    most: int | None = None


@dataclass(frozen=True)
class OneOf:
    """Any of several shapes."""

    shapes: tuple['Shape', ...]
    about: str = ''


@dataclass(frozen=True)
class Keys:
    """A mapping.

    Attributes:
        entries: by key; no other key is known.
        required: keys that must be there.
        about: as of `Number`.
        named: what stands under names that the user chooses; None where there are none.
        name_pattern: what such a name may look like.
        fewest: so many entries at least.
    """

    entries: Mapping[str, 'Shape'] = field(default_factory=dict)
    required: tuple[str, ...] = ()
    about: str = ''
    named: 'Shape | None' = None
    name_pattern: str = ANY_NAME
    fewest: int = 0


Shape: TypeAlias = Number | Whole | Flag | Text | Constant | Choice | ListOf | OneOf | Keys


def vector(size: int, about: str, allowed: Interval = FINITE) -> ListOf:
    """Return the shape of a list of so many numbers."""
    return ListOf(Number(allowed=allowed), about, fewest=size, most=size)
