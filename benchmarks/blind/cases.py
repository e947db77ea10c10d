# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The list of cases of a set; every case draws its own numbers from its own name."""

from dataclasses import dataclass, replace
import hashlib
from itertools import combinations

import numpy as np

from benchmarks.blind.amplitudes import LIBRARY, MOTION, OUTSIDE, SIZES
from benchmarks.blind.eighteenth_forms import EIGHTEENTH_PAIRS
from benchmarks.blind.eighteenth_outside import EIGHTEENTH_OUTSIDE
from benchmarks.blind.eighth_forms import EIGHTH_PAIRS
from benchmarks.blind.eighth_outside import EIGHTH_OUTSIDE
from benchmarks.blind.eleventh_forms import ELEVENTH_PAIRS
from benchmarks.blind.eleventh_outside import ELEVENTH_OUTSIDE
from benchmarks.blind.fifteenth_forms import FIFTEENTH_PAIRS
from benchmarks.blind.fifteenth_outside import FIFTEENTH_OUTSIDE
from benchmarks.blind.forms import FORMS, PAIRS
from benchmarks.blind.fourteenth_forms import FOURTEENTH_PAIRS
from benchmarks.blind.fourteenth_outside import FOURTEENTH_OUTSIDE
from benchmarks.blind.motion_forms import MOTION_FORMS
from benchmarks.blind.nineteenth_forms import NINETEENTH_PAIRS
from benchmarks.blind.nineteenth_outside import NINETEENTH_OUTSIDE
from benchmarks.blind.ninth_forms import NINTH_PAIRS
from benchmarks.blind.ninth_outside import NINTH_OUTSIDE
from benchmarks.blind.outside_forms import FURTHER_OUTSIDE
from benchmarks.blind.rubber import LAWS
from benchmarks.blind.sensor import DRAWN
from benchmarks.blind.seventeenth_forms import SEVENTEENTH_PAIRS
from benchmarks.blind.seventeenth_outside import SEVENTEENTH_OUTSIDE
from benchmarks.blind.seventh_forms import SEVENTH_PAIRS
from benchmarks.blind.seventh_outside import SEVENTH_OUTSIDE
from benchmarks.blind.shapes import DEVELOPMENT_FAMILIES, SEALED_FAMILIES
from benchmarks.blind.sixteenth_forms import SIXTEENTH_PAIRS
from benchmarks.blind.sixteenth_outside import SIXTEENTH_OUTSIDE
from benchmarks.blind.tenth_forms import TENTH_PAIRS
from benchmarks.blind.tenth_outside import TENTH_OUTSIDE
from benchmarks.blind.thirteenth_forms import THIRTEENTH_PAIRS
from benchmarks.blind.thirteenth_outside import THIRTEENTH_OUTSIDE
from benchmarks.blind.thirtieth_forms import THIRTIETH_PAIRS
from benchmarks.blind.thirtieth_outside import THIRTIETH_OUTSIDE
from benchmarks.blind.thirtyfirst_forms import THIRTYFIRST_PAIRS
from benchmarks.blind.thirtyfirst_outside import THIRTYFIRST_OUTSIDE
from benchmarks.blind.thirtysecond_forms import THIRTYSECOND_PAIRS
from benchmarks.blind.thirtysecond_outside import THIRTYSECOND_OUTSIDE
from benchmarks.blind.thirtythird_forms import THIRTYTHIRD_PAIRS
from benchmarks.blind.thirtythird_outside import THIRTYTHIRD_OUTSIDE
from benchmarks.blind.twelfth_forms import TWELFTH_PAIRS
from benchmarks.blind.twelfth_outside import TWELFTH_OUTSIDE
from benchmarks.blind.twentieth_forms import TWENTIETH_PAIRS
from benchmarks.blind.twentieth_outside import TWENTIETH_OUTSIDE
from benchmarks.blind.twentyeighth_forms import TWENTYEIGHTH_PAIRS
from benchmarks.blind.twentyeighth_outside import TWENTYEIGHTH_OUTSIDE
from benchmarks.blind.twentyfifth_forms import TWENTYFIFTH_PAIRS
from benchmarks.blind.twentyfifth_outside import TWENTYFIFTH_OUTSIDE
from benchmarks.blind.twentyfirst_forms import TWENTYFIRST_PAIRS
from benchmarks.blind.twentyfirst_outside import TWENTYFIRST_OUTSIDE
from benchmarks.blind.twentyfourth_forms import TWENTYFOURTH_PAIRS
from benchmarks.blind.twentyfourth_outside import TWENTYFOURTH_OUTSIDE
from benchmarks.blind.twentyninth_forms import TWENTYNINTH_PAIRS
from benchmarks.blind.twentyninth_outside import TWENTYNINTH_OUTSIDE
from benchmarks.blind.twentysecond_forms import TWENTYSECOND_PAIRS
from benchmarks.blind.twentysecond_outside import TWENTYSECOND_OUTSIDE
from benchmarks.blind.twentyseventh_forms import TWENTYSEVENTH_PAIRS
from benchmarks.blind.twentyseventh_outside import TWENTYSEVENTH_OUTSIDE
from benchmarks.blind.twentysixth_forms import TWENTYSIXTH_PAIRS
from benchmarks.blind.twentysixth_outside import TWENTYSIXTH_OUTSIDE
from benchmarks.blind.twentythird_forms import TWENTYTHIRD_PAIRS
from benchmarks.blind.twentythird_outside import TWENTYTHIRD_OUTSIDE

