# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the twenty-second set do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest
from support.blind_contact import check_pushes, dents_of
from support.blind_derivatives import check_body_stiffness, check_derivatives, check_loose_fibres
from support.blind_draws import draw_faults, draw_sealed, SEALED, STEPS
from support.blind_rests import clamp_motion_and_load, COARSE, lying, rest_of, tip_rises
from support.blind_views import with_and_without

from benchmarks.blind.contact import contact_laws, highest_tops, OUTER
from benchmarks.blind.fattening import sample_grid
from benchmarks.blind.faults import Faults
from benchmarks.blind.fibres import Fibres
from benchmarks.blind.forms import BY_KEY
from benchmarks.blind.laying import lay_on_plane, softer
from benchmarks.blind.moduli import crease_share
from benchmarks.blind.paint import FIXTURE
from benchmarks.blind.pipe import pipe
from benchmarks.blind.rest_shape import stress_free_nodes
from benchmarks.blind.setups import Observation, Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.wick import wick_masses


@pytest.mark.parametrize('pose', range(4))
def test_a_cord_is_as_heavy_everywhere_up_to_where_it_is_wet(
    setup: Setup, plain: Specimen, pose: int
) -> None:
    faults, view = draw_faults('added_mass/wicking', setup), setup.observations[pose]
    found = wick_masses(plain.body.masses, plain.shares, setup, view, faults)
    front, last = faults.mass_places[pose], faults.mass_places[-1]
    assert found.sum() == pytest.approx(1e-3 * faults.added_mass * front / last)
    # Up to the front its middle is halfway there, and its weight that of the body by a factor.
    assert float(found @ plain.shares / found.sum()) == pytest.approx(0.5 * front, abs=0.03)
    within = (plain.shares > 0.0) & (plain.shares < front - 0.06)
    beyond = plain.shares > front + 0.06
    factors = found[within] / plain.body.masses[within]
    assert factors == pytest.approx(np.full(len(factors), factors[0]))
    assert factors[0] > 0.0
    assert not found[beyond].any()


@pytest.mark.parametrize('family', SEALED)
def test_a_cord_is_wet_by_the_root_of_the_time(family: str) -> None:
    squares = np.square(draw_faults('added_mass/wicking', draw_sealed(family)).mass_places)
    steps = np.diff(squares)
    assert steps == pytest.approx(np.full(3, steps.mean()), abs=1e-3)
    assert steps.mean() > 0.1
    assert 0.8 <= np.sqrt(squares[-1]) <= 0.95


def test_creases_fall_by_the_exponential_of_the_square_and_add() -> None:
    share = np.array([0.2, 0.3, 0.5, 0.6, 3.0])
    found = crease_share(share, (0.2, 0.5), 0.1)
    each = np.exp(-np.array([[0.0, 9.0], [1.0, 4.0], [9.0, 0.0], [16.0, 1.0], [784.0, 625.0]]))
    assert found == pytest.approx(each.sum(axis=1))


def test_a_creased_body_is_soft_around_two_places(setup: Setup) -> None:
    faults = draw_faults('stiffness_contrast/creased', setup)
    soft, whole = (make_specimen(setup, each) for each in (faults, Faults()))
    harder = np.log(np.asarray(soft.body.numbers.shear / whole.body.numbers.shear))
    places = whole.body.quadrature.values @ whole.mesh.nodes[whole.mesh.cells]
    share = (places[..., 0] - setup.shape.clamp) / (setup.shape.length - setup.shape.clamp)
    inner, outer = faults.contrast_creases
    width, beyond = faults.contrast_width, share > 0.05
    bells = [np.exp(-(((share - at) / width) ** 2)) for at in (inner, outer)]
    expected = faults.contrast * (bells[0] + bells[1])
    # Shares are told at nodes: in the cells beside the clamp alone is that another thing.
    assert harder[beyond] == pytest.approx(expected[beyond], abs=1e-6)
    for at in (inner, outer):
        assert harder[np.abs(share - at) < 0.05].min() < 0.7 * faults.contrast
    assert np.abs(harder[share > 0.8]).max() < 0.1


