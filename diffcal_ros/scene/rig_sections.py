# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The sections about the rig: cameras, masks, sensor and the rigid offset's prior."""

import math

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.scene.effects import EFFECTS
from diffcal_ros.scene.model import DepthSensor, Masks, RigidOffset
from diffcal_ros.scene.problems import shown
from diffcal_ros.scene.section import (
    as_number,
    Interval,
    Section,
    whole_numbers,
)

FROM_CAMERA_INFO = 'from_camera_info'
_LARGEST_IMAGE = 20000
_FOCAL_LENGTHS = Interval(0.0, 1e5, is_open=True)
# Of the image's side: 160 degrees are seen at once.
_WIDEST_VIEW = 0.088
# The optical axis of an image that was cut out of a larger one may lie outside it.
_AXES = Interval(-20000.0, 40000.0)
_DISTORTION_SIZES = (0, 4, 5, 8, 12, 14)
# In pixels; a fit takes hours where the band is wider than the body.
_BANDS = Interval(0.0, 100.0)
# Beyond a metre, a length of these sections was written in millimetres.
_LENGTHS = Interval(0.0, 1.0)
_POSITIVE_LENGTHS = Interval(0.0, 1.0, is_open=True)
_PRIORS = Interval(1e-9, 1.0)
_IN_METRES = 'give a length in metres, between 0 and 1'


def read_camera(scene: Section, name: str, *, may_be_distorted: bool) -> PinholeCamera | None:
    """Read a camera; None where it is taken from camera_info."""
    if not scene.has(name) or scene.raw(name) == FROM_CAMERA_INFO:
        return None
    if not isinstance(scene.raw(name), dict):
        scene.wrong(name, f'write {FROM_CAMERA_INFO} or {{width, height, fx, fy, cx, cy}}')
        return None
    section = scene.child(name)
    if section is None:
        return None
    width = section.integer('width', low=1, high=_LARGEST_IMAGE)
    height = section.integer('height', low=1, high=_LARGEST_IMAGE)
    focal = 'give the focal length in pixels, above 0; zero means not calibrated'
    fx = section.number('fx', allowed=_FOCAL_LENGTHS, needed=focal)
    fy = section.number('fy', allowed=_FOCAL_LENGTHS, needed=focal)
    cx = section.number('cx', allowed=_AXES, needed="give the optical axis's column in pixels")
    cy = section.number('cy', allowed=_AXES, needed="give the optical axis's row in pixels")
    distortion = _read_distortion(section)
    section.refuse_unknown()
    for name, size, length in (('fx', width, fx), ('fy', height, fy)):
        if section.is_sound and length < _WIDEST_VIEW * size:
            section.wrong(
                name, f'no camera sees so wide an angle on {size} pixels; give it in pixels'
            )
    if section.is_sound and any(distortion) and not may_be_distorted:
        section.wrong('distortion', 'depth images are rectified: give zeros or leave it out')
    if not section.is_sound:
        return None
    return PinholeCamera(width, height, fx, fy, cx, cy, distortion)


def _read_distortion(section: Section) -> tuple[float, ...]:
    value = section.raw('distortion')
    if value is None:
        return ()
    numbers = [as_number(item) for item in value] if isinstance(value, list) else [None]
    sound = tuple(number for number in numbers if number is not None and math.isfinite(number))
    if len(sound) != len(numbers) or len(sound) not in _DISTORTION_SIZES:
        section.wrong('distortion', "give OpenCV's 4, 5, 8, 12 or 14 coefficients")
    return sound


def read_masks(scene: Section, camera: PinholeCamera | None) -> Masks:
    """Read `masks`; what is not given keeps its default."""
    section = scene.child('masks')
    usual = Masks()
    if section is None:
        return usual
    angle = section.number(
        'grazing_angle_deg',
        default=math.degrees(usual.grazing_angle),
        allowed=Interval(0.0, 90.0),
        needed='give an angle from the normal in degrees, 0 to 90',
    )
    masks = Masks(
        held=section.flag('held', default=usual.held),
        held_margin=section.number(
            'held_margin', default=usual.held_margin, allowed=_LENGTHS, needed=_IN_METRES
        ),
        boxes=_read_boxes(section, camera),
        silhouette_band=section.number(
            'silhouette_band', default=usual.silhouette_band, allowed=_BANDS
        ),
        grazing_angle=math.radians(angle),
        truncation=section.number(
            'truncation',
            default=usual.truncation,
            allowed=_POSITIVE_LENGTHS,
            needed=_IN_METRES,
        ),
    )
    section.refuse_unknown()
    return masks


