# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms and causes of the eighth set do what their labels say."""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from support.blind_law import stress_of
from support.blind_rests import COARSE, rest_of, tip_moves

from benchmarks.blind.contact import contact_laws
from benchmarks.blind.eighth_outside import EIGHTH_OUTSIDE
from benchmarks.blind.faults import Faults
from benchmarks.blind.forms import BY_KEY
from benchmarks.blind.hexahedra import mesh_hexahedra
from benchmarks.blind.laying import lay_on_plane, softer
from benchmarks.blind.material import constants, respond, stiffened
from benchmarks.blind.observe import true_camera, true_rendering
from benchmarks.blind.paint import tip_part
from benchmarks.blind.rest_shape import stress_free_nodes
from benchmarks.blind.rotations import applied
from benchmarks.blind.rubber import draw_rubber
from benchmarks.blind.setups import Setup
from benchmarks.blind.simulation import make_specimen, Specimen
from benchmarks.blind.springs import foam_stiffness

Depths = Callable[[Faults, int], np.ndarray]


def _motion(clean: np.ndarray, found: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return by what nodes turn on the whole, small angles [rad], and shift [m]."""
    middle = clean.mean(axis=0)
    arms, moves = clean - middle, found - clean
    slopes = np.linalg.lstsq(arms, moves - moves.mean(axis=0), rcond=None)[0].T
    skew = 0.5 * (slopes - slopes.T)
    return np.array([skew[2, 1], skew[0, 2], skew[1, 0]]), moves.mean(axis=0)


def test_a_camera_sags_about_its_foot_less_and_less(
    setup: Setup, plain: Specimen, depths: Depths
) -> None:
    foot = (0.01, 0.15, -0.02)
    sagging = Faults(camera_turn=(-2.0, 0.0, 0.0), camera_foot=foot, camera_sags=True)
    off = true_camera(plain, setup, sagging) @ np.linalg.inv(setup.depth_from_world)
    assert applied(off, np.array([foot]))[0] == pytest.approx(foot, abs=1e-12)
    assert off[2, 1] == pytest.approx(np.sin(np.deg2rad(2.0)), rel=1e-9), 'it looks down'
    assert np.array_equal(depths(sagging, 0), depths(Faults(), 0))
    assert np.array_equal(depths(sagging, 3), depths(replace(sagging, camera_sags=False), 3))
    for pose in (1, 2):
        share = (1.0 - np.exp(-0.8 * pose)) / (1.0 - np.exp(-2.4))
        assert share > pose / 3.0
        steady = replace(sagging, camera_sags=False, camera_turn=(-2.0 * share, 0.0, 0.0))
        assert np.array_equal(
            np.isfinite(depths(sagging, pose)), np.isfinite(depths(steady, pose))
        )


def test_a_clamp_is_closed_one_way_and_then_another(setup: Setup, plain: Specimen) -> None:
    changes = BY_KEY['clamp_offset/clamped twice'].draw(2, setup, np.random.default_rng(8))
    held = plain.mesh.held
    motions = []
    for pose in range(4):
        found = rest_of(setup, Faults(**changes), pose)[held]
        turn, shift = _motion(plain.mesh.nodes[held], found)
        assert 4.5 < 1e3 * np.linalg.norm(shift) < 7.5
        assert 4.5 < np.rad2deg(np.linalg.norm(turn)) < 7.5
        motions.append(1e3 * shift)
    steps = [np.linalg.norm(new - old) > 1e-3 for old, new in pairwise(motions)]
    assert sum(steps) == 1
    assert motions[0] == pytest.approx(changes['clamp_shift'], abs=0.02)


def test_foam_turns_a_rigid_body_by_its_compliance_and_more_at_its_mouth(
    plain: Specimen,
) -> None:
    nodes, held = plain.mesh.nodes, plain.mesh.held
    clamp, compliance = 2.0 * plain.center[0], 2.0
    stiffness = foam_stiffness(nodes, plain.areas, held, clamp, compliance)
    assert set(np.flatnonzero(stiffness)) == set(held[plain.areas[held] > 0.0])
    middle = stiffness @ nodes / stiffness.sum()
    assert middle[0] < 0.5 * clamp
    by_turn = [
        (stiffness * (np.cross(axis, nodes - middle) ** 2).sum(axis=1)).sum()
        for axis in (np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0]))
    ]
    assert np.mean(by_turn) == pytest.approx(1.0 / compliance, rel=1e-9)


def test_a_body_in_a_lined_jaw_bears_its_weight_on_the_foam(setup: Setup, plain: Specimen) -> None:
    held, turns = plain.mesh.held, []
    for compliance in (1e-4, 1.0):
        found = rest_of(setup, Faults(clamp_form='lined', clamp_compliance=compliance))
        turn, _ = _motion(plain.mesh.nodes[held], found[held])
        turns.append(float(np.rad2deg(np.linalg.norm(turn))))
    # In hard foam what is held hardly turns; in soft foam it does, and it is bent as well.
    assert turns[0] < 0.1
    assert 2.0 < turns[1] < 10.0
    nodes = plain.mesh.nodes
    stiffness = foam_stiffness(nodes, plain.areas, held, 2.0 * plain.center[0], 1.0)
    pull = stiffness @ (found - nodes)
    weight = 9.81 * (plain.body.masses + plain.added).sum()
    down = -setup.observations[0].world_from_object[1, :3]
    assert pull == pytest.approx(weight * down, rel=1e-4, abs=1e-6)


def test_a_set_body_is_bent_most_at_its_clamp_and_its_tip_moves_as_an_arcs(
    setup: Setup,
) -> None:
    mesh = mesh_hexahedra(setup.shape)
    on_line = np.abs(mesh.lattice[:, 1:]).max(axis=1) < 1e-9
    order = np.argsort(mesh.lattice[on_line, 0])
    lines = {}
    for form in ('arc', 'set'):
        faults = Faults(rest_curvature=(1.2, -1.6), curvature_form=form)
        lines[form] = stress_free_nodes(mesh.nodes, setup.shape, faults)[on_line][order]
    tips = {form: line[-1] for form, line in lines.items()}
    moved = np.linalg.norm(tips['arc'][1:])
    assert np.linalg.norm(tips['set'] - tips['arc']) < 0.05 * moved
    middle = len(order) // 2
    halves = {form: np.linalg.norm(line[middle, 1:]) for form, line in lines.items()}
    assert halves['set'] > 1.2 * halves['arc']


def test_a_sleeve_stiffens_the_outside_of_the_inner_part(setup: Setup, plain: Specimen) -> None:
    faults = BY_KEY['stiffness_contrast/sleeve'].draw(2, setup, np.random.default_rng(8))
    assert faults['contrast'] < 0.0
    sleeved, whole = (make_specimen(setup, each, 1.0) for each in (Faults(**faults), Faults()))
    stiffer = np.log(np.asarray(sleeved.body.numbers.shear / whole.body.numbers.shear))
    assert set(np.round(stiffer.ravel(), 9)) == {0.0, round(-faults['contrast'], 9)}
    points = stiffer > 0.1
    nodes = whole.shares[whole.body.cells[points.any(axis=1)]]
    assert nodes.min() == 0.0
    assert nodes.max() < 0.5
    assert not points.all(axis=1).any(), 'the core stays'


@pytest.mark.parametrize('law', ['stable', 'plain', 'mooney'])
def test_a_law_of_veronda_and_westmann_is_theirs_and_keeps_what_the_rubber_has(law: str) -> None:
    amount = 12.0
    rubber = draw_rubber(law, np.random.default_rng(3))
    before = rubber.numbers(np.array(1e5), 0.49)
    numbers = stiffened(before, 'veronda_westmann', amount)
    F = np.eye(3) + np.random.default_rng(1).uniform(-0.05, 0.1, size=(3, 3))
    right = F.T @ F
    first = np.trace(right)
    second = 0.5 * (first**2 - np.trace(right @ right))
    mu = 0.75 * float(before.shear)
    own = mu / amount * np.expm1(amount * (first - 3.0)) - 0.5 * mu * (
        second - 3.0 - 4.0 * (np.linalg.det(F) - 1.0)
    )
    # The law's first term counts twice, and Fung's takes it away again.
    lam = float(before.bulk) - 0.625 * float(before.shear)
    doubled = replace(before, shear=2.0 * before.shear, bulk=lam + 1.25 * before.shear)
    expected = respond(F, doubled).energy - mu * (first - 3.0) + own
    assert respond(F, numbers).energy == pytest.approx(float(expected), rel=1e-9)
    assert np.abs(stress_of(np.eye(3), numbers)).max() < 1e-6


def test_what_stiffens_by_an_exponential_gives_way_less_and_less(setup: Setup) -> None:
    form, world = BY_KEY['strain_stiffening/veronda_westmann'], softer(setup, 0.3)
    sags = []
    for size in (None, 1, 2):
        changes = {} if size is None else form.draw(size, setup, np.random.default_rng(8))
        found = rest_of(world, Faults(**changes))
        sags.append(float(np.abs(found - make_specimen(world, Faults(), COARSE).mesh.nodes).max()))
    assert sags[0] - sags[1] > 0.002
    assert sags[1] > sags[2]
    # Yeoh's law of the same slope at rest stays behind where the strain is large.
    plain = constants(np.array(1e5), 0.49)
    exponential = stiffened(plain, 'veronda_westmann', 40.0)
    square = constants(np.array(1e5), 0.49, 40.0)
    ratios = []
    for stretch in (1.01, 1.3):
        F = np.diag([stretch, stretch**-0.5, stretch**-0.5])
        one, other = (stress_of(F, law) for law in (exponential, square))
        ratios.append((one - other)[0, 0] / (one[0, 0] - one[1, 1]))
    assert abs(ratios[0]) < 0.1
    assert ratios[1] > 0.3


def test_half_of_a_sensors_mass_is_its_cables(setup: Setup) -> None:
    faults = Faults(added_mass=3.0, added_mass_at=0.8, mass_form='cable')
    specimen = make_specimen(setup, faults, 1.0)
    added, shares = specimen.added, specimen.shares
    assert added.sum() == pytest.approx(0.003, rel=1e-9)
    # Evenly up to the place: a half of the half is nearer than half of it.
    assert added[shares < 0.4].sum() / 0.003 == pytest.approx(0.25, abs=0.04)
    assert added @ shares / 0.003 == pytest.approx(0.5 * 0.4 + 0.5 * 0.8, abs=0.03)
    upper = added @ specimen.mesh.nodes[:, 2] / 0.003
    assert upper > 0.25 * setup.shape.section[1]


def test_an_error_of_the_near_field_falls_with_the_depth(setup: Setup, depths: Depths) -> None:
    distance = float(np.linalg.norm(setup.depth_from_world[:3, 3]))
    for pose in (0, 2):
        clean = depths(Faults(), pose)
        seen = np.isfinite(clean)
        error = depths(Faults(depth_bias=2.0, depth_form='near field'), pose)[seen] - clean[seen]
        expected = 0.002 * np.exp((distance - clean[seen]) / 0.1)
        assert np.allclose(error, expected, atol=1e-12)
        assert np.ptp(error) > 0.0004


def test_a_sticker_ends_before_the_tip(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults = Faults(region_from=0.45, region_until=0.85, region_ramp=0.08)
    observation, nodes = setup.observations[1], plain.mesh.nodes
    view = true_rendering(plain, setup, observation, faults, nodes)
    part = tip_part(view.labels)
    rows, columns, _ = np.nonzero(part > 0.0)
    z = view.depth[part > 0.0]
    x = (columns + view.column - setup.camera.cx) / setup.camera.fx * z
    y = (rows + view.row - setup.camera.cy) / setup.camera.fy * z
    from_camera = np.linalg.inv(setup.depth_from_world @ observation.world_from_object)
    shares = setup.shape.arc_share(applied(from_camera, np.stack([x, y, z], axis=-1)))
    assert 0.36 < shares.min() < 0.46
    assert 0.84 < shares.max() < 0.94
    full = part[part > 0.0] == 1.0
    assert 0.44 < shares[full].min() < 0.54
    assert 0.76 < shares[full].max() < 0.86
    assert full.mean() > 0.6


def test_a_mat_presses_back_more_the_thinner_it_is(setup: Setup, plain: Specimen) -> None:
    observation = replace(setup.observations[0], world_from_object=np.eye(4))
    faults = Faults(contact_height=0.0, contact_form='mat')
    (law,) = contact_laws(plain.areas, plain.shares, observation, faults)
    node = int(plain.areas.argmax())
    pushes = []
    for dent in (0.0005, 0.0015, 0.0025, 0.0035):
        places = [np.full((len(plain.areas), 3), 1.0) for _ in range(3)]
        for place, step in zip(places, (-1e-7, 0.0, 1e-7), strict=True):
            place[node, 1] = step - dent
        low, here, high = (law(place) for place in places)
        push = -here.gradient[node, 1]
        assert (low.energy - high.energy) / 2e-7 == pytest.approx(push, rel=1e-5)
        slope = (high.gradient - low.gradient)[node, 1] / 2e-7
        assert slope == pytest.approx(here.diagonal[node, 1, 1], rel=1e-5)
        pushes.append(push / plain.areas[node])
    assert pushes[:3] == pytest.approx([60.0, 300.0, 1500.0], rel=1e-6)
    assert pushes[3] > 5000.0


def test_a_body_sinks_into_a_mat_by_less_than_its_thickness(setup: Setup) -> None:
    changes = BY_KEY['contact_plane/mat'].draw(2, setup, np.random.default_rng(8))
    laid, faults = lay_on_plane(setup, Faults(**changes), np.random.default_rng(1))
    hard, free = replace(faults, contact_form='hard'), replace(faults, contact_height=None)
    lifted, on_hard, hanging = (rest_of(laid, each) for each in (faults, hard, free))
    heights = applied(laid.observations[0].world_from_object, lifted)[:, 1]
    assert faults.contact_height is not None
    assert -0.003 < heights.min() - faults.contact_height < -0.0003
    assert 0.002 < np.abs(lifted - hanging).max() < np.abs(on_hard - hanging).max()
    assert np.array_equal(rest_of(laid, faults, 1), rest_of(laid, free, 1))


@pytest.mark.parametrize('name', ['hose', 'parted', 'memory'])
def test_a_cause_outside_moves_the_tip(setup: Setup, plain: Specimen, name: str) -> None:
    faults = Faults(**EIGHTH_OUTSIDE[name](2, setup, np.random.default_rng(8)).changes)
    at_tip = make_specimen(setup, faults, COARSE).shares > 0.99
    moves = tip_moves(setup, plain, faults, at_tip)
    assert 0.002 < max(moves) < 0.03
    # What remembers has nothing to remember when it is first seen.
    assert (moves[0] < 1e-9) == (name == 'memory')


def test_a_hose_draws_its_place_to_where_it_would_be(setup: Setup, plain: Specimen) -> None:
    near = np.abs(plain.shares - 0.6) < 0.05
    target = plain.mesh.nodes[near].mean(axis=0) + np.array([0.0, 0.006, -0.004])
    away = []
    for stiffness in (0.0, 5.0, 500.0):
        faults = Faults(hose=stiffness, hose_at=0.6, hose_offset=(0.0, 6.0, -4.0))
        away.append(np.linalg.norm(rest_of(setup, faults)[near].mean(axis=0) - target))
    assert away[0] > 1.1 * away[1]
    assert away[2] < 0.15 * away[0]


def test_a_parted_mould_makes_a_body_higher_and_no_wider(setup: Setup) -> None:
    higher, plain = (make_specimen(setup, each, 1.0) for each in (Faults(parted=0.1), Faults()))
    one, other = (np.ptp(each.mesh.nodes, axis=0) for each in (higher, plain))
    assert one == pytest.approx(other * [1.0, 1.0, 1.1], rel=1e-9)
    assert higher.body.masses.sum() == pytest.approx(1.1 * plain.body.masses.sum(), rel=1e-9)


def test_a_body_with_a_memory_rests_under_a_mixture_of_two_loads(setup: Setup) -> None:
    last, before = (setup.observations[pose].world_from_object[1, :3] for pose in (3, 2))
    mixed = 0.7 * last + 0.3 * before
    found = rest_of(setup, Faults(memory=0.3), 3)
    # The same as gravity that points and weighs so.
    turn = np.linalg.svd(mixed[None])[2]
    if np.linalg.det(turn) < 0.0:
        turn[2] *= -1.0
    up = np.sign(turn[0] @ mixed)
    world = np.eye(4)
    world[:3, :3] = np.stack([-up * turn[1], up * turn[0], turn[2]])
    posed = replace(setup.observations[3], world_from_object=world)
    lighter = replace(setup, density=setup.density * float(np.linalg.norm(mixed)))
    lighter = replace(lighter, observations=(*setup.observations[:3], posed))
    assert np.abs(found - rest_of(lighter, Faults(), 3)).max() < 1e-8


def test_tiles_have_an_error_each_that_stays(setup: Setup, depths: Depths) -> None:
    faults = Faults(tiles=3.0, tiles_edge=32, tiles_seed=5)
    errors: dict[float, int] = {}
    for pose in (0, 1):
        clean = depths(Faults(), pose)
        seen = np.isfinite(clean)
        found = np.round(depths(faults, pose)[seen] - clean[seen], 9)
        for error in np.unique(found):
            errors[float(error)] = errors.get(float(error), 0) + 1
    assert 5 < len(errors) < 60
    assert max(errors.values()) == 2, 'both poses cross some tile'
    assert 0.0015 < np.std(list(errors)) < 0.0045