@pytest.mark.parametrize('family', SEALED)
def test_bodies_of_other_shapes_are_creased_too(family: str) -> None:
    drawn = draw_sealed(family)
    faults = draw_faults('stiffness_contrast/creased', drawn)
    soft, whole = (make_specimen(drawn, each) for each in (faults, Faults()))
    harder = np.log(np.asarray(soft.body.numbers.shear / whole.body.numbers.shear))
    assert 1.1 * faults.contrast < harder.min() < 0.6 * faults.contrast
    assert harder.max() <= 0.0


@pytest.mark.parametrize('step', STEPS)
@pytest.mark.parametrize('way', [-1.0, 1.0])
def test_interlocked_strips_resist_by_their_energy_beyond_their_play(
    setup: Setup, step: float, way: float
) -> None:
    faults = Faults(stiffening_form='interlocked', stiffening=2.0, stiffening_from=0.04)
    families = make_specimen(setup, faults, COARSE).body.numbers.network
    # One resists a pull, and the other a push.
    signs = [1.0 if each.slack else -1.0 for each in families]
    assert sorted(signs) == [-1.0, 1.0]
    strips = replace(families[signs.index(way)], stiffness=np.array(3e4))
    other = replace(families[signs.index(-way)], stiffness=np.array(3e4))
    random = np.random.default_rng(1)
    along = np.array([1.0 + 0.08 * way, 1.0 - 0.03 * way, 1.0 - 0.03 * way])
    bent = np.diag(along) + random.uniform(-0.02, 0.02, (3, 3))
    check_loose_fibres(strips, bent, step, still=(0.985, 1.0, 1.015))
    assert not other.stress(bent).any()


@pytest.mark.parametrize('step', [1e-7, 1e-8, 1e-9])
@pytest.mark.parametrize('longer', [0.9, 1.07])
def test_a_body_around_a_hose_resists_as_its_forces_change(
    setup: Setup, step: float, longer: float
) -> None:
    faults = Faults(stiffening_form='interlocked', stiffening=2.0, stiffening_from=0.01)
    specimen = make_specimen(setup, faults, COARSE)
    for each in specimen.body.numbers.network:
        assert isinstance(each, Fibres)
        stiffness = 8.0 * np.asarray(each.stiffness) / setup.youngs_modulus
        assert set(np.unique(np.round(stiffness, 9))) == {0.0, 2.0}
    drawn = specimen.mesh.nodes * np.array([longer, longer**-0.5, longer**-0.5])
    check_body_stiffness(specimen.body, drawn, step=step)


def test_a_body_around_a_hose_sags_less_than_a_bare_one(setup: Setup) -> None:
    soft = softer(setup, 0.3)
    listed = [draw_faults('strain_stiffening/interlocked', soft, size) for size in (1, 2)]
    lifts = tip_rises(soft, listed)
    assert 0.002 < lifts[0] < lifts[1] < 0.03


@pytest.mark.parametrize('family', SEALED)
def test_a_hose_has_play_that_a_body_uses_up(family: str) -> None:
    drawn = draw_sealed(family)
    faults = draw_faults('strain_stiffening/interlocked', drawn)
    bare, held = (rest_of(drawn, each) for each in (Faults(), faults))
    assert np.linalg.norm(held - bare, axis=1).max() > 0.0008