SETS = ('development', 'sealed')
FORM_SETS = tuple(FORMS)
CLEAN_COUNT = 300
MOTION_CLEAN_COUNT = 100
FORM_CLEAN_COUNT = 60
# Whose end face can lie on a ledge.
_SWINGING = {'development': ('beam', 'taper', 'plate'), 'sealed': ('waist', 'fin', 'beam')}
_PAIR_COUNT = 20
_OUTSIDE_COUNT = 20
# Single effects: one pose, four poses, and four poses of another shape.
_ARMS = (('one', 1, 0), ('four', 4, 0), ('shape', 4, 1))


@dataclass(frozen=True)
class Case:
    """What a case is to be drawn as.

    Attributes:
        id: name, unique in its set, with a kind and no label in it.
        kind: clean, single, pair, outside, denied or form.
        family: of its shape.
        poses: 1 or 4.
        effects: identifier and index of the size of each.
        without: effect that the workflow's library must lack.
        set_name: development or sealed.
        sensor: one of `sensor.DRAWN` in a world where everything is a little off; None: one that
            is known, in a world where nothing is.
        law: of the body, where that is not always the scene's; one of `rubber.LAWS`.
        is_held: whether a motion of a set of `swing_set` is a load that is held.
    """

    id: str
    kind: str
    family: str
    poses: int
    effects: tuple[tuple[str, int], ...]
    set_name: str
    without: str | None = None
    salt: str = ''
    sensor: str | None = None
    law: str | None = None
    is_held: bool = False

    def random(self, purpose: str) -> np.random.Generator:
        """Return a source of its own for one purpose."""
        return _seeded(f'{self.salt}/{self.set_name}/{self.key}/{purpose}')

    @property
    def is_moving(self) -> bool:
        """Tell whether the body is filmed after its release."""
        return self.id.startswith('swing_')

    @property
    def key(self) -> str:
        """What the case is, in words: the seed of its draws."""
        parts = [f'{name}-{SIZES[size]}' for name, size in self.effects]
        return '_'.join([self.kind, self.family, str(self.poses), *parts, self.id])


@dataclass(frozen=True)
class Contents:
    """What a set with bodies of several laws has beside single forms.

    Attributes:
        pairs: of forms, by their keys.
        outside: names of causes outside the library.
        clean_count: number of worlds without any.
        outside_sizes: of each of these causes.
    """

    pairs: tuple[tuple[str, str], ...]
    outside: tuple[str, ...]
    clean_count: int
    outside_sizes: tuple[int, ...] = (1, 2)


