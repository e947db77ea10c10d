# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Depth sensors: a scanning lidar in the manner of the L515, an active stereo pair, and others.

The last three are drawn anew in every case, errors of some tenths of a millimetre included that
vary smoothly over the image.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from benchmarks.blind.renderer import Camera, Rendering
from benchmarks.blind.shapes import FloatArray

BoolArray = NDArray[np.bool_]

_ONE_SURFACE = 0.005  # Samples of a pixel within this depth of the nearest are one surface [m].
_FIELD_STEP = 8  # The smooth bias is drawn on every eighth pixel.
_GRAZING = np.deg2rad(78.0)
_HALO_PIXELS = 4.0


@dataclass(frozen=True)
class Sensor:
    """What a sensor adds to the truth.

    Attributes:
        kind: `lidar` or `stereo`.
        noise: standard deviation of a pixel in one frame [m].
        grain: correlation of that noise, standard deviation of its blur [px]; 0 for white.
        step: between the values that it knows [m]; a stereo pair's holds at `step_distance`
            and grows with the square of distance.
        step_distance: where `step` holds [m]; 0: everywhere.
        bias: root mean square of the smooth error that all frames share [m].
        bias_length: over which that error changes [px].
        flying: share of the pixels on an outline that hang behind the surface.
        wall: distance of the dark background, which gives no depth of its own [m].
        standing: share of the variance of the smooth error that is the same in all poses.
        halo: how far the outline's pixels, up to four inside it, read too far at most [m].
        dropout: share of the pixels that a frame misses.
    """

    kind: str
    noise: float
    grain: float
    step: float
    step_distance: float
    bias: float
    bias_length: float
    flying: float
    wall: float = 0.75
    standing: float = 0.5
    halo: float = 0.0
    dropout: float = 0.0


@dataclass(frozen=True)
class Scan:
    """One exact view, pixel by pixel in a window.

    Attributes:
        depth: of the surface that prevails in a pixel [m], shape (h, w); NaN for none.
        behind: what lies behind it: another surface, or the wall [m].
        share: of the pixel that any surface covers.
        is_outline: whether a pixel sees two surfaces.
        loss: probability that a pixel gives nothing, because it is seen too flat.
    """

    depth: FloatArray
    behind: FloatArray
    share: FloatArray
    is_outline: BoolArray
    loss: FloatArray


def lidar(bias: float) -> Sensor:
    """Return a sensor like the L515 with a smooth error of this size [m]."""
    return Sensor('lidar', 0.00014, 0.0, 0.00025, 0.0, bias, 80.0, 0.15)


def stereo(bias: float, distance: float) -> Sensor:
    """Return an active stereo pair that works at about a distance [m]."""
    return Sensor('stereo', 0.00022, 1.2, 0.0002, distance, bias, 80.0, 0.08)


def scanning(random: np.random.Generator, distance: float) -> Sensor:
    """Draw an L515: errors of 0.2 to 0.4 mm that are smooth, most of them from its own optics."""
    return Sensor(
        'l515',
        noise=random.uniform(0.0001, 0.0003),
        grain=0.0,
        step=0.00025,
        step_distance=0.0,
        bias=random.uniform(0.0002, 0.0004),
        bias_length=random.uniform(70.0, 160.0),
        flying=random.uniform(0.1, 0.25),
        standing=random.uniform(0.6, 0.95),
        halo=random.uniform(0.0, 0.0006),
        dropout=random.uniform(0.0, 0.03),
    )


def near_stereo(random: np.random.Generator, distance: float) -> Sensor:
    """Draw a D405: a passive stereo pair, with shorter errors that change from pose to pose."""
    return Sensor(
        'd405',
        noise=random.uniform(0.00015, 0.0003),
        grain=random.uniform(1.0, 2.0),
        step=0.0001,
        step_distance=distance,
        bias=random.uniform(0.00015, 0.0003),
        bias_length=random.uniform(30.0, 70.0),
        flying=random.uniform(0.02, 0.08),
        standing=random.uniform(0.1, 0.4),
        halo=random.uniform(-0.0004, 0.0004),
        dropout=random.uniform(0.0, 0.02),
    )


def time_of_flight(random: np.random.Generator, distance: float) -> Sensor:
    """Draw an indirect time-of-flight camera: long waves of error, and strong flying pixels."""
    return Sensor(
        'itof',
        noise=random.uniform(0.0003, 0.0007),
        grain=0.0,
        step=0.001,
        step_distance=0.0,
        bias=random.uniform(0.0003, 0.0005),
        bias_length=random.uniform(120.0, 250.0),
        flying=random.uniform(0.2, 0.4),
        standing=random.uniform(0.5, 0.9),
        halo=random.uniform(0.0, 0.001),
        dropout=random.uniform(0.0, 0.02),
    )


