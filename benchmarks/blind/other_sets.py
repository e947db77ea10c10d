# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Sets of bodies and rigs that no set of before had, with effects that some had."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import Effect
from benchmarks.blind.cases import Case
from benchmarks.blind.equilibrium import NoEquilibriumError
from benchmarks.blind.faults import Faults
from benchmarks.blind.observe import true_rendering
from benchmarks.blind.other_ranges import Ranges, RANGES_34
from benchmarks.blind.other_rigs import (
    draw_other_setup,
    OtherSetup,
    rests_of,
    sees_all,
    UnfitError,
)
from benchmarks.blind.other_sizes import laid, sized, smaller, wanted_change
from benchmarks.blind.paint import FIXTURE
from benchmarks.blind.rubber import LAWS
from benchmarks.blind.salted_effects import draw_effects, FORMS_37, OUTSIDE_37, RANGES_37
from benchmarks.blind.sensor import DRAWN
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.thirtyfifth_forms import (
    FORMS_35,
    LEAST_CHANGES_35,
    OUTSIDE_35,
    PAIRS_35,
    RANGES_35,
    wanted_change_35,
)
from benchmarks.blind.thirtyfourth_forms import FORMS_34, OtherForm, OUTSIDE_34, PAIRS_34
from benchmarks.blind.thirtysixth_forms import (
    FORMS_36,
    OUTSIDE_36,
    PAIRED_36,
    PAIRS_36,
    RANGES_36,
)

_ATTEMPTS = 200
_DrawnEffects = Callable[
    [np.random.Generator], tuple[tuple[OtherForm, ...], tuple[tuple[str, str], ...]]
]
_LEAST_PIXELS = 40  # Of a body in each pose, in a sixteenth of all pixels.


@dataclass(frozen=True)
class OtherContents:
    """What a set has.

    Attributes:
        forms: of effects of the library, each once.
        outside: causes that are not in it.
        pairs: of forms, by their keys.
        clean_count: number of worlds without any.
        poses: least and largest number.
        ranges: of rigs.
        wanted: by how much an effect of a size is to change what is seen [m].
        least_changes: least of that, of a single effect and of each of a pair [m].
        paired: forms that pairs alone have.
        is_shuffled: whether the salt tells as well which bodies, sensors and laws go together.
        drawn: draws forms and pairs, where the salt tells these, too.
        by_key: its forms and causes outside by their keys.
    """

    forms: tuple[OtherForm, ...]
    outside: tuple[OtherForm, ...]
    pairs: tuple[tuple[str, str], ...]
    clean_count: int
    poses: tuple[int, int]
    ranges: Ranges
    wanted: Callable[[OtherSetup, int, np.random.Generator], float]
    least_changes: tuple[float, float]
    paired: tuple[OtherForm, ...] = ()
    is_shuffled: bool = False
    drawn: _DrawnEffects | None = None
    by_key: dict[str, OtherForm] = field(init=False)

    def __post_init__(self) -> None:
        by_key = {form.key: form for form in (*self.forms, *self.paired, *self.outside)}
        object.__setattr__(self, 'by_key', by_key)


OTHER_SETS = {
    'thirtyfourth': OtherContents(
        FORMS_34,
        OUTSIDE_34,
        PAIRS_34,
        18,
        (2, 6),
        RANGES_34,
        lambda setup, size, random: wanted_change(setup, size),
        (0.0014, 0.0014),
    ),
    'thirtyfifth': OtherContents(
        FORMS_35,
        OUTSIDE_35,
        PAIRS_35,
        14,
        (2, 5),
        RANGES_35,
        wanted_change_35,
        LEAST_CHANGES_35,
    ),
    'thirtysixth': OtherContents(
        FORMS_36,
        OUTSIDE_36,
        PAIRS_36,
        12,
        (2, 5),
        RANGES_36,
        wanted_change_35,
        LEAST_CHANGES_35,
        PAIRED_36,
        is_shuffled=True,
    ),
    'thirtyseventh': OtherContents(
        (),
        OUTSIDE_37,
        (),
        12,
        (2, 5),
        RANGES_37,
        wanted_change_35,
        LEAST_CHANGES_35,
        FORMS_37,
        is_shuffled=True,
        drawn=draw_effects,
    ),
}


@cache
def contents_of(set_name: str, salt: str = '') -> OtherContents:
    """Return what a set has, with the effects that a salt draws where it does."""
    contents = OTHER_SETS[set_name]
    if contents.drawn is None:
        return contents
    forms, pairs = contents.drawn(
        Case('', 'pair', '', 0, (), set_name, salt=salt).random('effects')
    )
    return replace(contents, forms=forms, pairs=pairs)


