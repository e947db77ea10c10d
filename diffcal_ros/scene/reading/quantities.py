# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Material numbers of the scene file: a start value, its bounds and what is known beforehand."""

from dataclasses import dataclass
import re

from diffcal_ros.scene.model import Quantity
from diffcal_ros.scene.reading.section import Section
from diffcal_ros.scene.reading.shapes import Interval, Keys, Number, OneOf, POSITIVE

# Names of regions and cables become parts of parameter and topic names.
NAME = re.compile(r'[A-Za-z][A-Za-z0-9_]*')
# A standard deviation beside its mean; far below, a fit cannot move and its matrices overflow.
_FINEST_PRIOR = 1e-6


@dataclass(frozen=True)
class QuantityRule:
    """What may be written for one material number.

    Attributes:
        title: for messages and tables.
        unit: SI unit; empty where dimensionless.
        allowed: values that make sense at all.
        usual: bounds where the scene gives none; wide for soft bodies, and narrow enough to
            catch a value in kPa or g/cm^3.
        may_lack: whether a region may leave it out.
    """

    title: str
    unit: str
    allowed: Interval
    usual: Interval
    may_lack: bool = False


QUANTITY_RULES = {
    'youngs_modulus': QuantityRule("Young's modulus", 'Pa', POSITIVE, Interval(1e3, 1e8)),
    'poissons_ratio': QuantityRule(
        "Poisson's ratio", '', Interval(-1.0, 0.5, is_open=True), Interval(0.0, 0.499)
    ),
    'density': QuantityRule('density', 'kg/m^3', POSITIVE, Interval(50.0, 2e4)),
    'damping': QuantityRule('damping', 'Pa s', POSITIVE, Interval(1e-3, 1e5), may_lack=True),
}
RELEASE_TIME = QuantityRule('the time of release', 's', Interval(0.0, 1e4), Interval(0.0, 3600.0))


def quantity_shape(rule: QuantityRule, about: str, plain: Interval | None = None) -> OneOf:
    """Return what may stand for a number that may be fitted.

    Args:
        rule: of the number.
        about: for whoever writes a scene.
        plain: what a plain number may be; None for what is usual.
    """
    number = Number(f'in {rule.unit}' if rule.unit else '', rule.allowed)
    prior = Keys(
        {'mean': number, 'std': Number('standard deviation, in the same unit', POSITIVE)},
        ('mean', 'std'),
        'what is known beforehand',
    )
    bounds = Keys(
        {'start': number, 'min': number, 'max': number, 'prior': prior},
        ('start',),
        'where a fit starts, its bounds, and what is known beforehand',
    )
    return OneOf((Number(allowed=rule.usual if plain is None else plain), bounds), about)


def read_quantity(region: Section, name: str, rule: QuantityRule) -> Quantity | None:
    """Read one number; None when a mistake was noted.

    Args:
        region: section that holds it, as a plain number or as {start, min, max, prior}.
        name: its key.
        rule: what may be written.
    """
    needed = f'give {rule.title}{_in_unit(rule)}, {rule.allowed}'
    section = region.child(name) if isinstance(region.raw(name), dict) else None
    if section is not None:
        return _read_mapping(section, rule, needed)
    value = region.number(name, allowed=rule.allowed, needed=needed)
    if region.problems.touch(region.at(name)):
        return None
    if not rule.usual.holds(value):
        region.wrong(
            name,
            f'{rule.title} is usually {rule.usual.low:g} to {rule.usual.high:g}{_unit(rule)}; '
            f'if it is meant so, write {{start: {value:g}, min: .., max: ..}}',
        )
        return None
    return Quantity(value, rule.usual.low, rule.usual.high)


def _read_mapping(section: Section, rule: QuantityRule, needed: str) -> Quantity | None:
    start = section.number('start', allowed=rule.allowed, needed=needed)
    lower = section.number('min', default=rule.usual.low, allowed=rule.allowed, needed=needed)
    upper = section.number('max', default=rule.usual.high, allowed=rule.allowed, needed=needed)
    mean, std = _read_prior(section, rule, needed)
    section.refuse_unknown()
    if not section.is_sound:
        return None
    if not lower < upper:
        section.problems.add(
            section.key, f'has min {lower:g} and max {upper:g}: min must be below max'
        )
    elif not lower <= start <= upper:
        section.wrong('start', f'it must lie within its bounds, {lower:g} to {upper:g}')
    return Quantity(start, lower, upper, mean, std) if section.is_sound else None


def _read_prior(
    section: Section, rule: QuantityRule, needed: str
) -> tuple[float | None, float | None]:
    prior = section.child('prior')
    if prior is None:
        return None, None
    mean = prior.number('mean', allowed=rule.allowed, needed=needed)
    std = prior.number(
        'std',
        allowed=POSITIVE,
        needed=f'give the standard deviation{_in_unit(rule)} of what is known, above 0',
    )
    prior.refuse_unknown()
    if prior.is_sound and std < _FINEST_PRIOR * max(abs(mean), _FINEST_PRIOR):
        prior.wrong(
            'std',
            f'nothing is known to {_FINEST_PRIOR:g} of itself: leave it out of `fit` instead',
        )
    return mean, std


def _unit(rule: QuantityRule) -> str:
    return f' {rule.unit}' if rule.unit else ''


def _in_unit(rule: QuantityRule) -> str:
    return f' in {rule.unit}' if rule.unit else ''
