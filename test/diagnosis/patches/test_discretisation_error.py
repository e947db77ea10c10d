# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the parameters of a motion take up of an error of mesh and step."""

from diffcal_ros.diagnosis.patches.discretisation_error import _take_off, DiscretisationError
import numpy as np


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