# Sensors whose errors are drawn, by name.
DRAWN = {'l515': scanning, 'd405': near_stereo, 'itof': time_of_flight}


def scan(rendering: Rendering, camera: Camera, wall: float) -> Scan:
    """Reduce samples to pixels."""
    depth = rendering.depth
    is_hit = np.isfinite(depth)
    nearest = depth.min(axis=-1, keepdims=True)
    in_front = is_hit & (depth <= nearest + _ONE_SURFACE)
    front, back = _mean(depth, in_front), _mean(depth, is_hit & ~in_front)
    share = is_hit.mean(axis=-1)
    front_prevails = in_front.sum(axis=-1) >= 0.5 * is_hit.sum(axis=-1)
    chosen = np.where(front_prevails, front, back)
    is_outline = (share < 1.0) | np.isfinite(back)
    behind = np.where(np.isfinite(back), back, wall)
    return Scan(chosen, behind, share, is_outline & (share > 0.0), _grazing_loss(chosen, camera))


def _mean(depth: FloatArray, chosen: BoolArray) -> FloatArray:
    count = chosen.sum(axis=-1)
    total = np.where(chosen, depth, 0.0).sum(axis=-1)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def _grazing_loss(depth: FloatArray, camera: Camera) -> FloatArray:
    """Return the share of lost pixels: none up to the grazing angle, all when edge on."""
    down, across = np.gradient(depth)
    slope = np.hypot(across * camera.fx, down * camera.fy) / depth
    cosine = 1.0 / np.sqrt(1.0 + np.nan_to_num(slope, nan=0.0) ** 2)
    return np.clip(1.0 - cosine / np.cos(_GRAZING), 0.0, 1.0)


def smooth_field(shape: tuple[int, int], length: float, random: np.random.Generator) -> FloatArray:
    """Draw a smooth random field of unit variance.

    Args:
        shape: of the image.
        length: at which its correlation has fallen to 1/e [px].
        random: source.
    """
    spread = 0.5 * length / _FIELD_STEP
    border = int(np.ceil(3 * spread))
    coarse = [side // _FIELD_STEP + 2 + 2 * border for side in shape]
    noise = ndimage.gaussian_filter(random.standard_normal(coarse), spread)
    # The blur of white noise of variance 1 has variance 1 / (4 pi spread^2).
    noise *= 2.0 * np.sqrt(np.pi) * spread
    rows = border + np.arange(shape[0]) / _FIELD_STEP
    columns = border + np.arange(shape[1]) / _FIELD_STEP
    grid = np.meshgrid(rows, columns, indexing='ij')
    field: FloatArray = ndimage.map_coordinates(noise, grid, order=3)
    return field


def expose(
    view: Scan, sensor: Sensor, bias: FloatArray, random: np.random.Generator
) -> NDArray[np.float32]:
    """Take one frame of a window.

    Args:
        view: what is there.
        sensor: takes it.
        bias: smooth error in the window [m].
        random: source of the noise.

    Returns:
        Depth [m], NaN where invalid.
    """
    shape = view.depth.shape
    noise = random.standard_normal(shape)
    if sensor.grain:
        noise = ndimage.gaussian_filter(noise, sensor.grain) * 2.0 * np.sqrt(np.pi) * sensor.grain
    flies = view.is_outline & (random.random(shape) < sensor.flying)
    mixture = random.random(shape)
    depth = np.where(flies, view.depth + mixture * (view.behind - view.depth), view.depth)
    depth = depth + bias + sensor.noise * noise
    if sensor.halo:
        depth = depth + sensor.halo * _halo(view)
    step = sensor.step
    if sensor.step_distance:
        # A disparity's step: the same in 1/z.
        grain = step / sensor.step_distance**2
        depth = 1.0 / (grain * np.round(1.0 / (depth * grain)))
    elif step:
        depth = step * np.round(depth / step)
    # An outline flickers around where half a pixel is covered, so it is not biased.
    is_covered = view.share + 0.15 * random.standard_normal(shape) * view.is_outline >= 0.5
    is_lost = random.random(shape) < view.loss
    if sensor.dropout:
        is_lost |= random.random(shape) < sensor.dropout
    return np.where(is_covered & ~is_lost, depth, np.nan).astype(np.float32)


def _halo(view: Scan) -> FloatArray:
    """Return how near each pixel is to an outline, 1 on it and 0 some pixels inside."""
    away: FloatArray = ndimage.distance_transform_edt(~view.is_outline)
    return np.maximum(1.0 - away / _HALO_PIXELS, 0.0)