def test_wax_flows_by_the_moment_of_each_pose_and_stays(setup: Setup, plain: Specimen) -> None:
    faults, before = draw_faults('compliant_clamp/waxed', setup), np.zeros(3)
    for pose in range(4):
        motion, load = clamp_motion_and_load(setup, plain, faults, pose)
        assert motion[:3] == pytest.approx(0.0, abs=1e-6)
        flowed = faults.clamp_compliance * load[3:]
        assert motion[3:] == pytest.approx(before + flowed, abs=1e-3)
        assert np.linalg.norm(flowed) > 0.01
        before = motion[3:]


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_spindle_is_off_by_one_motion_that_does_not_roll_along(family: str) -> None:
    drawn = draw_sealed(family)
    scatter = np.array(draw_faults('clamp_offset/runout', drawn).clamp_scatter)
    errors = []
    for pose, motion in zip(drawn.observations, scatter, strict=True):
        # The frame of the spindle: the same x, and a z that is as upright as that allows.
        ahead, up = pose.world_from_object[:3, 0], np.array([0.0, 1.0, 0.0])
        upright = up - (up @ ahead) * ahead
        upright /= np.linalg.norm(upright)
        spindle = np.array([ahead, np.cross(upright, ahead), upright])
        turned = spindle @ pose.world_from_object[:3, :3]
        errors.append(np.concatenate([turned @ motion[:3], turned @ motion[3:]]))
    assert np.array(errors) == pytest.approx(np.tile(errors[0], (4, 1)), abs=3e-4)
    assert errors[0][[0, 3]] == pytest.approx(0.0, abs=1e-9)
    # As the body sees it, it goes round.
    assert np.ptp(scatter[:, 4:], axis=0).max() > np.linalg.norm(errors[0][3:])
    way = drawn.shape.length - 0.5 * drawn.shape.clamp
    tip = np.deg2rad(np.linalg.norm(errors[0][3:])) * way
    assert tip == pytest.approx(0.010, rel=0.16)
    assert np.linalg.norm(errors[0][:3]) == pytest.approx(2.0, abs=1e-3)


@pytest.fixture(scope='module')
def on_a_pipe(setup: Setup) -> tuple[Setup, Faults]:
    """A set-up whose body lies on a pipe in the first pose, and that pipe."""
    return lay_on_plane(setup, draw_faults('contact_plane/pipe', setup), np.random.default_rng(1))


