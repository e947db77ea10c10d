# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How a fit is said to have ended: each rule by itself, and which goes before which."""

from dataclasses import replace

from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.calibration.results.outcome import EXIT_NOT_FITTED, Outcome
from diffcal_ros.calibration.results.outcome_rules import judge, warn
from diffcal_ros.calibration.results.result import FittedParameter
from diffcal_ros.calibration.uncertainty.uncertainty import Uncertainty
from diffcal_ros.least_squares.levenberg_marquardt import Minimum, Stop
from diffcal_ros.least_squares.normal_equations import Linearisation
import numpy as np
import pytest

GOOD = Gap(median=0.0005, rms=0.0007, coverage=0.97, pixels=5000, explained=0.98)
MODULUS = FittedParameter('youngs_modulus', 60e3, 600.0, 100.0, 'Pa', 80e3)
BIAS = FittedParameter('edge_bias', 0.1, 0.01, 0.0, 'px', 0.0, is_nuisance=True)
SMALL, NOTHING = 1e-4 * np.eye(2), np.zeros(2)
KNOWN = Uncertainty(SMALL, SMALL, NOTHING, NOTHING, SMALL, (), ())


def _judge(
    *, stop=Stop.CONVERGED, gap=GOOD, fitted=(MODULUS, BIAS), known=KNOWN, **others
) -> Outcome:
    square = np.eye(2)
    minimum = Minimum(
        np.zeros(2), Linearisation(1.0, np.zeros(2), square, square, square), 5, stop
    )
    return judge(minimum, gap, fitted, known, **others)


def test_a_fit_without_anything_amiss_has_converged() -> None:
    assert _judge() is Outcome.CONVERGED
    assert warn(GOOD, (MODULUS, BIAS), KNOWN) == []


@pytest.mark.parametrize(
    ('changes', 'outcome'),
    [
        ({'stop': Stop.INTERRUPTED}, Outcome.INTERRUPTED),
        ({'stop': Stop.STUCK}, Outcome.DIVERGED),
        ({'stop': Stop.EXHAUSTED}, Outcome.NOT_CONVERGED),
        ({'gap': replace(GOOD, median=float('nan'))}, Outcome.DIVERGED),
        ({'gap': replace(GOOD, coverage=0.09)}, Outcome.DIVERGED),
        ({'gap': replace(GOOD, median=0.0031)}, Outcome.MODEL_DISAGREES),
        ({'gap': replace(GOOD, coverage=0.89)}, Outcome.MODEL_DISAGREES),
        ({'gap': replace(GOOD, explained=0.89)}, Outcome.MODEL_DISAGREES),
        # What something else hides cannot be covered.
        ({'gap': replace(GOOD, coverage=0.75, hidden=0.2)}, Outcome.CONVERGED),
        ({'known': replace(KNOWN, blind=('youngs_modulus',))}, Outcome.NOT_IDENTIFIABLE),
        ({'known': replace(KNOWN, blind=('edge_bias',))}, Outcome.CONVERGED),
        ({'fitted': (replace(MODULUS, at_bound=True), BIAS)}, Outcome.AT_BOUND),
        ({'fitted': (MODULUS, replace(BIAS, at_bound=True))}, Outcome.CONVERGED),
        ({'is_ambiguous': True}, Outcome.AMBIGUOUS),
    ],
)
def test_each_rule_by_itself(changes, outcome) -> None:
    assert _judge(**changes) is outcome


def test_the_worse_news_goes_first() -> None:
    """Each change is added to those before it, from the mildest to the most severe."""
    changes = {}
    for more, outcome in (
        ({'is_ambiguous': True}, Outcome.AMBIGUOUS),
        ({'gap': replace(GOOD, median=0.005)}, Outcome.MODEL_DISAGREES),
        ({'fitted': (replace(MODULUS, at_bound=True), BIAS)}, Outcome.AT_BOUND),
        ({'stop': Stop.EXHAUSTED}, Outcome.NOT_CONVERGED),
        ({'known': replace(KNOWN, blind=('youngs_modulus',))}, Outcome.NOT_IDENTIFIABLE),
        ({'gap': replace(GOOD, coverage=0.01)}, Outcome.DIVERGED),
        ({'stop': Stop.INTERRUPTED}, Outcome.INTERRUPTED),
    ):
        changes.update(more)
        assert _judge(**changes) is outcome


def test_only_a_converged_fit_may_be_used_unseen() -> None:
    assert [outcome for outcome in Outcome if outcome.is_usable] == [Outcome.CONVERGED]
    assert [outcome for outcome in Outcome if outcome.exit_code == 0] == [Outcome.CONVERGED]
    unfitted = {outcome for outcome in Outcome if not outcome.is_fitted}
    assert {outcome.exit_code for outcome in unfitted} == {EXIT_NOT_FITTED}
    assert len({outcome.remedy for outcome in Outcome}) == len(Outcome)


def test_a_body_that_stands_where_it_cannot_is_not_called_converged():
    assert _judge(placement=2e-4) is Outcome.CONVERGED
    assert _judge(placement=5e-5) is Outcome.MODEL_DISAGREES
    assert _judge(placement=5e-5, is_ambiguous=True) is Outcome.MODEL_DISAGREES
    (warning,) = warn(GOOD, (MODULUS, BIAS), KNOWN, placement=5e-5)
    assert 'where the scene says that they are not (chance 5e-05)' in warning
    assert warn(GOOD, (MODULUS, BIAS), KNOWN, placement=2e-4) == []


@pytest.mark.parametrize(
    ('gap', 'fitted', 'known', 'words'),
    [
        (replace(GOOD, median=0.0042), (MODULUS, BIAS), KNOWN, 'a median gap of 4.2 mm is left'),
        (replace(GOOD, coverage=0.8), (MODULUS, BIAS), KNOWN, 'only 80% of the rendered body'),
        (replace(GOOD, explained=0.7), (MODULUS, BIAS), KNOWN, '30% of the measured body lies'),
        (GOOD, (replace(MODULUS, at_bound=True), BIAS), KNOWN, 'stopped at its bound 6e+04 Pa'),
        (GOOD, (replace(MODULUS, mesh_error=9e3), BIAS), KNOWN, 'by about 15 %'),
        (GOOD, (MODULUS, BIAS), replace(KNOWN, prior_bound=('density',)), 'its prior than from'),
        (GOOD, (MODULUS, BIAS), replace(KNOWN, blind=('x', 'y')), 'cannot tell apart: x, y'),
    ],
)
def test_what_a_person_should_know_is_told(gap, fitted, known, words) -> None:
    (warning,) = warn(gap, fitted, known)
    assert words in warning


def test_two_that_are_hard_to_tell_apart_are_named_unless_nobody_asked() -> None:
    tied = replace(KNOWN, statistical=1e-4 * np.array([[1.0, -0.97], [-0.97, 1.0]]))
    asked = (MODULUS, replace(BIAS, name='rigid_offset.x', is_nuisance=False))
    (warning,) = warn(GOOD, asked, tied)
    assert 'youngs_modulus and rigid_offset.x are hard to tell apart' in warning
    assert '-0.97' in warning
    assert warn(GOOD, (MODULUS, BIAS), tied) == []
