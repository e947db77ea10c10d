# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The section about the depth camera: a model by name, or its figures."""

from diffcal_ros.scene.model import DepthSensor
from diffcal_ros.scene.reading.section import Section
from diffcal_ros.scene.reading.shapes import Choice, Interval, Keys, Number
from diffcal_ros.scene.sections.depth_sensors import SENSOR_MODELS

# Beyond a metre, a length of this section was written in millimetres.
_LENGTHS = Interval(0.0, 1.0)
_POSITIVE_LENGTHS = Interval(0.0, 1.0, is_open=True)
_DISTANCES = Interval(0.0, 100.0)
_POSITIVE_DISTANCES = Interval(0.0, 100.0, is_open=True)
_IN_METRES = 'give a length in metres, between 0 and 1'

SENSOR_SHAPE = Keys(
    {
        'model': Choice(
            tuple(SENSOR_MODELS), "a camera's data sheet: noise, steps and range where not given"
        ),
        'noise': Number("standard deviation of one pixel's depth, in m", _POSITIVE_LENGTHS),
        'quantization': Number('step of the depth values, in m; 0: none', _LENGTHS),
        'quantization_mode': Choice(
            ('round', 'truncate'), "truncate: the RealSense ROS driver's 16UC1"
        ),
        'smooth_error': Number(
            'standard deviation of an error that is smooth over the image and stays, in m',
            _POSITIVE_LENGTHS,
        ),
        'nearest': Number('depth below it is no measurement, in m', _DISTANCES),
        'farthest': Number('depth beyond it is no measurement, in m', _POSITIVE_DISTANCES),
    },
    about='what is known about the depth camera',
)


def read_sensor(scene: Section) -> DepthSensor:
    """Read `sensor`; what is not given keeps its default."""
    section = scene.child('sensor')
    usual = DepthSensor()
    if section is None:
        return usual
    name = section.choice('model', default='') if section.has('model') else ''
    if name in SENSOR_MODELS:
        usual = SENSOR_MODELS[name].sensor(name)
    has_steps = section.has('quantization') or section.has('quantization_mode')
    sensor = DepthSensor(
        noise=section.number('noise', default=usual.noise, needed=_IN_METRES),
        quantization=section.number('quantization', default=usual.quantization, needed=_IN_METRES),
        quantization_mode=section.choice('quantization_mode', default=usual.quantization_mode),
        model='' if section.has('noise') else usual.model,
        nearest=section.number('nearest', default=usual.nearest),
        farthest=section.number('farthest', default=usual.farthest),
        driver_step=0.0 if has_steps else usual.driver_step,
        smooth_error=section.number('smooth_error', default=usual.smooth_error, needed=_IN_METRES),
    )
    if section.is_sound and sensor.nearest >= sensor.farthest:
        section.wrong('nearest', f'give less than farthest, {sensor.farthest:g} m')
    section.refuse_unknown()
    return sensor