def test_a_pipe_lifts_a_body_and_pushes_it_aside(
    on_a_pipe: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_a_pipe
    moves = []
    for pose in range(4):
        found, move = lying(laid, plain, faults, pose)
        dents = dents_of(laid, faults, found, pose)[plain.shares > OUTER['pipe']]
        moves.append(move)
        assert (dents.max() > 0.0) == (pose in (0, 2))
        assert dents.max() < 2e-4
    assert 0.006 < moves[0] < 0.014
    assert moves[0] > moves[2] > 0.001
    assert moves[1] == moves[3] == 0.0
    (law,) = contact_laws(plain.areas, plain.shares, laid.observations[0], faults)
    world = laid.observations[0].world_from_object
    push = world[:3, :3] @ -law(rest_of(laid, faults)).gradient.sum(axis=0)
    tip = world[:3, :3] @ rest_of(laid, faults)[plain.shares > 0.99].mean(axis=0) + world[:3, 3]
    # Away from its axis, and not along that.
    assert push[1] > 0.0
    assert abs(push[0]) < 1e-9
    assert push[2] * (tip[2] - faults.contact_at) > 0.0


def test_a_pipe_is_as_far_from_its_axis_everywhere() -> None:
    faults = Faults(contact_form='pipe', contact_round=0.05, contact_at=0.01, contact_height=0.3)
    angles = np.linspace(-1.4, 1.4, 15)
    axis = np.array([0.0, 0.25, 0.01])
    around = np.stack([np.linspace(-0.2, 0.2, 15), np.cos(angles), np.sin(angles)], axis=-1)
    places = axis + around * np.array([1.0, 0.05, 0.05])
    # What touches it tells how high it reaches; what lies beside it does not.
    assert highest_tops(places, faults) == pytest.approx(np.full(15, 0.3))
    beside = np.array([[0.0, 0.3, 0.061], [0.0, 0.3, -0.041]])
    assert np.isinf(highest_tops(beside, faults)).all()
    # In any frame of a body a dent of a millimetre presses along the normal.
    turn, _ = np.linalg.qr(np.random.default_rng(2).standard_normal((3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    world = np.eye(4)
    world[:3, :3], world[:3, 3] = turn, [0.03, -0.02, 0.04]
    inside = places - 0.001 * around * np.array([0.0, 1.0, 1.0])
    law = pipe(Observation('level', world), faults, np.full(15, 200.0))
    found = law((inside - world[:3, 3]) @ turn)
    pushes = -found.gradient @ turn.T
    assert pushes == pytest.approx(0.2 * around * np.array([0.0, 1.0, 1.0]), abs=1e-9)
    assert found.energy == pytest.approx(15 * 0.5 * 200.0 * 0.001**2)


# Some nodes of that body lie a hair from where they come to the pipe.
@pytest.mark.parametrize('step', [1e-6, 1e-7, 1e-8])
def test_a_pipe_pushes_by_its_energy(
    on_a_pipe: tuple[Setup, Faults], plain: Specimen, step: float
) -> None:
    laid, faults = on_a_pipe
    check_pushes(laid, plain, faults, step)
    # All around it as well.
    angles = np.linspace(-1.4, 1.4, 15)
    around = np.stack([np.linspace(-0.2, 0.2, 15), np.cos(angles), np.sin(angles)], axis=-1)
    alone = replace(faults, contact_height=0.05, contact_at=0.0, contact_round=0.05)
    level = Observation('level', np.eye(4))
    law = pipe(level, alone, np.linspace(50.0, 300.0, 15))
    stiff = check_derivatives(law, around * np.array([1.0, 0.048, 0.048]), step=step, share=1e-4)
    assert stiff.any(axis=1).all()


@pytest.mark.parametrize('pose', range(4))
def test_a_warped_sensor_errs_by_a_saddle(
    setup: Setup, plain: Specimen, rests: list[np.ndarray], pose: int
) -> None:
    faults = draw_faults('depth_affine/warped', setup)
    view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
    rows, columns, _ = np.nonzero(there)
    # Where it is, as a complex number from the principal point: the real part of its square.
    place = (right.column + columns - setup.camera.cx) + 1j * (right.row + rows - setup.camera.cy)
    turned = place * np.exp(-1j * np.deg2rad(faults.depth_slant)) / faults.depth_width
    errors = (view.depth[there] - right.depth[there]) / (1e-3 * faults.depth_bias)
    assert errors == pytest.approx((turned**2).real, abs=1e-9)
    assert np.abs(errors).max() > 0.5
    assert np.ptp(np.abs(errors)) > 0.5


def test_a_saddle_errs_both_ways_by_as_much(setup: Setup, plain: Specimen) -> None:
    slant, far = 25.0, 90.0
    faults = Faults(depth_form='warped', depth_bias=4.0, depth_slant=slant, depth_width=far)
    rest = rest_of(setup, Faults())
    view, right, there = with_and_without(plain, setup, faults, 0, rest)
    errors = np.full(there.shape, np.nan)
    errors[there] = view.depth[there] - right.depth[there]
    grid, centre = sample_grid(errors), np.array([setup.camera.cx, setup.camera.cy])
    rows, columns = np.nonzero(np.isfinite(grid))
    places = np.stack([right.column + columns // 3, right.row + rows // 3], axis=-1) - centre
    ways = np.deg2rad(slant) + np.array([0.0, 0.25, 0.5]) * np.pi
    along, diagonal, across = (places @ [np.cos(way), np.sin(way)] for way in ways)
    found = 1e3 * grid[rows, columns]
    assert found == pytest.approx(4.0 * (along**2 - across**2) / far**2, abs=1e-6)
    level = np.abs(np.abs(along) - np.abs(across)) < 1.0
    assert np.abs(found[level]).max() < 4.0 * np.abs(diagonal).max() * 3.0 / far**2


def test_what_glows_errs_less_from_pose_to_pose(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults = draw_faults('depth_bias_by_region/luminous', setup)
    errors = []
    for pose in range(4):
        view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
        error = view.depth[there] - right.depth[there]
        painted = np.abs(error) > 1e-9
        assert 0.1 < painted.mean() < 0.9
        assert not painted[right.labels[there] == FIXTURE].any()
        assert np.ptp(error[painted]) < 1e-9
        errors.append(float(error[painted][0]))
    assert errors[0] == pytest.approx(1e-3 * faults.region_bias)
    assert abs(errors[0]) == pytest.approx(0.010, rel=0.16)
    # By the inverse of the time: what it is over what it was at first.
    steps = np.diff(errors[0] / np.array(errors))
    assert steps == pytest.approx(np.full(3, steps.mean()), abs=2e-3)
    assert 0.29 < steps.mean() < 0.91


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_table_rocks_one_way_or_back(family: str) -> None:
    drawn = draw_sealed(family)
    faults = draw_faults('gravity_tilt/rocking', drawn)
    assert set(faults.tilt_shares) == {-1.0, 1.0}
    assert 2.0 < np.linalg.norm(faults.gravity_tilt) < 27.0


def test_gravity_is_tilted_by_what_a_table_rocks(setup: Setup) -> None:
    sides = (1.0, -1.0, -1.0, 1.0)
    faults = Faults(tilt_form='rocking', gravity_tilt=(3.0, -7.0), tilt_shares=sides)
    for pose, side in enumerate(sides):
        tilted = Faults(gravity_tilt=(3.0 * side, -7.0 * side))
        found, expected = (rest_of(setup, each, pose) for each in (faults, tilted))
        assert found == pytest.approx(expected, abs=1e-9)


def test_a_table_rocks_to_where_one_part_of_the_rig_is(setup: Setup) -> None:
    for seed in range(6):
        drawn = BY_KEY['gravity_tilt/rocking'].draw(1, setup, np.random.default_rng(seed))
        x, z = drawn['gravity_tilt']
        way = np.array([z, 0.0, -x]) / np.hypot(x, z)
        seen = np.array([way @ pose.world_from_object[:3, :3] for pose in setup.observations])
        sides = np.array(drawn['tilt_shares'])
        # Of all directions from the rig's middle there are some that are where it leans.
        tried = np.random.default_rng(1).standard_normal((20000, 3))
        fits = (np.sign(tried @ seen.T) == sides).all(axis=1)
        assert fits.any()


@pytest.mark.parametrize('prop', [0.45, 0.52, 0.6])
def test_a_propped_body_is_bent_by_its_weight_less_a_block(setup: Setup, prop: float) -> None:
    shape = setup.shape
    free = shape.length - shape.clamp
    line = np.zeros((1201, 3))
    line[:, 0] = shape.clamp + np.linspace(0.0, 1.0, 1201) * free
    faults = Faults(rest_curvature=(0.0, 0.4), curvature_form='propped', curvature_prop=prop)
    bent = stress_free_nodes(line, shape, faults)
    steps = np.diff(bent, axis=0)
    assert np.linalg.norm(steps, axis=1).sum() == pytest.approx(free, rel=1e-6)
    angles = np.arctan2(steps[:, 1], steps[:, 0])
    # What an even load and a force at the tip turn a place by, up to a twelfth of the length.
    share = (np.arange(1200) + 0.5) / 1200.0
    turned = (1.0 - (1.0 - share) ** 3) / 3.0 - 0.5 * prop * (1.0 - (1.0 - share) ** 2)
    lever = 0.25 - prop / 3.0
    expected = 0.4 * free * 0.5 / lever * turned
    assert angles == pytest.approx(expected, abs=0.02 * float(np.abs(expected).max()))
    # The outer part is bent back.
    assert np.argmax(angles) / 1200.0 == pytest.approx(1.0 - prop, abs=0.05)
    arc = stress_free_nodes(line, shape, Faults(rest_curvature=(0.0, 0.4)))
    assert bent[-1, 1] == pytest.approx(arc[-1, 1], rel=0.06)
