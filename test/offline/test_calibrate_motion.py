# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""From a bag of a released beam to its parameters, and what is said of bags that do not do."""

from dataclasses import replace
import json

from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.errors import RecordingError, SceneError
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.offline.calibrate_recordings import open_inputs, run_calibration
from diffcal_ros.report.figures.gap_over_time import gap_over_time_figure, motion_gaps
from diffcal_ros.report.pages.fit_page import write_report
from diffcal_ros.report.tables.result_table import result_text
from diffcal_ros.scene.load import load_scene
from diffcal_ros.synthetic.filming import Timing
import numpy as np
import pytest
from support.released_beam import DAMPING, record_release, RELEASE_TIME

TRUTH = {'youngs_modulus': 200e3, 'damping': DAMPING, 'density': 1080.0}


# Of a standard error.
_UNSEEN = 0.3


@pytest.fixture(scope='module')
def released(tmp_path_factory):
    return record_release(tmp_path_factory.mktemp('released'), integrator='semi_implicit')


def _fit(made, out, settings):
    inputs = open_inputs(load_scene(made.scene), list(made.bags.values()))
    return (*run_calibration(inputs, settings, out), out)


@pytest.fixture(scope='module')
def fitted(released, tmp_path_factory):
    return _fit(released, tmp_path_factory.mktemp('fit'), CalibrationSettings())


@pytest.fixture(scope='module')
def quick(tmp_path_factory):
    """A fit of linear elements to what linear elements show: the mesh is no part of it."""
    folder = tmp_path_factory.mktemp('quick')
    made = record_release(folder, {'mesh.element': 'linear'}, element=Element.LINEAR)
    return _fit(made, folder / 'fit', CalibrationSettings(with_mesh_error=False))


def test_frames_keep_their_stamps_and_some_are_held_out(released):
    inputs = open_inputs(load_scene(released.scene), list(released.bags.values()))
    instants = [observation.instant for observation in inputs.observations]
    assert [instant.time for instant in instants] == pytest.approx([k / 30.0 for k in range(12)])
    assert [k for k, instant in enumerate(instants) if instant.is_held_out] == [2, 6, 10]
    assert inputs.observations[3].name.endswith(', 0.100 s')


def _come_back_with_honest_errors(result, out):
    assert result.outcome is Outcome.CONVERGED
    for name, true in TRUTH.items():
        found = result[name]
        # The data are of the very mesh that is fitted: no mesh error is to be taken off.
        assert abs(np.log(found.value / true)) < 1.96 * found.std_error / found.value, name
        assert abs(found.value / true - 1.0) < 0.15, name
    # A hundredth of the time between two frames.
    assert result['release_time'].value == pytest.approx(RELEASE_TIME, abs=0.003)
    assert result.gap_held_out.median < 2.0 * result.gap_end.median
    held_out = json.loads((out / 'result.json').read_text())['gap']['held_out']
    assert held_out['pixels'] == result.gap_held_out.pixels
    assert 'held out    median' in result_text('beam', result)


def test_the_parameters_come_back_from_motion_of_the_same_mesh(quick):
    _, result, out = quick
    _come_back_with_honest_errors(result, out)


@pytest.mark.slow
def test_the_parameters_come_back_with_honest_errors(fitted):
    _, result, out = fitted
    _come_back_with_honest_errors(result, out)


@pytest.mark.slow
def test_steps_by_a_tolerance_find_the_same(released, fitted, tmp_path):
    scene = load_scene(released.scene)
    (setup,) = scene.observations
    setup = replace(setup, motion=replace(setup.motion, tolerance=2e-6))
    inputs = open_inputs(replace(scene, observations=(setup,)), list(released.bags.values()))
    settings = CalibrationSettings(with_mesh_error=False)
    _, found = run_calibration(inputs, settings, tmp_path)
    _, expected, _ = fitted
    assert found.outcome is Outcome.CONVERGED
    assert not any('time steps' in warning for warning in found.warnings)
    for name in (*TRUTH, 'release_time'):
        # Steps of both are short enough not to be seen among the noise.
        wrong = abs(found[name].value - expected[name].value)
        assert wrong < _UNSEEN * expected[name].std_error, name


