# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bodies of the thirty-fifth set: their shapes, meshes and stiffness."""

from itertools import pairwise

import numpy as np
import pytest
from support.blind_rigs import largest_move, level_rig

from benchmarks.blind.further_bodies import FURTHER_FAMILIES
from benchmarks.blind.further_shape import FurtherShape
from benchmarks.blind.hexahedra import integrate, mesh_hexahedra
from benchmarks.blind.other_bodies import draw_other_shape, OTHER_FAMILIES
from benchmarks.blind.shapes import FAMILIES
from benchmarks.blind.tetrahedra import mesh_tetrahedra

_BENT = ('horseshoe', 'ribbon', 'crescent', 'twisted')  # Of a bar, whose volume they keep.
_BLOCKS = ('bellows', 'fork', 'cross', 'crank')  # As they are in the lattice.


def _drawn(family: str, seed: int = 3) -> FurtherShape:
    shape = draw_other_shape(family, np.random.default_rng(seed), FURTHER_FAMILIES)
    assert isinstance(shape, FurtherShape)
    return shape


@pytest.fixture(params=sorted(FURTHER_FAMILIES))
def shape(request: pytest.FixtureRequest) -> FurtherShape:
    return _drawn(request.param)


def _block_volume(shape: FurtherShape) -> float:
    """Return the volume of all blocks of a lattice [m^3]."""
    x, y, z = (np.diff(way) for way in shape.breaks)
    return float(np.einsum('ijk,i,j,k->', shape.solid.astype(float), x, y, z))


def _volumes(shape: FurtherShape) -> np.ndarray:
    mesh = mesh_tetrahedra(shape)
    edges = mesh.points[mesh.tets[:, 1:]] - mesh.points[mesh.tets[:, :1]]
    return np.linalg.det(edges) / 6.0


def test_no_family_is_one_of_before() -> None:
    assert len(FURTHER_FAMILIES) == 11
    assert not set(FURTHER_FAMILIES) & {*FAMILIES, *OTHER_FAMILIES}


@pytest.mark.parametrize('seed', range(4))
def test_bodies_have_volume_and_stay_clear_of_themselves(shape: FurtherShape, seed: int) -> None:
    drawn = _drawn(shape.family, seed)
    mesh, tets = mesh_hexahedra(drawn), mesh_tetrahedra(drawn)
    volumes = integrate(mesh.nodes, mesh.cells).volumes
    assert volumes.min() > 0.1 * np.median(volumes)
    own = _volumes(drawn)
    assert own.min() > 0.1 * np.median(own)
    # Straight edges cut what is round.
    assert own.sum() == pytest.approx(volumes.sum(), rel=0.011)
    assert not drawn.touches_itself(mesh.lattice, mesh.nodes)
    assert 900 <= len(tets.tets) <= 2500
    assert 100 <= len(mesh.cells) <= 600
    assert 0.049 <= drawn.size <= 0.301


def test_what_is_folded_over_itself_touches() -> None:
    shape = _drawn('horseshoe')
    mesh = mesh_hexahedra(shape)
    folded = mesh.nodes.copy()
    folded[:, 1] = np.minimum(folded[:, 1], 0.5 * shape.size - folded[:, 1])
    assert shape.touches_itself(mesh.lattice, folded)


def test_volumes_are_those_of_their_measures(shape: FurtherShape) -> None:
    mesh = mesh_hexahedra(shape)
    volume = integrate(mesh.nodes, mesh.cells).volumes.sum()
    blocks = _block_volume(shape)
    # An arc about the middle of a section and a twist keep a volume, what is lacking is known.
    taper = shape.taper[1]
    kept = {
        'wedge': (shape.clamp + shape.free * (1.0 - 0.5 * taper)) / shape.length,
        'tentacle': (shape.clamp + shape.free * (1.0 - taper + taper**2 / 3.0)) / shape.length,
        'ring': 1.0,
    }
    # A round section lacks up to a tenth, rounded corners of a square no more than a fifth.
    lacks = {'tentacle': 0.15, 'ring': 0.2}.get(shape.family, 2e-4)
    whole = blocks * kept.get(shape.family, 1.0)
    assert (1.0 - lacks) * whole <= volume <= whole * (1.0 + 1e-4)
    assert {*_BENT, *_BLOCKS, *kept} == set(FURTHER_FAMILIES)