# Sets whose bodies are of several laws.
LAWS_SETS = {
    'sixth': Contents(PAIRS, tuple(FURTHER_OUTSIDE), 300),
    'seventh': Contents(SEVENTH_PAIRS, tuple(SEVENTH_OUTSIDE), 60),
    'eighth': Contents(EIGHTH_PAIRS, tuple(EIGHTH_OUTSIDE), 60),
    'ninth': Contents(NINTH_PAIRS, tuple(NINTH_OUTSIDE), 60),
    'tenth': Contents(TENTH_PAIRS, tuple(TENTH_OUTSIDE), 24),
    'eleventh': Contents(ELEVENTH_PAIRS, tuple(ELEVENTH_OUTSIDE), 60),
    'twelfth': Contents(TWELFTH_PAIRS, tuple(TWELFTH_OUTSIDE), 60),
    'thirteenth': Contents(THIRTEENTH_PAIRS, tuple(THIRTEENTH_OUTSIDE), 60),
    'fourteenth': Contents(FOURTEENTH_PAIRS, tuple(FOURTEENTH_OUTSIDE), 300),
    'fifteenth': Contents(FIFTEENTH_PAIRS, tuple(FIFTEENTH_OUTSIDE), 40),
    'sixteenth': Contents(SIXTEENTH_PAIRS, tuple(SIXTEENTH_OUTSIDE), 40),
    'seventeenth': Contents(SEVENTEENTH_PAIRS, tuple(SEVENTEENTH_OUTSIDE), 40),
    'eighteenth': Contents(EIGHTEENTH_PAIRS, tuple(EIGHTEENTH_OUTSIDE), 40),
    'nineteenth': Contents(NINETEENTH_PAIRS, tuple(NINETEENTH_OUTSIDE), 40),
    'twentieth': Contents(TWENTIETH_PAIRS, tuple(TWENTIETH_OUTSIDE), 40),
    'twentyfirst': Contents(TWENTYFIRST_PAIRS, tuple(TWENTYFIRST_OUTSIDE), 40),
    'twentysecond': Contents(TWENTYSECOND_PAIRS, tuple(TWENTYSECOND_OUTSIDE), 40),
    'twentythird': Contents(TWENTYTHIRD_PAIRS, tuple(TWENTYTHIRD_OUTSIDE), 40),
    'twentyfourth': Contents(TWENTYFOURTH_PAIRS, tuple(TWENTYFOURTH_OUTSIDE), 40),
    'twentyfifth': Contents(TWENTYFIFTH_PAIRS, tuple(TWENTYFIFTH_OUTSIDE), 40),
    'twentysixth': Contents(TWENTYSIXTH_PAIRS, tuple(TWENTYSIXTH_OUTSIDE), 40),
    'twentyseventh': Contents(TWENTYSEVENTH_PAIRS, tuple(TWENTYSEVENTH_OUTSIDE), 40),
    'twentyeighth': Contents(TWENTYEIGHTH_PAIRS, tuple(TWENTYEIGHTH_OUTSIDE), 40),
    'twentyninth': Contents(TWENTYNINTH_PAIRS, tuple(TWENTYNINTH_OUTSIDE), 40),
    'thirtieth': Contents(THIRTIETH_PAIRS, tuple(THIRTIETH_OUTSIDE), 40),
    'thirtyfirst': Contents(THIRTYFIRST_PAIRS, tuple(THIRTYFIRST_OUTSIDE), 24),
    'thirtysecond': Contents(THIRTYSECOND_PAIRS, tuple(THIRTYSECOND_OUTSIDE), 30),
    'thirtythird': Contents(THIRTYTHIRD_PAIRS, tuple(THIRTYTHIRD_OUTSIDE), 16, (2,)),
}


