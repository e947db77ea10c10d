# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One material over many bodies: published figures, a second route, bias and coverage."""

from diffcal_ros.batch.random_effects import (
    cochran_q,
    fit_random_effects,
    restricted_spread,
    spread_interval,
)
from diffcal_ros.errors import InputError
import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from scipy.stats import norm

# Published to four digits.
_PRINTED = 6e-5
# Both routes climb to the same flat top.
_FLAT = 1e-5
_DRAWS = 400
# Five standard deviations of a share of 95 % in so many draws, below; the interval of a mean is
# never narrower than stated errors make it, and so wide where bodies are alike.
_LEAST_COVERED = 0.95 - 5.0 * np.sqrt(0.95 * 0.05 / _DRAWS)

# Thirteen trials of the BCG vaccine against tuberculosis (Colditz et al. 1994): cases and others
# among those who were treated, and among those who were not.
_BCG = np.array(
    [
        *((4, 119, 11, 128), (6, 300, 29, 274), (3, 228, 11, 209), (62, 13536, 248, 12619)),
        *((33, 5036, 47, 5761), (180, 1361, 372, 1079), (8, 2537, 10, 619)),
        *((505, 87886, 499, 87892), (29, 7470, 45, 7232), (17, 1699, 65, 1600)),
        *((186, 50448, 141, 27197), (5, 2493, 3, 2338), (27, 16886, 29, 17825)),
    ],
    dtype=float,
)


@pytest.fixture
def trials() -> tuple[np.ndarray, np.ndarray]:
    """Logarithms of the relative risk, and their standard errors."""
    a, b, c, d = _BCG.T
    values = np.log(a / (a + b)) - np.log(c / (c + d))
    return values, np.sqrt(1.0 / a - 1.0 / (a + b) + 1.0 / c - 1.0 / (c + d))


def test_a_published_analysis_is_found_again(trials) -> None:
    # Viechtbauer 2010, Conducting meta-analyses in R with the metafor package, section 3.2: REML,
    # with its interval of the spread, and the mean with the method of Knapp and Hartung.
    values, errors = trials
    fit = fit_random_effects(values, errors)
    assert fit.spread**2 == pytest.approx(0.3132, abs=_PRINTED)
    assert fit.mean == pytest.approx(-0.7145, abs=_PRINTED)
    assert cochran_q(values, errors, 0.0) == pytest.approx(152.2330, abs=_PRINTED)
    assert np.square(fit.spread_95) == pytest.approx([0.1197, 1.1115], abs=_PRINTED)
    assert fit.mean_error == pytest.approx(0.1808, abs=_PRINTED)
    assert fit.interval_95 == pytest.approx((-1.1084, -0.3206), abs=_PRINTED)


def test_the_spread_is_that_of_contrasts_without_a_mean(random) -> None:
    # The other route: the likelihood of the n - 1 contrasts that no mean changes, written out.
    errors = random.uniform(0.02, 0.3, 9)
    values = 1.3 + random.normal(scale=np.hypot(errors, 0.15))
    contrasts = np.linalg.qr(np.column_stack([np.ones(9), np.eye(9)[:, 1:]]))[0][:, 1:].T

    def cost(log_spread: float) -> float:
        covariance = contrasts @ np.diag(errors**2 + np.exp(2.0 * log_spread)) @ contrasts.T
        seen = contrasts @ values
        return float(np.linalg.slogdet(covariance)[1] + seen @ np.linalg.solve(covariance, seen))

    found = minimize_scalar(cost, bounds=(-6.0, 1.0), method='bounded', options={'xatol': 1e-8})
    assert restricted_spread(values, errors) == pytest.approx(np.exp(found.x), rel=_FLAT)


def test_equal_errors_have_a_closed_form(random) -> None:
    values, error = random.normal(scale=0.4, size=12), 0.1
    spread = np.sqrt(np.var(values, ddof=1) - error**2)
    assert restricted_spread(values, np.full(12, error)) == pytest.approx(spread, rel=_FLAT)
    assert restricted_spread(values, np.full(12, 3.0)) == 0.0


