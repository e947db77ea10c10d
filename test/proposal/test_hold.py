# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Ends at which a body may be held."""

from diffcal_ros.proposal.hold import Hold, possible_holds
from diffcal_ros.rigid_transform import rotation_matrix
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
import pytest


def test_a_beam_may_be_held_at_both_ends_of_its_length(make_beam):
    mesh = make_beam((10, 2, 2), (0.2, 0.03, 0.02))
    upper, lower = possible_holds(mesh)
    assert upper.direction.tolist() == [1.0, 0.0, 0.0]
    assert (lower.direction == -upper.direction).all()
    assert upper.plane == lower.plane == pytest.approx(0.07)
    assert mesh.rest_positions[upper.vertices(mesh), 0].min() == pytest.approx(0.08)
    assert mesh.rest_positions[lower.vertices(mesh), 0].max() == pytest.approx(-0.08)
    assert upper.axis == lower.axis == 0


def test_a_cube_may_be_held_anywhere(make_beam):
    assert len(possible_holds(make_beam((2, 2, 2), (0.05, 0.05, 0.05)))) == 6


def test_an_oblique_body_is_held_along_its_own_axis(make_beam):
    turn = rotation_matrix(np.deg2rad([0.0, 0.0, 35.0]))
    straight = make_beam((10, 2, 2), (0.2, 0.03, 0.02))
    mesh = TetMesh(straight.rest_positions @ turn.T, straight.tets)
    holds = possible_holds(mesh)
    assert len(holds) == 2
    assert np.abs(holds[0].direction @ turn[:, 0]) == pytest.approx(1.0, abs=1e-3)
    assert holds[0].axis is None


def test_the_plane_goes_on_until_enough_is_held(make_beam):
    mesh = make_beam((2, 1, 1), (0.2, 0.03, 0.02))
    assert len(possible_holds(mesh)[0].vertices(mesh)) == 4


def test_a_hold_is_moved_along_itself(make_beam):
    mesh = make_beam((10, 2, 2), (0.2, 0.03, 0.02))
    hold = Hold(np.array([-1.0, 0.0, 0.0]), 0.07).moved(0.05)
    # Vertices on the plane are held, too.
    assert np.unique(mesh.rest_positions[hold.vertices(mesh), 0]) == pytest.approx(
        [-0.1, -0.08, -0.06]
    )


@pytest.mark.parametrize(('plane', 'doubt', 'held'), [(0.0808, 0.001, 0.08), (0.074, 0.007, 0.08)])
def test_a_plane_is_moved_to_a_row_that_is_near_enough(make_beam, plane, doubt, held):
    mesh = make_beam((10, 2, 2), (0.2, 0.03, 0.02))
    hold = Hold(np.array([1.0, 0.0, 0.0]), plane).at_row(mesh, doubt)
    assert hold.plane == pytest.approx(held)
    assert mesh.rest_positions[hold.vertices(mesh), 0].min() == pytest.approx(held)


def test_a_plane_far_from_rows_stays(make_beam, random):
    mesh = make_beam((10, 2, 2), (0.2, 0.03, 0.02))
    hold = Hold(np.array([1.0, 0.0, 0.0]), 0.07)
    assert hold.at_row(mesh, 0.003).plane == 0.07
    # Nor is a body without rows given one.
    bent = mesh.rest_positions + random.normal(0.0, 0.002, mesh.rest_positions.shape)
    assert hold.at_row(TetMesh(bent, mesh.tets), 0.02).plane == 0.07
