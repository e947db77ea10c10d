# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Both meshes of a body are sound and have one outline."""

from diffcal_ros.depth.surface_edges import surface_edges
from diffcal_ros.tet_mesh import mesh_problems
import numpy as np
import pytest

from benchmarks.blind.hexahedra import integrate
from benchmarks.zoo.bodies import BODIES
from benchmarks.zoo.meshes import fit_mesh, held_vertices, true_mesh
from benchmarks.zoo.truth import body_surface

_VOLUMES = 1e-9  # All faces are plane, so that only rounding is left.

bodies = pytest.mark.parametrize('name', list(BODIES))


@bodies
def test_fit_mesh_is_sound_and_of_a_size_that_fits_quickly(name: str) -> None:
    solid = BODIES[name]()
    mesh = fit_mesh(solid)
    assert mesh_problems(mesh) == []
    assert 700 <= mesh.tet_count <= 2000
    assert 12 <= len(held_vertices(solid, mesh)) < 0.5 * mesh.vertex_count


@bodies
def test_surfaces_are_closed(name: str) -> None:
    solid = BODIES[name]()
    hexahedra = true_mesh(solid)
    for triangles in (
        fit_mesh(solid).surface_triangles,
        body_surface(hexahedra, hexahedra.nodes)[1],
    ):
        _, faces = surface_edges(triangles)
        assert (faces >= 0).all()


@bodies
def test_both_meshes_and_the_drawn_surface_have_one_volume(name: str) -> None:
    solid = BODIES[name]()
    hexahedra = true_mesh(solid)
    volume = fit_mesh(solid).volumes.sum()
    true = integrate(hexahedra.nodes, hexahedra.cells).volumes
    points, triangles = body_surface(hexahedra, hexahedra.nodes)
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    assert true.min() > 0.0
    assert true.sum() == pytest.approx(volume, rel=_VOLUMES)
    # Outward triangles: the volume that they enclose is positive.
    enclosed = float((a * np.cross(b, c)).sum()) / 6.0
    assert enclosed == pytest.approx(volume, rel=1e-6)


def test_cells_of_the_truth_are_cut_elsewhere() -> None:
    solid = BODIES['notched_finger']()
    own = np.unique(fit_mesh(solid).rest_positions[:, 0].round(9))
    # Mid-edge nodes of a hexahedron are no faces of it.
    hexahedra = true_mesh(solid)
    other = np.unique(hexahedra.nodes[hexahedra.cells[:, [0, -1]], 0].round(9))
    assert len(np.setdiff1d(own, other)) > 0
    assert len(other) > len(own)


def test_a_scaled_body_has_its_proportions() -> None:
    solid = BODIES['tube']()
    ratio = fit_mesh(solid.scaled(1.1)).volumes.sum() / fit_mesh(solid).volumes.sum()
    assert ratio == pytest.approx(1.1**3)
