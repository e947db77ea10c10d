# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The sensor floor: how far patches of a measurement may be off, and how that is correlated.

A patch is many pixels, so white noise averages out in it; what is left is a smooth error that
whole parts of an image share. Taken for white noise it raises false alarms by the dozen. Most of
it stands in the image and does not move with the body: frames of one recording have it in common,
and many frames tell no more about it than one.
"""

from dataclasses import dataclass, replace

from diffcal_ros.calibration.observations.frame_noise import MEASURED_FRAMES
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.scene.model import DepthSensor
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

FloatArray = NDArray[np.float64]

# Share of the variance of smooth errors that does not change while the body moves.
_COMMON = 0.8
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
        edge_pixels: standard deviation of where one segment of an outline is found [px].
        edge_smooth: of an error that segments near each other share [px].
        edge_length: over which that changes [px].
        edge_rough: of one that no two patches of outline share [px].
        is_measured: whether `pixel` comes from repeated frames.
        common: share of the variance of smooth errors that frames of a recording have in common.
        standing: share of that of depth which all recordings have in common, before that.
        is_mixed: whether that of depth changes over lengths of all sizes about `smooth_length`.
        is_stated: whether `smooth` is what the scene states of the sensor.
        grain: pixels whose average scatters as one does: an average over fewer is known as one.
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
    common: float = 0.0
    standing: float = 0.0
    is_mixed: bool = False
    is_stated: bool = False
    grain: float = 1.0

    def depth_covariance(self, centers: FloatArray, counts: FloatArray) -> FloatArray:
        """Return the covariance of patches of depth [m^2], shape (n, n).

        Args:
            centers: of the patches [px], shape (n, 2).
            counts: pixels in each, shape (n,).
        """
        variance = (1.0 - self.common) * (1.0 - self.standing) * self.smooth**2
        shared = variance * kernel(centers, self.smooth_length, is_mixed=self.is_mixed)
        own = self.pixel**2 * np.minimum(self.grain / counts, 1.0)
        return shared + np.diag(own + self.rough**2)

    def edge_covariance(
        self, centers: FloatArray, counts: FloatArray, pixel_sizes: FloatArray
    ) -> FloatArray:
        """Return the covariance of patches of outline [m^2], shape (n, n).

        Args:
            centers: of the patches [px], shape (n, 2).
            counts: length of outline in each [px], shape (n,).
            pixel_sizes: of a pixel at the body [m], shape (n,).
        """
        shared = (1.0 - self.common) * self.edge_smooth**2 * kernel(centers, self.edge_length)
        own = np.diag(self.edge_pixels**2 / np.maximum(counts, 1.0) + self.edge_rough**2)
        return (shared + own) * np.outer(pixel_sizes, pixel_sizes)

    def depth_common(self, count: int) -> 'CommonError':
        """Return what so many patches of depth have in common with those of other frames."""
        spread = np.sqrt(self.common * (1.0 - self.standing)) * self.smooth
        return CommonError(np.full(count, spread), self.smooth_length, self.is_mixed)

    def depth_standing(self, count: int) -> 'CommonError':
        """Return what so many patches of depth have in common with those of all recordings."""
        spread = np.sqrt(self.standing) * self.smooth
        return CommonError(np.full(count, spread), self.smooth_length, self.is_mixed)

    def edge_common(self, pixel_sizes: FloatArray) -> 'CommonError':
        """Return what patches of outline have in common with those of other frames.

        Args:
            pixel_sizes: of a pixel at the body [m], shape (n,).
        """
        return CommonError(np.sqrt(self.common) * self.edge_smooth * pixel_sizes, self.edge_length)


@dataclass(frozen=True)
class CommonError:
    """A smooth error that stands in the image through all frames of a recording, or of all.

    Attributes:
        spread: standard deviation at each patch [m], shape (n,).
        length: over which it changes [px].
        is_mixed: whether it changes over lengths of all sizes about that.
    """

    spread: FloatArray
    length: float
    is_mixed: bool = False

    def of(self, spread: FloatArray) -> 'CommonError':
        """Return the same error in other patches, shape (m,)."""
        return replace(self, spread=spread)

    def covariance(self, centers: FloatArray) -> FloatArray:
        """Return the covariance of patches [m^2], shape (n, n), at image points (n, 2) [px]."""
        shared = kernel(centers, self.length, is_mixed=self.is_mixed)
        return shared * np.outer(self.spread, self.spread)


def noise_of(observation: Observation, sensor: DepthSensor) -> NoiseModel:
    """Return the noise of an observation: measured from its frames where there are enough.

    Its smooth error is what the scene states of it; else it is guessed.
    """
    is_moving = observation.instant is not None
    enough = is_moving or observation.frame_count >= MEASURED_FRAMES
    is_measured = enough and np.isfinite(observation.noise)
    pixel = observation.noise if is_measured else sensor.noise
    known = {} if is_measured else _UNMEASURED
    if sensor.smooth_error > 0.0:
        known = {**known, 'smooth': sensor.smooth_error}
    # Rounding is noise too, as long as the true depth varies over a patch; each pixel's own.
    rounding = sensor.quantization / np.sqrt(12.0 * max(observation.frame_count, 1))
    whole = float(np.hypot(pixel, rounding))
    grain = observation.grain if is_measured else 1.0
    return NoiseModel(
        pixel=whole,
        is_measured=bool(is_measured),
        is_stated=sensor.smooth_error > 0.0,
        common=_COMMON if is_moving else 0.0,
        is_mixed=False,
        grain=1.0 + (grain - 1.0) * (pixel / whole) ** 2 if whole > 0.0 else 1.0,
        **known,
    )


def kernel(centers: FloatArray, length: float, *, is_mixed: bool = False) -> FloatArray:
    """Return the correlation of smooth errors at image points [px], shape (n, n).

    Over what they change is known by its order at best. Mixed, it is a rational quadratic:
    Gaussian kernels of all lengths about this one (Rasmussen and Williams, Gaussian Processes for
    Machine Learning, 2006, eq. 4.19, alpha 1). What a whole picture has in common is likely, then,
    as it hardly is by one length; no patches beside so many tangents could show it.

    Args:
        centers: shape (n, 2).
        length: over which they change [px].
        is_mixed: whether over lengths of all sizes about that.
    """
    squares = cdist(centers, centers, 'sqeuclidean') / length**2
    return np.asarray(1.0 / (1.0 + squares) if is_mixed else np.exp(-squares))
