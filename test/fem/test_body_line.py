# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The line of a bent body: places along and across it, and how it is bent on."""

from concurrent.futures import ThreadPoolExecutor
import sys

from diffcal_ros.fem.body_axes import body_axes, BodyAxes
from diffcal_ros.fem.terms.rest_shape import bent
from diffcal_ros.rigid_transform import apply, rotation_matrix, transform
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
import pytest
from support.beams import beam_mesh, held_end

LENGTH, CLAMP = 0.16, 0.02
BODY = beam_mesh((24, 3, 2), (LENGTH, 0.02, 0.012))
# Of the arc into which the free part is bent [1/m]: four fifths of half a turn.
CURVATURE = 18.0
_STATIONS = np.linspace(CLAMP, LENGTH, 22)[::3]
TURN = transform(rotation_matrix(np.array([0.4, -0.7, 0.9])), np.array([0.3, -0.2, 1.1]))


def _on_arc(points: np.ndarray, curvature: float) -> np.ndarray:
    """Bend what is beyond the clamp into an arc about z, its middle line as long as before."""
    along = np.maximum(points[:, 0] - CLAMP, 0.0)
    beside = points[:, 1] - 0.01
    angle = curvature * along
    x = np.minimum(points[:, 0], CLAMP) + (1.0 / curvature - beside) * np.sin(angle)
    y = beside + (1.0 / curvature - beside) * (1.0 - np.cos(angle))
    return np.column_stack([x, y, points[:, 2]])


def _axes(mesh: TetMesh, held: np.ndarray | None = None) -> BodyAxes:
    if held is None:
        held = held_end(BODY, CLAMP + 1e-6)
    border = held[np.abs(BODY.rest_positions[held, 0] - CLAMP) < 1e-6]
    return body_axes(mesh.rest_positions, held.astype(np.int32), border.astype(np.int32), mesh)


@pytest.fixture
def arc() -> TetMesh:
    return TetMesh(_on_arc(BODY.rest_positions, CURVATURE), BODY.tets)


SHARES = np.clip((BODY.rest_positions[:, 0] - CLAMP) / (LENGTH - CLAMP), 0.0, 1.0)


def test_places_along_an_arc_are_those_along_the_straight_body(arc):
    axes = _axes(arc)
    found = axes.fraction(arc.rest_positions)
    # Half an element's length at most; along the axis they are off by a fifth.
    assert np.abs(found - SHARES).max() < 0.02
    straight = (arc.rest_positions - axes.root) @ axes.axes[0]
    assert np.abs(straight / straight.max() - SHARES).max() > 0.2
    np.testing.assert_allclose(axes.length, LENGTH - CLAMP, rtol=0.02)


def test_centroids_and_points_between_nodes_have_places_too(arc):
    axes = _axes(arc)
    expected = SHARES[arc.tets].mean(axis=1)
    assert np.abs(axes.fraction(arc.centroids) - expected).max() < 0.03


def test_places_between_nodes_do_not_jump(arc):
    """Middles of edges are as far from several nodes: rounding must not choose among them."""
    axes = _axes(arc)
    points = arc.rest_positions[arc.edges[0]].mean(axis=1)
    off = 1e-12 * np.random.default_rng(3).standard_normal((5, *points.shape))
    for moved in off:
        moves = np.abs(axes.fraction(points + moved) - axes.fraction(points))
        assert 0.0 < moves.max() < 1e-9


def test_places_that_are_remembered_are_those_that_were_found(arc):
    asked = [arc.rest_positions + 1e-4 * number for number in range(40)]
    line = _axes(arc).line
    first = [line.fraction(points) for points in asked]
    # By now the first of them are forgotten; the last ones are the same arrays, not to be changed.
    again = [line.fraction(points) for points in asked[::-1]][::-1]
    for one, other, points in zip(first, again, asked, strict=True):
        np.testing.assert_array_equal(one, other)
        np.testing.assert_array_equal(one, _axes(arc).line.fraction(points))
    assert again[-1] is first[-1]
    assert again[0] is not first[0]
    with pytest.raises(ValueError, match='read-only'):
        first[-1][0] = 0.5


def test_threads_may_ask_for_places_at_once(arc):
    asked = [arc.rest_positions[:20] + 1e-5 * number for number in range(100)]
    line = _axes(arc).line
    expected = [line.fraction(points) for points in asked]

    def ask(seed: int) -> bool:
        numbers = np.random.default_rng(seed).integers(0, len(asked), 1000)
        return all(np.array_equal(line.fraction(asked[n]), expected[n]) for n in numbers)

    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(4) as pool:
            assert all(pool.map(ask, range(4)))
    finally:
        sys.setswitchinterval(before)


def test_places_across_an_arc_are_those_across_the_straight_body(arc):
    axes = _axes(arc)
    triangles = arc.surface_triangles
    places = axes.on_surface(arc.rest_positions, triangles)
    across = BODY.rest_positions[triangles][..., 1:] / np.array([0.01, 0.006]) - 1.0
    is_free = SHARES[triangles].min(axis=1) > 0.1
    is_tip = SHARES[triangles].max(axis=1) > 0.95
    found, expected = places[..., 1:], across
    middle = is_free & ~is_tip
    # Which of the two is the first one, and which way it goes, is the axes' own.
    products = np.einsum('fci,fcj->ij', found[middle], expected[middle])
    products /= np.einsum('fci,fci->i', expected[middle], expected[middle])
    pairing = np.round(products)
    np.testing.assert_array_equal(np.abs(pairing).sum(axis=0), 1.0)
    np.testing.assert_allclose((found @ pairing)[middle], expected[middle], atol=0.1)
    # Corners of the tip are beyond the last section.
    np.testing.assert_allclose((found @ pairing)[is_tip], expected[is_tip], atol=0.2)


