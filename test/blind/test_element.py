# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from benchmarks.blind.body import Body, make_body
from benchmarks.blind.equilibrium import find_equilibrium, Load
from benchmarks.blind.hexahedra import CORNERS, HexMesh, mesh_hexahedra, shape_functions
from benchmarks.blind.material import constants
from benchmarks.blind.shapes import Shape

MODULUS, NU, DENSITY = 1.0e5, 0.49, 1000.0
LENGTH, CLAMP, WIDTH, HEIGHT = 0.100, 0.020, 0.016, 0.018


def _beam() -> Shape:
    breaks = ((0.0, CLAMP, CLAMP + LENGTH), (-WIDTH / 2, WIDTH / 2), (-HEIGHT / 2, HEIGHT / 2))
    return Shape('beam', breaks, np.ones((2, 1, 1), dtype=bool), CLAMP)


def _body(mesh: HexMesh, modulus: float = MODULUS, nu: float = NU, yeoh: float = 0.0) -> Body:
    numbers = constants(np.full((len(mesh.cells), 8), modulus), nu, yeoh)
    return make_body(mesh.nodes, mesh.cells, mesh.held, numbers, DENSITY)


def _distorted(mesh: HexMesh, random: np.random.Generator) -> np.ndarray:
    """Move the corners of all cells at random; edges stay straight."""
    nodes = mesh.nodes.copy()
    is_corner = np.abs(CORNERS).sum(axis=1) == 3
    corners = np.unique(mesh.cells[:, is_corner])
    nodes[corners] += random.uniform(-4e-4, 4e-4, size=(len(corners), 3))
    for place, local in enumerate(CORNERS):
        if np.abs(local).sum() == 2:
            axis = np.flatnonzero(local == 0)[0]
            ends = []
            for side in (-1.0, 1.0):
                end = local.copy()
                end[axis] = side
                ends.append(int(np.flatnonzero((end == CORNERS).all(axis=1))[0]))
            nodes[mesh.cells[:, place]] = nodes[mesh.cells[:, ends]].mean(axis=1)
    return nodes


def _bent(mesh: HexMesh) -> np.ndarray:
    nodes = mesh.nodes.copy()
    nodes[:, 2] -= 2.0 * nodes[:, 0] ** 2
    return nodes


def test_shape_functions_are_nodal() -> None:
    # Rounding of a product of four factors.
    assert np.allclose(shape_functions(CORNERS), np.eye(20), atol=1e-14)


def test_patch_of_distorted_elements_bears_uniform_strain() -> None:
    random = np.random.default_rng(3)
    mesh = mesh_hexahedra(_beam(), 0.5)
    nodes = _distorted(mesh, random)
    body = make_body(
        nodes, mesh.cells, mesh.held, constants(np.full((len(mesh.cells), 8), MODULUS), NU), 1.0
    )
    F = np.eye(3) + random.uniform(-0.1, 0.1, size=(3, 3))
    forces = np.abs(body.evaluate(nodes @ F.T, with_stiffness=False).gradient).max(axis=1)
    is_inner = (np.abs(mesh.lattice[:, 1]) < 0.4 * WIDTH) & (
        np.abs(mesh.lattice[:, 2]) < 0.4 * HEIGHT
    )
    is_inner &= (mesh.lattice[:, 0] > 1e-4) & (mesh.lattice[:, 0] < CLAMP + LENGTH - 1e-4)
    assert is_inner.sum() >= 9
    # Exact integration of straight-edged elements: only rounding is left.
    assert forces[is_inner].max() < 1e-11 * forces.max()


def test_gradient_is_the_slope_of_the_energy() -> None:
    mesh = mesh_hexahedra(_beam(), 0.6)
    body, positions = _body(mesh, yeoh=3.0), _bent(mesh)
    direction = np.random.default_rng(1).standard_normal(positions.shape)
    step = 1e-8
    energies = [
        body.evaluate(positions + sign * step * direction, with_stiffness=False).energy
        for sign in (-1, 1)
    ]
    slope = float((body.evaluate(positions).gradient * direction).sum())
    # Central differences at this step: 1e-9 of truncation, 1e-7 of rounding.
    assert (energies[1] - energies[0]) / (2 * step) == pytest.approx(slope, rel=1e-6)


def test_stiffness_is_the_slope_of_the_gradient() -> None:
    mesh = mesh_hexahedra(_beam(), 0.6)
    body, positions = _body(mesh, yeoh=3.0), _bent(mesh)
    direction = np.random.default_rng(2).standard_normal(positions.shape)
    step = 1e-8
    low, high = (
        body.evaluate(positions + sign * step * direction, with_stiffness=False).gradient
        for sign in (-1, 1)
    )
    blocks = body.evaluate(positions).blocks
    assert blocks is not None
    forces = np.einsum('cij,cj->ci', blocks, direction[mesh.cells].reshape(-1, 60))
    product = np.zeros(positions.shape)
    np.add.at(product, mesh.cells, forces.reshape(-1, 20, 3))
    difference = (high - low) / (2 * step)
    assert np.abs(difference - product).max() < 1e-6 * np.abs(product).max()


def _sag(refinement: float, nu: float = NU, modulus: float = MODULUS) -> float:
    mesh = mesh_hexahedra(_beam(), refinement)
    body = _body(mesh, modulus, nu)
    rest = find_equilibrium(body, Load(body.masses[:, None] * [0.0, 0.0, -9.81]), mesh.nodes)
    tip = mesh.lattice[:, 0] > CLAMP + LENGTH - 1e-6
    return float((mesh.nodes - rest)[tip, 2].mean())


def test_stiff_beam_sags_as_timoshenko_says() -> None:
    modulus = 100 * MODULUS
    load = DENSITY * 9.81 * WIDTH * HEIGHT
    bending = load * LENGTH**4 * 12.0 / (8.0 * modulus * WIDTH * HEIGHT**3)
    shear = load * LENGTH**2 / (2.0 * (5.0 / 6.0) * modulus / 2.0 * WIDTH * HEIGHT)
    # Without lateral strain the clamp only hinders warping of the section at the root.
    assert _sag(1.0, nu=0.0, modulus=modulus) == pytest.approx(bending + shear, rel=0.005)


@pytest.mark.slow
def test_sag_converges_and_does_not_lock() -> None:
    coarse, usual, fine = (_sag(refinement) for refinement in (0.5, 1.0, 1.5))
    # What the usual mesh costs: 0.3 % of the sag, less than 1 % of E.
    assert usual == pytest.approx(fine, rel=0.004)
    assert abs(usual - fine) < abs(coarse - fine)
    # Locking would make the nearly incompressible beam stiffer by tens of percent.
    assert usual == pytest.approx(_sag(1.0, nu=0.3), rel=0.05)