def _read_boxes(
    section: Section, camera: PinholeCamera | None
) -> tuple[tuple[int, int, int, int], ...]:
    value = section.raw('boxes')
    if value is None:
        return ()
    if not isinstance(value, list):
        section.wrong('boxes', 'give a list of [u0, v0, u1, v1] in pixels')
        return ()
    boxes = []
    for index, item in enumerate(value):
        numbers = whole_numbers(item) if isinstance(item, list) else None
        fault = _box_fault(numbers, camera)
        if numbers is None or fault:
            section.problems.add(section.at(f'boxes[{index}]'), f'is {shown(item)}: {fault}')
            continue
        boxes.append((numbers[0], numbers[1], numbers[2], numbers[3]))
    return tuple(boxes)


def _box_fault(numbers: list[int] | None, camera: PinholeCamera | None) -> str:
    if numbers is None or len(numbers) != 4:
        return 'give four whole numbers, [u0, v0, u1, v1] in pixels'
    u0, v0, u1, v1 = numbers
    if u0 > u1 or v0 > v1:
        return 'it is empty, u0 must not exceed u1, nor v0 v1'
    if max(numbers) > _LARGEST_IMAGE:
        return f'an image has at most {_LARGEST_IMAGE} pixels a side'
    if u1 < 0 or v1 < 0 or (camera and (u0 >= camera.width or v0 >= camera.height)):
        return 'it lies outside the image'
    return ''


def read_sensor(scene: Section) -> DepthSensor:
    """Read `sensor`; what is not given keeps its default."""
    section = scene.child('sensor')
    usual = DepthSensor()
    if section is None:
        return usual
    sensor = DepthSensor(
        noise=section.number(
            'noise', default=usual.noise, allowed=_POSITIVE_LENGTHS, needed=_IN_METRES
        ),
        quantization=section.number(
            'quantization', default=usual.quantization, allowed=_LENGTHS, needed=_IN_METRES
        ),
        quantization_mode=section.choice(
            'quantization_mode', ('round', 'truncate'), default=usual.quantization_mode
        ),
    )
    section.refuse_unknown()
    return sensor


def read_rigid_offset(scene: Section) -> RigidOffset:
    """Read `rigid_offset`; what is not given keeps its default."""
    section = scene.child('rigid_offset')
    usual = RigidOffset()
    if section is None:
        return usual
    translation_std = section.number(
        'translation_std',
        default=usual.translation_std,
        allowed=_PRIORS,
        needed='give a length in metres, between 1e-9 and 1',
    )
    degrees = section.number(
        'rotation_std_deg',
        default=math.degrees(usual.rotation_std),
        allowed=Interval(1e-6, 180.0),
        needed='give degrees, between 1e-6 and 180',
    )
    each_recording = section.flag('each_recording', default=False)
    section.refuse_unknown()
    return RigidOffset(translation_std, math.radians(degrees), each_recording)


def read_effects(scene: Section) -> dict[str, dict[str, float]]:
    """Read `effects`: amplitudes of what was added to the model, by identifier."""
    section = scene.child('effects')
    if section is None:
        return {}
    found: dict[str, dict[str, float]] = {}
    for identifier, effect in EFFECTS.items():
        entry = section.child(identifier)
        if entry is None:
            continue
        numbers = {
            part.name: entry.number(
                part.name,
                default=0.0,
                allowed=Interval(part.lower, part.upper),
                needed=f'give a number in {part.unit}, {Interval(part.lower, part.upper)}',
            )
            for part in effect.components
        }
        for name, usual in effect.settings.items():
            allowed = Interval(*effect.setting_limits)
            numbers[name] = entry.number(name, default=usual, allowed=allowed)
        entry.refuse_unknown()
        found[identifier] = numbers
    section.refuse_unknown()
    return found
