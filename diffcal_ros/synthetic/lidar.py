# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A depth camera's errors, after the Intel L515: noise, steps, flying pixels, lost pixels."""

from dataclasses import dataclass, replace

from diffcal_ros.errors import InputError
from diffcal_ros.scene.model import DepthSensor
from diffcal_ros.synthetic.scan import Scan
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

BoolArray = NDArray[np.bool_]
FloatArray = NDArray[np.float64]

ENCODINGS = ('32FC1', '16UC1')
_EDGE_STEP = 0.010  # Neighbours this far apart in depth [m] are two surfaces.
_BIAS_WAVES = 6
_LONGEST_WAVE, _SHORTEST_WAVE = 1.0, 0.25  # In image widths.


@dataclass(frozen=True)
class LidarModel:
    """How a measured depth differs from the true one.

    Attributes:
        noise: standard deviation of one pixel in one frame [m].
        step: distance between the values that the sensor knows [m]; 0 for none.
        encoding: `32FC1` keeps the steps; `16UC1` is cut to whole millimetres, as the camera's
            ROS driver does.
        edge_noise: further noise beside edges, where the spot covers two surfaces [m].
        flying_share: of the pixels beside edges, those that hang between the two surfaces.
        lost_share: of the same pixels, those without a depth.
        grazing_angle: surfaces seen at a flatter angle than this, from the normal [rad], lose
            pixels, all of them at a right angle.
        bias: root mean square of a smooth error that stays the same in all frames [m].
        nearest: the sensor sees nothing nearer [m].
        farthest: nor farther [m].
    """

    noise: float = 0.00014
    step: float = 0.00025
    encoding: str = '32FC1'
    edge_noise: float = 0.0008
    flying_share: float = 0.25
    lost_share: float = 0.15
    grazing_angle: float = np.deg2rad(78.0)
    bias: float = 0.0
    nearest: float = 0.10
    farthest: float = 9.0

    def __post_init__(self) -> None:
        if self.encoding not in ENCODINGS:
            raise InputError(f'depth encoding is {self.encoding!r}: {" or ".join(ENCODINGS)}')
        for name in ('noise', 'step', 'edge_noise', 'bias'):
            size = getattr(self, name)
            if not 0.0 <= size < 1.0:
                raise InputError(f"the sensor's {name} is {size:g}: give metres, 0 to 1")
        fractions = (self.flying_share, self.lost_share)
        if min(fractions) < 0.0 or sum(fractions) > 1.0:
            raise InputError(
                f'shares of flying and lost pixels are {fractions[0]:g} and {fractions[1]:g}: '
                'give two numbers from 0 whose sum is at most 1'
            )
        if not 0.0 <= self.grazing_angle <= np.pi / 2:
            degrees = np.rad2deg(self.grazing_angle)
            raise InputError(f'the grazing angle is {degrees:g} degrees: give 0 to 90')
        if not 0.0 <= self.nearest < self.farthest:
            raise InputError(
                f'the range of the sensor is {self.nearest:g} to {self.farthest:g} m: '
                'its far end must lie beyond its near end'
            )

    def bias_field(self, shape: tuple[int, int], random: np.random.Generator) -> FloatArray:
        """Return the smooth error of every pixel [m], shape `shape`."""
        if self.bias == 0.0:
            return np.zeros(shape)
        rows, columns = np.indices(shape) / shape[1]
        field = np.zeros(shape)
        for _ in range(_BIAS_WAVES):
            length = random.uniform(_SHORTEST_WAVE, _LONGEST_WAVE)
            angle, phase = random.uniform(0.0, 2.0 * np.pi, size=2)
            along = np.cos(angle) * columns + np.sin(angle) * rows
            field += np.cos(2.0 * np.pi * along / length + phase)
        field -= field.mean()
        return field * (self.bias / field.std())

    def measure(
        self, scan: Scan, bias: FloatArray, random: np.random.Generator
    ) -> NDArray[np.float32]:
        """Measure one frame.

        Args:
            scan: what is there.
            bias: smooth error [m], shape (H, W); see `bias_field`.
            random: source of the noise.

        Returns:
            Depth [m], shape (H, W), NaN where the sensor saw nothing.
        """
        near, far = _neighbourhood(scan.depth)
        beside_edge = far - near > _EDGE_STEP
        fate = random.random(scan.depth.shape)
        flies = beside_edge & (fate < self.flying_share)
        mixed = near + random.random(scan.depth.shape) * (far - near)
        depth = np.where(flies, mixed, scan.depth)
        spread = np.hypot(self.noise, np.where(beside_edge, self.edge_noise, 0.0))
        depth = self._stepped(depth + bias + spread * random.standard_normal(depth.shape))
        lost = beside_edge & (fate > 1.0 - self.lost_share)
        lost |= random.random(depth.shape) < self._grazing_loss(scan.cosine)
        lost |= (depth < self.nearest) | (depth > self.farthest)
        depth[lost] = np.nan
        return depth.astype(np.float32)

    def _stepped(self, depth: FloatArray) -> FloatArray:
        if self.step > 0.0:
            depth = self.step * np.round(depth / self.step)
        if self.encoding == '16UC1':
            # A step that is a whole millimetre must not fall below it by a rounding error.
            depth = 1e-3 * np.floor(1e3 * depth + 1e-6)
        return depth

    def _grazing_loss(self, cosine: FloatArray) -> FloatArray:
        """Return the share of lost pixels: none up to the grazing angle, all at 90 degrees."""
        limit = np.cos(self.grazing_angle)
        if limit < 1e-9:
            return np.zeros_like(cosine)
        return np.clip(1.0 - cosine / limit, 0.0, 1.0)


def lidar_of(
    sensor: DepthSensor, *, encoding: str | None = None, noise: float | None = None
) -> LidarModel:
    """Return the errors of a scene's sensor.

    Args:
        sensor: of the scene.
        encoding: one of `ENCODINGS`; None: as the sensor's quantisation implies.
        noise: of one pixel [m], in place of the sensor's.
    """
    is_cut = sensor.quantization_mode == 'truncate'
    usual = LidarModel()
    return replace(
        usual,
        noise=sensor.noise if noise is None else noise,
        # Whole millimetres are the driver's doing; the camera's own steps are finer.
        step=usual.step if is_cut else sensor.quantization,
        encoding=encoding or ('16UC1' if is_cut else '32FC1'),
    )


def _neighbourhood(depth: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the nearest and the farthest depth around each pixel [m]; both NaN for none."""
    is_empty = np.isnan(depth)
    near = ndimage.minimum_filter(np.where(is_empty, np.inf, depth), size=3)
    far = ndimage.maximum_filter(np.where(is_empty, -np.inf, depth), size=3)
    nothing = np.isinf(near)
    return np.where(nothing, np.nan, near), np.where(nothing, np.nan, far)
