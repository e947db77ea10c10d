# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The roughness of fields, and grids that carry them."""

from diffcal_ros.calibration.field.layout import FieldKind, tets_from_unknowns
from diffcal_ros.calibration.field.smoothness import face_roughness, inner_faces, Smoothness
from diffcal_ros.errors import InputError
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
import pytest
from support.beams import beam_mesh

SIZE = (0.12, 0.03, 0.02)


@pytest.fixture
def mesh() -> TetMesh:
    return beam_mesh((8, 3, 2), SIZE)


def _halves(mesh: TetMesh) -> list[np.ndarray]:
    is_low = mesh.centroids[:, 0] < 0.5 * SIZE[0]
    return [np.flatnonzero(is_low), np.flatnonzero(~is_low)]


def test_inner_faces_belong_to_two_tetrahedra(mesh: TetMesh) -> None:
    first, second, faces = inner_faces(mesh)
    assert 4 * mesh.tet_count == 2 * len(faces) + len(mesh.surface_triangles)
    for a, b, face in zip(first, second, faces, strict=True):
        assert set(face) == set(mesh.tets[a]) & set(mesh.tets[b])


def test_a_constant_has_no_roughness(mesh: TetMesh, random) -> None:
    form = face_roughness(mesh)
    assert np.abs(form @ np.ones(mesh.tet_count)).max() < 1e-10
    assert random.normal(size=mesh.tet_count) @ form @ random.normal(size=mesh.tet_count) != 0.0


def test_roughness_counts_a_jump_by_its_area() -> None:
    # Of the same beam cut finer, the jump's faces have the same area and lie half as far apart.
    rough = []
    for counts in ((8, 3, 2), (16, 6, 4)):
        mesh = beam_mesh(counts, SIZE)
        jump = np.where(mesh.centroids[:, 0] < 0.5 * SIZE[0], -0.5, 0.5)
        rough.append(float(jump @ face_roughness(mesh) @ jump))
    assert rough[1] / rough[0] == pytest.approx(2.0, rel=1e-9)


def test_roughness_does_not_depend_on_the_unit(mesh: TetMesh) -> None:
    field = mesh.centroids[:, 0] / SIZE[0]
    larger = TetMesh(7.0 * mesh.rest_positions, mesh.tets)
    assert float(field @ face_roughness(larger) @ field) == pytest.approx(
        float(field @ face_roughness(mesh) @ field), rel=1e-12
    )


@pytest.mark.parametrize('spacing', [None, 0.02], ids=['tets', 'grid'])
def test_solve_undoes_apply(mesh: TetMesh, spacing, random) -> None:
    spread = tets_from_unknowns(mesh, FieldKind(spacing))
    smoothness = Smoothness(mesh, spread, _halves(mesh))
    unknowns = random.normal(size=(spread.shape[1], 3))
    back = smoothness.solve(np.stack([smoothness.apply(u) for u in unknowns.T], axis=1))
    # The means weigh a million times what settles a constant.
    np.testing.assert_allclose(back, unknowns, atol=1e-6)
    assert smoothness.roughness(unknowns[:, 0]) > 0.0


def test_what_is_asked_for_keeps_no_mean_where_moduli_are_fitted(mesh: TetMesh, random) -> None:
    spread = tets_from_unknowns(mesh, FieldKind())
    smoothness = Smoothness(mesh, spread, _halves(mesh))
    field = smoothness.solve(random.normal(size=mesh.tet_count))
    for tets in _halves(mesh):
        mean = np.average(field[tets], weights=mesh.volumes[tets])
        # A mean weighs a thousand times what a field of its size costs at the least.
        assert abs(mean) < 1e-2 * np.abs(field).max()


def test_variances_are_the_diagonal_of_the_inverse(mesh: TetMesh) -> None:
    spread = tets_from_unknowns(mesh, FieldKind(0.03))
    smoothness = Smoothness(mesh, spread)
    inverse = smoothness.solve(spread.T.toarray())
    np.testing.assert_allclose(smoothness.variances(), np.diag(spread @ inverse), rtol=1e-9)


def test_a_grid_carries_what_is_linear(mesh: TetMesh) -> None:
    spread = tets_from_unknowns(mesh, FieldKind(0.015))
    assert spread.shape[1] < mesh.tet_count
    np.testing.assert_allclose(spread.sum(axis=1), 1.0)
    wanted = mesh.centroids @ np.array([3.0, -2.0, 5.0])
    carried = spread @ np.linalg.lstsq(spread.toarray(), wanted, rcond=None)[0]
    np.testing.assert_allclose(carried, wanted, atol=1e-9)


@pytest.mark.parametrize('spacing', [0.0, -0.01, 0.5])
def test_a_grid_that_is_too_coarse_is_refused(mesh: TetMesh, spacing: float) -> None:
    with pytest.raises(InputError, match='control grid has a spacing'):
        tets_from_unknowns(mesh, FieldKind(spacing))