def list_other_cases(set_name: str, salt: str = '') -> list[Case]:
    """List a set: clean worlds, forms of each effect, pairs, and causes outside the library.

    Of two forms of an effect one is of the second size, the other of the third, as pairs and
    causes outside the library are.
    """
    contents = contents_of(set_name, salt)
    # Of each two forms of an effect, in turn the first one and the second one are larger.
    sizes = [1 + (number + number // 2) % 2 for number in range(len(contents.forms))]
    kinds: list[tuple[str, tuple[tuple[str, int], ...]]] = [
        ('form', ((form.key, size),)) for form, size in zip(contents.forms, sizes, strict=True)
    ]
    kinds += [('pair', ((one, 2), (two, 2))) for one, two in contents.pairs]
    kinds += [('outside', ((form.key, 2),)) for form in contents.outside]
    kinds = [*[('clean', ())] * contents.clean_count, *kinds]
    every = _in_turns([Case('', kind, '', 0, each, set_name, salt=salt) for kind, each in kinds])
    clean, faulty = every[: contents.clean_count], every[contents.clean_count :]
    found = []
    for prefix, cases in (('world', clean), ('form', faulty)):
        order = cases[0].random(f'order of {prefix}').permutation(len(cases))
        found += [replace(cases[i], id=f'{prefix}_{number:03d}') for number, i in enumerate(order)]
    return found


def _contents(case: Case) -> OtherContents:
    return contents_of(case.set_name, case.salt)


def _in_turns(cases: list[Case]) -> list[Case]:
    """Return cases with bodies of all families as often, and two of each effect's forms."""
    contents, found = _contents(cases[0]), list[Case]()
    families, turns = list(contents.ranges.families), np.arange(len(cases))
    if contents.is_shuffled:
        random = cases[0].random('order of families')
        families = [families[i] for i in random.permutation(len(families))]
        turns = random.permutation(turns)
    counts = dict.fromkeys(families, 0)
    taken: dict[str, set[str]] = {}
    # In the last rounds those come first that few bodies are fit for.
    order = sorted(range(len(cases)), key=lambda i: (bool(cases[i].effects), _fit(cases[i])))
    drawn: dict[int, str] = {}
    for i in order:
        forms = _forms(cases[i])
        truths = [form.truth for form in forms if cases[i].kind == 'form']
        allowed = [
            family
            for family in counts
            if all(family in form.families for form in forms if form.families)
            and not any(family in taken.get(truth, ()) for truth in truths)
        ]
        family = min(allowed, key=lambda name: counts[name])
        counts[family] += 1
        for truth in truths:
            taken.setdefault(truth, set()).add(family)
        drawn[i] = family
    for i, case in enumerate(cases):
        found.append(_in_turn(replace(case, family=drawn[i]), int(turns[i])))
    return found


def _fit(case: Case) -> int:
    """Return how many families a case's forms leave."""
    limits = [form.families for form in _forms(case) if form.families]
    every = len(_contents(case).ranges.families)
    return min((len(families) for families in limits), default=every)


def _forms(case: Case) -> list[OtherForm]:
    """Return the forms of a case's effects."""
    by_key = _contents(case).by_key
    return [by_key[key] for key, _ in case.effects]


def _in_turn(case: Case, turn: int) -> Case:
    """Return a case with the sensor, the law and the number of poses whose turn it is."""
    forms = _forms(case)
    sensors = tuple(DRAWN)
    fewest, most = _contents(case).poses
    least = max((form.poses for form in forms), default=fewest)
    return replace(
        case,
        sensor=sensors[(turn + turn // 3) % len(sensors)],
        law=LAWS[(turn + turn // 5) % len(LAWS)],
        poses=max(fewest + (2 * turn + turn // 5) % (most - fewest + 1), least),
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
    forms = _forms(case)
    contents = _contents(case)
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
        ranges=contents.ranges,
    )
    effects, changes, every = [], [], dict[str, Any]()
    for form, (_, size) in zip(forms, case.effects, strict=True):
        wanted = contents.wanted(setup, size, random)
        if form.truth == 'contact_plane':
            drawn = form.draw(setup, random)
            # Beside what else there is; of the sets before, a contact comes first.
            setup, every, change = laid(setup, {**every, **drawn}, wanted, random)
            drawn = {name: every[name] for name in drawn}
        else:
            drawn, change = sized(form, wanted, setup, random)
        effects.append(_told(form, drawn))
        changes.append(change)
        every.update(drawn)
    setup, faults = replace(setup, changes=tuple(changes)), Faults(**every)
    least = contents.least_changes[case.kind == 'pair']
    if min(changes, default=least) < least:
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
    if any(setup.body.touches_itself(specimen.mesh.lattice, rest) for rest in rests):
        raise UnfitError('the body touches itself')
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
