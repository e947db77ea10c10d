# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A fixture in view parts a camera that is elsewhere from a body that sits elsewhere."""

from dataclasses import replace
import re

from diffcal_ros.calibration.parameters.fixture_offset import fixture_offset_parameters
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.diagnose import diagnose
from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.diagnosis.patches.patch_gap import patch_gap
from diffcal_ros.diagnosis.patches.rigid_reference import _widened
from diffcal_ros.diagnosis.patches.whitened import Part
from diffcal_ros.scene.sections.fixture import blocks_fixture
import numpy as np
import pytest
from scipy.ndimage import binary_dilation
from support.fixtured_beam import BLOCK, block_depth, FRAMES, scene, seen, SHIFT
from support.scenes import (
    DEPTH_FROM_WORLD,
    noisy,
    observation,
    true_depth,
    WORLD_FROM_OBJECT,
)


@pytest.fixture(scope='module')
def still():
    nothing = np.zeros(3)
    return seen(body_shift=nothing, block_shift=nothing)


@pytest.fixture(scope='module')
def agreed(still):
    """The diagnosis of it, where nothing is off."""
    return diagnose(scene(), [still])


def test_body_and_block_agree_where_nothing_is_off(agreed):
    nominal = agreed.nominal
    rigid = [group for group in nominal.groups if group.is_rigid]
    assert {group.kind for group in rigid} == {'depth', 'edge'}
    values = np.concatenate([group.patches.values for group in rigid])
    assert len(values) > 10
    # A tenth of a pixel at the outline, a tenth of the depth's step within.
    assert np.sqrt(np.mean(values**2)) < 1e-4
    assert agreed.diagnosis.verdict is Verdict.AGREE


@pytest.mark.parametrize('reach', [1, 4, 10])
@pytest.mark.parametrize('corner', [(0, 0), (200, 260), (470, 630)])
def test_what_is_near_the_body_is_found_wherever_it_is(corner, reach, random):
    marks = np.zeros((480, 640), dtype=bool)
    row, column = corner
    part = marks[row : row + 40, column : column + 60]
    part[:] = random.random(part.shape) < 0.05
    np.testing.assert_array_equal(_widened(marks, reach), binary_dilation(marks, iterations=reach))
    assert not _widened(np.zeros_like(marks), reach).any()


def test_the_gap_that_is_told_is_the_bodys(agreed):
    with_block = agreed.nominal
    bodies = [group for group in with_block.groups if not group.is_rigid]
    assert len(bodies) < len(with_block.groups)
    for part in Part:
        assert patch_gap(with_block.groups, part) == patch_gap(bodies, part)


def test_what_the_block_hides_of_the_body_is_not_compared(random):
    """A block that is wider than the beam, and reaches over it for a tenth of its length."""
    jaws = blocks_fixture([np.array([[-0.030, -0.011, -0.009], [0.012, 0.037, 0.026]])])
    before, body = block_depth(block=jaws), true_depth()
    hidden = np.isfinite(body) & (before < body)
    assert hidden.sum() > 300
    depth = noisy(np.fmin(body, before), random)
    taken = replace(observation(depth), frame_count=FRAMES, noise=0.00014)
    evaluator, nominal = fit_nominal(replace(scene(), fixture=jaws), [taken], None)
    own = [group for group in evaluator.groups(nominal.coordinates) if not group.is_rigid]
    shown = np.isfinite(body) & ~hidden
    pixels = sum(group.patches.weights.sum() for group in own if group.kind == 'depth')
    assert pixels < 1.02 * shown.sum()
    # Nothing of the body was thrown out beside them: they are millimetres nearer.
    assert evaluator.left_out == frozenset()


def test_the_picture_of_what_is_left_shows_the_block_before_the_body():
    moved = seen(body_shift=np.zeros(3), block_shift=np.array([0.0, 0.0, 0.003]))
    evaluator, nominal = fit_nominal(scene(), [moved], None)
    # Where it is stated: the fit lets it go where it is seen.
    is_own = [name.startswith('fixture_offset') for name in nominal.parameters.names]
    (left,) = evaluator.residual_images(np.where(is_own, 0.0, nominal.coordinates))
    group, body = block_depth(), true_depth()
    is_block = np.isfinite(group) & ~(body < group)
    assert np.nanmedian(left[is_block]) == pytest.approx(0.003, abs=3e-4)
    assert abs(np.nanmedian(left[np.isfinite(body) & ~np.isfinite(group)])) < 1e-3


