# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the twenty-fourth set do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest
from support.blind_contact import check_pushes, dents_of
from support.blind_draws import draw_faults, draw_sealed, SEALED, STEPS
from support.blind_rests import check_rests_where_borne, lying, rest_of
from support.blind_views import region_errors, with_and_without

from benchmarks.blind.contact import contact_laws, highest_tops
from benchmarks.blind.faults import Faults
from benchmarks.blind.flexure import stand_compliance
from benchmarks.blind.forms import BY_KEY
from benchmarks.blind.laying import lay_on_plane
from benchmarks.blind.loads import load_in_pose
from benchmarks.blind.moduli import wedge_value
from benchmarks.blind.observe import jostled, true_camera
from benchmarks.blind.paint import Paint, tip_part
from benchmarks.blind.rest_shape import stress_free_nodes
from benchmarks.blind.rotations import rotation
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.surface import body_triangles


def _gauss_places(setup: Setup, specimen: Specimen) -> tuple[np.ndarray, np.ndarray]:
    """Return shares of the free length and places across, -1 to 1, of Gauss points, (C, 8)."""
    mesh, values = specimen.mesh, specimen.body.quadrature.values
    places = mesh.lattice[mesh.cells].swapaxes(1, 2) @ values.T
    share = (places[:, 0] - setup.shape.clamp) / (setup.shape.length - setup.shape.clamp)
    return share, 2.0 * places[:, 1] / setup.shape.section[0]


@pytest.mark.parametrize('degrees', [0.0, 70.0, 135.0, 270.0])
def test_a_drip_lies_on_its_side_of_a_body(setup: Setup, plain: Specimen, degrees: float) -> None:
    faults = Faults(mass_form='spattered', added_mass=8.0, mass_drips=((0.6, degrees, 1.0),))
    added = make_specimen(setup, faults, 0.5).added
    assert added.sum() == pytest.approx(0.008)
    assert float(added @ plain.shares) / 0.008 == pytest.approx(0.6, abs=0.04)
    middle = added @ plain.mesh.lattice[:, 1:] / 0.008 / (0.5 * np.array(setup.shape.section))
    way = np.array([np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))])
    assert middle @ way > 0.35
    # And no more to one side of that than to the other.
    assert abs(middle @ np.array([-way[1], way[0]])) < 0.3


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_drips_are_as_heavy_in_all_as_told_and_lie_where_told(family: str) -> None:
    drawn = draw_sealed(family)
    faults = draw_faults('added_mass/spattered', drawn)
    specimen = make_specimen(drawn, faults)
    places, around, parts = np.array(faults.mass_drips).T
    assert 5 <= len(parts) <= 8
    assert parts.sum() == pytest.approx(1.0, abs=5e-4)
    assert parts.max() > 1.3 * parts.min()
    assert np.ptp(around) > 90.0
    mass = 1e-3 * faults.added_mass * parts.sum()
    assert specimen.added.sum() == pytest.approx(mass)
    assert float(specimen.added @ specimen.shares) / mass == pytest.approx(
        float(places @ parts / parts.sum()), abs=0.03
    )


