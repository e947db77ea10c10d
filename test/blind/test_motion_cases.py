# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Released bodies of the independent generator: its integrator, its creep, its list of cases."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind.cases import list_motion_cases, list_motion_form_cases
from benchmarks.blind.creep import held_load
from benchmarks.blind.drag import AIR, make_drag
from benchmarks.blind.equilibrium import find_equilibrium, Load
from benchmarks.blind.faults import Faults
from benchmarks.blind.generator import draw_case, draw_timing
from benchmarks.blind.setups import draw_setup, GRAVITY, Setup
from benchmarks.blind.simulation import make_specimen, Specimen
from benchmarks.blind.stamping import moments
from benchmarks.blind.swing import consistent_masses, Forces, swing
from benchmarks.blind.timing import draw_swing

DOWN = np.array([0.1, 0.0, -GRAVITY])


def _setup() -> Setup:
    return draw_setup('beam', is_sealed=False, poses=1, random=np.random.default_rng(3))


@pytest.fixture(scope='module')
def specimen() -> Specimen:
    return make_specimen(replace(_setup(), youngs_modulus=6.0e5), Faults(), refinement=0.5)


def _forces(specimen: Specimen, damping: float, area: float) -> Forces:
    drag = make_drag(specimen.mesh, area)
    return Forces(specimen.body.masses[:, None] * DOWN, damping, drag, 6.0e5)


def _energy(specimen: Specimen, masses, start, end, step: float) -> tuple[float, float]:
    """Return total energy [J] at the start and half way through the last step."""
    body, weight = specimen.body, specimen.body.masses[:, None] * DOWN
    middle, rate = 0.5 * (start + end), (end - start) / step
    moving = 0.5 * float(np.einsum('cai,cab,cbi', rate[body.cells], masses, rate[body.cells]))
    still = body.evaluate(middle, with_stiffness=False).energy - float((weight * middle).sum())
    return moving, still


def test_masses_are_those_of_the_body(specimen: Specimen) -> None:
    density = 1000.0
    masses = consistent_masses(specimen.mesh.nodes, specimen.body, density)
    assert masses.sum() == pytest.approx(density * specimen.body.quadrature.volumes.sum())
    assert np.linalg.eigvalsh(masses).min() > 0.0


@pytest.mark.slow
def test_a_swing_keeps_its_energy_without_damping_and_loses_it_with(specimen: Specimen) -> None:
    density = float(specimen.body.masses.sum() / specimen.body.quadrature.volumes.sum())
    masses = consistent_masses(specimen.mesh.nodes, specimen.body, density)
    rest, step = specimen.mesh.nodes, 1.0 / 2000.0
    first = -float((specimen.body.masses[:, None] * DOWN * rest).sum())
    left = {}
    for name, damping, area in (('free', 0.0, 0.0), ('damped', 20.0, 0.0), ('air', 0.0, 0.1)):
        forces = _forces(specimen, damping, area)
        times = [0.06, 0.06 + step]
        start, end = swing(specimen.body, masses, forces, rest, times, step)
        moving, still = _energy(specimen, masses, start, end, step)
        left[name] = (moving + still - first) / moving
    # The rule keeps energy to the square of its step; half a step's middle is off as much.
    assert abs(left['free']) < 0.02
    assert left['damped'] < -0.05
    assert left['air'] < -0.05


@pytest.mark.slow
def test_creep_ends_at_the_equilibrium_of_the_relaxed_modulus(specimen: Specimen) -> None:
    share, tau = 0.3, 2.0
    load = Load(specimen.body.masses[:, None] * DOWN)
    first, last = held_load(specimen.body, load, specimen.mesh.nodes, [1e-6, 40.0], [(share, tau)])
    numbers = specimen.body.numbers
    softer = replace(
        specimen.body,
        numbers=replace(
            numbers,
            shear=(1.0 - share) * numbers.shear,
            bulk=(1.0 - share) * numbers.bulk,
        ),
    )
    sag = find_equilibrium(specimen.body, load, specimen.mesh.nodes)
    relaxed = find_equilibrium(softer, load, specimen.mesh.nodes)
    size = np.abs(relaxed - sag).max()
    assert size > 1e-3
    assert np.abs(first - sag).max() < 1e-3 * size
    assert np.abs(last - relaxed).max() < 1e-2 * size


