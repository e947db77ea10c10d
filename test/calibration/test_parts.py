# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Gap, correlation, fused frames, result file."""

import json

from diffcal_ros.calibration.calibrate import calibrate
from diffcal_ros.calibration.observations.frame_noise import noise_at_rest
from diffcal_ros.calibration.observations.observation import fuse_frames
from diffcal_ros.calibration.residuals.correlation import correlation_lengths
from diffcal_ros.calibration.residuals.gap import measure_gap
from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.calibration.results.result import save_result
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.errors import InputError, RecordingError
import numpy as np
import pytest
from scipy.ndimage import gaussian_filter, uniform_filter
from support.scenes import beam_scene, noisy, observation, true_depth


def test_gap_counts_what_was_found() -> None:
    residual = np.array([[0.001, -0.003, np.nan], [0.002, 0.05, 0.004]])
    counted = np.array([[True, True, True], [True, True, False]])
    gap = measure_gap([residual], [counted], truncation=0.02)
    assert gap.pixels == 3
    assert gap.median == pytest.approx(0.002)
    assert gap.rms == pytest.approx(np.sqrt((1 + 9 + 4) / 3) * 1e-3)
    # Missing (NaN) and beyond the truncation: rendered, but not found.
    assert gap.coverage == pytest.approx(3 / 5)


def test_white_noise_is_correlated_with_itself_only(random) -> None:
    image = random.normal(size=(120, 150))
    square, line = correlation_lengths(image, np.ones(image.shape, dtype=bool))
    assert square == pytest.approx(1.0, abs=0.5)
    assert line == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize('width', [5, 9])
def test_averaged_noise_is_worth_its_square(width, random) -> None:
    # The mean over w x w pixels correlates over a square of side w.
    image = uniform_filter(random.normal(size=(900, 900)), width)
    square, _ = correlation_lengths(image, np.ones(image.shape, dtype=bool))
    assert square == pytest.approx(width, rel=0.25)


def test_correlation_sees_through_a_mask(random) -> None:
    image = gaussian_filter(random.normal(size=(300, 300)), 3.0)
    whole, _ = correlation_lengths(image, np.ones(image.shape, dtype=bool))
    # A beam's shape: a tilted stripe.
    rows, columns = np.mgrid[:300, :300]
    stripe = np.abs(rows - 0.4 * columns - 80) < 35
    seen, _ = correlation_lengths(np.where(stripe, image, 1e3), stripe)
    assert seen == pytest.approx(whole, rel=0.3)


def _frames(images: list[np.ndarray]) -> list[DepthFrame]:
    return [DepthFrame(image.astype(np.float32), number) for number, image in enumerate(images)]


def test_fused_frames_leave_out_what_flies_and_know_their_noise(random) -> None:
    truth = 0.4 + 0.1 * random.random((40, 50))
    images = [truth + random.normal(scale=0.0005, size=truth.shape) for _ in range(15)]
    images[3][10, 10] = 3.0  # a flying pixel
    for image in images[:9]:
        image[20, 20] = np.nan  # seen in fewer than half
    fused = fuse_frames(_frames(images))
    assert fused.frame_count == 15
    assert np.isnan(fused.depth[20, 20])
    assert fused.depth[10, 10] == pytest.approx(truth[10, 10], abs=0.001)
    assert fused.noise == pytest.approx(0.0005 / np.sqrt(15.0), rel=0.1)
    left = fused.depth - truth
    assert np.nanstd(left) == pytest.approx(fused.noise, rel=0.1)


@pytest.mark.parametrize('count', [3, 4, 5, 31])
def test_noise_is_told_alike_by_few_frames_and_by_many(random, count) -> None:
    noise, shape = 0.0007, (80, 100)
    images = [0.5 + random.normal(scale=noise, size=shape) for _ in range(count)]
    told = fuse_frames(_frames(images)).noise * np.sqrt(count)
    # Of three frames the median of what each pixel shows is 17 % less.
    assert told == pytest.approx(noise, rel=0.03)
    assert noise_at_rest(_frames(images)).pixel == pytest.approx(told)


