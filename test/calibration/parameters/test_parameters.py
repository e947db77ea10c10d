# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace

from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.parameters.parameters import Kind
from diffcal_ros.errors import SceneError
from diffcal_ros.scene.fit_names import allowed_fit_names
import numpy as np
import pytest
from support.moving_beams import moving_scene
from support.scenes import beam_scene


def test_every_region_gets_its_own_modulus() -> None:
    scene = beam_scene(region_count=2)
    assert make_parameters(scene, ('youngs_modulus',)).names == (
        'youngs_modulus.part_0',
        'youngs_modulus.part_1',
        'edge_bias',
    )
    assert make_parameters(scene, ('youngs_modulus.part_1',)).names[0] == 'youngs_modulus.part_1'


def test_coordinates_and_values_are_inverse() -> None:
    parameters = make_parameters(beam_scene(), ('youngs_modulus', 'poissons_ratio'))
    values = parameters.values(parameters.start())
    assert values['youngs_modulus'] == pytest.approx(60e3)
    assert values['poissons_ratio'] == pytest.approx(0.45)
    lower, upper = parameters.bounds()
    assert lower[0] == pytest.approx(np.log(1e3))
    assert upper[1] == pytest.approx(0.499)


def test_a_prior_on_a_modulus_acts_on_its_logarithm() -> None:
    scene = beam_scene()
    (region,) = scene.regions
    known = replace(region.youngs_modulus, prior_mean=50e3, prior_std=5e3)
    parameters = make_parameters(replace(scene, regions=(replace(region, youngs_modulus=known),)))
    mean, precision = parameters.prior()
    assert mean[0] == pytest.approx(np.log(50e3))
    assert precision[0, 0] == pytest.approx(1.0 / 0.1**2)


def test_a_pose_covariance_becomes_a_joint_prior(random) -> None:
    root = random.normal(size=(6, 6))
    covariance = root @ root.T + np.eye(6)
    parameters = make_parameters(beam_scene(), pose_covariances=[None, covariance])
    places = parameters.find(Kind.CAMERA_POSE)
    assert len(places) == 6
    assert all(parameters.parameters[place].is_nuisance for place in places)
    _, precision = parameters.prior()
    np.testing.assert_allclose(
        precision[np.ix_(places, places)] @ covariance, np.eye(6), atol=1e-9
    )


def test_the_scene_file_allows_the_same_names() -> None:
    scene = moving_scene(region_count=2)
    for name in allowed_fit_names([region.name for region in scene.regions]):
        assert len(make_parameters(scene, (name,))) > 0


def test_a_start_outside_its_bounds_is_refused() -> None:
    scene = beam_scene(modulus=1.0)
    with pytest.raises(SceneError, match='youngs_modulus starts at 1 Pa: it must lie within'):
        make_parameters(scene)
