# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What tests ask of sets of blind motions, and of bodies that swing or creep."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind.amplitudes import Drawer, OUTSIDE_CLASS
from benchmarks.blind.cases import Case
from benchmarks.blind.drag import make_drag
from benchmarks.blind.equilibrium import PotentialLaw
from benchmarks.blind.faults import Faults
from benchmarks.blind.filming import drawing, positions_at
from benchmarks.blind.forms import BY_KEY
from benchmarks.blind.generator import draw_case, draw_timing, main
from benchmarks.blind.labels import label_of
from benchmarks.blind.laying import softer
from benchmarks.blind.motion_forms import MOTION_FORMS
from benchmarks.blind.outcomes import CLASS
from benchmarks.blind.relaxation import Pair
from benchmarks.blind.rig_motion import rig_at
from benchmarks.blind.rotations import applied
from benchmarks.blind.rubber import LAWS
from benchmarks.blind.scene_file import scene_text
from benchmarks.blind.sensor import DRAWN
from benchmarks.blind.setups import draw_setup, GRAVITY, Setup
from benchmarks.blind.simulation import make_specimen, Specimen
from benchmarks.blind.stamping import moments, stamps
from benchmarks.blind.swing import consistent_masses, Forces, swing
from benchmarks.blind.swing_set import list_swing_set_cases, SWING_SET_FAMILIES, SWING_SETS
from benchmarks.blind.swing_set_outside import SOFTER
from benchmarks.blind.timing import Timing
from support.blind_labels import check_label


def soft_beam() -> Setup:
    """Return a bar that swings far."""
    drawn = draw_setup('beam', is_sealed=False, poses=1, random=np.random.default_rng(3))
    return replace(drawn, youngs_modulus=6.0e5)


def check_contents(set_name: str, cases: list[Case], kinds: dict[str, int]) -> None:
    """Fail where a set does not have as many cases of each kind, or not each effect's two sizes.

    Its forms must be no other set's, and all that it has must have a class.
    """
    contents = SWING_SETS[set_name]
    assert Counter(case.kind for case in cases) == kinds
    assert len({case.id for case in cases}) == len(cases)
    assert all(case.is_moving and case.poses == 1 for case in cases)
    sizes = Counter(case.effects[0] for case in cases if case.effects)
    assert set(sizes) == {(name, size) for name in contents.effects for size in (1, 2)}
    assert set(sizes.values()) == {1}
    others = {*BY_KEY, *(form.key for form in MOTION_FORMS)}
    others |= {
        key for name, each in SWING_SETS.items() if name != set_name for key in each.effects
    }
    assert others.isdisjoint(contents.effects)
    assert {form.truth for form in contents.forms} <= set(CLASS)
    assert set(contents.outside) <= set(OUTSIDE_CLASS)


def check_crossed(cases: list[Case]) -> None:
    """Fail where laws, sensors and shapes are not all there about as often, and crossed."""
    clean = [case for case in cases if case.kind == 'clean']
    for key, names in (('law', LAWS), ('sensor', DRAWN), ('family', SWING_SET_FAMILIES)):
        for some in (cases, clean):
            counts = Counter(getattr(case, key) for case in some)
            assert set(counts) == set(names)
            assert max(counts.values()) < 2.2 * min(counts.values())
    assert len({(case.law, case.sensor) for case in clean}) == 15
    assert len({(case.sensor, case.is_held) for case in clean}) == 6


def check_drawn(cases: list[Case]) -> None:
    """Fail where a case cannot be drawn, or its label or scene does not tell what it is."""
    for case in cases:
        setup, effects, faults = draw_case(case)
        timing = draw_timing(case, effects)
        label = label_of(case, setup, effects, faults, np.zeros(3), timing)
        check_label(case, label)
        assert timing.is_slow == case.is_held
        assert ('damping' in label['parameters']) != timing.is_slow
        assert label['parameters'].get('damping', timing.damping) == timing.damping
        assert (faults == Faults()) == (case.kind == 'clean')
        assert label['sensor'] == case.sensor
        view = setup.observations[0]
        assert 0.0 < np.abs(view.stated - view.world_from_object)[:3, 3].max() < 0.002
        text = scene_text(setup, timing)
        assert 'ledge' in text
        assert ('quasi_static' in text) == timing.is_slow
        assert len(stamps(timing, faults)) == len(moments(timing, faults))


def check_salted(set_name: str, name: str) -> None:
    """Fail where a salt does not decide a set's order, and how large a cause of it is."""
    cases, again, other = (list_swing_set_cases(set_name, salt) for salt in ('a', 'a', 'b'))
    assert again == cases
    assert [case.effects for case in cases] != [case.effects for case in other]
    one, two = (
        next(case for case in listed if case.effects == ((name, 2),)) for listed in (cases, other)
    )
    assert getattr(draw_case(one)[2], name) != getattr(draw_case(two)[2], name)