@pytest.mark.slow
def test_only_camera_reading_and_its_own_place_move_the_block(agreed):
    """Tangents agree with differences of three steps, and are zero for what moves the body."""
    evaluator, nominal = agreed.evaluator, agreed.nominal
    names = ('youngs_modulus', 'clamp_offset', 'rigid_offset', 'depth_affine')
    made = make_parameters(scene(), names, with_edge_bias=False)
    parameters = ParameterSet((*made.parameters, *fixture_offset_parameters()))
    wide = evaluator.of(evaluator.model.with_parameters(scene(), parameters))
    start = parameters.start()
    # From a place of its own that is turned about all axes.
    start[-6:] = 0.002, -0.001, 0.0015, 0.01, -0.02, 0.015
    start[0] = nominal.coordinates[nominal.parameters.names.index(parameters.names[0])]

    def depths(coordinates):
        groups = [b for b in wide.groups(coordinates) if b.is_rigid and b.kind == 'depth']
        return groups[0].patches

    here = depths(start)
    is_body = np.array(
        [name.partition('.')[0] in ('youngs_modulus', 'clamp_offset') for name in parameters.names]
    )
    assert 0 < is_body.sum() < len(is_body)
    assert not here.jacobian[:, is_body].any()
    for place in np.flatnonzero(~is_body):
        name, slope = parameters.names[place], here.jacobian[:, place]
        errors = []
        for step in (4e-4, 2e-4, 1e-4):
            ahead, behind = start.copy(), start.copy()
            ahead[place], behind[place] = start[place] + step, start[place] - step
            both = [depths(at) for at in (ahead, behind)]
            shared = np.intersect1d(np.intersect1d(both[0].cells, both[1].cells), here.cells)
            rows = [np.searchsorted(p.cells, shared) for p in (*both, here)]
            change = (both[1].values[rows[1]] - both[0].values[rows[0]]) / (2.0 * step)
            # A pixel that joins or leaves a patch at its rim changes its mean a little.
            errors.append(float(np.median(np.abs(change - slope[rows[2]]))))
        assert min(errors) < 0.03 * max(float(np.abs(slope).max()), 0.05), (name, errors)


@pytest.mark.parametrize('shift', [[0.001, -0.0004, 0.0008], [-0.0005, 0.0007, -0.0011]])
@pytest.mark.slow
def test_a_block_a_millimetre_from_where_it_is_stated_is_no_fault_of_the_body(shift, agreed):
    """Nor of the camera, nor of how the body is held."""
    off = seen(body_shift=np.zeros(3), block_shift=np.array(shift))
    trace = diagnose(scene(), [off])
    assert trace.diagnosis.verdict is Verdict.AGREE
    assert not any('the fixture is seen' in note for note in trace.diagnosis.notes)
    value = 'youngs_modulus'
    index = agreed.nominal.parameters.names.index(value)
    error = np.sqrt(trace.nominal.covariance[index, index])
    apart = trace.nominal.coordinates[index] - agreed.nominal.coordinates[index]
    assert abs(apart) < error
    names = trace.nominal.parameters.names
    place = [names.index(f'fixture_offset.{axis}') for axis in 'xyz']
    found = DEPTH_FROM_WORLD[:3, :3] @ WORLD_FROM_OBJECT[:3, :3] @ trace.nominal.coordinates[place]
    # The camera's pose may have taken up what is known of it.
    assert np.linalg.norm(found - shift) < 0.7 * np.linalg.norm(shift)


def test_a_block_far_from_where_it_is_stated_is_told():
    moved = seen(body_shift=np.zeros(3), block_shift=np.array([0.0, 0.006, 0.0]))
    told = diagnose(scene(), [moved]).diagnosis
    assert any(re.search(r'the fixture is seen [56]\.', note) for note in told.notes)


def test_a_scene_without_a_fixture_has_no_place_for_one(still):
    evaluator, _ = fit_nominal(scene(has_fixture=False), [still], None)
    assert not any('fixture' in name for name in evaluator.model.parameters.names)


def test_a_fixture_that_is_not_seen_is_told(still, agreed):
    behind = replace(BLOCK, positions=BLOCK.positions - np.array([0.5, 0.0, 0.0]))
    elsewhere = replace(scene(), fixture=behind)
    trace = diagnose(elsewhere, [still])
    assert 'test does not show the fixture' in trace.diagnosis.notes
    assert trace.diagnosis.verdict is Verdict.AGREE
    assert not any('fixture' in note for note in agreed.diagnosis.notes)


@pytest.mark.slow
@pytest.mark.parametrize(
    ('name', 'block_shift', 'frame'),
    [
        ('camera_offset', SHIFT, np.eye(4)),
        ('clamp_offset', np.zeros(3), DEPTH_FROM_WORLD @ WORLD_FROM_OBJECT),
    ],
)
def test_one_pose_tells_the_cameras_place_from_the_clamps(name, block_shift, frame):
    shifted = seen(body_shift=SHIFT, block_shift=block_shift)
    alone = diagnose(scene(has_fixture=False), [shifted]).diagnosis
    assert {'camera_offset', 'clamp_offset'} <= set(alone.ambiguity_set)
    told = diagnose(scene(), [shifted]).diagnosis
    assert told.ambiguity_set == (name,)
    assert [effect.identifier for effect in told.effects] == [name]
    found = [told.effects[0].amplitude[axis] for axis in 'xyz']
    # The clamp's offset is told in the object's frame.
    np.testing.assert_allclose(frame[:3, :3] @ found, 1e3 * SHIFT, atol=0.4)
