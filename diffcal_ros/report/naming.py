# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Names, units and rounding for people: kPa, mm and degrees in place of SI."""

from collections.abc import Mapping
from dataclasses import dataclass
import math

import numpy as np

_UNITS = {'Pa': (1e-3, 'kPa'), 'm': (1e3, 'mm'), 'rad': (math.degrees(1.0), 'deg'), '1': (1.0, '')}
_TITLES = {
    'youngs_modulus': "Young's modulus",
    'poissons_ratio': "Poisson's ratio",
}
_TURNS = {'rx': 'turn about x', 'ry': 'turn about y', 'rz': 'turn about z'}
_SYMBOLS = {
    'youngs_modulus': 'E',
    'poissons_ratio': 'nu',
    'density': 'density',
    'damping': 'damping',
    'rest_length': 'rest length',
    'cable_stiffness': 'cable stiffness',
}


@dataclass(frozen=True)
class Shown:
    """A number in a unit for people.

    Attributes:
        value: in `unit`.
        error: standard error in `unit`; NaN when not known.
        unit: kPa, mm, deg and others; empty where dimensionless.
    """

    value: float
    error: float
    unit: str

    def text(self, plus_minus: str = '+-') -> str:
        """Write value and error to two digits of the error, and the unit."""
        if not (math.isfinite(self.error) and self.error > 0.0):
            return f'{self.value:.4g} {self.unit}'.rstrip()
        digits = _digits(self.error)
        value, error = _fixed(self.value, digits), _fixed(self.error, digits)
        return f'{value} {plus_minus} {error} {self.unit}'.rstrip()


def shown(value: float, error: float, unit: str) -> Shown:
    """Turn a number in SI into one for people."""
    scale, name = _UNITS.get(unit, (1.0, unit))
    return Shown(scale * value, scale * error, name)


def title(name: str) -> str:
    """Return a parameter's name for people: `youngs_modulus.tip` is "Young's modulus, tip"."""
    head, _, rest = name.partition('.')
    words = _TITLES.get(head, head.replace('_', ' '))
    if not rest:
        return words
    if head == 'camera_pose':
        number, _, axis = rest.partition('.')
        return f'{words} {int(number) + 1}, {_TURNS.get(axis, axis)}'
    return f'{words}, {_TURNS.get(rest, rest)}'


def is_material(name: str) -> bool:
    """Tell whether a parameter belongs to the body and its cables, not to the rig."""
    return name.partition('.')[0] in _SYMBOLS


def short_values(values: Mapping[str, float]) -> str:
    """Write the main parameters in a few words: material, and the length of the offset."""
    words = []
    for name, value in values.items():
        head, _, region = name.partition('.')
        if head == 'youngs_modulus':
            words.append(f'{_subject("E", region)} {1e-3 * value:.1f} kPa')
        elif head == 'rest_length':
            words.append(f'{_subject("rest length", region)} {1e3 * value:.1f} mm')
        elif head in _SYMBOLS:
            words.append(f'{_subject(_SYMBOLS[head], region)} {value:.4g}')
    offset = [value for name, value in values.items() if name in _SHIFTS]
    if offset:
        words.append(f'offset {1e3 * float(np.linalg.norm(offset)):.1f} mm')
    return ', '.join(words)


_SHIFTS = tuple(f'rigid_offset.{axis}' for axis in 'xyz')


def _subject(symbol: str, region: str) -> str:
    return f'{symbol} of {region}' if region else symbol


def two_digits(size: float) -> str:
    """Write a positive number to two digits, without an exponent."""
    return _fixed(size, _digits(size))


def _digits(error: float) -> int:
    """Return how many decimals show two digits of an error; negative: tens, hundreds."""
    digits = 1 - math.floor(math.log10(error))
    # 0.0996 is written 0.10, with one decimal less than its first digit asks for.
    return digits if float(f'{error:.1e}') < 10.0 ** (2 - digits) else digits - 1


def _fixed(value: float, digits: int) -> str:
    rounded = round(value, digits) + 0.0  # Adding zero turns -0.0 into 0.0.
    return f'{rounded:.{max(digits, 0)}f}'
