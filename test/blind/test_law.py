# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from support.blind_law import stress_change, stress_of

from benchmarks.blind.material import (
    constants,
    respond,
    stiffened,
)

MODULUS, NU = 2.0e5, 0.47


@pytest.mark.parametrize('nu', [0.0, 0.3, 0.49])
def test_small_pull_measures_modulus_and_poissons_ratio(nu: float) -> None:
    strain = 1e-6
    numbers = constants(np.array(MODULUS), nu)
    law = respond(np.diag([1.0 + strain, 1.0 - nu * strain, 1.0 - nu * strain]), numbers)
    stretched = np.diag([1.0 + strain, 1.0 - nu * strain, 1.0 - nu * strain])
    stress = law.along * stretched + law.pressure * law.cofactor
    # Second order in the strain, times the bulk modulus at nu = 0.49.
    assert stress[0, 0] == pytest.approx(MODULUS * strain, rel=1e-4)
    assert abs(stress[1, 1]) < 1e-4 * MODULUS * strain


def test_yeoh_term_is_that_share_of_half_the_shear_modulus() -> None:
    F = np.array([[1.1, 0.2, 0.0], [0.0, 0.95, 0.1], [0.05, 0.0, 1.02]])
    plain = respond(F, constants(np.array(MODULUS), NU))
    stiff = respond(F, constants(np.array(MODULUS), NU, 3.0))
    shear = MODULUS / (2.0 * (1.0 + NU))
    expected = 3.0 * 0.5 * shear * (np.sum(F * F) - 3.0) ** 2
    assert stiff.energy - plain.energy == pytest.approx(expected, rel=1e-12)


def test_stress_is_the_slope_of_the_energy() -> None:
    random = np.random.default_rng(0)
    F = np.eye(3) + random.uniform(-0.2, 0.2, size=(3, 3))
    direction = random.standard_normal((3, 3))
    numbers, step = constants(np.array(MODULUS), NU, 2.0), 1e-6
    high, low = (respond(F + sign * step * direction, numbers).energy for sign in (1, -1))
    law = respond(F, numbers)
    stress = law.along * F + law.pressure * law.cofactor
    assert (high - low) / (2 * step) == pytest.approx(float(np.sum(stress * direction)), rel=1e-7)


FORMS = [
    ('gent', 6.0),
    ('fung', 8.0),
    ('cubic', 40.0),
    ('mooney_rivlin', 0.6),
    ('ogden', 0.4),
    ('veronda_westmann', 8.0),
    ('hart_smith', 60.0),
]


@pytest.mark.parametrize(('form', 'amount'), FORMS)
def test_other_forms_of_stiffening_keep_what_is_at_rest(form: str, amount: float) -> None:
    numbers = stiffened(constants(np.array(MODULUS), NU), form, amount)
    assert abs(stress_of(np.eye(3), numbers)).max() < 1e-9 * MODULUS
    sheared = np.eye(3)
    sheared[0, 1] = 1e-4
    expected = 1e-4 * MODULUS / (2.0 * (1.0 + NU))
    assert stress_of(sheared, numbers)[0, 1] == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize(('form', 'amount'), FORMS)
@pytest.mark.parametrize('step', [1e-4, 1e-5, 1e-6])
def test_stress_and_stiffness_of_other_forms_are_slopes(
    form: str, amount: float, step: float
) -> None:
    random = np.random.default_rng(1)
    F = np.eye(3) + random.uniform(-0.08, 0.12, size=(3, 3))
    direction = random.standard_normal((3, 3))
    numbers = stiffened(constants(np.array(MODULUS), NU), form, amount)
    ends = [F + sign * step * direction for sign in (1, -1)]
    slope = np.subtract(*(respond(end, numbers).energy for end in ends)) / (2 * step)
    stress = stress_of(F, numbers)
    assert slope == pytest.approx(float(np.sum(stress * direction)), rel=3e-4)
    change = stress_change(F, numbers, direction, step)
    expected = np.subtract(*(stress_of(end, numbers) for end in ends)) / (2 * step)
    assert np.allclose(change, expected, rtol=0.0, atol=1e-3 * np.abs(expected).max())
