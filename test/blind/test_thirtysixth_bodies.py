# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bodies of the thirty-sixth set: their shapes, meshes and stiffness."""

from itertools import pairwise

import numpy as np
import pytest
from support.blind_rigs import largest_move, level_rig

from benchmarks.blind.further_bodies import FURTHER_FAMILIES
from benchmarks.blind.hexahedra import integrate, mesh_hexahedra
from benchmarks.blind.later_bodies import LATER_FAMILIES, NEW_FAMILIES
from benchmarks.blind.later_shape import LaterShape
from benchmarks.blind.other_bodies import draw_other_shape, OTHER_FAMILIES, OtherShape
from benchmarks.blind.shapes import FAMILIES
from benchmarks.blind.tetrahedra import mesh_tetrahedra


def _drawn(family: str, seed: int = 3) -> OtherShape:
    return draw_other_shape(family, np.random.default_rng(seed), LATER_FAMILIES)


def _later(family: str) -> LaterShape:
    shape = _drawn(family)
    assert isinstance(shape, LaterShape)
    return shape


@pytest.fixture(params=sorted(NEW_FAMILIES))
def shape(request: pytest.FixtureRequest) -> LaterShape:
    return _later(request.param)


def _way(shape: OtherShape, x: float, y: float = 0.0) -> np.ndarray:
    """Return where a line along x points at a place [m] of the lattice, shape (3,)."""
    ends = shape.place(np.array([[x - 1e-4, y, 0.0], [x, y, 0.0]]))
    return np.diff(ends, axis=0)[0] / 1e-4


def test_new_families_are_none_of_before_and_others_are_drawn_anew() -> None:
    before = {*FAMILIES, *OTHER_FAMILIES, *FURTHER_FAMILIES}
    assert len(NEW_FAMILIES) == 6
    assert not set(NEW_FAMILIES) & before
    assert set(LATER_FAMILIES) - set(NEW_FAMILIES) == {'elbow', 'ribbon', 'crank', 'horseshoe'}
    for family, kind in {**OTHER_FAMILIES, **FURTHER_FAMILIES}.items():
        assert LATER_FAMILIES.get(family) != kind


@pytest.mark.parametrize('seed', range(4))
@pytest.mark.parametrize('family', sorted(LATER_FAMILIES))
def test_bodies_have_volume_and_stay_clear_of_themselves(family: str, seed: int) -> None:
    drawn = _drawn(family, seed)
    mesh, tets = mesh_hexahedra(drawn), mesh_tetrahedra(drawn)
    volumes = integrate(mesh.nodes, mesh.cells).volumes
    assert volumes.min() > 0.1 * np.median(volumes)
    edges = tets.points[tets.tets[:, 1:]] - tets.points[tets.tets[:, :1]]
    own = np.linalg.det(edges) / 6.0
    assert own.min() > 0.1 * np.median(own)
    # Straight edges cut what is round.
    assert own.sum() == pytest.approx(volumes.sum(), rel=0.011)
    assert not drawn.touches_itself(mesh.lattice, mesh.nodes)
    assert 900 <= len(tets.tets) <= 2500
    assert 100 <= len(mesh.cells) <= 600
    least, most = LATER_FAMILIES[family].sizes
    assert 0.95 * least <= drawn.size <= 1.05 * most
    assert 0.059 <= drawn.size <= 0.301


def test_volumes_are_those_of_their_blocks(shape: LaterShape) -> None:
    mesh = mesh_hexahedra(shape)
    volume = integrate(mesh.nodes, mesh.cells).volumes.sum()
    x, y, z = (np.diff(way) for way in shape.breaks)
    blocks = float(np.einsum('ijk,i,j,k->', shape.solid.astype(float), x, y, z))
    # Arcs about the middle of a section and shears keep it; a vault draws its legs out.
    longer = {'vault': 0.2}.get(shape.family, 1e-4)
    assert (1.0 - 2e-3) * blocks <= volume <= (1.0 + longer) * blocks


