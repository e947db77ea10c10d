# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fits from several starts: which is best, which others explain as much, what is said of it."""

from copy import copy
from dataclasses import replace

from diffcal_ros.calibration.contest import Contest, Entry
from diffcal_ros.calibration.parameters.parameters import Kind, Parameter, ParameterSet
from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.calibration.residuals.residual_scales import Scale, Scales
from diffcal_ros.calibration.residuals.two_way_comparison import Misfit
from diffcal_ros.calibration.results.outcome import (
    EXIT_AMBIGUOUS,
    EXIT_MODEL_DISAGREES,
    EXIT_NOT_FITTED,
    Outcome,
)
from diffcal_ros.calibration.results.outcome_rules import judge
from diffcal_ros.calibration.uncertainty.uncertainty import estimate_uncertainty
from diffcal_ros.fem.statics.tangent_stiffness import EquilibriumError
from diffcal_ros.least_squares.levenberg_marquardt import minimise, Minimum, Stop
from diffcal_ros.least_squares.normal_equations import Linearisation
from diffcal_ros.scene.model import Quantity
import numpy as np
import pytest

PARAMETERS = ParameterSet(
    (Parameter('youngs_modulus', Kind.YOUNGS_MODULUS, 0, 'Pa', Quantity(1e5, 1e3, 1e7)),)
)
BOUNDS = PARAMETERS.bounds()
LONGEST = np.array([0.7])
LEFT, RIGHT = np.log(5e4), np.log(4e5)
STIFFNESS = 400.0
FINE = 0.001
GOOD = Gap(0.0005, 0.001, 0.98, 9000, explained=0.99)


class TwoWells:
    """A cost with two minima, `lift` apart in height: the lower of two parabolas.

    Attributes:
        scales: as an objective of depth images has them; nothing here depends on them.
    """

    is_annealed = True
    parameters = PARAMETERS

    def __init__(self, lift: float, right: Gap = GOOD) -> None:
        self._right = right
        self.scales = Scales()
        self._wells = ((LEFT, 20.0), (RIGHT, 20.0 + lift))

    def under(self, scales: Scales) -> 'TwoWells':
        other = copy(self)
        other.scales = scales
        return other

    def cost(self, coordinates) -> float:
        return min(h + 0.5 * STIFFNESS * (coordinates[0] - c) ** 2 for c, h in self._wells)

    def misfit(self, coordinates) -> Misfit:
        cost = self.cost(coordinates)
        return Misfit(cost, cost)

    def linearise(self, coordinates) -> Linearisation:
        centre = min(
            self._wells, key=lambda w: w[1] + 0.5 * STIFFNESS * (coordinates[0] - w[0]) ** 2
        )[0]
        stiff = np.array([[STIFFNESS]])
        return Linearisation(
            self.cost(coordinates), STIFFNESS * (centre - coordinates), stiff, stiff, stiff
        )

    def anneal(self, coordinates) -> None:
        """Keep the one form that it has."""

    def refine(self, coordinates) -> bool:
        return False

    def gap_and_misfit(self, coordinates) -> tuple[Gap, Misfit]:
        gap = GOOD if coordinates[0] < 0.5 * (LEFT + RIGHT) else self._right
        return gap, self.misfit(coordinates)


def _are_same(one, other) -> bool:
    return bool(np.abs(one - other).max() < 0.5)


def _contest(lift: float, first: float, others: tuple[float, ...], right: Gap = GOOD):
    objective = TwoWells(lift, right)
    contest = Contest(objective, minimise(objective, np.array([first]), BOUNDS, LONGEST))
    for other in others:
        if not contest.is_known(np.array([other]), _are_same):
            contest.challenge(np.array([other]))
    return contest


def _ended(at: float, stop: Stop) -> Minimum:
    where = np.array([at])
    return Minimum(where, TwoWells(0.0).linearise(where), 20, stop)


@pytest.mark.parametrize(('off', 'is_first'), [(0.05, True), (0.3, False)])
def test_a_fit_that_ran_out_wins_only_where_it_is_clearly_better(off, is_first) -> None:
    # Half chi-square is 0.5 and 18 above the minimum.
    arrived = _ended(LEFT + off, Stop.CONVERGED)
    contest = Contest(TwoWells(6.0), arrived)
    contest.challenge(np.array([LEFT]))
    (ended,) = (own for own in contest.entries if own.minimum is not arrived)
    ran_out = replace(ended, minimum=replace(ended.minimum, stop=Stop.EXHAUSTED))
    contest.entries = [ran_out, contest.entries[-1]]
    contest.challenge(np.array([RIGHT]))
    assert (contest.best.minimum is arrived) is is_first


@pytest.mark.parametrize('first', [LEFT - 0.4, RIGHT + 0.3])
def test_the_lower_minimum_wins_from_either_side(first) -> None:
    contest = _contest(6.0, first, (LEFT + 0.2, RIGHT - 0.2))
    assert contest.best.minimum.coordinates[0] == pytest.approx(LEFT, abs=1e-3)
    (other,) = contest.alternatives(_are_same)
    assert other.values['youngs_modulus'] == pytest.approx(4e5, rel=1e-3)
    assert other.misfit == pytest.approx(6.0, abs=1e-3)


@pytest.mark.parametrize(('lift', 'is_as_good'), [(0.5, True), (4.0, True), (30.0, False)])
def test_about_as_well_means_within_three_standard_errors(lift, is_as_good) -> None:
    contest = _contest(lift, LEFT, (RIGHT,))
    (other,) = contest.alternatives(_are_same)
    assert other.is_as_good is is_as_good


