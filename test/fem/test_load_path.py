# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which way a branched body goes: along what carries the rest."""

from diffcal_ros.fem.body_axes import body_axes, BodyAxes
from diffcal_ros.fem.load_path import load_path, LoadPath
from diffcal_ros.rigid_transform import apply, rotation_matrix, transform
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
import pytest
from support.beams import beam_mesh, held_end

CLAMP = 0.02
TURN = transform(rotation_matrix(np.array([0.4, -0.7, 0.9])), np.array([0.3, -0.2, 1.1]))
SPINE = np.array([1.0, 0.0, 0.0])


def _of(cells: tuple[int, int, int], size: tuple[float, float, float], keep) -> TetMesh:
    """Return a block of which only the elements are kept whose middles are within a shape."""
    block = beam_mesh(cells, size)
    tets = block.tets[keep(block.rest_positions[block.tets].mean(axis=1))]
    nodes, own = np.unique(tets, return_inverse=True)
    return TetMesh(block.rest_positions[nodes], own.reshape(tets.shape).astype(np.int32))


def _comb() -> TetMesh:
    """Return a spine along x, and teeth on one of its sides, longer towards its end."""

    def keep(middles: np.ndarray) -> np.ndarray:
        x, y, _ = middles.T
        is_tooth = (x > 0.04) & ((x - 0.04) % 0.02 < 0.01) & (y < 0.01 + 0.5 * (x - 0.04))
        return (y < 0.01) | is_tooth

    return _of((28, 12, 2), (0.14, 0.06, 0.01), keep)


def _fork() -> TetMesh:
    """Return a stem that parts in a long prong on one side and a short one on the other."""

    def keep(middles: np.ndarray) -> np.ndarray:
        x, y, _ = middles.T
        is_stem, is_bridge = (y > 0.02) & (y < 0.03) & (x < 0.05), (x > 0.05) & (x < 0.06)
        return is_stem | is_bridge | (x > 0.05) & ((y > 0.04) | (y < 0.01) & (x < 0.09))

    return _of((28, 10, 2), (0.14, 0.05, 0.01), keep)


def _path(mesh: TetMesh) -> LoadPath | None:
    return load_path(mesh, held_end(mesh, CLAMP + 1e-6).astype(np.int32))


def _axes(mesh: TetMesh, *, by_spread: bool = False) -> BodyAxes:
    held = held_end(mesh, CLAMP + 1e-6).astype(np.int32)
    return body_axes(mesh.rest_positions, held, mesh=None if by_spread else mesh)


def _degrees(way: np.ndarray) -> float:
    return float(np.rad2deg(np.arccos(np.clip(way @ SPINE, -1.0, 1.0))))


@pytest.mark.parametrize('layers', [9, 18, 36])
def test_a_bars_load_grows_to_the_clamp(layers):
    """What a section carries is what is beyond it: its square has its middle at a quarter."""
    path = _path(beam_mesh((layers, 3, 2), (0.18, 0.02, 0.012)))
    assert _degrees(path.way) < 0.01
    # Elements of constant flux: off by the square of their length.
    expected = CLAMP + 0.25 * 0.16
    assert path.middle[0] == pytest.approx(expected, abs=0.04 / layers**2)
    np.testing.assert_allclose(path.middle[1:], [0.01, 0.006], atol=1e-6)


@pytest.mark.parametrize(('mesh', 'most'), [(_comb(), 6.0), (_fork(), 6.0)])
def test_a_branched_body_goes_along_what_carries_the_rest(mesh, most):
    spread, found = _axes(mesh, by_spread=True), _axes(mesh)
    assert found.line is None
    assert _degrees(spread.axes[0]) > 1.5 * most
    assert _degrees(found.axes[0]) < most
    # And begins at the clamp, within the spine.
    held = mesh.rest_positions[held_end(mesh, CLAMP + 1e-6)]
    low, high = held.min(axis=0), held.max(axis=0)
    assert np.all((found.root > low - 2e-3) & (found.root < high + 2e-3))
    assert np.any((spread.root < low - 2e-3) | (spread.root > high + 2e-3))


def test_axes_are_a_frame_and_turn_with_the_body():
    mesh = _comb()
    turned = TetMesh(apply(TURN, mesh.rest_positions), mesh.tets)
    held = held_end(mesh, CLAMP + 1e-6).astype(np.int32)
    here, there = (body_axes(own.rest_positions, held, mesh=own) for own in (mesh, turned))
    np.testing.assert_allclose(here.axes @ here.axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(here.axes) == pytest.approx(1.0)
    placed = here.placed(TURN)
    np.testing.assert_allclose(np.abs(np.sum(placed.axes * there.axes, axis=1)), 1.0, atol=1e-9)
    np.testing.assert_allclose(placed.root, there.root, atol=1e-9)
    assert placed.length == pytest.approx(there.length)


def test_what_has_no_way_has_none():
    bar = beam_mesh((16, 3, 2), (0.18, 0.02, 0.012))
    amid = np.flatnonzero(np.abs(bar.rest_positions[:, 0] - 0.09) < 0.02).astype(np.int32)
    assert load_path(bar, amid) is None, 'as much to either side'


def test_a_straight_body_goes_where_it_did():
    bar = beam_mesh((16, 3, 2), (0.18, 0.02, 0.012))
    spread, found = _axes(bar, by_spread=True), _axes(bar)
    np.testing.assert_array_equal(spread.axes, found.axes)
    np.testing.assert_array_equal(spread.root, found.root)