def test_bodies_have_no_plane_of_symmetry_across_their_arms() -> None:
    fork, cross, crescent, ribbon = (
        _drawn(family) for family in ('fork', 'cross', 'crescent', 'ribbon')
    )
    broad, gap, narrow = np.diff(fork.breaks[1])
    assert min(broad - narrow, narrow - 0.5 * gap) > 0.0
    nodes = mesh_hexahedra(fork).nodes
    aside = nodes[:, 1] > fork.breaks[1][2] - 1e-9
    assert nodes[aside, 0].max() < 0.9 * nodes[~aside, 0].max()
    arms = sorted([-cross.breaks[0][0], np.diff(cross.breaks[0])[-1], *np.diff(cross.breaks[1])])
    assert min(b - a for a, b in pairwise(arms)) > 0.0
    assert crescent.arcs[0][1] - crescent.clamp > 1.05 * -crescent.breaks[0][0]
    inner, outer = ribbon.arcs[1][2], ribbon.arcs[0][2]
    assert inner * outer < 0.0
    assert abs(inner + outer) > 1e-3


def test_a_twist_and_arcs_leave_what_is_held(shape: FurtherShape) -> None:
    mesh, tets = mesh_hexahedra(shape), mesh_tetrahedra(shape)
    held = shape.is_held(mesh.lattice)
    assert mesh.nodes[held] == pytest.approx(mesh.lattice[held], abs=1e-12)
    # Nothing else lies there, wherever a body was bent to.
    assert (held == shape.is_held(mesh.nodes)).all()
    assert np.flatnonzero(held).tolist() == mesh.held.tolist()
    assert (shape.arc_share(mesh.lattice[mesh.held]) == 0.0).all()
    assert set(tets.regions) == {0, 1}
    (box,) = shape.held
    low, high = np.array(box).T
    inside = ((tets.points > low - 1e-6) & (tets.points < high + 1e-6)).all(axis=1)
    assert tets.points[inside].min(axis=0) == pytest.approx(low)
    assert tets.points[inside].max(axis=0) == pytest.approx(high)


def test_arcs_turn_the_far_end() -> None:
    for family in ('horseshoe', 'crescent'):
        shape = _drawn(family)
        ahead = np.array([[shape.length - 1e-3, 0.0, 0.0], [shape.length, 0.0, 0.0]])
        way = np.diff(shape.place(ahead), axis=0)[0] / 1e-3
        angle = shape.arcs[0][2]
        # The last millimetre is an arc itself.
        assert way == pytest.approx([np.cos(angle), np.sin(angle), 0.0], abs=0.03)
    shape = _drawn('crescent')
    begin = shape.breaks[0][0]
    behind = np.array([[begin + 1e-3, 0.0, 0.0], [begin, 0.0, 0.0]])
    way = np.diff(shape.place(behind), axis=0)[0] / 1e-3
    angle = shape.back_arcs[0][2]
    assert way == pytest.approx([-np.cos(angle), np.sin(angle), 0.0], abs=0.03)
    twisted = _drawn('twisted')
    aside = np.array([twisted.length, 0.01, 0.0])
    turned = [0.01 * np.cos(twisted.twist), 0.01 * np.sin(twisted.twist)]
    assert twisted.place(aside)[1:] == pytest.approx(turned)


def test_a_disc_is_round_and_its_hole_is_open() -> None:
    shape = _drawn('ring')
    nodes = mesh_hexahedra(shape).nodes
    begin, half, _ = shape.disc
    far = np.linalg.norm(nodes[:, :2] - [begin + half, 0.0], axis=1)
    assert far.min() > 0.4 * half
    assert far[nodes[:, 0] > begin + half].max() < 1.1 * half


def test_the_block_around_a_clamp_ends_where_the_body_goes_on() -> None:
    for family, ways in (('cross', (0, 1)), ('crescent', (0,))):
        setup = level_rig(_drawn(family))
        (low, high), (box,) = setup.fixtures[0], setup.body.held
        held_low, held_high = np.array(box).T
        inside = (low > held_low) & (high < held_high)
        assert np.flatnonzero(inside).tolist() == list(ways)
        around = (low < held_low) & (high > held_high)
        assert (inside ^ around).all()


@pytest.mark.slow
def test_finer_elements_sag_as_far(shape: FurtherShape) -> None:
    ways = [largest_move(shape, refinement) for refinement in (1.0, 1.3)]
    assert ways[0] > 1e-4 * shape.free
    assert ways[0] == pytest.approx(ways[1], rel=0.025)
