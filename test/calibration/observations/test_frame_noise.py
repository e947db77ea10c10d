# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What frames of a scene at rest tell of their noise, and of what neighbouring pixels share."""

from collections.abc import Sequence

from diffcal_ros.calibration.observations.frame_noise import frame_noise, FrameNoise, noise_at_rest
from diffcal_ros.depth_frame import DepthFrame
import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

_SIGMA = 0.0004


def _scattered(
    random: np.random.Generator, blur: float, shape: tuple[int, ...] = (5, 96, 128)
) -> np.ndarray:
    """Return frames whose noise is blurred over so many pixels, and as large whatever that is."""
    noise = random.standard_normal(shape)
    if blur:
        noise = gaussian_filter(noise, (0.0, blur, blur), mode='wrap')
        noise /= noise.std()
    surface = 0.4 + 0.1 * random.random(shape[1:])
    return (surface + _SIGMA * noise).astype(np.float32)


def _scatter_of_averages(images: np.ndarray, side: int) -> float:
    """Return the variance over time of averages over squares of so many pixels, in all places."""
    frames, rows, columns = images.shape
    whole = images[:, : rows // side * side, : columns // side * side].astype(float)
    averages = whole.reshape(frames, rows // side, side, columns // side, side).mean(axis=(2, 4))
    return float(averages.var(axis=0, ddof=1).mean())


@pytest.mark.parametrize('blur', [0.0, 1.0, 2.0])
@pytest.mark.parametrize('side', [7, 10])
def test_averages_scatter_as_those_of_so_many_pixels(random, blur, side):
    """Beside what is told of five frames, what two thousand others of that camera show."""
    told = frame_noise(_scattered(random, blur))
    assert told.pixel == pytest.approx(_SIGMA, rel=0.05)
    assert (told.grain > 1.2) == (blur > 0.0)
    expected = _scatter_of_averages(_scattered(random, blur, (2000, 20, 20)), side)
    assert told.pixel**2 * told.grain / side**2 == pytest.approx(expected, rel=0.2)


def test_where_it_is_noisier_far_away_all_places_tell_alike(random):
    images = _scattered(random, 1.5)
    middle = images.mean(axis=0)
    growing = middle + (images - middle) * np.linspace(1.0, 4.0, 128)
    alike, other = frame_noise(images).grain, frame_noise(growing.astype(np.float32)).grain
    assert other == pytest.approx(alike, rel=0.03)


def test_pixels_that_flicker_between_surfaces_share_nothing_for_that(random):
    images = _scattered(random, 0.0)
    images[::2, 40:44] += 0.05
    assert frame_noise(images).grain == pytest.approx(1.0, abs=0.15)


def _frames(images: Sequence[np.ndarray]) -> list[DepthFrame]:
    return [DepthFrame(image, number) for number, image in enumerate(images)]


def test_what_few_frames_or_pixels_show_tells_nothing(random):
    images = _scattered(random, 2.0)
    assert noise_at_rest(_frames(images)).grain > 5.0
    assert np.isnan(noise_at_rest(_frames(images[:2])).pixel)
    assert frame_noise(images[:2]).grain == 1.0
    small = images.copy()
    small[:, 24:] = np.nan
    small[:, :, 24:] = np.nan
    assert frame_noise(small).grain == 1.0, 'nine blocks'
    still = np.repeat(images[:1], 5, axis=0)
    assert frame_noise(still) == FrameNoise(0.0, 1.0)