def test_late_stamps_show_earlier_moments() -> None:
    timing = draw_swing(np.random.default_rng(1))
    late = moments(timing, Faults(stamps_late=5.0))
    np.testing.assert_allclose(np.array(moments(timing, Faults())) - late, 0.005)


def test_the_list_of_cases() -> None:
    cases = list_motion_cases('development')
    assert Counter(case.kind for case in cases) == {'clean': 100, 'single': 27}
    assert len({case.id for case in cases}) == len(cases)
    assert all(case.is_moving for case in cases)
    singles = Counter(case.effects[0] for case in cases if case.kind == 'single')
    assert set(singles.values()) == {3}
    assert {name for name, _ in singles} == {'time_offset', 'air_drag', 'creep'}
    with pytest.raises(ValueError, match='development or sealed'):
        list_motion_cases('other')


def test_drag_is_an_integral_over_the_free_surface(specimen: Specimen) -> None:
    """Speeds that grow as x^2 from the clamp on: x^6 on the sides, and the end."""
    shape = _setup().shape
    free = shape.length - shape.clamp
    velocities = np.zeros_like(specimen.mesh.nodes)
    velocities[:, 2] = np.maximum((specimen.mesh.nodes[:, 0] - shape.clamp) / free, 0.0) ** 2
    power = float((make_drag(specimen.mesh, 0.1).forces(velocities) * velocities).sum())
    width, height = shape.section
    around, end = 2.0 * (width + height) * free, width * height
    assert power == pytest.approx(0.05 * AIR * (around / 7.0 + end) / (around + end), rel=1e-3)


def test_normal_drag_acts_along_the_faces_and_linear_drag_is_more_of_it(
    specimen: Specimen,
) -> None:
    velocities = np.tile([0.0, 0.0, -0.5], (len(specimen.mesh.nodes), 1))
    square, linear, normal = (
        make_drag(specimen.mesh, 0.1, form).forces(velocities).sum(axis=0)
        for form in ('square', 'linear', 'normal')
    )
    # At half a metre per second both parts are alike.
    np.testing.assert_allclose(linear, 2.0 * square, rtol=1e-9)
    width, height = _setup().shape.section
    length = _setup().shape.length - _setup().shape.clamp
    # Two of four sides, and no end, lie across the motion.
    broad = width * length / ((width + height) * length + 0.5 * width * height)
    assert normal[2] == pytest.approx(broad * square[2], rel=1e-6)
    np.testing.assert_allclose(normal[:2], 0.0, atol=1e-9 * abs(normal[2]))


def test_a_pair_in_two_halves_is_the_pair_and_a_slow_half_lags(specimen: Specimen) -> None:
    load = Load(specimen.body.masses[:, None] * DOWN)

    def end(*pairs: tuple[float, float]) -> np.ndarray:
        return held_load(specimen.body, load, specimen.mesh.nodes, [1.0], list(pairs))[0]

    start = find_equilibrium(specimen.body, load, specimen.mesh.nodes)
    whole, halves, slower = (
        end((0.3, 1.0)),
        end((0.15, 1.0), (0.15, 1.0)),
        end((0.15, 1.0), (0.15, 5.0)),
    )
    crept = np.linalg.norm(whole - start)
    assert np.linalg.norm(halves - whole) < 1e-3 * crept
    assert 0.4 * crept < np.linalg.norm(slower - start) < 0.8 * crept


def test_forms_of_motions_are_sealed_and_can_be_drawn() -> None:
    cases = list_motion_form_cases('sealed', 'salt')
    assert len({case.id for case in cases}) == len(cases) == 10
    with pytest.raises(ValueError, match='sealed only'):
        list_motion_form_cases('development')
    times = {}
    for case in cases:
        _, (effect,), faults = draw_case(case)
        timing = draw_timing(case, (effect,))
        assert timing.is_slow == (effect.identifier == 'creep')
        times[faults.stamps_form] = np.diff(moments(timing, faults))
    np.testing.assert_allclose(times['constant'], times['constant'][0])
    assert np.ptp(times['drift']) < 1e-9 < abs(times['drift'][0] - times['constant'][0])
    assert np.ptp(times['jitter']) > 1e-3
