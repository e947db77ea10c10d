# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Sets of motions: bodies of five laws before three sensors, released or loaded."""

from dataclasses import dataclass, replace

import numpy as np

from benchmarks.blind.amplitudes import Drawer
from benchmarks.blind.cases import Case
from benchmarks.blind.form import Form
from benchmarks.blind.rubber import LAWS
from benchmarks.blind.sensor import DRAWN
from benchmarks.blind.swing_set_forms import SWING_SET_FORMS
from benchmarks.blind.swing_set_outside import SWING_SET_OUTSIDE
from benchmarks.blind.swings_five_forms import SWINGS_FIVE_FORMS
from benchmarks.blind.swings_five_outside import SWINGS_FIVE_OUTSIDE
from benchmarks.blind.swings_four_forms import SWINGS_FOUR_FORMS
from benchmarks.blind.swings_four_outside import SWINGS_FOUR_OUTSIDE
from benchmarks.blind.swings_three_forms import SWINGS_THREE_FORMS
from benchmarks.blind.swings_three_outside import SWINGS_THREE_OUTSIDE
from benchmarks.blind.swings_two_forms import SWINGS_TWO_FORMS
from benchmarks.blind.swings_two_outside import SWINGS_TWO_OUTSIDE
from benchmarks.blind.timing import draw_hold, draw_swing, jittery, Timing

# Whose end face can lie on a ledge: those that are stated as they are drawn, and sealed ones.
SWING_SET_FAMILIES = ('beam', 'taper', 'plate', 'waist', 'fin')


@dataclass(frozen=True)
class SwingSet:
    """What a set of motions has.

    Attributes:
        clean_count: number of worlds without any effect.
        forms: each in two sizes.
        outside: causes outside the library, likewise.
        held: effects that show in loads which are held; all others are of bodies that swing.
    """

    clean_count: int
    forms: tuple[Form, ...]
    outside: dict[str, Drawer]
    held: tuple[str, ...]

    @property
    def effects(self) -> dict[str, Drawer]:
        """How all that is in the set is drawn, by the names that its cases have for it."""
        return {**{form.key: form.effect for form in self.forms}, **self.outside}


SWING_SETS = {
    'swings': SwingSet(24, SWING_SET_FORMS, SWING_SET_OUTSIDE, ('creep',)),
    'swings_two': SwingSet(16, SWINGS_TWO_FORMS, SWINGS_TWO_OUTSIDE, ('creep', 'depth_affine')),
    'swings_three': SwingSet(
        16,
        SWINGS_THREE_FORMS,
        SWINGS_THREE_OUTSIDE,
        ('creep', 'added_mass', 'camera_offset'),
    ),
    'swings_four': SwingSet(
        16, SWINGS_FOUR_FORMS, SWINGS_FOUR_OUTSIDE, ('creep', 'rest_curvature')
    ),
    'swings_five': SwingSet(16, SWINGS_FIVE_FORMS, SWINGS_FIVE_OUTSIDE, ('creep',)),
}
SWING_SET_EFFECTS: dict[str, Drawer] = {
    name: drawer for each in SWING_SETS.values() for name, drawer in each.effects.items()
}


def list_swing_set_cases(set_name: str, salt: str = '') -> list[Case]:
    """List a set's clean motions, and its forms and causes outside the library in two sizes each.

    All are in one order that tells nothing. Every third clean one is a held load.
    """
    contents = SWING_SETS[set_name]
    clean = [
        Case('', 'clean', '', 1, (), set_name, is_held=number % 3 == number // 3 % 3)
        for number in range(contents.clean_count)
    ]
    forms = [
        Case('', 'form', '', 1, ((form.key, size),), set_name, is_held=form.truth in contents.held)
        for form in contents.forms
        for size in (1, 2)
    ]
    outside = [
        Case('', 'outside', '', 1, ((name, size),), set_name)
        for name in contents.outside
        for size in (1, 2)
    ]
    # The second size of an effect is far from its first in all three rotations.
    turns = list(range(len(clean)))
    turns += [number // 2 + 7 * (1 + number % 2) for number in range(len(forms))]
    turns += [number // 2 + 3 + 7 * (1 + number % 2) for number in range(len(outside))]
    cases = [
        _in_turn(replace(case, salt=salt), turn)
        for case, turn in zip((*clean, *forms, *outside), turns, strict=True)
    ]
    order = cases[0].random('order').permutation(len(cases))
    return [replace(cases[i], id=f'swing_world_{number:03d}') for number, i in enumerate(order)]


def _in_turn(case: Case, turn: int) -> Case:
    """Return a case with the law, the sensor and the shape whose turn it is."""
    sensors, families = tuple(DRAWN), SWING_SET_FAMILIES
    # There are as many shapes as laws: each round of five begins elsewhere.
    family = families[(2 * turn + turn // len(LAWS)) % len(families)]
    sensor, law = sensors[turn % len(sensors)], LAWS[turn % len(LAWS)]
    return replace(case, family=family, sensor=sensor, law=law)


def draw_swing_set_timing(case: Case, random: np.random.Generator) -> Timing:
    """Draw when a case's body is let go, and how far stamps are off that are as good as any."""
    return jittery(draw_hold(random) if case.is_held else draw_swing(random), random)
