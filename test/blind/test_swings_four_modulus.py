# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How stiff a body is along its length, as labels of the set `swings_four` tell it."""

import numpy as np
import pytest
from scipy.optimize import minimize

from benchmarks.blind.material import respond
from benchmarks.blind.rubber import draw_rubber, LAWS, Rubber
from benchmarks.blind.uniaxial import modulus_along

MODULUS, NU = 3.0e5, 0.48


def _energy_drawn(rubber: Rubber, stretch: float) -> float:
    """Return the least energy of a cube whose length alone is given, over its modulus [-]."""
    numbers = rubber.numbers(np.array(1.0), NU)

    def energy(other: np.ndarray) -> float:
        y, z, yz, xz, xy = stretch * other
        strain = np.array([[stretch, xy, xz], [xy, y, yz], [xz, yz, z]])
        return float(respond(np.eye(3) + strain, numbers).energy) / stretch**2

    best = minimize(energy, np.array([-0.48, -0.48, 0.0, 0.0, 0.0]), tol=1e-9)
    return float(best.fun) * stretch**2


@pytest.mark.parametrize('step', [1e-2, 3e-3, 1e-3])
@pytest.mark.parametrize('law', LAWS)
def test_it_is_the_curvature_of_the_least_energy_by_the_length(law: str, step: float) -> None:
    rubber = draw_rubber(law, np.random.default_rng(3))
    found = modulus_along(rubber, MODULUS, NU)
    curve = (_energy_drawn(rubber, step) + _energy_drawn(rubber, -step)) / step**2
    assert found / MODULUS == pytest.approx(curve, rel=1e-3)


@pytest.mark.parametrize('law', [law for law in LAWS if law != 'fibres'])
def test_it_is_the_plain_one_of_a_law_that_is_the_same_in_all_directions(law: str) -> None:
    rubber = draw_rubber(law, np.random.default_rng(5))
    assert modulus_along(rubber, MODULUS, NU) == pytest.approx(MODULUS, rel=1e-7)


@pytest.mark.parametrize('slant', [0.0, 25.0, 45.0, 70.0, 90.0])
def test_oblique_fibres_stiffen_by_what_a_pull_draws_them(slant: float) -> None:
    """What a fibre adds to the stiffness has rank one: its inverse by Sherman and Morrison."""
    angle, share = np.deg2rad(slant), 0.22
    direction = (float(np.cos(angle)), 0.6 * float(np.sin(angle)), 0.8 * float(np.sin(angle)))
    rubber = Rubber('fibres', share=share, direction=direction)
    drawn = (1.0 + NU) * np.cos(angle) ** 2 - NU
    expected = MODULUS / (1.0 - share / (1.0 + share) * drawn**2)
    assert modulus_along(rubber, MODULUS, NU) == pytest.approx(expected, rel=1e-7)


def test_fibres_along_a_body_stiffen_it_by_their_whole_share() -> None:
    rubber = Rubber('fibres', share=0.2)
    assert modulus_along(rubber, MODULUS, NU) == pytest.approx(1.2 * MODULUS, rel=1e-7)