def test_two_pours_meet_where_a_line_goes_from_side_to_side() -> None:
    share = np.array([0.2, 0.2, 0.6, 0.6, 0.6, 1.0, 1.0])
    across = np.array([1.0, 0.7, 0.0, 0.06, -0.06, -1.0, -0.7])
    found = wedge_value(share, across, 0.2, 1.0)
    assert found == pytest.approx([0.0, -0.5, 0.0, 0.2, -0.2, 0.0, 0.5])


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_the_outer_pour_is_thicker_the_farther_out(family: str) -> None:
    drawn = draw_sealed(family)
    faults = draw_faults('stiffness_contrast/wedged', drawn)
    poured, whole = (make_specimen(drawn, each) for each in (faults, Faults()))
    harder = np.log(np.asarray(poured.body.numbers.shear / whole.body.numbers.shear))
    share, across = _gauss_places(drawn, whole)
    # How far a place is out from the line between (begin, 1) and (until, -1), by two triangles.
    begin, until = faults.contrast_at, faults.contrast_until
    side = faults.contrast_side * across
    twice = (until - begin) * (side - 1.0) + 2.0 * (np.clip(share, 0.0, 1.0) - begin)
    expected = faults.contrast * np.clip(twice / (until - begin) / 0.3, -0.5, 0.5)
    # Shares are told at nodes: in the cells beside the clamp alone is that another thing.
    free = share > 0.05
    assert harder[free] == pytest.approx(expected[free], abs=1e-6)
    # In a bar; a crossbar is farther out to either side.
    bar = free & (np.abs(side) < 1.0)
    inner, outer = (harder[bar & (share > low) & (share < low + 0.2)] for low in (0.1, 0.75))
    assert inner.mean() < -0.15 * faults.contrast
    assert outer.mean() > 0.15 * faults.contrast
    amid = bar & (np.abs(share - 0.5) < 0.15)
    assert harder[amid & (side > 0.3)].mean() > harder[amid & (side < -0.3)].mean() + 0.3


def test_a_stand_gives_way_by_what_its_arm_and_rod_are_bent_and_twisted() -> None:
    by_turn, length, nu = 0.3, 0.1, 0.3
    height, found = 1.5 * length, np.zeros((6, 6))
    per_length = by_turn / (length + height)
    # Moments at places along both by each part of the load, and Castigliano's theorem.
    nodes, weights = np.polynomial.legendre.leggauss(3)
    back, down = np.array([-length, 0.0, 0.0]), np.array([0.0, 0.0, -height])
    for begin, way, twist in ((np.zeros(3), back, 0), (back, down, 2)):
        gives = per_length * np.ones(3)
        gives[twist] *= 1.0 + nu
        for node, weight in zip(nodes, weights, strict=True):
            place = begin + 0.5 * (node + 1.0) * way
            moments = np.hstack([-np.cross(place, np.eye(3)).T, np.eye(3)])
            part = 0.5 * weight * float(np.linalg.norm(way))
            found += part * moments.T @ np.diag(gives) @ moments
    assert stand_compliance(by_turn, length) == pytest.approx(found, abs=1e-12)
    assert found[4, 4] == pytest.approx(by_turn)


@pytest.mark.parametrize('pose', range(4))
def test_a_clamp_on_a_stand_rests_where_that_bears_the_body(
    setup: Setup, plain: Specimen, pose: int
) -> None:
    faults = draw_faults('compliant_clamp/stand', setup)
    compliance = stand_compliance(faults.clamp_compliance, faults.clamp_length)
    check_rests_where_borne(setup, plain, faults, pose, compliance)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_jaws_are_turned_by_whole_clicks_about_a_pin(family: str) -> None:
    drawn = draw_sealed(family)
    for size, most in ((1, 0.004), (2, 0.010)):
        scatter = np.array(draw_faults('clamp_offset/clicking', drawn, size).clamp_scatter)
        center = np.array([0.5 * drawn.shape.clamp, 0.0, 0.0])
        tip, tips = np.array([drawn.shape.length, 0.0, 0.0]), []
        for motion in scatter:
            turn = rotation(np.deg2rad(motion[3:]))
            # What is at the pin stays.
            assert center - turn @ center + 1e-3 * motion[:3] == pytest.approx(0.0, abs=1e-6)
            tips.append(float((turn @ (tip - center) + center + 1e-3 * motion[:3])[1]))
        assert not scatter[:, 3:5].any()
        clicks = 2.0 * scatter[:, 5] / np.abs(scatter[:, 5]).max()
        assert clicks == pytest.approx(np.round(clicks), abs=1e-3)
        assert len(set(np.round(clicks))) > 2
        assert np.abs(tips).max() == pytest.approx(most, rel=0.16)


