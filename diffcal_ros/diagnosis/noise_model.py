# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The sensor floor: how far patches of a measurement may be off, and how that is correlated.

A patch is many pixels, so white noise averages out in it; what is left is a smooth error that
whole parts of an image share. Taken for white noise it raises false alarms by the dozen.
"""

from dataclasses import dataclass

from diffcal_ros.calibration.observation import Observation
from diffcal_ros.scene.model import DepthSensor
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Repeated frames from which the noise of a pixel counts as measured.
MEASURED_FRAMES = 5
# What a sensor that was not watched for a while is trusted with: structured errors of a LIDAR on
# translucent silicone are far above its noise.
_UNMEASURED = {
    'smooth': 0.0005,
    'rough': 0.00015,
    'edge_pixels': 0.7,
    'edge_smooth': 0.4,
    'edge_rough': 0.3,
}


@dataclass(frozen=True)
class NoiseModel:
    """Errors of one observation's patches.

    Attributes:
        pixel: standard deviation of one fused pixel [m].
        smooth: of the smooth error of depth [m].
        smooth_length: over which that changes [px].
        rough: of an error of depth that no two patches share [m].
        edge_pixels: standard deviation of where one piece of an outline is found [px].
        edge_smooth: of an error that pieces near each other share [px].
        edge_length: over which that changes [px].
        edge_rough: of one that no two patches of outline share [px].
        is_measured: whether `pixel` comes from repeated frames.
    """

    pixel: float
    smooth: float = 0.0002
    smooth_length: float = 80.0
    rough: float = 0.00005
    edge_pixels: float = 0.35
    edge_smooth: float = 0.10
    edge_length: float = 40.0
    edge_rough: float = 0.06
    is_measured: bool = False

    def depth_covariance(self, centers: FloatArray, counts: FloatArray) -> FloatArray:
        """Return the covariance of patches of depth [m^2], shape (n, n).

        Args:
            centers: of the patches [px], shape (n, 2).
            counts: pixels in each, shape (n,).
        """
        shared = self.smooth**2 * _kernel(centers, self.smooth_length)
        return shared + np.diag(self.pixel**2 / counts + self.rough**2)

    def edge_covariance(
        self, centers: FloatArray, counts: FloatArray, pixel_sizes: FloatArray
    ) -> FloatArray:
        """Return the covariance of patches of outline [m^2], shape (n, n).

        Args:
            centers: of the patches [px], shape (n, 2).
            counts: length of outline in each [px], shape (n,).
            pixel_sizes: of a pixel at the body [m], shape (n,).
        """
        shared = self.edge_smooth**2 * _kernel(centers, self.edge_length)
        own = np.diag(self.edge_pixels**2 / np.maximum(counts, 1.0) + self.edge_rough**2)
        return (shared + own) * np.outer(pixel_sizes, pixel_sizes)


def noise_of(observation: Observation, sensor: DepthSensor) -> NoiseModel:
    """Return the noise of an observation: measured from its frames where there are enough."""
    is_measured = observation.frame_count >= MEASURED_FRAMES and np.isfinite(observation.noise)
    pixel = observation.noise if is_measured else sensor.noise
    unmeasured = {} if is_measured else _UNMEASURED
    # Rounding is noise too, as long as the true depth varies over a patch.
    rounding = sensor.quantization / np.sqrt(12.0 * max(observation.frame_count, 1))
    return NoiseModel(
        pixel=float(np.hypot(pixel, rounding)), is_measured=bool(is_measured), **unmeasured
    )


def _kernel(centers: FloatArray, length: float) -> FloatArray:
    apart = centers[:, None] - centers[None]
    return np.exp(-np.sum(apart**2, axis=-1) / length**2)
