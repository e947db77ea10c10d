# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The thirty-fourth set: bodies and rigs that no set of before had, with effects that some had."""

from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import Effect
from benchmarks.blind.cases import Case
from benchmarks.blind.equilibrium import NoEquilibriumError
from benchmarks.blind.faults import Faults
from benchmarks.blind.observe import true_rendering
from benchmarks.blind.other_bodies import OTHER_FAMILIES
from benchmarks.blind.other_rigs import (
    draw_other_setup,
    OtherSetup,
    rests_of,
    sees_all,
    UnfitError,
)
from benchmarks.blind.other_sizes import laid, sized, smaller
from benchmarks.blind.paint import FIXTURE
from benchmarks.blind.rubber import LAWS
from benchmarks.blind.sensor import DRAWN
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.thirtyfourth_forms import (
    BY_KEY_34,
    FORMS_34,
    OtherForm,
    OUTSIDE_34,
    PAIRS_34,
)

OTHER_SETS = ('thirtyfourth',)
_CLEAN_COUNT = 18
_ATTEMPTS = 200
_LEAST_CHANGE = 0.0014  # Of what is seen by an effect [m].
_LEAST_PIXELS = 40  # Of a body in each pose, in a sixteenth of all pixels.


def list_other_cases(set_name: str, salt: str = '') -> list[Case]:
    """List a set: clean worlds, two forms of each effect, pairs, and causes outside the library.

    One form of an effect is of the second size, the other of the third, as pairs and causes
    outside the library are.
    """
    # Of each two forms of an effect, in turn the first one and the second one are larger.
    sizes = [1 + (number + number // 2) % 2 for number in range(len(FORMS_34))]
    kinds: list[tuple[str, tuple[tuple[str, int], ...]]] = [
        ('form', ((form.key, size),)) for form, size in zip(FORMS_34, sizes, strict=True)
    ]
    kinds += [('pair', ((one, 2), (two, 2))) for one, two in PAIRS_34]
    kinds += [('outside', ((form.key, 2),)) for form in OUTSIDE_34]
    kinds = [*[('clean', ())] * _CLEAN_COUNT, *kinds]
    every = _in_turns([Case('', kind, '', 0, each, set_name, salt=salt) for kind, each in kinds])
    clean, faulty = every[:_CLEAN_COUNT], every[_CLEAN_COUNT:]
    found = []
    for prefix, cases in (('world', clean), ('form', faulty)):
        order = cases[0].random(f'order of {prefix}').permutation(len(cases))
        found += [replace(cases[i], id=f'{prefix}_{number:03d}') for number, i in enumerate(order)]
    return found


def _in_turns(cases: list[Case]) -> list[Case]:
    """Return cases with bodies of all families as often, and two of each effect's forms."""
    counts, found = dict.fromkeys(OTHER_FAMILIES, 0), list[Case]()
    taken: dict[str, set[str]] = {}
    # In the last rounds those come first that few bodies are fit for.
    order = sorted(range(len(cases)), key=lambda i: (bool(cases[i].effects), _fit(cases[i])))
    drawn: dict[int, str] = {}
    for i in order:
        forms = [BY_KEY_34[key] for key, _ in cases[i].effects]
        truths = [form.truth for form in forms if cases[i].kind == 'form']
        allowed = [
            family
            for family in OTHER_FAMILIES
            if all(family in form.families for form in forms if form.families)
            and not any(family in taken.get(truth, ()) for truth in truths)
        ]
        family = min(allowed, key=lambda name: counts[name])
        counts[family] += 1
        for truth in truths:
            taken.setdefault(truth, set()).add(family)
        drawn[i] = family
    for i, case in enumerate(cases):
        found.append(_in_turn(replace(case, family=drawn[i]), i))
    return found


def _fit(case: Case) -> int:
    """Return how many families a case's forms leave."""
    limits = [BY_KEY_34[key].families for key, _ in case.effects if BY_KEY_34[key].families]
    return min((len(families) for families in limits), default=len(OTHER_FAMILIES))


def _in_turn(case: Case, turn: int) -> Case:
    """Return a case with the sensor, the law and the number of poses whose turn it is."""
    forms = [BY_KEY_34[key] for key, _ in case.effects]
    sensors = tuple(DRAWN)
    least = max((form.poses for form in forms), default=2)
    return replace(
        case,
        sensor=sensors[(turn + turn // 3) % len(sensors)],
        law=LAWS[(turn + turn // 5) % len(LAWS)],
        poses=max(2 + (2 * turn + turn // 5) % 5, least),
    )


def draw_other_case(case: Case) -> tuple[OtherSetup, tuple[Effect, ...], Faults]:
    """Draw a case's rig, effects and faults: the first of some draws that can be filmed."""
    for attempt in range(_ATTEMPTS):
        try:
            return _drawn(case, case.random(f'attempt {attempt}'))
        except UnfitError:
            continue
    raise UnfitError(f'no draw of {_ATTEMPTS} fits')


def _drawn(
    case: Case, random: np.random.Generator
) -> tuple[OtherSetup, tuple[Effect, ...], Faults]:
    forms = [BY_KEY_34[key] for key, _ in case.effects]
    assert case.sensor is not None
    assert case.law is not None
    setup = draw_other_setup(
        case.family,
        poses=case.poses,
        sensor=case.sensor,
        law=case.law,
        random=random,
        is_lower=any(form.truth == 'contact_plane' for form in forms),
        sags_more=any(form.sags for form in forms),
    )
    effects, changes, every = [], [], dict[str, Any]()
    for form, (_, size) in zip(forms, case.effects, strict=True):
        if form.truth == 'contact_plane':
            setup, drawn, change = laid(setup, form.draw(setup, random), size, random)
        else:
            drawn, change = sized(form, size, setup, random)
        effects.append(_told(form, drawn))
        changes.append(change)
        every.update(drawn)
    setup, faults = replace(setup, changes=tuple(changes)), Faults(**every)
    if min(changes, default=_LEAST_CHANGE) < _LEAST_CHANGE:
        raise UnfitError('the effect can hardly be seen')
    _check_views(setup, faults)
    return setup, tuple(effects), faults


def _check_views(setup: OtherSetup, faults: Faults) -> None:
    """Check that a body rests in all poses, and is seen there."""
    specimen = make_specimen(setup, faults)
    try:
        rests = rests_of(specimen, setup, faults)
    except (NoEquilibriumError, RuntimeError) as error:
        raise UnfitError(str(error)) from error
    if not sees_all(setup, rests):
        raise UnfitError('the body leaves the image')
    small = replace(setup, camera=smaller(setup.camera))
    for rest, view in zip(rests, setup.observations, strict=True):
        rendering = true_rendering(specimen, small, view, faults, rest)
        is_body = np.isfinite(rendering.depth[..., 4]) & (rendering.labels[..., 4] != FIXTURE)
        if is_body.sum() < _LEAST_PIXELS:
            raise UnfitError('hardly any of the body is seen')


def _told(form: OtherForm, changes: dict[str, Any]) -> Effect:
    if form.name == 'outside':
        return Effect(form.truth, dict(changes), 'as the faults', changes)
    told = {name: str(value) for name, value in changes.items()}
    return Effect(form.truth, {'form': form.name, **told}, 'as the faults', changes)


def rig_label(setup: OtherSetup) -> dict[str, Any]:
    """Return what a label tells of a rig that is not as others are, lengths in mm."""
    return {
        'size_mm': round(1e3 * setup.body.size, 3),
        'free_length_mm': round(1e3 * setup.body.free, 3),
        'sag_mm': round(1e3 * setup.sag, 3),
        'distance_mm': round(1e3 * float(setup.depth_from_world[2, 3]), 2),
        'smooth_error_mm': round(1e3 * setup.sensor.bias, 4),
        'largest_changes_mm': [round(1e3 * change, 3) for change in setup.changes],
    }