def test_two_frames_do_not_tell_the_noise(random) -> None:
    images = [0.5 + random.normal(scale=0.001, size=(40, 50)) for _ in range(2)]
    assert np.isnan(noise_at_rest(_frames(images)).pixel)


def test_fused_frames_see_between_the_steps_of_a_sensor(random) -> None:
    truth = np.linspace(0.4, 0.401, 4000).reshape(40, 100)
    step, noise = 0.00025, 0.00014
    images = [
        step * np.round((truth + random.normal(scale=noise, size=truth.shape)) / step)
        for _ in range(30)
    ]
    left = fuse_frames(_frames(images)).depth - truth
    assert np.std(left) < 0.2 * step
    # Nor is a part of it the same for all pixels at one height above a step.
    assert np.abs(left.reshape(-1, 50).mean(axis=1)).max() < 0.1 * step


def test_fused_frames_never_mix_two_surfaces(random) -> None:
    """At an edge the pixel sees one surface or the other, of which it takes the more frequent."""
    truth = np.full((20, 20), 0.4)
    images = [truth + random.normal(scale=0.0005, size=truth.shape) for _ in range(15)]
    for image in images[::3]:
        image[5] += 0.1
    for image in images[:8]:
        image[6, :3] = np.nan
    fused = fuse_frames(_frames(images))
    assert np.abs(fused.depth - truth)[np.isfinite(fused.depth)].max() < 0.001
    even = fuse_frames(_frames([truth, truth + 0.1]))
    assert even.depth == pytest.approx(truth + 0.05)


def test_frames_without_depth_are_refused() -> None:
    with pytest.raises(RecordingError, match='at least one'):
        fuse_frames([])
    with pytest.raises(RecordingError, match='every depth pixel is invalid'):
        fuse_frames(_frames([np.full((4, 4), np.nan)]))


def test_result_file_holds_everything_asked_for(tmp_path, random) -> None:
    result = calibrate(
        beam_scene(modulus=80e3),
        [observation(noisy(true_depth(), random))],
        CalibrationSettings(with_mesh_error=False),
    )
    path = tmp_path / 'out' / 'result.json'
    save_result(result, path)
    written = json.loads(path.read_text())
    assert written['outcome'] == Outcome.CONVERGED.value
    modulus = written['parameters']['youngs_modulus']
    assert modulus['value'] == pytest.approx(result['youngs_modulus'].value)
    assert modulus['unit'] == 'Pa'
    assert modulus['start'] == pytest.approx(80e3)
    assert modulus['std_error'] > 0.0
    for end in ('start', 'end'):
        assert set(written['gap'][end]) == {
            'median_mm',
            'rms_mm',
            'coverage',
            'explained',
            'hidden',
            'pixels',
        }
    assert written['iterations'] == len(written['history']) - 1
    assert written['loss']['name'] == 'robust'
    assert written['seconds'] > 0.0


def test_result_keeps_the_old_file_when_it_cannot_be_written(tmp_path, random) -> None:
    result = calibrate(
        beam_scene(), [observation(true_depth())], CalibrationSettings(with_mesh_error=False)
    )
    target = tmp_path / 'result.json'
    target.mkdir()  # a folder in the way
    with pytest.raises(InputError, match=r'result\.json'):
        save_result(result, target)


@pytest.mark.parametrize(
    ('settings', 'message'),
    [
        ({'loss': 'l2'}, "loss is 'l2': use one of robust, paper, l1"),
        ({'optimizer': 'adam'}, "optimizer is 'adam': use one of gauss_newton, adam_demon"),
        ({'optimizer': 'adam_demon'}, 'minimises the whole-image losses'),
        ({'max_iterations': 0}, 'give at least 1'),
    ],
)
def test_impossible_settings_are_refused(settings, message) -> None:
    with pytest.raises(InputError, match=message):
        CalibrationSettings(**settings)