def test_what_is_held_stays_and_nothing_else_lies_there(shape: LaterShape) -> None:
    mesh, tets = mesh_hexahedra(shape), mesh_tetrahedra(shape)
    held = shape.is_held(mesh.lattice)
    assert mesh.nodes[held] == pytest.approx(mesh.lattice[held], abs=1e-12)
    assert (held == shape.is_held(mesh.nodes)).all()
    assert np.flatnonzero(held).tolist() == mesh.held.tolist()
    shares = shape.arc_share(mesh.lattice)
    assert (shares[held] == 0.0).all()
    assert 0.0 <= shares.min() < shares.max() == 1.0
    assert set(tets.regions) == {0, 1}
    for box in shape.held:
        low, high = np.array(box).T
        inside = ((tets.points > low - 1e-6) & (tets.points < high + 1e-6)).all(axis=1)
        assert tets.points[inside].min(axis=0) == pytest.approx(low)
        assert tets.points[inside].max(axis=0) == pytest.approx(high)


def test_a_zigzag_turns_to_and_fro() -> None:
    shape = _later('zigzag')
    turns = [angle for _, _, angle in reversed(shape.arcs)]
    assert all(one * other < 0.0 for one, other in pairwise(turns))
    told = np.sum(turns)
    far = [np.cos(told), np.sin(told), 0.0]
    assert _way(shape, shape.length) == pytest.approx(far, abs=1e-6)


def test_a_cane_and_a_coil_come_back() -> None:
    for family in ('cane', 'coil'):
        assert _way(_later(family), _later(family).length)[0] < -0.8
    coil = _later('coil')
    begin, way = coil.rise
    points = coil.place(np.array([[begin, 0.0, 0.0], [coil.length, 0.0, 0.0]]))
    assert points[:, 2] == pytest.approx([0.0, way])
    assert abs(way) > 0.1 * coil.free


def test_arms_spread_and_are_not_alike() -> None:
    shape = _later('wye')
    _, _, aside, one, other = shape.spread
    for sign, angle in ((1.0, one), (-1.0, -other)):
        way = _way(shape, shape.breaks[0][-2], sign * aside)
        assert way == pytest.approx([np.cos(angle), np.sin(angle), 0.0], abs=1e-6)
    assert abs(one - other) > 1e-3
    nodes = mesh_hexahedra(shape).nodes
    assert nodes[:, 1].max() > shape.section[0]
    assert nodes[:, 1].min() < -shape.section[0]


def test_teeth_of_a_comb_are_not_alike() -> None:
    shape = _later('comb')
    _, half, short, long = shape.breaks[1]
    assert 0.1 * (long - half) < long - short
    teeth = shape.solid[2::2, :, 0].sum(axis=1)
    assert teeth.tolist() == [2, 3, 2, 3]


def test_a_vault_stands_on_two_feet_of_which_one_is_higher() -> None:
    shape = _later('vault')
    lower, higher = shape.held
    assert higher[0][0] > lower[0][1]
    aside, held, beam, vault = shape.feet or (0.0, 0.0, 0.0, 0.0)
    amid = shape.place(np.array([[beam, 0.0, 0.0], [beam, shape.breaks[1][-1], 0.0]]))
    assert amid[:, 0] == pytest.approx([beam + vault, beam])
    assert (higher[0][1], higher[1][0]) == pytest.approx((held, aside))
    one, other = level_rig(shape).fixtures
    assert one[0][0] < lower[0][0]
    assert one[1][0] < lower[0][1]
    assert other[0][0] < higher[0][0]
    assert other[1][0] < higher[0][1]


@pytest.mark.slow
def test_finer_elements_sag_as_far(shape: LaterShape) -> None:
    ways = [largest_move(shape, refinement) for refinement in (1.0, 1.3)]
    assert ways[0] > 1e-4 * shape.free
    assert ways[0] == pytest.approx(ways[1], rel=0.025)
