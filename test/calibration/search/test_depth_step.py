# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A camera that looks into one of two materials: half of the body would be left out."""

from dataclasses import replace

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.calibration.results.result import CalibrationResult
from diffcal_ros.calibration.search.depth_step import may_have_step
from diffcal_ros.calibration.settings import CalibrationSettings
import numpy as np
import pytest
from support.scenes import beam_scene, MODULUS, noisy, observation, true_depth
from support.two_materials import second_material

_STEP = 0.022  # More than the 20 mm at which a robust fit gives pixels up [m].
_NAME = 'depth_bias_by_region.bias'
_FIT = ('youngs_modulus', 'rigid_offset')
_QUICK = CalibrationSettings(with_mesh_error=False)


def _scene(start: float = MODULUS):
    return beam_scene((8, 2, 2), modulus=start, region_count=2, fit=_FIT)


def _observation(step: float) -> Observation:
    depth = noisy(true_depth(), np.random.default_rng(3))
    depth[second_material()] += step
    return observation(depth)


def _fit(
    step: float, start: float = MODULUS, settings: CalibrationSettings = _QUICK
) -> tuple[Calibration, CalibrationResult]:
    calibration = Calibration(_scene(start), [_observation(step)], settings)
    return calibration, calibration.run()


@pytest.mark.parametrize('step', [_STEP, pytest.param(-0.9 * _STEP, marks=pytest.mark.slow)])
@pytest.mark.parametrize('start', [20e3, pytest.param(1e6, marks=pytest.mark.slow)])
@pytest.mark.slow
def test_a_step_beyond_a_robust_fit_is_found_and_told(step: float, start: float) -> None:
    calibration, result = _fit(step, start)
    assert result.outcome is Outcome.CONVERGED
    # Who goes on from scene and values, as a tracker does, has the same parameters in this order.
    again = Calibration(calibration.scene, [_observation(step)], _QUICK)
    assert again.parameters.names == calibration.parameters.names
    assert result[_NAME].value == pytest.approx(step, abs=5e-4)
    assert result['youngs_modulus.part_0'].value == pytest.approx(MODULUS, rel=0.05)
    assert result.gap_end.coverage > 0.97
    (told,) = (text for text in result.warnings if _NAME in text)
    assert 'part_1' in told
    assert f'too {"far" if step > 0.0 else "near"} beside part_0' in told
    # Every record, also of steps before, knows every parameter, for tables and figures.
    assert all(_NAME in record.values for record in result.history)
    assert calibration.parameters.names == tuple(own.name for own in result.parameters)


@pytest.mark.slow
def test_without_it_half_of_the_body_is_left_out() -> None:
    _, result = _fit(_STEP, settings=replace(_QUICK, looks_farther=False))
    assert result.outcome is not Outcome.CONVERGED
    assert _NAME not in result.values()


@pytest.mark.slow
def test_nothing_is_added_where_both_materials_are_read_alike() -> None:
    _, result = _fit(0.0)
    assert result.outcome is Outcome.CONVERGED
    assert _NAME not in result.values()


@pytest.mark.slow
def test_nothing_is_added_where_something_else_is_missing() -> None:
    """Of half the body there is no depth: no step brings it back."""
    seen = _observation(0.0)
    depth = seen.depth.copy()
    depth[second_material() & (np.arange(len(depth))[:, None] % 4 < 2)] = np.nan
    result = Calibration(_scene(), [replace(seen, depth=depth)], _QUICK).run()
    assert result.outcome is Outcome.MODEL_DISAGREES
    assert _NAME not in result.values()


@pytest.mark.slow
def test_a_step_is_not_added_where_it_only_led_to_a_better_place() -> None:
    """From the first place, a table behind the body taken for it, the way leads over a step."""
    depth = noisy(true_depth(), np.random.default_rng(5))
    table = np.nanmedian(depth[second_material()]) + 0.03
    seen = observation(np.where(np.isnan(depth), table, depth))
    result = Calibration(_scene(20e3), [seen], _QUICK).run()
    assert result.outcome is Outcome.CONVERGED
    assert _NAME not in result.values()
    assert result['youngs_modulus.part_0'].value == pytest.approx(MODULUS, rel=0.05)


def test_who_states_it_is_not_second_guessed() -> None:
    scene = _scene()
    parameters = Calibration(scene, [observation(true_depth())]).parameters
    assert may_have_step(scene, parameters)
    stated = replace(scene, effects={'depth_bias_by_region': {'bias': 0.0}})
    assert not may_have_step(stated, parameters)
    fitted = replace(scene, fit=(*_FIT, _NAME))
    own = Calibration(fitted, [observation(true_depth())]).parameters
    assert not may_have_step(fitted, own)
    single = beam_scene((8, 2, 2), fit=_FIT)
    assert not may_have_step(single, parameters)
