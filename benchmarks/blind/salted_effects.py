# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the thirty-seventh set is drawn from: the salt tells which effects make a pair.

Bodies and forms are all those of the three sets before. Nobody chose which effects there are,
alone or beside which other one, and another salt is another set.
"""

from dataclasses import replace
from itertools import chain

import numpy as np

from benchmarks.blind.further_bodies import FURTHER_FAMILIES
from benchmarks.blind.later_bodies import LATER_FAMILIES, NEW_FAMILIES
from benchmarks.blind.other_bodies import OTHER_FAMILIES
from benchmarks.blind.other_ranges import Ranges
from benchmarks.blind.thirtyfifth_forms import FORMS_35, OUTSIDE_35
from benchmarks.blind.thirtyfourth_forms import FORMS_34, OtherForm
from benchmarks.blind.thirtysixth_forms import FORMS_36, OUTSIDE_36, PAIRED_36

SINGLES, PAIRS = 8, 18
_EVERY_BODY = {**OTHER_FAMILIES, **FURTHER_FAMILIES, **NEW_FAMILIES}
_BODIES_OF_SETS = (
    (FORMS_34, OTHER_FAMILIES),
    (FORMS_35, FURTHER_FAMILIES),
    ((*FORMS_36, *PAIRED_36), LATER_FAMILIES),
)
RANGES_37 = Ranges(
    families=_EVERY_BODY,
    images={
        (424, 240): (0.8, 0.95),
        (576, 576): (0.7, 0.9),
        (640, 360): (0.6, 0.8),
        (800, 600): (0.65, 0.9),
    },
    filled=(0.4, 0.9),
    distances=(0.15, 1.0),
    smooth=(0.00012, 0.0008),
    misstated=(1.0, 1.0, 1.0, 1.0, 1.6, 1.0 / 1.6),
    moduli=(20.0e3, 8.0e6),
    frames=(3, 8),
)


def _pool() -> tuple[OtherForm, ...]:
    """Return all forms, each on the bodies on which it makes sense in any set that has it."""
    found: dict[str, OtherForm] = {}
    for forms, bodies in _BODIES_OF_SETS:
        for form in forms:
            known = found.get(form.key)
            fit = (*(known.families if known else ()), *(form.families or bodies))
            found[form.key] = replace(form, families=tuple(dict.fromkeys(fit)))
    return tuple(found.values())


FORMS_37 = _pool()
OUTSIDE_37 = (
    next(
        replace(form, families=tuple(FURTHER_FAMILIES))
        for form in OUTSIDE_35
        if form.truth == 'jet'
    ),
    next(form for form in OUTSIDE_36 if form.truth == 'shrinking'),
)


def draw_effects(
    random: np.random.Generator,
) -> tuple[tuple[OtherForm, ...], tuple[tuple[str, str], ...]]:
    """Draw the single effects of a set, all different ones, and the forms that its pairs have."""
    by_truth: dict[str, list[OtherForm]] = {}
    for form in FORMS_37:
        by_truth.setdefault(form.truth, []).append(form)
    truths = random.permutation(list(by_truth))[:SINGLES]
    singles = tuple(_one_of(by_truth[truth], random) for truth in truths)
    pairs = list[tuple[str, str]]()
    for one, two in _pairs_of(list(by_truth), random):
        while True:
            forms = sorted(
                (_one_of(by_truth[truth], random) for truth in (one, two)),
                key=lambda form: form.truth == 'contact_plane',  # It comes last.
            )
            if set(forms[0].families) & set(forms[1].families):
                break
        pairs.append((forms[0].key, forms[1].key))
    return singles, tuple(pairs)


def _one_of(forms: list[OtherForm], random: np.random.Generator) -> OtherForm:
    return forms[int(random.integers(len(forms)))]


def _pairs_of(truths: list[str], random: np.random.Generator) -> list[tuple[str, str]]:
    """Draw pairs of two different effects, none twice, each effect in about as many."""
    deals = -(-2 * PAIRS // len(truths))
    while True:
        dealt = list(chain.from_iterable(random.permutation(truths) for _ in range(deals)))
        pairs = list(zip(dealt[0 : 2 * PAIRS : 2], dealt[1 : 2 * PAIRS : 2], strict=True))
        if len({frozenset(pair) for pair in pairs if pair[0] != pair[1]}) == PAIRS:
            return [(str(one), str(two)) for one, two in pairs]