def test_offsets_solve_the_mixed_model_equations(random) -> None:
    # Henderson 1950: mean and offsets in one system of equations.
    errors = random.uniform(0.05, 0.2, 7)
    values = 2.0 + random.normal(scale=np.hypot(errors, 0.3))
    fit = fit_random_effects(values, errors)
    weights = errors**-2.0
    system = np.diag(np.append(weights.sum(), weights + fit.spread**-2.0))
    system[0, 1:] = system[1:, 0] = weights
    solved = np.linalg.solve(system, np.append(weights @ values, weights * values))
    np.testing.assert_allclose(np.append(fit.mean, fit.offsets), solved, atol=1e-12)


@pytest.mark.parametrize(('count', 'spread'), [(4, 0.2), (12, 0.06), (40, 0.2)])
@pytest.mark.slow_but_first
def test_intervals_hold_the_truth_and_the_spread_has_no_bias(random, count, spread) -> None:
    held, of_spread, squares = [], [], []
    for _ in range(_DRAWS):
        errors = random.uniform(0.02, 0.1, count)
        fit = fit_random_effects(5.0 + random.normal(scale=np.hypot(errors, spread)), errors)
        held.append(fit.interval_95[0] <= 5.0 <= fit.interval_95[1])
        of_spread.append(fit.spread_95[0] <= spread <= fit.spread_95[1])
        squares.append(fit.spread**2)
    assert np.mean(held) > _LEAST_COVERED
    assert abs(np.mean(of_spread) - 0.95) < 0.95 - _LEAST_COVERED
    error = np.std(squares) / np.sqrt(_DRAWS)
    # What is cut off at zero adds a little where errors are as large as the spread.
    assert abs(np.mean(squares) - spread**2) < 4.0 * error + 0.02 * spread**2


def test_another_body_is_where_it_is_expected(random) -> None:
    held = []
    for _ in range(_DRAWS):
        errors = random.uniform(0.02, 0.05, 20)
        fit = fit_random_effects(random.normal(scale=np.hypot(errors, 0.1)), errors)
        held.append(fit.prediction_95[0] <= random.normal(scale=0.1) <= fit.prediction_95[1])
    assert np.mean(held) > _LEAST_COVERED


def test_what_all_share_does_not_shrink_with_their_number(random) -> None:
    errors = np.full(400, 0.1)
    fit = fit_random_effects(random.normal(scale=0.1, size=400), errors, shared_error=0.05)
    assert 0.05 < fit.mean_error < 0.051
    low, high = fit.interval_95
    assert high - low > 2.0 * norm.ppf(0.975) * 0.05


def test_a_single_body_is_its_own_mean() -> None:
    fit = fit_random_effects(np.array([3.0]), np.array([0.2]))
    assert fit.interval_95 == pytest.approx(
        (3.0 - 0.2 * norm.ppf(0.975), 3.0 + 0.2 * norm.ppf(0.975))
    )
    assert np.isnan([fit.spread, *fit.spread_95, *fit.prediction_95, fit.homogeneity_p]).all()
    assert fit.offsets == pytest.approx([0.0])


def test_bodies_alike_have_no_spread() -> None:
    values, errors = np.full(5, 2.0), np.full(5, 0.1)
    assert restricted_spread(values, errors) == 0.0
    assert spread_interval(values, errors)[0] == 0.0


@pytest.mark.parametrize(
    ('values', 'errors', 'sentence'),
    [
        ([], [], 'no body was given'),
        ([1.0, 2.0], [0.1, 0.0], 'an error is not positive'),
        ([1.0, np.nan], [0.1, 0.1], 'are not finite'),
    ],
)
def test_what_cannot_be_fitted_is_told(values, errors, sentence) -> None:
    with pytest.raises(InputError, match=sentence):
        fit_random_effects(np.array(values), np.array(errors))
