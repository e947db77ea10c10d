# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where a step begins to be looked for, and how rounds are mixed."""

from diffcal_ros.fem.motion.generalised_alpha import StepState
from diffcal_ros.fem.motion.mixing import Mixing
from diffcal_ros.fem.motion.prediction import Predictor
from diffcal_ros.fem.motion.trajectory import Trajectory
import numpy as np
import pytest
from scipy.sparse import csr_matrix

STEP = 0.01


def _place(time: float) -> np.ndarray:
    return np.array([[1.0, -2.0, 0.5]]) + np.array([[3.0, 1.0, -2.0]]) * time + 40.0 * time**3


def _speed(time: float) -> np.ndarray:
    return np.array([[3.0, 1.0, -2.0]]) + 120.0 * time**2


def _marched(count: int, place=_place, step: float = STEP) -> Trajectory:
    trajectory = Trajectory()
    for number in range(count):
        time = number * step
        state = StepState(place(time), _speed(time), np.zeros((1, 3)), np.zeros((1, 3)))
        trajectory.append(time, state)
        trajectory.steps.extend([step] if number else [])
    return trajectory


@pytest.mark.parametrize(('count', 'degree'), [(1, 0), (2, 1), (3, 2), (4, 3), (9, 3)])
def test_the_degree_that_leaves_least_is_taken(count, degree) -> None:
    trajectory = _marched(count)
    true = _place(count * STEP)
    guess = Predictor(None).guess(trajectory, STEP, lambda own: float(np.abs(own - true).max()))
    states = np.array(trajectory.positions)[:, 0]
    times = np.array(trajectory.times)
    fit = np.polynomial.polynomial.polyfit(times[-degree - 1 :], states[-degree - 1 :], degree)
    expected = np.polynomial.polynomial.polyval(count * STEP, fit)
    np.testing.assert_allclose(guess[0], expected, rtol=1e-9)


def test_what_rings_is_not_foretold() -> None:
    ringing = _marched(9, lambda time: _place(0.0) + (-1.0) ** round(time / STEP))
    guess = Predictor(None).guess(ringing, STEP, lambda own: float(np.abs(own - 1.0).max()))
    np.testing.assert_array_equal(guess, ringing.positions[-1])


def test_degrees_are_compared_now_and_then() -> None:
    predictor, asked = Predictor(None), []

    def ask(_: np.ndarray) -> float:
        asked.append(1)
        return float(len(asked))

    for _ in range(10):
        predictor.guess(_marched(6), STEP, ask)
    assert len(asked) == 2 * 4


def test_beside_a_like_motion_only_the_distance_is_foretold() -> None:
    def other(time: float) -> np.ndarray:
        return _place(time) + np.sin(60.0 * time)

    like = _marched(12, lambda time: other(time) - 0.25).path
    true = other(7 * STEP)
    guess = Predictor(like).guess(
        _marched(7, other), STEP, lambda own: float(np.abs(own - true).max())
    )
    np.testing.assert_allclose(guess, true, atol=1e-12)
    # It does not go so far: what is known is what went before.
    short = Predictor(_marched(5, other).path)
    own = Predictor(None)
    guesses = [
        one.guess(_marched(7, other), STEP, lambda own: float(np.abs(own - true).max()))
        for one in (short, own)
    ]
    np.testing.assert_array_equal(*guesses)


def test_a_step_of_another_size_begins_where_the_last_one_ended() -> None:
    trajectory = _marched(6)
    guess = Predictor(None).guess(trajectory, 0.5 * STEP, lambda _: 0.0)
    np.testing.assert_array_equal(guess, trajectory.positions[-1])


def test_a_path_is_cubic_between_its_states_and_ends() -> None:
    path = _marched(4).path
    for time in (0.0, 0.0137, 0.02, 0.03):
        place, speed = path.at(time)
        np.testing.assert_allclose(place, _place(time), atol=1e-13)
        np.testing.assert_allclose(speed, _speed(time), atol=1e-11)
    assert path.at(0.0301) is None
    assert _marched(1).path.at(0.0) is None
    both = path.mapped(csr_matrix(np.array([[1.0], [0.5]])))
    np.testing.assert_allclose(both.at(0.02)[0], [[1.0], [0.5]] * _place(0.02))


def test_mixing_ends_a_linear_problem_in_as_many_rounds_as_it_has_ways(random) -> None:
    matrix = np.eye(5) + 0.4 * random.normal(size=(5, 5))
    side, place, mixing = random.normal(size=5), np.zeros(5), Mixing()
    sizes = []
    for _ in range(7):
        change = side - matrix @ place
        sizes.append(float(np.linalg.norm(change)))
        place = place + mixing.step(place, change)
    assert sizes[-1] < 1e-6 * sizes[0]
    assert sizes[3] > 1e-4 * sizes[0]
    np.testing.assert_allclose(place, np.linalg.solve(matrix, side), rtol=1e-6)
