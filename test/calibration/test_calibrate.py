# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fits of synthetic twins: another mesh made the data."""

from dataclasses import replace

from diffcal_ros.calibration.calibrate import calibrate, Calibration
from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.errors import InputError, SceneError
from diffcal_ros.rigid_transform import rotation_matrix, transform
import numpy as np
import pytest
from support.scenes import (
    beam_scene,
    CAMERA,
    DEPTH_FROM_WORLD,
    GRAVITY,
    MODULUS,
    noisy,
    observation,
    true_depth,
)

_NO_MESH = {'with_mesh_error': False}


def _inside(parameter, truth: float) -> bool:
    return abs(parameter.value - truth) <= 1.96 * parameter.std_error


@pytest.mark.parametrize('start', [0.6, 1.5])
def test_modulus_is_found_within_its_error(start, random) -> None:
    result = calibrate(
        beam_scene(modulus=start * MODULUS), [observation(noisy(true_depth(), random))]
    )
    assert result.outcome is Outcome.CONVERGED
    modulus = result['youngs_modulus']
    assert _inside(modulus, MODULUS)
    assert 1.96 * modulus.std_error < 0.15 * MODULUS
    assert result.gap_end.median < 0.3e-3
    assert result.gap_end.coverage > 0.97
    assert result.gap_end.median < result.gap_start.median


def test_where_a_fit_ends_can_be_asked_for_alone(random) -> None:
    scene, seen = beam_scene(modulus=80e3), [observation(noisy(true_depth(), random))]
    whole, brief = (Calibration(scene, seen, CalibrationSettings(**_NO_MESH)) for _ in range(2))
    result = whole.run()
    brief.go_to_best()
    assert len(result.history) > 2
    np.testing.assert_allclose(brief.coordinates, whole.coordinates, rtol=1e-6)


def test_rigid_offset_is_found_beside_the_modulus(random) -> None:
    # The body lies 8 mm and 3 degrees from where the pose says.
    wrong = transform(rotation_matrix(np.array([0.02, -0.03, 0.04])), np.array([0.008, -0.004, 0]))
    scene = beam_scene(modulus=80e3, fit=('youngs_modulus', 'rigid_offset'))
    result = calibrate(
        scene, [observation(noisy(true_depth(), random), pose=DEPTH_FROM_WORLD @ wrong)]
    )
    assert result.outcome is Outcome.CONVERGED
    assert _inside(result['youngs_modulus'], MODULUS)
    assert result.gap_end.median < 0.3e-3
    fixed = calibrate(
        replace(scene, fit=('youngs_modulus',)),
        [observation(noisy(true_depth(), random), pose=DEPTH_FROM_WORLD @ wrong)],
        CalibrationSettings(**_NO_MESH),
    )
    assert fixed.gap_end.median > 3.0 * result.gap_end.median


@pytest.mark.slow
def test_two_observations_share_one_modulus(random) -> None:
    # The same body seen from two sides, one further away.
    other = transform(rotation_matrix(np.array([0.1, 0.3, 0.0])), np.array([0.01, 0.02, 0.08]))
    second = other @ DEPTH_FROM_WORLD
    views = [
        observation(noisy(true_depth(), random)),
        observation(noisy(true_depth(depth_from_world=second), random), pose=second),
    ]
    scene = beam_scene(modulus=85e3)
    both = calibrate(scene, views)
    assert _inside(both['youngs_modulus'], MODULUS)
    alone = calibrate(scene, views[:1])
    statistical = [
        np.sqrt(r['youngs_modulus'].std_error ** 2 - r['youngs_modulus'].mesh_error ** 2)
        for r in (alone, both)
    ]
    assert statistical[1] < statistical[0]


@pytest.mark.slow
def test_two_postures_share_one_modulus(random) -> None:
    # Gravity along another axis: the clamp was turned.
    sideways = np.array([0.0, -2.0, 9.6])
    scene = beam_scene(modulus=85e3)
    (setup,) = scene.observations
    scene = replace(scene, observations=(setup, replace(setup, name='turned', gravity=sideways)))
    views = [
        observation(noisy(true_depth(), random)),
        replace(observation(noisy(true_depth(gravity=sideways), random)), setup_index=1),
    ]
    result = calibrate(scene, views)
    assert result.outcome is Outcome.CONVERGED
    assert _inside(result['youngs_modulus'], MODULUS)


def test_data_at_rest_do_not_tell_modulus_from_density(random) -> None:
    result = calibrate(
        beam_scene(modulus=80e3, fit=('youngs_modulus', 'density')),
        [observation(noisy(true_depth(), random))],
        CalibrationSettings(**_NO_MESH),
    )
    assert result.outcome is Outcome.NOT_IDENTIFIABLE
    assert any('ratio of Young' in warning for warning in result.warnings)
    # The ratio itself is found all the same.
    ratio = result['youngs_modulus'].value / result['density'].value
    assert ratio == pytest.approx(MODULUS / 1080.0, rel=0.05)


def test_a_prior_on_the_density_decides(random) -> None:
    scene = beam_scene(modulus=80e3, fit=('youngs_modulus', 'density'))
    (region,) = scene.regions
    known = replace(region.density, prior_mean=1080.0, prior_std=20.0)
    scene = replace(scene, regions=(replace(region, density=known),))
    result = calibrate(scene, [observation(noisy(true_depth(), random))])
    assert result.outcome is Outcome.CONVERGED
    assert _inside(result['youngs_modulus'], MODULUS)
    assert any('prior' in warning for warning in result.warnings)
    # The density's own 2 % stay in the modulus' error.
    assert result['youngs_modulus'].std_error > 0.018 * MODULUS


