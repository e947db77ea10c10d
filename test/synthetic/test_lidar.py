# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The synthetic sensor's errors, by their statistics."""

from dataclasses import replace

from diffcal_ros.errors import InputError
from diffcal_ros.scene.model import DepthSensor
from diffcal_ros.synthetic.lidar import lidar_of, LidarModel
from diffcal_ros.synthetic.scan import Scan
import numpy as np
import pytest

SHAPE = (150, 200)
PLAIN = LidarModel(noise=0.0, step=0.0, edge_noise=0.0, flying_share=0.0, lost_share=0.0)
# Of a mean or a share over 30,000 pixels, four standard errors.
_FOUR = 4.0 / np.sqrt(SHAPE[0] * SHAPE[1])


def flat(depth: float | np.ndarray = 0.4, cosine: float | np.ndarray = 1.0) -> Scan:
    """A surface at some depth, seen under some angle."""
    ones = np.ones(SHAPE)
    return Scan(depth * ones, cosine * ones, np.ones(SHAPE, dtype=np.int32))


def step_edge(near: float = 0.3, far: float = 0.5) -> Scan:
    """Two surfaces that meet in the middle column."""
    return flat(np.where(np.arange(SHAPE[1]) < SHAPE[1] // 2, near, far)[None])


def measure(model: LidarModel, scan: Scan, seed: int = 1) -> np.ndarray:
    random = np.random.default_rng(seed)
    return model.measure(scan, model.bias_field(SHAPE, random), random).astype(np.float64)


def test_noise_has_its_standard_deviation_and_no_mean():
    error = measure(replace(PLAIN, noise=3e-4), flat()) - 0.4
    assert abs(error.mean()) < 3e-4 * _FOUR
    assert abs(error.std() / 3e-4 - 1.0) < _FOUR


def test_depths_lie_on_the_sensors_steps_without_bias():
    ramp = np.linspace(0.3, 0.31, SHAPE[1])[None]
    depth = measure(replace(PLAIN, step=0.00025), flat(ramp))
    steps = depth / 0.00025
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-3)  # float32 at 0.3 m.
    assert abs((depth - ramp).mean()) < 1e-6


def test_whole_millimetres_are_cut_which_makes_depths_too_small():
    """Of four steps a millimetre, cutting takes 0, 0.25, 0.5 or 0.75 mm: 0.375 on average."""
    ramp = np.linspace(0.3, 0.34, SHAPE[1] * SHAPE[0]).reshape(SHAPE)
    depth = measure(replace(PLAIN, step=0.00025, encoding='16UC1'), flat(ramp))
    np.testing.assert_allclose(1e3 * depth, np.round(1e3 * depth), atol=1e-4)
    assert (depth - ramp).mean() == pytest.approx(-0.375e-3, abs=0.005e-3)


def test_a_whole_millimetre_stays_what_it_is():
    model = replace(PLAIN, step=0.00025, encoding='16UC1')
    millimetres = np.arange(100, 100 + SHAPE[1])
    depth = measure(model, flat(1e-3 * millimetres[None]))
    np.testing.assert_array_equal(np.round(1e3 * depth[0]), millimetres)


def test_flying_and_lost_pixels_lie_beside_edges_only_and_in_their_shares():
    model = replace(PLAIN, flying_share=0.3, lost_share=0.2)
    scan = step_edge()
    depth = measure(model, scan)
    beside = np.zeros(SHAPE, dtype=bool)
    beside[:, SHAPE[1] // 2 - 1 : SHAPE[1] // 2 + 1] = True
    np.testing.assert_allclose(depth[~beside], scan.depth[~beside], rtol=1e-7)
    lost = np.isnan(depth[beside])
    hanging = (depth[beside] > 0.3001) & (depth[beside] < 0.4999)
    error = 4.0 * 0.5 / np.sqrt(beside.sum())
    assert abs(lost.mean() - 0.2) < error
    assert abs(hanging.mean() - 0.3) < error
    assert np.nanmin(depth) >= 0.3 - 1e-7
    assert np.nanmax(depth) <= 0.5 + 1e-7


def test_edges_are_noisier_than_surfaces():
    depth = measure(replace(PLAIN, noise=1e-4, edge_noise=1e-3), step_edge())
    error = depth - step_edge().depth
    middle = SHAPE[1] // 2
    beside, away = error[:, middle - 1 : middle + 1], error[:, : middle - 1]
    assert away.std() == pytest.approx(1e-4, rel=0.05)
    assert beside.std() == pytest.approx(np.hypot(1e-4, 1e-3), rel=0.2)


def test_flat_angles_lose_pixels_more_the_flatter_they_are():
    model = replace(PLAIN, grazing_angle=np.deg2rad(60.0))
    lost = [
        np.isnan(measure(model, flat(cosine=np.cos(np.deg2rad(angle))))).mean()
        for angle in (0.0, 59.0, 70.0, 80.0, 90.0)
    ]
    assert lost[:2] == [0.0, 0.0]
    assert lost[2] == pytest.approx(1.0 - 2.0 * np.cos(np.deg2rad(70.0)), abs=0.5 * _FOUR)
    assert lost[2] < lost[3] < lost[4] == 1.0


def test_nothing_is_seen_outside_the_range_or_where_nothing_is():
    ramp = np.linspace(0.1, 0.9, SHAPE[1])[None] * np.ones(SHAPE)
    ramp[:, :5] = np.nan
    depth = measure(replace(PLAIN, nearest=0.25, farthest=0.6), flat(ramp))
    inside = (ramp >= 0.25) & (ramp <= 0.6)
    np.testing.assert_array_equal(np.isfinite(depth), inside)


def test_the_bias_is_smooth_stays_and_has_its_size():
    model = replace(PLAIN, bias=5e-4)
    first = measure(model, flat(), seed=3) - 0.4
    np.testing.assert_array_equal(first, measure(model, flat(), seed=3) - 0.4)
    assert np.sqrt((first**2).mean()) == pytest.approx(5e-4, rel=1e-3)
    # A wave of a quarter of the image changes by less than an eighth of its height a pixel.
    assert np.abs(np.diff(first, axis=1)).max() < 0.3 * 5e-4
    other = measure(model, flat(), seed=4) - 0.4
    assert abs(np.corrcoef(first.ravel(), other.ravel())[0, 1]) < 0.9


def test_the_same_seed_gives_the_same_image():
    model = LidarModel()
    np.testing.assert_array_equal(
        measure(model, step_edge(), seed=8), measure(model, step_edge(), seed=8)
    )
    assert not np.array_equal(
        measure(model, step_edge(), seed=8), measure(model, step_edge(), seed=9), equal_nan=True
    )


def test_a_scenes_sensor_becomes_a_model():
    model = lidar_of(DepthSensor(noise=2e-4, quantization=5e-4))
    assert (model.noise, model.step, model.encoding) == (2e-4, 5e-4, '32FC1')
    cut = lidar_of(DepthSensor(quantization=0.001, quantization_mode='truncate'), noise=1e-4)
    assert (cut.noise, cut.step, cut.encoding) == (1e-4, LidarModel().step, '16UC1')
    assert lidar_of(DepthSensor(), encoding='16UC1').encoding == '16UC1'


@pytest.mark.parametrize(
    ('change', 'message'),
    [
        ({'encoding': 'mono8'}, r"depth encoding is 'mono8': 32FC1 or 16UC1"),
        ({'noise': -1.0}, r"the sensor's noise is -1: give metres, 0 to 1"),
        ({'noise': float('nan')}, r"the sensor's noise is nan"),
        ({'bias': 2.0}, r"the sensor's bias is 2"),
        ({'flying_share': 0.9, 'lost_share': 0.3}, r'0\.9 and 0\.3: .* sum is at most 1'),
        ({'grazing_angle': 2.0}, r'the grazing angle is 114\.\d+ degrees: give 0 to 90'),
        ({'farthest': 0.05}, r'range of the sensor is 0\.1 to 0\.05 m'),
    ],
)
def test_settings_that_make_no_sense_are_refused(change, message):
    with pytest.raises(InputError, match=message):
        LidarModel(**change)