def test_a_body_in_jaws_that_click_is_held_where_they_are(setup: Setup, plain: Specimen) -> None:
    faults = draw_faults('clamp_offset/clicking', setup)
    held = plain.mesh.held
    for pose, motion in enumerate(faults.clamp_scatter):
        found = rest_of(setup, faults, pose)[held]
        # About the object's z through its origin, as angles of a plane.
        x, y, z = plain.mesh.nodes[held].T
        angle = np.arctan2(y, x) + np.deg2rad(motion[5])
        there = np.stack([np.hypot(x, y) * np.cos(angle), np.hypot(x, y) * np.sin(angle), z])
        assert found == pytest.approx(there.T, abs=1e-6)


@pytest.fixture(scope='module')
def on_a_rack(setup: Setup) -> tuple[Setup, Faults]:
    """A set-up whose body lies on a drying rack in the first pose, and that rack."""
    return lay_on_plane(setup, draw_faults('contact_plane/rack', setup), np.random.default_rng(1))


def test_a_rack_lifts_a_body(on_a_rack: tuple[Setup, Faults], plain: Specimen) -> None:
    laid, faults = on_a_rack
    moves = []
    for pose in range(4):
        found, move = lying(laid, plain, faults, pose)
        dents = dents_of(laid, faults, found, pose)
        moves.append(move)
        assert (dents.max() > 0.0) == (pose in (0, 2))
        # It is hard.
        assert dents.max() < 1e-4
        assert plain.shares[dents > 0.0].min(initial=1.0) > 0.5
    assert 0.007 < moves[0] < 0.013
    assert moves[0] > moves[2] > 0.001
    assert moves[1] == moves[3] == 0.0


@pytest.mark.parametrize('step', STEPS)
def test_a_racks_bars_push_by_their_energies(
    on_a_rack: tuple[Setup, Faults], plain: Specimen, step: float
) -> None:
    laid, faults = on_a_rack
    check_pushes(laid, plain, faults, step)


def test_a_rack_has_round_bars_as_far_apart_as_told() -> None:
    faults = Faults(contact_form='rack', contact_at=0.013, contact_wave=0.025)
    points = np.random.default_rng(2).uniform(-0.1, 0.1, (400, 3))
    found, radius = highest_tops(points, faults), 0.008
    tops = []
    for x, y, _ in points:
        # Where a circle below a place touches it, of each bar.
        away = np.abs(x - (0.013 + 0.025 * np.arange(-8, 9)))
        nearest = float(away.min())
        rises = radius - np.sqrt(radius**2 - nearest**2) if nearest < radius else np.inf
        tops.append(y + rises)
    assert np.isfinite(found) == pytest.approx(np.isfinite(tops))
    there = np.isfinite(found)
    assert 0.5 < there.mean() < 0.8
    assert found[there] == pytest.approx(np.array(tops)[there], abs=1e-12)


