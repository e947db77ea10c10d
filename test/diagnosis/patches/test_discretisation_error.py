# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the parameters of a motion take up of an error of mesh and step."""

from types import SimpleNamespace
from typing import Any

from diffcal_ros.diagnosis.patches import discretisation_error
from diffcal_ros.diagnosis.patches.discretisation_error import (
    _take_off,
    _taken_up,
    DiscretisationError,
)
from diffcal_ros.fem.motion.inputs import MotionError
import numpy as np
import pytest

HERE, FINER = np.array([0.3, 1.0]), np.array([0.355, 0.97])


class CurvedModel:
    """Three frames that follow a large coordinate by a curve, and a small one by little."""

    parameters = SimpleNamespace(bounds=lambda: (np.array([-9.0, 0.0]), np.array([9.0, 9.0])))

    def __init__(self, random: np.random.Generator, least: float = -np.inf) -> None:
        self.base = random.normal(size=(3, 3, 40, 3)) * np.array([1.0, 3.0, 0.1])[:, None, None]
        self.least = least

    def keep(self, coordinates: np.ndarray) -> None:
        pass

    def views(self, coordinates: np.ndarray) -> list[Any]:
        x, small = coordinates
        if x > self.least > 0.0:
            raise MotionError('no motion there')
        ways = (x, x**2, small)
        return [SimpleNamespace(points=np.einsum('k,kni->ni', ways, own)) for own in self.base]

    def tangents(self, coordinates: np.ndarray) -> list[np.ndarray]:
        x, _ = coordinates
        return [np.stack([own[0] + 2.0 * x * own[1], own[2]]) for own in self.base]

    def moves(self) -> list[np.ndarray]:
        """Return what a finer mesh does: it moves as this one does elsewhere."""
        pairs = zip(self.views(HERE), self.views(FINER), strict=True)
        return [after.points - before.points for before, after in pairs]


@pytest.fixture
def _hardly_known(monkeypatch) -> None:
    known = (np.zeros(2), 1e-3 * np.eye(2))
    monkeypatch.setattr(discretisation_error, 'regularised_prior', lambda _: known)


@pytest.mark.usefixtures('_hardly_known')
def test_a_small_parameter_does_not_take_up_how_a_large_one_bends(random) -> None:
    model: Any = CurvedModel(random)
    straight = _take_off(model.moves(), model.tangents(HERE), [0, 1, 2], 1e-3 * np.eye(2))
    moves = model.moves()
    found = _taken_up(model, HERE, moves, [0, 1, 2])
    assert np.linalg.norm(found - (FINER - HERE)) < 0.1 * np.linalg.norm(straight - FINER + HERE)
    assert np.linalg.norm(moves) < 1e-3 * np.linalg.norm(model.moves())


@pytest.mark.usefixtures('_hardly_known')
def test_tangents_serve_where_no_motion_is_found(random) -> None:
    model: Any = CurvedModel(random)
    straight = _take_off(model.moves(), model.tangents(HERE), [0, 1, 2], 1e-3 * np.eye(2))
    moves, model.least = model.moves(), 0.32
    np.testing.assert_allclose(_taken_up(model, HERE, moves, [0, 1, 2]), straight)


def test_parameters_take_up_what_they_can_and_the_rest_is_left(random) -> None:
    columns = random.normal(size=(2, 3, 50, 3))  # Two parameters, three frames.
    rest = random.normal(scale=1e-4, size=(3, 50, 3))
    moves = list(np.einsum('k,ksni->sni', [0.05, -0.2], columns) + rest)
    tangents = list(np.swapaxes(columns, 0, 1))
    found = _take_off(moves, tangents, [0, 1, 2], np.eye(2))
    np.testing.assert_allclose(found, [0.05, -0.2], atol=2e-5)
    assert np.linalg.norm(moves) < 1.01 * np.linalg.norm(rest)


def test_a_parameter_that_hardly_moves_the_body_stays_near_what_is_known(random) -> None:
    columns = random.normal(size=(2, 3, 50, 3)) * np.array([1e-2, 1e-6])[:, None, None, None]
    # By least squares alone the second one would go twenty of its units.
    moves = list(np.einsum('k,ksni->sni', [0.05, 20.0], columns))
    tangents = list(np.swapaxes(columns, 0, 1))
    found = _take_off(moves, tangents, [0, 1, 2], np.diag([1.0, 100.0]))
    assert abs(found[0] - 0.05) < 1e-3
    assert abs(found[1]) < 0.1


def test_only_views_of_one_recording_are_touched(random) -> None:
    moves = list(random.normal(size=(2, 5, 3)))
    kept = moves[1].copy()
    _take_off(moves, list(random.normal(size=(2, 1, 5, 3))), [0], np.eye(1))
    np.testing.assert_array_equal(moves[1], kept)


def test_shifts_go_by_the_names_of_parameters() -> None:
    class Named:
        names = ('damping', 'added_mass.mass')

    discretisation_error = DiscretisationError(
        (), (), (), {'damping': -0.3, 'youngs_modulus': 0.1}
    )
    np.testing.assert_array_equal(discretisation_error.shifts_of(Named()), [-0.3, 0.0])  # type: ignore[arg-type]