@pytest.mark.parametrize(
    ('right', 'is_as_good'),
    [
        # It fits what both see far better, though the misfit counts more without counterpart.
        (replace(GOOD, median=0.0002, explained=0.7), True),
        (replace(GOOD, median=0.0004, explained=0.7), False),
        # A few pixels are met by anything, and so is a body that is left out.
        (replace(GOOD, median=0.0001, pixels=3000), False),
        (replace(GOOD, median=0.0001, explained=0.3), False),
    ],
)
def test_a_place_with_a_far_smaller_gap_is_not_ruled_out(right, is_as_good) -> None:
    (other,) = _contest(30.0, LEFT, (RIGHT,), right).alternatives(_are_same)
    assert other.is_as_good is is_as_good


def test_a_place_that_is_known_is_not_fitted_again() -> None:
    contest = _contest(6.0, LEFT, (LEFT + 0.1, LEFT - 0.2))
    assert len(contest.entries) == 1
    assert contest.alternatives(_are_same) == ()


def _judged(gap: Gap, *, is_ambiguous: bool = False) -> Outcome:
    objective = TwoWells(0.0)
    minimum = minimise(objective, np.array([LEFT]), BOUNDS, LONGEST)
    uncertainty = estimate_uncertainty(minimum.linearisation, PARAMETERS, np.zeros(1))
    return judge(minimum, gap, (), uncertainty, is_ambiguous=is_ambiguous)


def test_converged_needs_both_shares_and_the_gap() -> None:
    assert _judged(GOOD) is Outcome.CONVERGED
    assert _judged(replace(GOOD, median=0.0035)) is Outcome.MODEL_DISAGREES
    assert _judged(replace(GOOD, coverage=0.88)) is Outcome.MODEL_DISAGREES
    assert _judged(replace(GOOD, explained=0.88)) is Outcome.MODEL_DISAGREES


def test_what_is_hidden_counts_against_nobody() -> None:
    assert _judged(replace(GOOD, coverage=0.66, hidden=0.32)) is Outcome.CONVERGED
    assert _judged(replace(GOOD, coverage=0.50, hidden=0.32)) is Outcome.MODEL_DISAGREES


def test_two_answers_are_ambiguous_unless_the_model_disagrees_anyway() -> None:
    assert _judged(GOOD, is_ambiguous=True) is Outcome.AMBIGUOUS
    assert _judged(replace(GOOD, coverage=0.5), is_ambiguous=True) is Outcome.MODEL_DISAGREES


def test_only_what_may_be_used_exits_with_zero() -> None:
    assert {own for own in Outcome if own.exit_code == 0} == {Outcome.CONVERGED}
    assert Outcome.MODEL_DISAGREES.exit_code == EXIT_MODEL_DISAGREES
    assert Outcome.AMBIGUOUS.exit_code == EXIT_AMBIGUOUS
    assert Outcome.AT_BOUND.exit_code == EXIT_NOT_FITTED
    assert len({0, 2, EXIT_NOT_FITTED, EXIT_MODEL_DISAGREES, EXIT_AMBIGUOUS}) == 5


class HeldOff(TwoWells):
    """Two wells of which the left one is lower where a residual counts as coarse noise."""

    def misfit(self, coordinates) -> Misfit:
        is_fine = self.scales.depth.noise < FINE
        cost = self.cost(coordinates)
        lower = RIGHT if is_fine else LEFT
        cost += 0.0 if abs(coordinates[0] - lower) < 0.5 else 50.0
        return Misfit(cost, cost)


@pytest.mark.parametrize('noises', [(1.5e-3, 3e-4), (3e-4, 1.5e-3)])
def test_places_are_judged_by_the_least_noise_that_any_of_them_shows(noises) -> None:
    objective = HeldOff(0.0)
    ends = [_ended(LEFT, Stop.CONVERGED), _ended(RIGHT, Stop.CONVERGED)]
    scales = [replace(Scales(), depth=Scale(noise=noise)) for noise in noises]
    contest = Contest(objective, ends[0])
    contest.entries = [Entry(*own) for own in zip(ends, scales, strict=True)]
    # A place that no fit comes to: it is sorted once more, with the two.
    contest.challenge(np.array([LEFT + 0.1]))
    assert contest.best.minimum.coordinates[0] == pytest.approx(RIGHT)


class OutOfReach(TwoWells):
    """The right well has no equilibrium once a fit has left it."""

    def misfit(self, coordinates) -> Misfit:
        if coordinates[0] > 0.5 * (LEFT + RIGHT):
            raise EquilibriumError('no equilibrium')
        return super().misfit(coordinates)

    def gap_and_misfit(self, coordinates) -> tuple[Gap, Misfit]:
        return GOOD, self.misfit(coordinates)


def test_a_place_that_cannot_be_reached_from_rest_is_no_answer() -> None:
    """A fit came there by steps; what cannot be simulated again explains nothing."""
    objective = OutOfReach(-10.0)
    contest = Contest(objective, _ended(LEFT, Stop.CONVERGED))
    contest.entries.append(Entry(_ended(RIGHT, Stop.CONVERGED), Scales()))
    contest.challenge(np.array([LEFT + 0.2]))
    assert contest.best.minimum.coordinates[0] == pytest.approx(LEFT, abs=0.05)
    assert contest.alternatives(_are_same) == ()
    lost = Contest(objective, _ended(RIGHT, Stop.CONVERGED))
    assert lost.is_beaten_by(contest)
    assert not contest.is_beaten_by(lost)


def test_another_model_beats_by_what_is_clearly_better_alone() -> None:
    low, high = (Contest(TwoWells(lift), _ended(RIGHT, Stop.CONVERGED)) for lift in (0.0, 30.0))
    near = Contest(TwoWells(4.0), _ended(RIGHT, Stop.CONVERGED))
    assert high.is_beaten_by(low)
    assert not low.is_beaten_by(high)
    assert not near.is_beaten_by(low)