def test_sides_are_those_of_the_straight_body(arc):
    axes, triangles = _axes(arc), arc.surface_triangles
    sides = axes.sides(arc.rest_positions, triangles)
    is_long = (SHARES[triangles].min(axis=1) > 0.05) & (SHARES[triangles].max(axis=1) < 0.95)
    # Its long sides face across the line wherever they are.
    assert (np.abs(sides[is_long]).max(axis=1) > 0.97).all()


@pytest.mark.parametrize('share', [-1.0, -0.5, 0.5])
def test_an_arc_that_is_bent_on_is_an_arc(arc, share):
    axes, rate = _axes(arc), share * CURVATURE
    about = axes.at_root[1:] @ [0.0, 0.0, 1.0]
    rates = np.array([[0.0, *(rate * about)]])
    found = bent(arc.rest_positions, axes, rates)
    curvature = CURVATURE + rate
    expected = _on_arc(BODY.rest_positions, curvature if curvature else 1e-6)
    # It turns by as much as the straight body did, or back to it, to a twentieth of what moves.
    moved = np.abs(expected - arc.rest_positions).max()
    assert np.abs(found - expected).max() < 0.05 * moved


def test_a_bend_out_of_its_plane_leaves_lengths_of_the_line(arc):
    axes = _axes(arc)
    rates = axes.at_root @ np.array([[0.0, 8.0, 0.0], [0.0, -4.0, 0.0]]).T
    found = bent(arc.rest_positions, axes, rates.T)
    middle = [np.flatnonzero(np.abs(BODY.rest_positions[:, 0] - at) < 1e-6) for at in _STATIONS]
    lines = [
        np.stack([points[own].mean(axis=0) for own in middle])
        for points in (found, arc.rest_positions)
    ]
    now, before = (np.linalg.norm(np.diff(line, axis=0), axis=1) for line in lines)
    np.testing.assert_allclose(now, before, rtol=0.05)
    assert np.ptp(found[:, 2]) > 2.0 * np.ptp(arc.rest_positions[:, 2])


def test_the_clamp_stays_where_it_is(arc):
    held = held_end(BODY, CLAMP + 1e-6)
    found = bent(arc.rest_positions, _axes(arc), np.array([[3.0, 10.0, -5.0]]))
    np.testing.assert_allclose(found[held], arc.rest_positions[held], atol=1e-9)


def test_places_do_not_depend_on_the_frame(arc):
    moved = TetMesh(apply(TURN, arc.rest_positions), arc.tets)
    placed = _axes(arc).placed(TURN)
    for axes in (placed, _axes(moved)):
        np.testing.assert_allclose(
            axes.fraction(moved.rest_positions), _axes(arc).fraction(arc.rest_positions), atol=1e-6
        )


def test_a_straight_body_and_a_slightly_bent_one_follow_their_axis():
    for curvature in (1e-6, 3.0):
        mesh = TetMesh(_on_arc(BODY.rest_positions, curvature), BODY.tets)
        assert _axes(mesh).line is None


@pytest.mark.parametrize('counts', [(4, 2, 1), (12, 3, 2)])
def test_a_straight_body_on_two_feet_follows_its_axis(counts):
    """Its axis ends at the first nodes that are free, the line at the feet."""
    mesh = beam_mesh(counts, (LENGTH, 0.02, 0.012))
    along = mesh.rest_positions[:, 0]
    feet = np.flatnonzero((along < 1e-9) | (along > LENGTH - 1e-9)).astype(np.int32)
    assert body_axes(mesh.rest_positions, feet, None, mesh).line is None


def test_an_arch_on_two_feet_goes_from_one_to_the_other(arc):
    feet = np.flatnonzero((SHARES == 0.0) | (SHARES > 0.95)).astype(np.int32)
    axes = _axes(arc, feet)
    found = axes.fraction(arc.rest_positions)
    # Its sign is its own; what is amid is amid.
    found = found if found[0] < 0.5 else 1.0 - found
    is_free = (SHARES > 0.0) & (SHARES < 0.95)
    assert np.abs(found - SHARES)[is_free].max() < 0.06


def test_arms_and_holes_have_no_line():
    """Two arms that go on beside each other, each bent: their middle is no part of the body."""
    points = BODY.rest_positions
    gone = (
        (BODY.centroids[:, 0] > 0.05)
        & (BODY.centroids[:, 1] > 0.0067)
        & (BODY.centroids[:, 1] < 0.0134)
    )
    assert gone.any()
    tets = BODY.tets[~gone]
    kept, own = np.unique(tets, return_inverse=True)
    bent_mesh = TetMesh(_on_arc(points, CURVATURE)[kept], own.reshape(-1, 4).astype(np.int32))
    held = np.flatnonzero(points[kept, 0] < CLAMP + 1e-6).astype(np.int32)
    assert body_axes(bent_mesh.rest_positions, held, None, bent_mesh).line is None