def check_wants_motions(set_name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Fail where the program makes anything of a set of motions but motions with forms."""
    for options in (['--forms'], ['--motion']):
        with pytest.raises(SystemExit):
            main(['--set', set_name, '--out', 'nowhere', *options])
        assert set_name in capsys.readouterr().err


def moves_by_size(
    drawn: Setup, drawer: Drawer, timing: Timing, refinement: float = 1.0
) -> list[float]:
    """Return how far two sizes of an effect move nodes in the room, at most [mm].

    Args:
        drawn: a set-up as it is drawn, before it is made softer so that it swings.
        drawer: of the effect.
        timing: of the motion.
        refinement: of the body's cells.
    """
    soft, moves = softer(drawn, SOFTER), []
    plain = _places_in_room(soft, Faults(), timing, refinement)
    for size in (1, 2):
        faults = Faults(**drawer(size, drawn, np.random.default_rng(8)).changes)
        away = np.abs(_places_in_room(soft, faults, timing, refinement) - plain).max(axis=(1, 2))
        moves.append(1e3 * float(away.max()))
    return moves


def _places_in_room(setup: Setup, faults: Faults, timing: Timing, refinement: float) -> np.ndarray:
    """Return where nodes are in every frame, world [m], shape (T, N, 3)."""
    specimen, times = make_specimen(setup, faults, refinement), moments(timing, faults)
    view = setup.observations[0]
    places = positions_at(specimen, setup, view, faults, timing, times)
    return np.array(
        [
            applied(rig_at(view, faults, time).world_from_object, place)
            for time, place in zip(times, places, strict=True)
        ]
    )


def compliance(pairs: Sequence[Pair], times: np.ndarray, count: int = 1500) -> np.ndarray:
    """Return how much softer stresses that relax are at times [s]: a Volterra equation.

    The convolution of the relaxation with the rate of the compliance is 1.
    """
    grid = np.linspace(0.0, times[-1], count + 1)
    step = grid[1]
    middles = step * (np.arange(count) + 0.5)
    stress = 1.0 - sum(g * (1.0 - np.exp(-middles / tau)) for g, tau in pairs)
    found = np.ones(count + 1)
    rises = np.zeros(count)
    first = 1.0 - sum(g * (1.0 - np.exp(-grid[1:] / tau)) for g, tau in pairs)
    for number in range(count):
        known = first[number] + stress[number:0:-1] @ rises[:number]
        rises[number] = (1.0 - known) / stress[0]
        found[number + 1] = found[number] + rises[number]
    return np.interp(times, grid, found)


def energies_of_a_swing(
    specimen: Specimen,
    setup: Setup,
    weight: np.ndarray,
    laws: tuple[PotentialLaw, ...],
    end: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Return what a body has in all as it swings without any loss, and what laws have of it [J].

    Args:
        specimen: the body.
        setup: of it.
        weight: on its nodes [N], shape (N, 3).
        laws: what else draws it.
        end: until when [s].
    """
    masses = consistent_masses(specimen.mesh.nodes, specimen.body, setup.density)
    forces = Forces(weight, 0.0, make_drag(specimen.mesh, 0.0), setup.youngs_modulus, None, laws)
    step, start = end / 40.0, specimen.mesh.nodes
    path = swing(specimen.body, masses, forces, start, step * np.arange(1, 41), step)
    whole, drawn = [], []
    for one, two in zip((start, *path[:-1]), path, strict=True):
        local, middle = ((two - one) / step)[specimen.body.cells], 0.5 * (one + two)
        moving = 0.5 * float(np.einsum('cai,cab,cbi', local, masses, local))
        still = specimen.body.evaluate(middle, with_stiffness=False).energy
        drawn.append(sum(law(middle).energy for law in laws))
        whole.append(moving + still + drawn[-1] - float((weight * middle).sum()))
    return np.array(whole), np.array(drawn)


def check_a_swing_keeps_its_energy(specimen: Specimen, setup: Setup, faults: Faults) -> None:
    """Check all forces of a motion at once: what a clamp's springs have is not there else."""
    weight = specimen.body.masses[:, None] * np.array([0.0, 0.0, -GRAVITY])
    laws = drawing(specimen, weight, faults)
    whole, drawn = energies_of_a_swing(specimen, setup, weight, laws, 0.03)
    assert len(laws) == 1
    assert drawn.max() > 1e-6
    assert np.ptp(whole) < 0.03 * np.ptp(drawn)


def check_draws_by_its_energy(law: PotentialLaw, places: np.ndarray, step: float) -> None:
    """Fail where forces, or stiffnesses of single nodes, are not the differences of an energy.

    Args:
        law: what draws nodes.
        places: of them [m], shape (N, 3).
        step: of the differences [m].
    """
    move = np.random.default_rng(2).standard_normal(places.shape)
    here, one, other = (law(places + way * step * move) for way in (0.0, 1.0, -1.0))
    slope = float((here.gradient * move).sum())
    assert abs(slope) > 1e-6
    assert abs((one.energy - other.energy) / (2.0 * step) - slope) < 1e-4 * abs(slope)
    change = np.einsum('nij,nj->ni', here.diagonal, move)
    found = (one.gradient - other.gradient) / (2.0 * step)
    assert np.abs(found - change).max() < 1e-4 * np.abs(change).max()
