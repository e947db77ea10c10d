# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the makers of depth cameras state: noise by distance, steps, and how near and far they see.

Noise of a stereo camera is that of its disparity, s = d z^2 / (f b), with the error d of the
disparity [px], the distance z, the focal length f [px] and the baseline b (Intel, "Tuning depth
cameras for best performance"; d is about 0.08 px on a textured surface). That of a time-of-flight
camera grows as the light comes back: with the square of the distance where daylight or the chip
decide. A data sheet states limits, so a camera may well do better.
"""

from dataclasses import dataclass
import math

from diffcal_ros.scene.model import DepthSensor

# Of a disparity on a textured surface [px].
_SUBPIXEL = 0.08
# What a ROS driver of a RealSense publishes as 16UC1 is cut to whole millimetres.
_WHOLE_MILLIMETRES = 0.001


@dataclass(frozen=True)
class SensorModel:
    """A depth camera that one can buy.

    Attributes:
        title: maker and name.
        source: of the figures.
        nearest: depth below it is not the camera's [m].
        farthest: depth beyond it is not the camera's [m].
        quantization: step of its own depth values [m]; 0 where they are floating-point numbers.
        driver_step: what its ROS driver cuts depth down to [m]; 0 where it does not.
        noise: standard deviation of a pixel that does not depend on distance [m].
        noise_growth: of the part that grows with the square of the distance [1/m].
        baseline: of a stereo camera [m]; 0 of others.
    """

    title: str
    source: str
    nearest: float
    farthest: float
    quantization: float
    driver_step: float = 0.0
    noise: float = 0.0
    noise_growth: float = 0.0
    baseline: float = 0.0

    def noise_at(self, distance: float, focal_length: float) -> float:
        """Return the stated standard deviation of one pixel [m].

        Args:
            distance: along the optical axis [m].
            focal_length: of the depth image [px].
        """
        growth = self.noise_growth
        if self.baseline > 0.0:
            growth = _SUBPIXEL / (focal_length * self.baseline)
        return math.hypot(self.noise, growth * distance**2)

    def sensor(self, name: str) -> DepthSensor:
        """Return what a scene holds that names this camera."""
        return DepthSensor(
            noise=max(self.noise, DepthSensor.noise),
            quantization=self.quantization,
            model=name,
            nearest=self.nearest,
            farthest=self.farthest,
            driver_step=self.driver_step,
        )


_INTEL_400 = 'Intel RealSense D400 series, data sheet 337029-017'
_INTEL_L515 = 'Intel RealSense LiDAR camera L515, data sheet'
_KINECT = 'Azure Kinect DK hardware specifications: at most 17 mm where it sees farthest'
_STEREOLABS = 'Stereolabs, depth settings and data sheets'

SENSOR_MODELS: dict[str, SensorModel] = {
    # 2.5 mm at 1 m and 15.5 mm at 9 m: 0.19 mm/m^2 beside a constant part.
    'realsense_l515': SensorModel(
        'Intel RealSense L515',
        _INTEL_L515,
        0.25,
        9.0,
        0.00025,
        driver_step=_WHOLE_MILLIMETRES,
        noise=0.0025,
        noise_growth=0.00019,
    ),
    'realsense_d405': SensorModel(
        'Intel RealSense D405',
        _INTEL_400,
        0.04,
        1.0,
        0.0001,
        driver_step=_WHOLE_MILLIMETRES,
        baseline=0.018,
    ),
    'realsense_d415': SensorModel(
        'Intel RealSense D415', _INTEL_400, 0.15, 10.0, 0.001, baseline=0.055
    ),
    'realsense_d435': SensorModel(
        'Intel RealSense D435, D435i', _INTEL_400, 0.1, 10.0, 0.001, baseline=0.05
    ),
    'realsense_d455': SensorModel(
        'Intel RealSense D455', _INTEL_400, 0.15, 15.0, 0.001, baseline=0.095
    ),
    'azure_kinect': SensorModel(
        'Azure Kinect DK', _KINECT, 0.25, 5.46, 0.001, noise_growth=0.017 / 5.46**2
    ),
    'femto_bolt': SensorModel(
        'Orbbec Femto Bolt (the chip of the Azure Kinect)',
        _KINECT,
        0.25,
        5.46,
        0.001,
        noise_growth=0.017 / 5.46**2,
    ),
    'zed_mini': SensorModel('Stereolabs ZED Mini', _STEREOLABS, 0.1, 15.0, 0.0, baseline=0.063),
    'zed_2': SensorModel('Stereolabs ZED 2, 2i', _STEREOLABS, 0.3, 20.0, 0.0, baseline=0.12),
    'zed_x': SensorModel('Stereolabs ZED X', _STEREOLABS, 0.2, 20.0, 0.0, baseline=0.12),
}
