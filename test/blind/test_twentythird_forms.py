# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the twenty-third set do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest
from support.blind_contact import check_pushes, moves_and_dents
from support.blind_derivatives import check_body_stiffness, check_derivatives, check_loose_fibres
from support.blind_draws import draw_faults, draw_sealed, SEALED, STEPS
from support.blind_rests import check_rests_where_borne, COARSE, rest_of
from support.blind_views import region_errors, with_and_without

from benchmarks.blind.contact import contact_laws
from benchmarks.blind.faults import Faults
from benchmarks.blind.fibres import Fibres
from benchmarks.blind.flexure import flexure_compliance, gantry_compliance
from benchmarks.blind.forms import BY_KEY
from benchmarks.blind.hung import hung_masses
from benchmarks.blind.laying import lay_on_plane, softer
from benchmarks.blind.moduli import edge_share
from benchmarks.blind.network import beside_middle
from benchmarks.blind.observe import jostled, true_camera
from benchmarks.blind.packing import packing
from benchmarks.blind.paint import FIXTURE, Paint, tip_part
from benchmarks.blind.rest_shape import stress_free_nodes
from benchmarks.blind.rotations import rotation
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.surface import body_triangles


@pytest.mark.parametrize('pose', range(4))
def test_a_clip_hangs_on_a_body_from_one_pose_on(setup: Setup, plain: Specimen, pose: int) -> None:
    faults, view = draw_faults('added_mass/hung on', setup), setup.observations[pose]
    found = hung_masses(plain.body.masses, plain.shares, setup, view, faults)
    assert faults.mass_from in (1, 2)
    is_there = pose >= faults.mass_from
    assert found.sum() == pytest.approx(1e-3 * faults.added_mass * is_there)
    # All of it near its place, and none before it is there.
    middle = float(found @ plain.shares / max(found.sum(), 1e-12))
    assert middle == pytest.approx(faults.added_mass_at * is_there, abs=0.03)
    # Where it does not hang a body rests as if there were none.
    rests = [rest_of(setup, each, pose) for each in (faults, Faults())]
    moved = float(np.linalg.norm(rests[0] - rests[1], axis=1).max())
    assert (moved > 0.003) == is_there
    assert (moved == 0.0) == (not is_there)


@pytest.mark.parametrize('family', SEALED)
def test_a_clip_is_hung_on_after_some_pose_and_before_the_last(family: str) -> None:
    drawn, found = draw_sealed(family), set()
    for seed in range(12):
        changes = BY_KEY['added_mass/hung on'].draw(1, drawn, np.random.default_rng(seed))
        found.add(changes['mass_from'])
        assert 0.7 <= changes['added_mass_at'] <= 0.95
    assert found == {1, 2}


def test_a_mould_keeps_edges_from_curing_and_not_the_middles_of_sides() -> None:
    across = np.array([0.0, 1.0, -1.0, 0.5, -0.5, 2.5, 0.0])
    height = np.array([1.0, 1.0, -1.0, 0.5, 1.0, -0.5, 0.0])
    found = edge_share(across, height)
    assert found == pytest.approx([0.0, 1.0, 1.0, 0.25, 0.5, 0.5, 0.0])


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_body_with_soft_edges_is_soft_there_alone(family: str) -> None:
    drawn = draw_sealed(family)
    faults = draw_faults('stiffness_contrast/edged', drawn)
    soft, whole = (make_specimen(drawn, each) for each in (faults, Faults()))
    harder = np.log(np.asarray(soft.body.numbers.shear / whole.body.numbers.shear))
    mesh, values = whole.mesh, whole.body.quadrature.values
    places = mesh.lattice[mesh.cells].swapaxes(1, 2) @ values.T
    aside, high = (
        np.minimum(np.abs(2.0 * places[:, axis] / size), 1.0)
        for axis, size in zip((1, 2), drawn.shape.section, strict=True)
    )
    assert harder == pytest.approx(faults.contrast * aside * high, abs=1e-9)
    # Of every section, alike along the body, and to either side.
    assert harder.max() > 0.15 * faults.contrast
    assert harder.min() < 0.3 * faults.contrast


@pytest.mark.parametrize('step', STEPS)
def test_leads_resist_by_their_energy_once_they_are_taut(setup: Setup, step: float) -> None:
    faults = Faults(stiffening_form='leads', stiffening=2.0, stiffening_from=0.04)
    (family,) = make_specimen(setup, faults, COARSE).body.numbers.network
    lead = replace(family, stiffness=np.array(3e4))
    along = np.diag([1.08, 0.97, 0.97])
    drawn = along + np.random.default_rng(1).uniform(-0.02, 0.02, (3, 3))
    check_loose_fibres(lead, drawn, step, still=(0.8, 1.0, 1.019))


