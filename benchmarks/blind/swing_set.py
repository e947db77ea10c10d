# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The set of motions `swings`: bodies of five laws before three sensors, released or loaded."""

from dataclasses import replace

import numpy as np

from benchmarks.blind.amplitudes import Drawer
from benchmarks.blind.cases import Case
from benchmarks.blind.rubber import LAWS
from benchmarks.blind.sensor import DRAWN
from benchmarks.blind.swing_set_forms import SWING_SET_FORMS
from benchmarks.blind.swing_set_outside import SWING_SET_OUTSIDE
from benchmarks.blind.timing import draw_hold, draw_swing, jittery, Timing

SWINGS = 'swings'
SWING_SET_CLEAN_COUNT = 24
# Whose end face can lie on a ledge: those that are stated as they are drawn, and sealed ones.
SWING_SET_FAMILIES = ('beam', 'taper', 'plate', 'waist', 'fin')
SWING_SET_EFFECTS: dict[str, Drawer] = {
    **{form.key: form.effect for form in SWING_SET_FORMS},
    **SWING_SET_OUTSIDE,
}


def list_swing_set_cases(salt: str = '') -> list[Case]:
    """List 24 clean motions, ten forms and two causes outside the library in two sizes each.

    All are in one order that tells nothing. Every third clean one is a held load, as is what
    creeps; all others swing.
    """
    clean = [
        _case('clean', (), number, salt, is_held=number % 3 == number // 3 % 3)
        for number in range(SWING_SET_CLEAN_COUNT)
    ]
    # The second size of an effect is far from its first in all three rotations.
    forms = [
        _case('form', ((form.key, size),), number + 7 * size, salt, is_held=form.truth == 'creep')
        for number, form in enumerate(SWING_SET_FORMS)
        for size in (1, 2)
    ]
    outside = [
        _case('outside', ((name, size),), number + 3 + 7 * size, salt)
        for number, name in enumerate(SWING_SET_OUTSIDE)
        for size in (1, 2)
    ]
    cases = [*clean, *forms, *outside]
    order = _case('clean', (), 0, salt).random('order').permutation(len(cases))
    return [replace(cases[i], id=f'swing_world_{number:03d}') for number, i in enumerate(order)]


def _case(
    kind: str,
    effects: tuple[tuple[str, int], ...],
    turn: int,
    salt: str,
    *,
    is_held: bool = False,
) -> Case:
    sensors, families = tuple(DRAWN), SWING_SET_FAMILIES
    # There are as many shapes as laws: each round of five begins elsewhere.
    family = families[(2 * turn + turn // len(LAWS)) % len(families)]
    return Case(
        '',
        kind,
        family,
        1,
        effects,
        SWINGS,
        salt=salt,
        sensor=sensors[turn % len(sensors)],
        law=LAWS[turn % len(LAWS)],
        is_held=is_held,
    )


def draw_swing_set_timing(case: Case, random: np.random.Generator) -> Timing:
    """Draw when a case's body is let go, and how far stamps are off that are as good as any."""
    return jittery(draw_hold(random) if case.is_held else draw_swing(random), random)
