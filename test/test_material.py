# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
from diffcal_ros.material import lame_lambda, lame_mu, LameConvention, Material
import numpy as np
import pytest


def _material(modulus: float, nu: float, convention: LameConvention) -> Material:
    return Material(np.array([modulus]), np.array([nu]), np.array([1080.0]), convention)


def test_lame_numbers_give_back_youngs_modulus_and_poissons_ratio() -> None:
    modulus, nu = np.array([120e3]), np.array([0.37])
    mu, lam = lame_mu(modulus, nu), lame_lambda(modulus, nu)
    np.testing.assert_allclose(mu * (3 * lam + 2 * mu) / (lam + mu), modulus)
    np.testing.assert_allclose(lam / (2 * (lam + mu)), nu)


def test_paper_convention_takes_lambda_as_49_mu_at_0_49() -> None:
    numbers = _material(206_424.6, 0.49, LameConvention.PAPER).lame_parameters()
    np.testing.assert_allclose(numbers.neo_hookean_mu, 69_270.0)
    np.testing.assert_allclose(numbers.neo_hookean_lambda, 49 * numbers.neo_hookean_mu)


@pytest.mark.parametrize('convention', list(LameConvention))
def test_derivatives_of_the_numbers(convention: LameConvention) -> None:
    modulus, nu = 83e3, 0.46
    material = _material(modulus, nu, convention)
    for step, derivative in (
        ((1.0, 0.0), material.lame_parameters_by_youngs_modulus()),
        ((0.0, 1e-6), material.lame_parameters_by_poissons_ratio()),
    ):
        above = _material(modulus + step[0], nu + step[1], convention).lame_parameters()
        below = _material(modulus - step[0], nu - step[1], convention).lame_parameters()
        size = 2.0 * sum(step)
        for name in ('neo_hookean_mu', 'neo_hookean_lambda'):
            difference = (getattr(above, name) - getattr(below, name)) / size
            np.testing.assert_allclose(difference, getattr(derivative, name), rtol=1e-6)


def test_refuses_a_poissons_ratio_of_a_half() -> None:
    with pytest.raises(ValueError, match=r"Poisson's ratio is 0\.5: it must lie above -1"):
        _material(1e5, 0.5, LameConvention.CONSISTENT)


def test_refuses_a_negative_modulus() -> None:
    with pytest.raises(ValueError, match="Young's modulus must be positive"):
        _material(-1.0, 0.49, LameConvention.CONSISTENT)
