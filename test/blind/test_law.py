# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from benchmarks.blind.material import constants, respond

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
