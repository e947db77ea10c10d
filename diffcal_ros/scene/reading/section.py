# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Typed access to one mapping of the scene file; mistakes are noted, not raised.

A reader that meets a mistake notes it and returns a stand-in of the right type. Whoever builds
something from a section looks at `is_sound` first.
"""

from collections.abc import Iterable
import math
from pathlib import Path
from typing import Any, TypeVar

from diffcal_ros.errors import InputError
from diffcal_ros.scene.reading.problems import listed, Problems, shown, suggestion
from diffcal_ros.scene.reading.shapes import (
    Choice,
    Interval,
    Keys,
    LARGEST,
    ListOf,
    Number,
    OneOf,
    Shape,
    SMALLEST,
    Whole,
)
from diffcal_ros.user_path import user_path
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
_Kind = TypeVar('_Kind', bound=Shape)


def as_number(value: Any) -> float | None:
    """Return a number, also from a text such as `1e5`, which YAML takes for a string."""
    if isinstance(value, bool):
        return None
    if isinstance(value, int | float | str):
        try:
            number = float(value)
        except (ValueError, OverflowError):
            return None
        return None if math.isnan(number) else number
    return None


class Section:
    """One mapping of a scene file.

    Args:
        content: the mapping as YAML read it; keys that are no text are noted.
        key: its dotted key; empty for the whole file.
        problems: where mistakes are noted.
        shape: what may stand in it; to ask for anything else is a fault of the reader.
    """

    def __init__(self, content: dict[Any, Any], key: str, problems: Problems, shape: Keys) -> None:
        self.key = key
        self.problems = problems
        self._shape = shape
        self._content = content
        self._known: list[str] = []
        for name in content:
            if not isinstance(name, str):
                problems.add(self.at(str(name)), 'is no text: put the key in quotes')

    @property
    def is_sound(self) -> bool:
        """Tell whether nothing was noted in this section so far."""
        return not self.problems.touch(self.key)

    @property
    def names(self) -> list[str]:
        """Keys in the order of the file."""
        return [name for name in self._content if isinstance(name, str)]

    def at(self, name: str) -> str:
        """Return the dotted key of an entry."""
        return f'{self.key}.{name}' if self.key else name

    def has(self, name: str) -> bool:
        """Tell whether an entry is given; `null` counts as not given."""
        self._ask(name)
        return self._content.get(name) is not None

    def raw(self, name: str) -> Any:
        """Return an entry as YAML read it, or None."""
        self._ask(name)
        return self._content.get(name)

    def allowed(self, name: str) -> Interval:
        """Return the numbers that an entry may be."""
        return self._expect(name, Number).allowed

    def required(self, name: str, needed: str) -> bool:
        """Note that an entry is missing; tell whether it is given."""
        if self.has(name):
            return True
        self.problems.add(self.at(name), f'is missing: {needed}')
        return False

    def wrong(self, name: str, needed: str) -> None:
        """Note that an entry is not what is needed."""
        self.problems.add(self.at(name), f'is {shown(self._content.get(name))}: {needed}')

    def number(
        self,
        name: str,
        *,
        default: float | None = None,
        allowed: Interval | None = None,
        needed: str = '',
    ) -> float:
        """Return a number; an entry without default must be given.

        Args:
            name: its key.
            default: where it is not given.
            allowed: narrower than what is declared, where other entries limit it.
            needed: for the message.
        """
        declared = self.allowed(name)
        allowed = declared if allowed is None else allowed
        what = needed or f'give a number {allowed}'.rstrip()
        if default is not None and not self.has(name):
            return default
        if not self.required(name, what):
            return math.nan
        value = as_number(self._content[name])
        if value is None or not allowed.holds(value):
            is_tiny = value is not None and 0.0 < value < SMALLEST
            self.wrong(name, f'no quantity is so small; {what}' if is_tiny else what)
            return math.nan
        return value

    def integer(self, name: str, *, high: int | None = None) -> int:
        """Return a whole number, which must be given.

        Args:
            name: its key.
            high: below the largest that is declared, where other entries limit it.
        """
        declared = self._expect(name, Whole)
        low = 0 if declared.low is None else declared.low
        top = declared.high if high is None else high
        allowed = Interval(low, math.inf if top is None else top)
        needed = f'give a whole number {allowed}'
        if not self.required(name, needed):
            return low
        value = as_number(self._content[name])
        if value is None or not allowed.holds(value) or not value.is_integer():
            self.wrong(name, needed)
            return low
        return int(value)

    def flag(self, name: str, *, default: bool) -> bool:
        """Return a truth value."""
        value = self.raw(name)
        if value is None:
            return default
        if not isinstance(value, bool):
            self.wrong(name, 'write true or false')
            return default
        return value

    def text(self, name: str, *, default: str | None = None, needed: str = 'give a text') -> str:
        """Return a text; a number is taken as the text that was written."""
        if default is not None and not self.has(name):
            return default
        if not self.required(name, needed):
            return ''
        value = self._content[name]
        if isinstance(value, bool) or not isinstance(value, str | int | float) or value == '':
            self.wrong(name, needed)
            return ''
        try:
            return str(value)
        except ValueError:  # Python refuses to write whole numbers of thousands of digits.
            self.wrong(name, needed)
            return ''

    def path(self, name: str, folder: Path, *, needed: str = 'name the file') -> Path:
        """Return a path, which must be given; a relative one starts at `folder`."""
        text = self.text(name, needed=needed)
        try:
            return folder / user_path(text)
        except InputError as error:
            self.problems.add(self.at(name), f'is no path: {error}')
            return folder

    def choice(self, name: str, *, default: str | None = None) -> str:
        """Return one of the names that are declared."""
        choices = self._expect(name, Choice).names
        needed = f'allowed: {listed(choices)}'
        value = self.text(name, default=default, needed=needed)
        if value in choices:
            return value
        if value:
            self.wrong(name, needed + suggestion(value, choices))
        return default or choices[0]

    def vector(self, name: str, *, needed: str) -> FloatArray:
        """Return finite numbers, as many as are declared; the entry must be given."""
        declared = self._expect(name, ListOf)
        size, item = declared.fewest, declared.item
        assert isinstance(item, Number)
        stand_in = np.zeros(size)
        if not self.required(name, needed):
            return stand_in
        numbers = finite_numbers(self._content[name], size)
        if numbers is None or not all(item.allowed.holds(number) for number in numbers):
            self.wrong(name, needed)
            return stand_in
        return numbers

    def child(self, name: str) -> 'Section | None':
        """Return the section under a key, or None where it is not given or no mapping."""
        value = self.raw(name)
        if value is None:
            return None
        if not isinstance(value, dict):
            self.wrong(name, 'a mapping is needed here, `key: value`')
            return None
        return Section(value, self.at(name), self.problems, self._expect(name, Keys))

    def refuse_unknown(self) -> None:
        """Note each entry that nobody asked for, with the nearest one that somebody did."""
        known = dict.fromkeys(self._known)
        for name in self.names:
            if name not in known:
                self.problems.add(
                    self.at(name),
                    f'is no key that is known here{suggestion(name, known)} '
                    f'(allowed: {listed(known)})',
                )

    def _ask(self, name: str) -> None:
        """Keep in mind that a key is known."""
        self._declared(name)
        self._known.append(name)

    def _declared(self, name: str) -> Shape:
        """Return the shape of an entry."""
        shape = self._shape.entries.get(name, self._shape.named)
        if shape is None:
            raise LookupError(
                f'{self.at(name)} is not declared: add it to the shape of {self.key!r}'
            )
        return shape

    def _expect(self, name: str, kind: type[_Kind]) -> _Kind:
        """Return the shape of an entry that is, or may be, of a kind."""
        shape = self._declared(name)
        for one in shape.shapes if isinstance(shape, OneOf) else (shape,):
            if isinstance(one, kind):
                return one
        raise LookupError(f'{self.at(name)} is declared as {shape}, not as {kind.__name__}')


def finite_numbers(value: Any, size: int) -> FloatArray | None:
    """Return a list of `size` finite numbers as an array, or None."""
    if not isinstance(value, list) or len(value) != size:
        return None
    numbers = [as_number(item) for item in value]
    if any(number is None or not abs(number) <= LARGEST for number in numbers):
        return None
    return np.array(numbers, dtype=np.float64)


def whole_numbers(values: Iterable[Any]) -> list[int] | None:
    """Return a list of integers, or None when something else is among them."""
    numbers = list(values)
    if any(isinstance(item, bool) or not isinstance(item, int) for item in numbers):
        return None
    return numbers