def list_cases(set_name: str, salt: str = '') -> list[Case]:
    """List all cases of a set: 300 clean, 99 single, 20 pairs, 20 outside, 11 denied."""
    if set_name not in SETS:
        raise ValueError(f'set is {set_name!r}: {" or ".join(SETS)}')
    families = DEVELOPMENT_FAMILIES if set_name == 'development' else SEALED_FAMILIES
    faulty = _faulty(set_name, families)
    # Names that tell nothing: an order that the set and the salt decide.
    order = _seeded(f'{salt}/{set_name}/order').permutation(len(faulty))
    named = [replace(faulty[i], id=f'case_{number:03d}') for number, i in enumerate(order)]
    return [replace(case, salt=salt) for case in (*_clean(set_name, families), *named)]


def list_motion_cases(set_name: str, salt: str = '') -> list[Case]:
    """List the cases of released bodies: 100 clean, 27 single (3 effects, sizes and set-ups)."""
    if set_name not in SETS:
        raise ValueError(f'set is {set_name!r}: {" or ".join(SETS)}')
    families = _SWINGING[set_name]
    clean = [
        Case(f'swing_clean_{number:03d}', 'clean', families[number % 3], 1, (), set_name)
        for number in range(MOTION_CLEAN_COUNT)
    ]
    faulty = [
        Case('', 'single', family, 1, ((name, size),), set_name)
        for name in MOTION
        for size in range(len(SIZES))
        for family in families
    ]
    order = _seeded(f'{salt}/{set_name}/motion order').permutation(len(faulty))
    named = [replace(faulty[i], id=f'swing_{number:03d}') for number, i in enumerate(order)]
    return [replace(case, salt=salt) for case in (*clean, *named)]


def list_motion_form_cases(set_name: str, salt: str = '') -> list[Case]:
    """List released bodies with effects in other forms: each in two sizes, on the sealed bodies.

    There is no set of them to develop on.
    """
    if set_name != 'sealed':
        raise ValueError(f'set is {set_name!r}: other forms of motions are sealed only')
    families = _SWINGING[set_name]
    faulty = [
        Case('', 'form', families[(number + size) % 3], 1, ((form.key, size),), set_name)
        for number, form in enumerate(MOTION_FORMS)
        for size in (1, 2)
    ]
    order = _seeded(f'{salt}/{set_name}/motion form order').permutation(len(faulty))
    named = [replace(faulty[i], id=f'swing_form_{number:03d}') for number, i in enumerate(order)]
    return [replace(case, salt=salt) for case in named]


def list_form_cases(set_name: str, salt: str = '') -> list[Case]:
    """List the cases of other forms: 60 clean, and each form of the set in two sizes.

    The sixth set and the fourteenth have 300 clean ones. From the sixth on, sets have pairs of
    forms and causes outside the library as well, and bodies of several laws.
    """
    if set_name not in FORM_SETS:
        raise ValueError(f'set is {set_name!r}: {" or ".join(FORM_SETS)}')
    families = DEVELOPMENT_FAMILIES if set_name == 'development' else SEALED_FAMILIES
    if set_name in LAWS_SETS:
        return _of_several_laws(set_name, families, salt)
    sensors = tuple(DRAWN)
    clean = [
        Case(
            f'world_{number:03d}',
            'clean',
            families[number % len(families)],
            4,
            (),
            set_name,
            sensor=sensors[number % len(sensors)],
        )
        for number in range(FORM_CLEAN_COUNT)
    ]
    faulty = [
        Case(
            '',
            'form',
            _fitting(form.truth, families[(number + size) % len(families)]),
            4,
            ((form.key, size),),
            set_name,
            sensor=sensors[(number + size) % len(sensors)],
        )
        for number, form in enumerate(FORMS[set_name])
        for size in (1, 2)
    ]
    order = _seeded(f'{salt}/{set_name}/form order').permutation(len(faulty))
    named = [replace(faulty[i], id=f'form_{number:03d}') for number, i in enumerate(order)]
    return [replace(case, salt=salt) for case in (*clean, *named)]