def test_bars_of_a_rack_push_away_from_their_axes(
    on_a_rack: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_a_rack
    assert faults.contact_height is not None
    view = laid.observations[0]
    laws = contact_laws(plain.areas, plain.shares, view, faults)
    turn, shift = view.world_from_object[:3, :3], view.world_from_object[:3, 3]
    for number in (-1, 0, 1):
        at = np.array([faults.contact_at + number * faults.contact_wave, 0.0, 0.0])
        at[1] = faults.contact_height - 0.008
        # All nodes 6 mm from one axis, aslant above it.
        world = at + 0.006 * np.array([0.6, 0.8, 0.0]) + np.zeros((len(plain.areas), 3))
        places = (world - shift) @ turn
        forces = -np.sum([law(places).gradient for law in laws], axis=0) @ turn.T
        sizes = np.linalg.norm(forces, axis=1)
        assert forces == pytest.approx(sizes[:, None] * np.array([0.6, 0.8, 0.0]), abs=1e-9)
        assert sizes == pytest.approx(5.0e8 * plain.areas * 0.002, rel=1e-6)


def test_what_is_seen_through_a_film_errs(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults, covered = draw_faults('depth_affine/peeling', setup), []
    slant = np.exp(1j * np.deg2rad(faults.depth_slant))
    for pose in range(4):
        view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
        errors = (view.depth[there] - right.depth[there]) / (1e-3 * faults.depth_bias)
        rows, columns, _ = np.nonzero(there)
        places = columns + right.column - setup.camera.cx
        places = places + 1j * (rows + right.row - setup.camera.cy)
        away = (places / slant).real - faults.depth_places[pose]
        # An S of the logistic function, half of which is there at the edge.
        assert errors == pytest.approx(1.0 / (1.0 + np.exp(-2.0 * away / faults.depth_width)))
        covered.append(float((errors > 0.5).mean()))
        assert errors.max() > 0.99
        assert errors.min() < 0.01
    assert covered[0] > covered[-1]
    assert abs(faults.depth_bias) == pytest.approx(10.0, rel=0.16)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_film_peels_off_farther_from_pose_to_pose(family: str) -> None:
    drawn = draw_sealed(family)
    for seed in range(6):
        changes = BY_KEY['depth_affine/peeling'].draw(2, drawn, np.random.default_rng(seed))
        steps = np.diff(changes['depth_places'])
        assert len(steps) == 3
        assert steps.min() > 11.9
        assert steps.max() < 35.1
        # Mostly from a side of the image.
        assert abs(np.cos(np.deg2rad(changes['depth_slant']))) > 0.6


def test_coats_add_up_to_the_tip(setup: Setup, plain: Specimen) -> None:
    dips = (0.2, 0.5, 0.55, 0.8)
    painted = body_triangles(plain.mesh, plain.mesh.nodes, plain.shares, Paint(dips=dips))
    free = setup.shape.length - setup.shape.clamp
    places = (painted.corners[..., 0].mean(axis=1) - setup.shape.clamp) / free
    parts = tip_part(painted.labels)
    ends = (-1.0, *dips, 1.1)
    for number in range(5):
        within = (places > ends[number] + 1e-6) & (places < ends[number + 1] - 1e-6)
        assert within.sum() > 4
        assert parts[within] == pytest.approx(0.25 * number)


def test_what_was_dipped_errs_by_how_many_coats_are_on_it(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults = draw_faults('depth_bias_by_region/dipped', setup)
    count = len(faults.region_dips)
    assert count in (4, 5)
    assert list(faults.region_dips) == sorted(faults.region_dips)
    for pose in range(4):
        error = region_errors(plain, setup, faults, pose, rests[pose])
        coats = count * error
        assert coats == pytest.approx(np.round(coats), abs=1e-6)
        assert set(np.unique(np.round(coats))) == set(range(count + 1))
    assert abs(faults.region_bias) == pytest.approx(12.0, rel=0.16)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_camera_goes_round_a_column_behind_the_body(family: str) -> None:
    drawn = draw_sealed(family)
    faults = draw_faults('camera_offset/orbiting', drawn)
    assert faults.camera_foot is not None
    plain = make_specimen(drawn, Faults(), 0.5)
    stored = np.linalg.inv(drawn.depth_from_world)
    column = (stored @ [*faults.camera_foot, 1.0])[:3]
    angles, sides = [], []
    for pose, motion in enumerate(faults.camera_scatter):
        off = jostled(drawn, drawn.observations[pose], faults)
        found = np.linalg.inv(true_camera(plain, drawn, off))
        before, after = (camera[:3, 3] - column for camera in (stored, found))
        assert after[1] == pytest.approx(before[1], abs=1e-5)
        assert np.hypot(*after[[0, 2]]) == pytest.approx(np.hypot(*before[[0, 2]]), abs=1e-5)
        # About the world's y, from z towards x.
        turn = np.angle(complex(after[2], after[0]) / complex(before[2], before[0]))
        angles.append(np.rad2deg(turn))
        assert abs(angles[-1]) == pytest.approx(np.linalg.norm(motion[3:]), abs=2e-3)
        # It looks at the column as it did.
        assert found[:3, :3].T @ after == pytest.approx(stored[:3, :3].T @ before, abs=1e-5)
        # By so much it sees the middle of all, and half a body beside that, elsewhere.
        half = 0.5 * (drawn.shape.length - drawn.shape.clamp)
        sides.append(abs(turn) * np.hypot(np.linalg.norm(column[[0, 2]]), half))
    assert np.ptp(angles) > np.abs(angles).max()
    assert max(sides) == pytest.approx(0.010, rel=0.17)
    assert 0.08 < np.linalg.norm(column[[0, 2]]) < 0.21


@pytest.mark.parametrize('pose', range(4))
def test_two_fans_blow_against_each_other(setup: Setup, plain: Specimen, pose: int) -> None:
    faults = draw_faults('gravity_tilt/opposed', setup)
    view = setup.observations[pose]
    blown, still = (load_in_pose(plain, setup, view, each).forces for each in (faults, Faults()))
    pushes = (blown - still) @ view.world_from_object[:3, :3].T
    pushes /= plain.body.masses[:, None]
    x, z = np.deg2rad(faults.gravity_tilt)
    tilt = float(np.hypot(x, z))
    outer = GRAVITY * np.sin(tilt) / tilt * np.array([z, 0.0, -x])
    for inside, factor in (
        (plain.shares > faults.tilt_at, 1.0),
        ((plain.shares > 0.0) & (plain.shares <= faults.tilt_at), -faults.tilt_back),
        (plain.shares == 0.0, 0.0),
    ):
        assert inside.any()
        assert pushes[inside] == pytest.approx(np.tile(factor * outer, (inside.sum(), 1)))
    assert 0.3 * GRAVITY < np.linalg.norm(outer) < 0.95 * GRAVITY


def test_the_inner_fan_holds_a_tip_back(setup: Setup, plain: Specimen) -> None:
    faults = draw_faults('gravity_tilt/opposed', setup)
    alone, tip = replace(faults, tilt_back=0.0), plain.shares > 0.99
    rests = [rest_of(setup, each, 1)[tip].mean(axis=0) for each in (Faults(), faults, alone)]
    both, one = (float(np.linalg.norm(rest - rests[0])) for rest in rests[1:])
    assert 1.03 * both < one < 1.5 * both


@pytest.mark.parametrize('heavy', [0.0, 0.4, 1.0])
def test_a_body_that_was_held_by_its_tip_is_bent_most_there(setup: Setup, heavy: float) -> None:
    shape = setup.shape
    free = shape.length - shape.clamp
    line = np.zeros((1201, 3))
    line[:, 0] = shape.clamp + np.linspace(0.0, 1.0, 1201) * free
    faults = Faults(
        rest_curvature=(0.0, 0.4), curvature_form='held by its tip', curvature_heavy=heavy
    )
    bent = stress_free_nodes(line, shape, faults)
    steps = np.diff(bent, axis=0)
    assert np.linalg.norm(steps, axis=1).sum() == pytest.approx(free, rel=1e-6)
    angles = np.arctan2(steps[:, 1], steps[:, 0])
    # What a weight at the free end turns a place by, and what an even one does, from there on.
    share = (np.arange(1200) + 0.5) / 1200.0
    turned = 0.5 * heavy * share**2 + (1.0 - heavy) * share**3 / 3.0
    whole = 0.5 * heavy + (1.0 - heavy) / 3.0
    expected = angles[-1] * turned / whole
    assert angles == pytest.approx(expected, abs=0.02 * float(angles[-1]))
    arc = stress_free_nodes(line, shape, Faults(rest_curvature=(0.0, 0.4)))
    assert bent[-1, 1] == pytest.approx(arc[-1, 1], rel=0.03)