@pytest.mark.parametrize('step', [1e-7, 1e-8, 1e-9])
def test_a_body_with_leads_resists_as_its_forces_change(setup: Setup, step: float) -> None:
    faults = Faults(stiffening_form='leads', stiffening=2.0, stiffening_from=0.01)
    specimen = make_specimen(setup, faults, COARSE)
    (family,) = specimen.body.numbers.network
    assert isinstance(family, Fibres)
    stiffness = 8.0 * np.asarray(family.stiffness) / setup.youngs_modulus
    assert set(np.unique(np.round(stiffness, 9))) == {0.0, 2.0}
    longer = specimen.mesh.nodes * np.array([1.07, 0.97, 0.97])
    check_body_stiffness(specimen.body, longer, step=step)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_leads_lie_along_both_sides_of_every_body(family: str) -> None:
    drawn = draw_sealed(family)
    specimen = make_specimen(drawn, draw_faults('strain_stiffening/leads', drawn))
    mesh, values = specimen.mesh, specimen.body.quadrature.values
    places = mesh.lattice[mesh.cells].swapaxes(1, 2) @ values.T
    aside, high = (
        2.0 * places[:, axis] / size
        for axis, size in zip((1, 2), drawn.shape.section, strict=True)
    )
    (found,) = specimen.body.numbers.network
    there = np.broadcast_to(found.stiffness, aside.shape) > 0.0
    assert there.any()
    assert np.abs(aside[there]).min() > 0.55
    assert np.abs(aside[there]).max() < 1.0
    assert np.abs(high[there]).max() < 0.6
    assert (there & (aside > 0.0)).sum() == (there & (aside < 0.0)).sum()
    # From the clamp to the tip.
    free = (places[:, 0] - drawn.shape.clamp) / (drawn.shape.length - drawn.shape.clamp)
    assert free[there].min() < 0.05
    assert free[there].max() > 0.7


def test_leads_are_on_neither_face_and_in_no_crossbar() -> None:
    across = np.array([[0.5, 0.6, 0.9, 0.9, 1.5], [0.0, 0.0, 0.5, 0.7, 0.0]])[None]
    assert beside_middle(across).tolist() == [[0.0, 1.0, 1.0, 0.0, 0.0]]


# A fin on its side hardly bends that way.
@pytest.mark.parametrize('family', ['arch', 'waist', 'tee'])
def test_leads_hold_a_body_most_where_it_lies_on_its_side(family: str) -> None:
    drawn = draw_sealed(family)
    soft, moves = softer(drawn, 0.3), []
    tip = make_specimen(soft, Faults(), COARSE).shares > 0.99
    bare = [rest_of(soft, Faults(), pose)[tip].mean(axis=0) for pose in range(2)]
    for size in (1, 2):
        faults = draw_faults('strain_stiffening/leads', drawn, size)
        held = [rest_of(soft, faults, pose)[tip].mean(axis=0) for pose in range(2)]
        moves.append(np.linalg.norm(np.subtract(held, bare), axis=1))
    largest = np.max(moves, axis=1)
    assert 0.0025 < largest[0] < 0.006
    assert 0.007 < largest[1] < 0.016
    assert moves[1][1] > 2.0 * moves[1][0]


def test_a_crossbar_is_two_beams_that_bear_together() -> None:
    by_turn, length, nu = 0.3, 0.2, 0.3
    # Its halves go from their feet to the clamp along y and against it.
    along = rotation(np.array([0.0, 0.0, 0.5 * np.pi]))
    stiffness = np.zeros((6, 6))
    bends = 2.0 * by_turn / (1.0 + nu)
    for turn in (along, along.T):
        # As a spring along x, but for what it is twisted by, and with a little give along it.
        half = flexure_compliance(bends, length)
        half[3, 3] *= 1.0 + nu
        half[0, 0] = 1e-12
        both = np.kron(np.eye(2), turn)
        stiffness += both @ np.linalg.inv(half) @ both.T
    found = gantry_compliance(by_turn, length)
    assert found == pytest.approx(np.linalg.inv(stiffness), rel=1e-6, abs=1e-10)
    assert found[4, 4] == by_turn


@pytest.mark.parametrize('pose', range(4))
def test_a_clamp_on_a_gantry_rests_where_that_bears_the_body(
    setup: Setup, plain: Specimen, pose: int
) -> None:
    faults = draw_faults('compliant_clamp/gantry', setup)
    compliance = gantry_compliance(faults.clamp_compliance, faults.clamp_length)
    check_rests_where_borne(setup, plain, faults, pose, compliance)


