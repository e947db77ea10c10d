# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Shapes without stress: arcs and helices, held against an integral of the turning frame."""

from diffcal_ros.fem.body_axes import body_axes, BodyAxes
from diffcal_ros.fem.terms.rest_shape import bent
from diffcal_ros.rigid_transform import cross_matrix
import numpy as np
import pytest
from scipy.integrate import solve_ivp

RATES = np.array([[4.0, 3.0, -2.0], [0.0, 0.0, 0.0], [-9.0, 1.0, 6.0], [0.0, -5.0, 2.0]])


@pytest.fixture
def points(random) -> np.ndarray:
    return random.normal(size=(400, 3)) * np.array([0.1, 0.01, 0.02])


@pytest.fixture
def axes(points) -> BodyAxes:
    return body_axes(points, np.flatnonzero(points[:, 0] > 0.15).astype(np.int32))


def _line(axes: BodyAxes, count: int = 200) -> np.ndarray:
    return axes.root + np.linspace(0.0, axes.length, count)[:, None] * axes.axes[0]


def test_an_arc_keeps_lengths_and_what_is_held(points, axes):
    rates = np.array([[0.0, 0.0, 5.0]])
    arc = bent(_line(axes), axes, rates)
    length = np.linalg.norm(np.diff(arc, axis=0), axis=1).sum()
    assert length == pytest.approx(axes.length, rel=1e-4)
    chord = np.linalg.norm(arc[-1] - arc[0])
    assert chord == pytest.approx(2.0 / 5.0 * np.sin(0.5 * 5.0 * axes.length), rel=1e-4)
    held = points[:, 0] > 0.15
    np.testing.assert_allclose(bent(points, axes, rates)[held], points[held], atol=1e-3)
    np.testing.assert_array_equal(bent(points, axes, np.zeros((3, 3))), points)


def test_parts_of_one_rate_are_one_helix(points, axes):
    rate = np.array([[7.0, 3.0, -2.0]])
    whole, parts = bent(points, axes, rate), bent(points, axes, np.tile(rate, (5, 1)))
    np.testing.assert_allclose(parts, whole, atol=1e-12)


def test_parts_follow_the_integral_of_the_turning_frame(axes):
    part_length = axes.length / len(RATES)

    def change(along: float, state: np.ndarray) -> np.ndarray:
        turn = state[3:].reshape(3, 3)
        rate = RATES[min(int(along / part_length), len(RATES) - 1)] @ axes.axes
        return np.concatenate([turn @ axes.axes[0], (turn @ cross_matrix(rate)).ravel()])

    beside = 0.01 * axes.axes[1] - 0.02 * axes.axes[2]
    state = np.concatenate([axes.root, np.eye(3).ravel()])
    for number in range(len(RATES)):
        begin, end = number * part_length, (number + 1) * part_length
        # Up to the border of a part, where its rate changes.
        found = solve_ivp(change, (begin, end - 1e-12), state, rtol=1e-10, atol=1e-12)
        state = found.y[:, -1]
        place = axes.root + (end - 1e-9) * axes.axes[0] + beside
        expected = state[:3] + state[3:].reshape(3, 3) @ beside
        np.testing.assert_allclose(bent(place[None], axes, RATES)[0], expected, atol=2e-8)


def test_sections_stay_plane_and_keep_their_size(axes):
    beside = np.array([[0.0, 0.0], [0.01, 0.0], [0.0, 0.02], [-0.01, 0.01]]) @ axes.axes[1:]
    section = axes.root + 0.6 * axes.length * axes.axes[0] + beside
    moved = bent(section, axes, RATES)
    before = np.linalg.norm(section[:, None] - section[None], axis=-1)
    after = np.linalg.norm(moved[:, None] - moved[None], axis=-1)
    np.testing.assert_allclose(after, before, atol=1e-12)