@pytest.mark.slow
def test_a_bound_is_reported(random) -> None:
    scene = beam_scene(modulus=90e3)
    (region,) = scene.regions
    bounded = replace(region.youngs_modulus, lower=75e3)
    scene = replace(scene, regions=(replace(region, youngs_modulus=bounded),))
    result = calibrate(
        scene, [observation(noisy(true_depth(), random))], CalibrationSettings(**_NO_MESH)
    )
    assert result.outcome is Outcome.AT_BOUND
    assert result['youngs_modulus'].value == pytest.approx(75e3)
    assert result['youngs_modulus'].at_bound


def test_a_linear_model_is_warned_of_its_mesh(random) -> None:
    from diffcal_ros.fem.elements.element import Element

    result = calibrate(
        beam_scene(element=Element.LINEAR), [observation(noisy(true_depth(), random))]
    )
    assert any('mesh' in warning for warning in result.warnings)
    assert _inside(result['youngs_modulus'], MODULUS)


def test_the_clamp_and_what_stands_in_front_weigh_nothing(random) -> None:
    depth = noisy(true_depth(), random)
    plain = calibrate(beam_scene(), [observation(depth)], CalibrationSettings(**_NO_MESH))
    rows, columns = np.nonzero(np.isfinite(depth))
    blocked = depth.copy()
    # Something 60 mm in front hides a stripe of the body, and a wall stands behind it.
    middle = int(np.median(columns))
    blocked[rows.min() - 4 : rows.max() + 5, middle - 6 : middle + 7] = np.nanmin(depth) - 0.06
    blocked[np.isnan(blocked)] = np.nanmax(depth) + 0.15
    result = calibrate(beam_scene(), [observation(blocked)], CalibrationSettings(**_NO_MESH))
    assert result['youngs_modulus'].value == pytest.approx(plain['youngs_modulus'].value, rel=0.02)


@pytest.mark.parametrize(
    ('loss', 'optimizer'),
    [
        ('paper', 'gauss_newton'),
        ('l1', 'gauss_newton'),
        ('l1', 'adam_demon'),
        pytest.param('paper', 'adam_demon', marks=pytest.mark.slow),
    ],
)
@pytest.mark.slow_but_first
def test_whole_image_losses_find_it_too(loss, optimizer, random) -> None:
    if optimizer == 'adam_demon':
        pytest.importorskip('torch')
    result = calibrate(
        beam_scene(modulus=80e3),
        [observation(noisy(true_depth(), random))],
        CalibrationSettings(loss=loss, optimizer=optimizer, **_NO_MESH),
    )
    assert result['youngs_modulus'].value == pytest.approx(MODULUS, rel=0.05)
    assert result.history[-1].loss < result.history[0].loss


def test_stopping_keeps_the_last_state(random) -> None:
    seen = []

    def stop_after_two(record) -> bool:
        seen.append(record)
        return record.number < 2

    result = calibrate(
        beam_scene(modulus=90e3),
        [observation(noisy(true_depth(), random))],
        CalibrationSettings(**_NO_MESH),
        on_iteration=stop_after_two,
    )
    assert result.outcome is Outcome.INTERRUPTED
    assert result.iterations == 2
    assert result['youngs_modulus'].value == pytest.approx(seen[-1].values['youngs_modulus'])


@pytest.mark.parametrize(
    ('fit', 'message'),
    [
        (('nonsense',), "cannot fit 'nonsense'"),
        (('youngs_modulus.tip',), 'the regions of the scene are part_0'),
        ((), 'nothing to fit'),
    ],
)
def test_unknown_parameters_are_named(fit, message) -> None:
    with pytest.raises(SceneError, match=message):
        calibrate(beam_scene(), [observation(true_depth())], CalibrationSettings(fit=fit))


def test_a_body_out_of_view_is_refused() -> None:
    pose = transform(np.eye(3), np.array([3.0, 0.0, 0.3]))
    with pytest.raises(InputError, match="must be in the camera's view"):
        calibrate(beam_scene(), [observation(np.full((240, 320), 0.3), pose=pose)])


def test_no_observation_is_refused() -> None:
    with pytest.raises(InputError, match='at least one recording'):
        calibrate(beam_scene(), [])


@pytest.mark.slow
def test_a_pose_covariance_widens_the_errors(random) -> None:
    seen = observation(noisy(true_depth(), random))
    covariance = np.diag([1e-3, 1e-3, 1e-3, 0.02, 0.02, 0.02]) ** 2
    exact = calibrate(beam_scene(), [seen], CalibrationSettings(**_NO_MESH))
    loose = calibrate(
        beam_scene(),
        [replace(seen, pose_covariance=covariance, pose_pivot=np.array([0.0, 0.05, 0.3]))],
        CalibrationSettings(**_NO_MESH),
    )
    assert loose['youngs_modulus'].std_error > exact['youngs_modulus'].std_error
    assert CAMERA.fx != CAMERA.fy  # the twin is as asymmetric as it says
    assert GRAVITY[1] < 0.0


def test_a_body_that_is_not_found_has_diverged():
    """There is only a wall, far behind where the body is said to be."""
    seen = observation(np.full(true_depth().shape, 1.5))
    result = calibrate(beam_scene((6, 2, 2)), [seen])
    assert not result.gap_end.coverage > 0.0
    assert result.outcome is Outcome.DIVERGED