def _of_several_laws(set_name: str, families: tuple[str, ...], salt: str) -> list[Case]:
    """List a set whose four families, three sensors and five laws have no common divisor."""
    sensors, contents = tuple(DRAWN), LAWS_SETS[set_name]
    singles = [('form', ((form.key, size),), size) for form in FORMS[set_name] for size in (1, 2)]
    pairs = [('pair', ((one, 2), (two, 2)), 0) for one, two in contents.pairs]
    sizes = contents.outside_sizes
    outside = [('outside', ((name, size),), size) for name in contents.outside for size in sizes]
    faulty = [
        Case('', kind, families[0], 4, effects, set_name)
        for kind, effects, _ in (*singles, *pairs, *outside)
    ]
    # The second size of a form is far from its first in all three rotations.
    turns = [number // 2 + 7 * size for number, (_, _, size) in enumerate(singles)]
    turns += list(range(len(singles), len(singles) + len(pairs)))
    turns += [number // len(sizes) + 7 * size for number, (_, _, size) in enumerate(outside)]
    order = _seeded(f'{salt}/{set_name}/form order').permutation(len(faulty))
    named = [(f'form_{number:03d}', faulty[i], turns[i]) for number, i in enumerate(order)]
    clean = Case('', 'clean', families[0], 4, (), set_name)
    named = [
        *((f'world_{number:03d}', clean, number) for number in range(contents.clean_count)),
        *named,
    ]
    found = []
    for name, case, turn in named:
        family = families[turn % len(families)]
        for effect, _ in case.effects:
            family = _fitting(effect.partition('/')[0], family)
        found.append(
            replace(
                case,
                id=name,
                salt=salt,
                family=family,
                sensor=sensors[turn % len(sensors)],
                law=LAWS[turn % len(LAWS)],
            )
        )
    return found


def _seeded(text: str) -> np.random.Generator:
    return np.random.default_rng(list(hashlib.sha256(text.encode()).digest()))


def _fitting(effect: str, family: str) -> str:
    """Replace a wide body by a slender one where it would lie on a plane with its root."""
    slender = {'plate': 'beam', 'fin': 'waist'}
    return slender.get(family, family) if effect == 'contact_plane' else family


def _clean(set_name: str, families: tuple[str, ...]) -> list[Case]:
    return [
        Case(
            id=f'clean_{number:03d}',
            kind='clean',
            family=families[number % len(families)],
            # Two of three with four poses, however long a part of the list is run.
            poses=1 if (number // len(families)) % 3 == 0 else 4,
            effects=(),
            set_name=set_name,
        )
        for number in range(CLEAN_COUNT)
    ]


def _faulty(set_name: str, families: tuple[str, ...]) -> list[Case]:
    count = len(families)
    cases = []
    for number, name in enumerate(LIBRARY):
        for size in range(len(SIZES)):
            for _, poses, other in _ARMS:
                family = _fitting(name, families[(number + size + other) % count])
                cases.append(Case('', 'single', family, poses, ((name, size),), set_name))
    pairs = list(combinations(LIBRARY, 2))
    order = np.random.default_rng([7, SETS.index(set_name)]).permutation(len(pairs))
    for number in range(_PAIR_COUNT):
        one, two = pairs[order[number]]
        effects = ((one, 1 + number % 2), (two, 1 + number % 2))
        family = _fitting(two, _fitting(one, families[number % count]))
        cases.append(Case('', 'pair', family, 4, effects, set_name))
    outside = list(OUTSIDE)
    for number in range(_OUTSIDE_COUNT):
        name, size = outside[number % len(outside)], 1 + (number // len(outside)) % 2
        cases.append(Case('', 'outside', families[number % count], 4, ((name, size),), set_name))
    for number, name in enumerate(LIBRARY):
        family = _fitting(name, families[number % count])
        cases.append(Case('', 'denied', family, 4, ((name, 2),), set_name, without=name))
    return cases
