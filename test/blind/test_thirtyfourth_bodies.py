# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bodies of other kinds than bars with one clamp: their shapes, meshes and stiffness."""

import numpy as np
import pytest
from support.blind_rigs import largest_move, level_rig

from benchmarks.blind.hexahedra import integrate, mesh_hexahedra
from benchmarks.blind.other_bodies import (
    bent_elbow,
    draw_other_shape,
    OTHER_FAMILIES,
    OtherShape,
)
from benchmarks.blind.tetrahedra import mesh_tetrahedra, TetMesh

_FINE = ('sheet', 'window', 'hand', 'slotted')  # Of so many elements that it takes seconds.


@pytest.fixture(params=sorted(OTHER_FAMILIES))
def shape(request: pytest.FixtureRequest) -> OtherShape:
    return draw_other_shape(request.param, np.random.default_rng(3))


def _volumes(mesh: TetMesh) -> np.ndarray:
    return np.linalg.det(mesh.points[mesh.tets[:, 1:]] - mesh.points[mesh.tets[:, :1]]) / 6.0


def _closed_volume(shape: OtherShape) -> float:
    """Return a body's volume by its measures: its box, less what is cut out of that."""
    x, y, z = (np.array(way) for way in shape.breaks)
    box = float(np.ptp(x) * np.ptp(y) * np.ptp(z))
    if shape.family == 'tube':
        return box - float((x[2] - x[1]) * (y[2] - y[1]) * (z[2] - z[1]))
    if shape.family == 'slotted':
        return box - float((x[3::2] - x[2:-1:2]).sum() * np.ptp(y) * (z[2] - z[1]))
    if shape.family == 'window':
        return box - float((x[3] - x[2]) * (y[2] - y[1]) * np.ptp(z))
    if shape.family == 'hand':
        gaps = (x[4] - x[2]) * (y[2] - y[1] + y[4] - y[3])
        prongs = (x[4] - x[3]) * (y[1] - y[0] + y[5] - y[4])
        return box - float((gaps + prongs) * np.ptp(z))
    if shape.family == 'portal':
        return box - float((x[2] - x[0]) * (y[2] - y[1]) * np.ptp(z))
    # An arc about the middle of a section keeps its volume (Pappus).
    return box


def test_volumes_are_those_of_their_measures(shape: OtherShape) -> None:
    mesh, tets = mesh_hexahedra(shape), mesh_tetrahedra(shape)
    volume = _closed_volume(shape)
    assert integrate(mesh.nodes, mesh.cells).volumes.sum() == pytest.approx(volume, rel=1e-5)
    own = _volumes(tets)
    assert own.min() > 0.0
    # Straight edges cut an arc short.
    assert own.sum() == pytest.approx(volume, rel=4e-3 if shape.family == 'elbow' else 1e-9)
    assert 900 <= len(tets.tets) <= 2500
    assert 100 <= len(mesh.cells) <= 600


def test_an_elbow_is_an_arc_between_two_straight_legs() -> None:
    begin, end, angle = 0.05, 0.09, float(np.deg2rad(95.0))
    radius = (end - begin) / angle
    ahead = np.linspace(0.0, 0.14, 15)
    for aside in (-0.008, 0.0, 0.008):
        line = np.column_stack([ahead, np.full(15, aside), np.full(15, 0.003)])
        found = bent_elbow(line, begin, end, angle)
        assert found[ahead <= begin] == pytest.approx(line[ahead <= begin])
        is_arc = (ahead > begin) & (ahead <= end)
        away = np.linalg.norm(found[is_arc, :2] - [begin, radius], axis=1)
        assert away == pytest.approx(radius - aside)
        last = np.diff(found[ahead >= end], axis=0)
        way = np.array([np.cos(angle), np.sin(angle), 0.0])
        assert last == pytest.approx(np.full((len(last), 1), 0.01) * way)


def test_a_slot_leaves_a_floor_and_a_tube_is_closed() -> None:
    random = np.random.default_rng(5)
    slotted, tube = (draw_other_shape(family, random) for family in ('slotted', 'tube'))
    points = mesh_hexahedra(slotted).nodes
    for block in (2, 4, 6, 8, 10):
        low, high = slotted.breaks[0][block : block + 2]
        amid = (points[:, 0] > low + 1e-6) & (points[:, 0] < high - 1e-6)
        assert points[amid, 2].max() == pytest.approx(slotted.breaks[2][1])
    mesh = mesh_hexahedra(tube)
    inner = np.abs(mesh.nodes[:, 1:]).max(axis=1) < tube.breaks[1][2] - 1e-9
    free = (mesh.nodes[:, 0] > tube.clamp + 1e-9) & (mesh.nodes[:, 0] < tube.breaks[0][2] - 1e-9)
    assert not (inner & free).any()
    assert (inner & ~free).any()


def test_proportions_are_those_of_their_names() -> None:
    random = np.random.default_rng(2)
    drawn = {family: draw_other_shape(family, random) for family in OTHER_FAMILIES}
    assert drawn['whip'].free / drawn['whip'].section[0] == pytest.approx(20.0, rel=0.06)
    assert drawn['stub'].free / drawn['stub'].section[0] == pytest.approx(2.5, rel=0.1)
    assert 0.003 <= drawn['sheet'].section[1] <= 0.004
    for family, shape in drawn.items():
        least, most = OTHER_FAMILIES[family].sizes
        assert 0.9 * least <= shape.size <= 1.1 * most


def test_both_meshes_are_held_at_the_same_places(shape: OtherShape) -> None:
    mesh, tets = mesh_hexahedra(shape), mesh_tetrahedra(shape)
    own = level_rig(shape).body.held
    assert len(own) == (2 if shape.family in ('portal', 'bridge') else 1)
    held = mesh.nodes[mesh.held]
    for box in own:
        low, high = np.array(box).T
        for points in (held, tets.points):
            inside = ((points > low - 1e-6) & (points < high + 1e-6)).all(axis=1)
            assert points[inside].min(axis=0) == pytest.approx(low)
            assert points[inside].max(axis=0) == pytest.approx(high)
    # Nothing else lies there, wherever a body was bent to.
    lattice_held = shape.is_held(mesh.lattice)
    in_boxes = shape.is_held(mesh.nodes)
    assert (lattice_held == in_boxes).all()
    assert np.flatnonzero(lattice_held).tolist() == mesh.held.tolist()
    assert (shape.arc_share(mesh.lattice[mesh.held]) == 0.0).all()
    assert set(tets.regions) == {0, 1}


@pytest.mark.parametrize(
    'family',
    [
        pytest.param(name, marks=[pytest.mark.slow] if name in _FINE else [])
        for name in sorted(OTHER_FAMILIES)
    ],
)
def test_finer_elements_sag_as_far(family: str) -> None:
    shape = draw_other_shape(family, np.random.default_rng(3))
    ways = [largest_move(shape, refinement) for refinement in (1.0, 1.3)]
    assert ways[0] > 1e-4 * shape.free
    assert ways[0] == pytest.approx(ways[1], rel=0.025)