@pytest.mark.slow
def test_the_report_shows_a_few_frames(quick, tmp_path):
    calibration, result, _ = quick
    write_report(tmp_path / 'report.html', calibration, result)
    page = (tmp_path / 'report.html').read_text()
    assert page.count('Depth and residual images of') == 4
    assert 'on frames kept from the fit' in page
    assert page.count('Gap over time of') == 1


def test_every_frame_has_its_gap(quick):
    calibration, result, _ = quick
    (motion,) = motion_gaps(calibration, result)
    assert motion.release_time == result['release_time'].value
    assert [frame.time for frame in motion.frames] == pytest.approx([k / 30.0 for k in range(12)])
    assert [k for k, frame in enumerate(motion.frames) if frame.is_held_out] == [2, 6, 10]
    # All frames together are what the result says of them.
    own = [frame.fitted for frame in motion.frames if not frame.is_held_out]
    assert sum(gap.pixels for gap in own) == result.gap_end.pixels
    square = sum(gap.pixels * gap.rms**2 for gap in own) / result.gap_end.pixels
    assert square**0.5 == pytest.approx(result.gap_end.rms, rel=1e-9)
    before = [frame for frame in motion.frames if frame.time < 0.05]
    falling = [frame for frame in motion.frames if 0.1 < frame.time < 0.2]
    assert max(frame.start.rms for frame in before) < max(frame.start.rms for frame in falling)
    # At some instants the wrong motion passes through the right place.
    assert all(frame.fitted.rms < frame.start.rms for frame in falling)
    axes = gap_over_time_figure(motion).axes[0]
    assert [line.get_label() for line in axes.get_lines()] == [
        'start',
        'fitted',
        'kept from the fit',
        'release',
    ]


@pytest.mark.slow
def test_without_a_prior_motion_shows_only_ratios(released):
    scene = load_scene(released.scene)
    region = scene.regions[0]
    unknown = replace(region.density, prior_mean=None, prior_std=None)
    scene = replace(scene, regions=(replace(region, density=unknown),))
    inputs = open_inputs(scene, list(released.bags.values()))
    settings = CalibrationSettings(with_mesh_error=False)
    _, result = run_calibration(inputs, settings, released.scene.parent / 'ratios')
    assert result.outcome is Outcome.NOT_IDENTIFIABLE
    assert any('only the ratios' in warning for warning in result.warnings)
    # As uncertain as a natural scale of the logarithm, shared by three.
    assert result['density'].std_error > 0.3 * result['density'].value


def test_a_release_that_is_not_in_the_bag_is_told(tmp_path):
    made = record_release(tmp_path, {'motion.at': {'start': 0.15, 'max': 0.2}}, Timing(4))
    with pytest.raises(RecordingError, match=r'release is expected at 0\.17 s: it is never seen'):
        open_inputs(load_scene(made.scene), list(made.bags.values()))


def test_a_body_that_does_not_rest_first_is_told(released):
    scene = load_scene(released.scene)
    (setup,) = scene.observations
    late = replace(setup.motion.release_time, start=0.25, lower=0.2, upper=0.3)
    motion = replace(setup.motion, release_time=late)
    scene = replace(scene, observations=(replace(setup, motion=motion),))
    with pytest.raises(RecordingError, match='must show the body at rest on its support'):
        open_inputs(scene, list(released.bags.values()))


def test_two_bags_of_one_motion_are_refused(released):
    bags = [*released.bags.values(), *released.bags.values()]
    with pytest.raises(SceneError, match='each has its own release, so list them under'):
        open_inputs(load_scene(released.scene), bags)
