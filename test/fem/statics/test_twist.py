# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Half a turn of one end from rest, for bodies on which an unguarded path would fail."""

from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.material import Material
from diffcal_ros.rigid_transform import rotation_matrix
import numpy as np
import pytest
from support.beams import beam_mesh

GRAVITY = np.array([0.0, 9.8, 0.3])
SIZE = (0.2, 0.04, 0.04)
# Central differences of whole new twists: the error of the solves, 1e-7 of the load, over 1e-3.
_GRADIENT_TOLERANCE = 1e-4
# Each node may keep 1e-7 of the mean load; the clamp carries the whole weight.
_FORCE_SHARE = 1e-5


class Twist:
    """A beam clamped at both ends, one of which turns about the beam's axis."""

    def __init__(self, element: Element) -> None:
        self.mesh = beam_mesh((8, 2, 2), SIZE)
        x = self.mesh.rest_positions[:, 0]
        held = np.flatnonzero((x < 1e-9) | (x > SIZE[0] - 1e-9)).astype(np.int32)
        self._rest = self.mesh.rest_positions[held]
        self._turning = self._rest[:, 0] < 1e-9
        self.body = StaticBody(self.mesh, element, held)

    def path(self, fraction: float) -> np.ndarray:
        targets = self._rest.copy()
        middle = self._rest[self._turning].mean(axis=0)
        turn = rotation_matrix(np.array([fraction * np.pi, 0.0, 0.0]))
        targets[self._turning] = middle + (self._rest[self._turning] - middle) @ turn.T
        return targets

    def material(self, modulus: float, contrast: float) -> Material:
        """The turning half is stiffer than the other by the contrast."""
        ones = np.ones(self.mesh.tet_count)
        share = np.where(self.mesh.centroids[:, 0] < 0.5 * SIZE[0], contrast, 1.0)
        return Material(modulus * share, 0.49 * ones, 1080.0 * ones)

    def solve_equilibrium(self, modulus: float, contrast: float) -> np.ndarray:
        self.body.forget()
        state = self.body.solve_equilibrium(
            self.material(modulus, contrast), GRAVITY, held_path=self.path
        )
        return state.positions


@pytest.mark.parametrize('element', list(Element))
@pytest.mark.parametrize(('modulus', 'contrast'), [(5e5, 4.0), (5e7, 0.1), (5e7, 4.0)])
def test_rounding_of_a_stiff_bodys_energy_does_not_stop_it(element, modulus, contrast) -> None:
    twist = Twist(element)
    positions = twist.solve_equilibrium(modulus, contrast)
    held = twist.body.held_nodes
    np.testing.assert_allclose(
        positions[held], twist.body.held.spread(twist.path(1.0)), atol=1e-12
    )


@pytest.mark.slow
def test_a_soft_half_takes_the_turn_in_steps_where_linear_elements_mislead() -> None:
    twist = Twist(Element.QUADRATIC)
    twist.solve_equilibrium(5e3, 0.1)
    weight = 1080.0 * twist.mesh.volumes.sum() * GRAVITY
    np.testing.assert_allclose(
        twist.body.state.reactions.sum(axis=0), -weight, atol=_FORCE_SHARE * np.abs(weight).max()
    )


def test_the_gradient_of_the_last_equilibrium_is_that_of_the_whole_twist() -> None:
    twist, step = Twist(Element.LINEAR), 1e-3
    twist.solve_equilibrium(3e4, 2.0)
    change = Change(youngs_modulus=twist.material(3e4, 2.0).youngs_modulus)
    (tangent,) = twist.body.tangents([change])
    ends = [twist.solve_equilibrium(3e4 * np.exp(sign * step), 2.0) for sign in (1.0, -1.0)]
    difference = (ends[0] - ends[1]) / (2.0 * step)
    error = np.linalg.norm(difference - tangent) / np.linalg.norm(tangent)
    assert error < _GRADIENT_TOLERANCE
