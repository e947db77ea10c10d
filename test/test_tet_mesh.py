# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
from diffcal_ros.tet_mesh import mesh_problems, TetMesh
import numpy as np
import pytest
from support.beams import beam_mesh


def test_surface_is_closed_and_encloses_the_volume() -> None:
    mesh = beam_mesh((3, 2, 1), (0.09, 0.04, 0.02))
    corners = mesh.rest_positions[mesh.surface_triangles]
    # Divergence theorem: outward normals give the volume with a plus.
    volume = np.linalg.det(corners).sum() / 6.0
    np.testing.assert_allclose(volume, 0.09 * 0.04 * 0.02)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    np.testing.assert_allclose(normals.sum(axis=0), 0.0, atol=1e-12)


def test_refinement_keeps_volume_boundary_and_orientation() -> None:
    mesh = beam_mesh((2, 1, 1), (0.05, 0.03, 0.02))
    finer, parents = mesh.refined()
    assert finer.tet_count == 8 * mesh.tet_count
    assert (finer.volumes > 0.0).all()
    np.testing.assert_allclose(
        np.bincount(parents, finer.volumes), mesh.volumes, rtol=1e-12, err_msg='volume of a parent'
    )
    assert len(finer.surface_triangles) == 4 * len(mesh.surface_triangles)
    np.testing.assert_array_equal(finer.extent, mesh.extent)
    assert mesh_problems(finer) == []


def test_edges_are_unique_and_belong_to_their_tetrahedra() -> None:
    mesh = beam_mesh((2, 2, 1))
    edges, sides = mesh.edges
    assert len(np.unique(edges, axis=0)) == len(edges)
    # Euler's formula for a ball: V - E + F - T = 1.
    face_count = (4 * mesh.tet_count + len(mesh.surface_triangles)) // 2
    assert mesh.vertex_count - len(edges) + face_count - mesh.tet_count == 1
    ends = set(map(tuple, np.sort(mesh.tets[:, [1, 2]], axis=1)))
    assert ends == {tuple(edges[side]) for side in sides[:, 1]}


@pytest.mark.parametrize(
    ('spoil', 'message'),
    [
        (lambda p, t: (p, t[:, [1, 0, 2, 3]]), 'inverted'),
        (lambda p, t: (p * [1.0, 1.0, 0.0], t), 'degenerate'),
        (lambda p, t: (p, np.vstack([t, t[:2]])), '2 tetrahedra are duplicates'),
        (lambda p, t: (np.vstack([p, [[0.0, 0.0, 0.0]]]), t), '1 vertices belong to no'),
        (lambda p, t: (p * 200.0, t), 'the body is 24 m long'),
        (lambda p, t: (np.where(p == p.max(), np.nan, p), t), 'NaN'),
        (lambda p, t: (p, t + 1), '0-based'),
        (lambda p, t: (p, t[:0]), 'no tetrahedra'),
    ],
)
def test_names_what_is_wrong_with_a_mesh(spoil, message: str) -> None:
    mesh = beam_mesh()
    positions, tets = spoil(mesh.rest_positions, mesh.tets)
    problems = mesh_problems(TetMesh(positions, tets.astype(np.int32)))
    assert any(message in problem for problem in problems), problems