@pytest.fixture(scope='module')
def on_packing(setup: Setup) -> tuple[Setup, Faults]:
    """A set-up whose body lies on packing foam in the first pose, and that foam."""
    return lay_on_plane(
        setup, draw_faults('contact_plane/packing', setup), np.random.default_rng(1)
    )


def test_packing_bears_a_body_and_lets_its_tip_sink_in(
    on_packing: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_packing
    moves, dents = moves_and_dents(laid, plain, faults)
    assert 0.007 < moves[0] < 0.013
    assert moves[0] > moves[2] > 0.001
    assert moves[1] == moves[3] == 0.0
    assert 0.001 < dents[0] < 0.006


@pytest.mark.parametrize('step', STEPS)
def test_packing_pushes_by_its_energy(
    on_packing: tuple[Setup, Faults], plain: Specimen, step: float
) -> None:
    laid, faults = on_packing
    check_pushes(laid, plain, faults, step)
    # Far on its plateau as well.
    normal, dents = np.array([0.0, 0.6, 0.8]), 0.002 * np.array([-0.5, 0.5, 2.0, 4.0])
    places = np.outer(0.03 - dents, normal) + np.array([0.02, 0.0, 0.0])
    pressed = packing(normal, 0.03, np.array([2.0, 2.0, 1.0, 5.0]), 0.002)
    stiff = check_derivatives(pressed, places, step=step, share=1e-4)
    assert stiff.any(axis=1).tolist() == [False, True, True, True]


def test_packing_presses_no_harder_the_deeper_it_is_dented(
    on_packing: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_packing
    assert faults.contact_height is not None
    (law,) = contact_laws(plain.areas, plain.shares, laid.observations[0], faults)
    world = laid.observations[0].world_from_object
    # All nodes at one height.
    up = world[1, :3]
    flat = plain.mesh.nodes - np.outer(plain.mesh.nodes @ up + world[1, 3], up)
    for dent, part in ((-1.0, 0.0), (0.0, 0.0), (1.0, 0.6321206), (30.0, 1.0), (60.0, 1.0)):
        deep = flat + (faults.contact_height - dent * faults.contact_bend) * up
        pushes = -law(deep).gradient @ up
        expected = part * faults.contact_pressure * plain.areas
        assert pushes == pytest.approx(expected, rel=1e-6, abs=1e-12)


def test_a_restarted_sensor_has_another_zero_in_each_pose(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults, errors = draw_faults('depth_affine/restarted', setup), []
    for pose in range(4):
        view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
        error = view.depth[there] - right.depth[there]
        # The same all over, the fixture too.
        assert (right.labels[there] == FIXTURE).any()
        assert np.ptp(error) < 1e-12
        errors.append(float(error[0]))
    assert errors == pytest.approx(1e-3 * faults.depth_bias * np.array(faults.depth_shares))
    assert np.abs(errors).max() == pytest.approx(0.010, rel=0.16)
    assert np.ptp(errors) > 0.0085
    assert len(set(np.round(errors, 6))) == 4


def test_strokes_of_a_brush_err_each_by_its_own(setup: Setup, plain: Specimen) -> None:
    strokes = (0.5, 1.0, 0.25, 0.75)
    shares = plain.shares
    painted = body_triangles(plain.mesh, plain.mesh.nodes, shares, Paint(0.6, strokes=strokes))
    free = setup.shape.length - setup.shape.clamp
    places = (painted.corners[..., 0].mean(axis=1) - setup.shape.clamp) / free
    parts = tip_part(painted.labels)
    assert not parts[places < 0.6].any()
    for number, stroke in enumerate(strokes):
        within = (places > 0.6 + 0.1 * number + 1e-6) & (places < 0.7 + 0.1 * number - 1e-6)
        assert within.sum() > 10
        assert parts[within] == pytest.approx(stroke)


def test_what_is_brushed_errs_by_a_part_of_what_is_told(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults = draw_faults('depth_bias_by_region/brushed', setup)
    assert 4 <= len(faults.region_strokes) <= 7
    assert max(faults.region_strokes) == 1.0
    for pose in range(4):
        error = region_errors(plain, setup, faults, pose, rests[pose])
        # To the nearest twentieth, as labels of a surface tell it.
        told = np.append(np.array(faults.region_strokes), 0.0)
        apart = np.abs(error[:, None] - told).min(axis=1)
        assert apart.max() < 0.026
        assert error.max() == pytest.approx(1.0)
        assert 0.1 < (np.abs(error) > 0.2).mean() < 0.95


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_slider_leaves_a_camera_somewhere_along_it(family: str) -> None:
    drawn = draw_sealed(family)
    faults = draw_faults('camera_offset/slider', drawn)
    scatter = np.array(faults.camera_scatter)
    assert not scatter[:, 3:].any()
    places = scatter[:, :3]
    _, sizes, ways = np.linalg.svd(places)
    assert sizes[1] < 1e-3 * sizes[0]
    # Mostly across what it sees.
    assert abs(ways[0][0]) > 0.85
    along = places @ ways[0]
    assert np.abs(along).max() == pytest.approx(10.0, rel=0.16)
    assert np.ptp(along) > np.abs(along).max()


def test_a_camera_on_a_slider_stands_where_its_label_says(setup: Setup, plain: Specimen) -> None:
    faults, places = draw_faults('camera_offset/slider', setup), np.random.default_rng(1)
    seen = places.uniform(-0.05, 0.05, (5, 3))
    for pose, motion in enumerate(faults.camera_scatter):
        off = jostled(setup, setup.observations[pose], faults)
        stored, found = setup.depth_from_world, true_camera(plain, setup, off)
        before = seen @ stored[:3, :3].T + stored[:3, 3]
        after = seen @ found[:3, :3].T + found[:3, 3]
        # What the camera is shifted by, all that it sees comes nearer by.
        assert before - after == pytest.approx(np.tile(1e-3 * np.array(motion[:3]), (5, 1)))


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_tyre_loses_its_air_by_an_exponential(family: str) -> None:
    faults = draw_faults('gravity_tilt/deflating', draw_sealed(family))
    shares = np.array(faults.tilt_shares)
    steps = np.diff(shares)
    assert shares[0] > 0.0
    assert shares[-1] == 1.0
    # Each step is the one before it times as much.
    assert steps[1] / steps[0] == pytest.approx(steps[2] / steps[1], abs=2e-3)
    assert 0.44 < steps[1] / steps[0] < 0.75
    assert 2.0 < np.linalg.norm(faults.gravity_tilt) < 27.0


def test_gravity_is_tilted_by_what_a_trolley_leans(setup: Setup) -> None:
    shares = (0.2, 0.6, 0.8, 1.0)
    faults = Faults(tilt_form='deflating', gravity_tilt=(3.0, -7.0), tilt_shares=shares)
    for pose, share in enumerate(shares):
        tilted = Faults(gravity_tilt=(3.0 * share, -7.0 * share))
        found, expected = (rest_of(setup, each, pose) for each in (faults, tilted))
        assert found == pytest.approx(expected, abs=1e-9)


def test_a_trolley_leans_aside_of_a_body(setup: Setup) -> None:
    for seed in range(8):
        drawn = BY_KEY['gravity_tilt/deflating'].draw(2, setup, np.random.default_rng(seed))
        turned = rotation(np.deg2rad([drawn['gravity_tilt'][0], 0.0, drawn['gravity_tilt'][1]]))
        side = turned @ np.array([0.0, -GRAVITY, 0.0]) * np.array([1.0, 0.0, 1.0])
        ways = [pose.world_from_object[:3, 1:3].T @ side for pose in setup.observations]
        most = max(float(np.linalg.norm(way)) for way in ways)
        assert most > 0.79 * np.linalg.norm(side)


@pytest.mark.parametrize('edge', [0.35, 0.5, 0.7])
def test_an_outweighed_body_is_bent_by_its_holder_up_to_the_edge(
    setup: Setup, edge: float
) -> None:
    shape = setup.shape
    free = shape.length - shape.clamp
    line = np.zeros((1201, 3))
    line[:, 0] = shape.clamp + np.linspace(0.0, 1.0, 1201) * free
    faults = Faults(rest_curvature=(0.0, 0.4), curvature_form='outweighed', curvature_at=edge)
    bent = stress_free_nodes(line, shape, faults)
    steps = np.diff(bent, axis=0)
    assert np.linalg.norm(steps, axis=1).sum() == pytest.approx(free, rel=1e-6)
    angles = np.arctan2(steps[:, 1], steps[:, 0])
    # What a force on the holder turns a place by; what lay on the shelf is straight.
    share = np.minimum((np.arange(1200) + 0.5) / 1200.0, edge)
    expected = angles[-1] * (share / edge) ** 2
    assert angles == pytest.approx(expected, abs=0.02 * float(angles[-1]))
    assert np.ptp(angles[np.arange(1200) > 1200 * edge + 1]) < 1e-9
    arc = stress_free_nodes(line, shape, Faults(rest_curvature=(0.0, 0.4)))
    assert bent[-1, 1] == pytest.approx(arc[-1, 1], rel=0.03)
