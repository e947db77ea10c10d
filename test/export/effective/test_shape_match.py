# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Linear elements are matched to a shape, and to themselves exactly."""

from dataclasses import replace
from types import SimpleNamespace

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.export.effective.shape_match import choose, match_shapes, match_swing, ShapeMatch
from diffcal_ros.fem.elements.element import Element
import numpy as np
import pytest
from support.moving_beams import moving_model, moving_scene
from support.scenes import beam_scene, observation, true_depth

FIT = ('youngs_modulus', 'poissons_ratio')


def prepared(scene):
    settings = CalibrationSettings(fit=FIT, with_mesh_error=False, search=False)
    return Calibration(scene, [observation(true_depth())], settings)


def points(calibration, coordinates):
    return [view.points.copy() for view in calibration.model.views(coordinates)]


def test_a_body_of_linear_elements_is_matched_by_its_own_moduli():
    """Two regions, started from moduli that are off by factors that differ."""
    scene = beam_scene(element=Element.LINEAR, region_count=2)
    calibration = prepared(scene)
    truth = calibration.parameters.start()
    wanted = points(calibration, truth)
    off = prepared(
        replace(
            scene,
            regions=tuple(
                replace(region, youngs_modulus=replace(region.youngs_modulus, start=start))
                for region, start in zip(scene.regions, (110e3, 25e3), strict=True)
            ),
        )
    )
    matches = match_shapes(off, wanted)
    assert choose(matches) is matches[0]
    np.testing.assert_allclose(matches[0].coordinates[:4], truth[:4], atol=1e-5)
    assert matches[0].distance < 1e-8
    assert [own.ceiling for own in matches] == [0.5, 0.4, 0.35, 0.3, 0.2, 0.1, 0.0]


def test_elements_that_lock_get_a_lower_ratio_and_a_lower_modulus():
    quadratic = prepared(beam_scene())
    start = quadratic.parameters.start()
    wanted = points(quadratic, start)
    scene = beam_scene(element=Element.LINEAR)
    linear = prepared(scene)
    corners = [own[: scene.mesh.vertex_count] for own in wanted]
    before = np.linalg.norm(points(linear, start)[0] - corners[0], axis=1).max()
    matches = match_shapes(linear, corners)
    distances = [own.distance for own in matches]
    assert distances == sorted(distances, reverse=True)
    chosen = choose(matches)
    assert chosen.ceiling < 0.45
    assert chosen.coordinates[0] < start[0] - 0.1
    after = np.linalg.norm(points(linear, chosen.coordinates)[0] - corners[0], axis=1).max()
    assert after < 0.2 * before


def test_the_ratio_that_is_nearest_to_the_materials_is_chosen():
    matches = [ShapeMatch(nu, np.zeros(1), far) for nu, far in ((0.5, 3.0), (0.4, 1.15), (0.3, 1))]
    assert choose(matches).ceiling == 0.4
    assert choose(matches[:1]).ceiling == 0.5


@pytest.mark.parametrize('ceiling', [0.5])
def test_ratios_without_an_equilibrium_are_left_out(monkeypatch, ceiling):
    """A tenth of the weight of a planet: nothing holds still at any ratio."""
    calibration = prepared(beam_scene(element=Element.LINEAR, gravity=np.array([0.0, -9.8e6, 0])))
    wanted = [np.zeros((calibration.scene.mesh.vertex_count, 3))]
    assert match_shapes(calibration, wanted) == []


def test_a_swing_is_matched_along_itself_and_not_by_what_shakes_it():
    """Moduli and damping from off by half, with a shiver across that the elements cannot make."""
    times = (0.0, 0.08, 0.12, 0.16, 0.2, 0.25, 0.3)
    scene = moving_scene(element=Element.LINEAR, damping=120.0, fit=('youngs_modulus', 'damping'))
    model = moving_model(scene, times)
    target = SimpleNamespace(model=model, parameters=model.parameters)
    truth = model.parameters.start()
    wanted = [view.points.copy() for view in model.views(truth)]
    moved = np.array(wanted) - np.mean(wanted, axis=0)
    _, _, ways = np.linalg.svd(moved.reshape(len(times), -1), full_matrices=False)
    shiver = np.random.default_rng(5).normal(size=wanted[0].size)
    shiver -= ways.T @ (ways @ shiver)
    shiver *= 5e-5 / np.abs(shiver).max()
    shaken = [
        points + (-1) ** number * shiver.reshape(points.shape)
        for number, points in enumerate(wanted)
    ]
    names = model.parameters.names
    start = truth.copy()
    start[names.index('youngs_modulus')] += 0.15
    start[names.index('damping')] -= 0.4
    found = match_swing(target, shaken, start)
    assert found.is_settled
    np.testing.assert_allclose(found.coordinates[:2], truth[:2], atol=0.02)
