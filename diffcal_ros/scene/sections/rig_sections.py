# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The sections about the rig: cameras, masks and the rigid offset's prior."""

from collections.abc import Iterator, Mapping
from functools import cache
import math
import re

from diffcal_ros.camera import PinholeCamera, SHORTEST_FOCAL_LENGTH
from diffcal_ros.effects import bands, picture_edge, surface_parts
from diffcal_ros.effects.effect import Effect
from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.scene.model import Masks, RigidOffset
from diffcal_ros.scene.reading.problems import shown
from diffcal_ros.scene.reading.section import as_number, Section, whole_numbers
from diffcal_ros.scene.reading.shapes import (
    Constant,
    Flag,
    Interval,
    Keys,
    ListOf,
    Number,
    OneOf,
    Shape,
    Whole,
)

FROM_CAMERA_INFO = 'from_camera_info'
_LARGEST_IMAGE = 20000
_FOCAL_LENGTHS = Interval(0.0, 1e5, is_open=True)
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

_PIXELS: dict[str, Shape] = {
    'width': Whole('in px', 1, _LARGEST_IMAGE),
    'height': Whole('in px', 1, _LARGEST_IMAGE),
    'fx': Number('focal length in px', _FOCAL_LENGTHS),
    'fy': Number('focal length in px', _FOCAL_LENGTHS),
    'cx': Number("the optical axis's column in px", _AXES),
    'cy': Number("the optical axis's row in px", _AXES),
}
CAMERA_SHAPE = OneOf(
    (
        Constant(FROM_CAMERA_INFO),
        Keys(
            {
                **_PIXELS,
                'distortion': ListOf(
                    Number(), "OpenCV's 4, 5, 8, 12 or 14 coefficients; depth images have none"
                ),
            },
            tuple(_PIXELS),
        ),
    ),
    'intrinsics in pixels, or from_camera_info (default)',
)
MASKS_SHAPE = Keys(
    {
        'held': Flag('leave out the held part, which the clamp hides; default true'),
        'held_margin': Number('and the surface within this distance of it, in m', _LENGTHS),
        'boxes': ListOf(
            ListOf(Whole(high=_LARGEST_IMAGE), '[u0, v0, u1, v1] in px', fewest=4, most=4),
            'image boxes, ends included',
        ),
        'silhouette_band': Number(
            'leave depth out this close to an outline, in px; default 3', _BANDS
        ),
        'grazing_angle_deg': Number(
            'leave out surfaces seen flatter than this, from their normal; default 75',
            Interval(0.0, 90.0),
        ),
        'truncation': Number(
            'residuals beyond this are not the body, in m; default 0.02', _POSITIVE_LENGTHS
        ),
    },
    about='pixels that the fit leaves out',
)
RIGID_OFFSET_SHAPE = Keys(
    {
        'translation_std': Number('in m; default 0.02', _PRIORS),
        'rotation_std_deg': Number('in degrees; default 5', Interval(1e-6, 180.0)),
        'each_recording': Flag('every recording has its own; else all share one (default)'),
    },
    about='how far the hand-set placement may be off: the prior of rigid_offset',
)


@cache
def _effect_shape(effect: Effect) -> Keys:
    amplitudes: dict[str, Shape] = {
        part.name: Number(f'in {part.unit}', Interval(*part.stated_limits))
        for part in effect.components
    }
    settings: dict[str, Shape] = {
        name: Number(f'default {usual:g}', Interval(*effect.limits_of(name)))
        for name, usual in effect.settings.items()
        if not _is_of_map(effect, name)
    }
    about = effect.sentence
    patterns = [*filter(None, [effect.map_pattern]), *(part.name for part in effect.forms)]
    if not patterns:
        return Keys({**amplitudes, **settings}, about=about)
    found = 'part of another form, or of a map' if effect.map_pattern else 'part of another form'
    return Keys(
        {**amplitudes, **settings},
        about=about,
        named=Number(f'{found}, as a diagnosis found it'),
        name_pattern='|'.join(patterns),
    )


def _is_of_map(effect: Effect, name: str) -> bool:
    return bool(effect.map_pattern) and re.fullmatch(effect.map_pattern, name) is not None


class _EffectShapes(Mapping[str, Shape]):
    """The sections of the effects that the library has when they are asked for."""

    def __getitem__(self, identifier: str) -> Shape:
        return _effect_shape(EFFECTS[identifier])

    def __iter__(self) -> Iterator[str]:
        return iter(EFFECTS)

    def __len__(self) -> int:
        return len(EFFECTS)


EFFECTS_SHAPE = Keys(
    _EffectShapes(),
    about='effects that the model is to have, in SI units; absent ones are left out',
)


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
    width = section.integer('width')
    height = section.integer('height')
    focal = 'give the focal length in pixels, above 0; zero means not calibrated'
    fx = section.number('fx', needed=focal)
    fy = section.number('fy', needed=focal)
    cx = section.number('cx', needed="give the optical axis's column in pixels")
    cy = section.number('cy', needed="give the optical axis's row in pixels")
    distortion = _read_distortion(section)
    section.refuse_unknown()
    for name, size, length in (('fx', width, fx), ('fy', height, fy)):
        if section.is_sound and length < SHORTEST_FOCAL_LENGTH * size:
            section.wrong(
                name,
                f'no camera sees so wide an angle on {size} pixels, more than 160 degrees; give '
                'it in pixels',
            )
    if section.is_sound and any(distortion) and not may_be_distorted:
        section.wrong('distortion', 'depth images are rectified: give zeros or leave it out')
    if not section.is_sound:
        return None
    try:
        return PinholeCamera(width, height, fx, fy, cx, cy, distortion)
    except ValueError as error:
        section.wrong('fx', str(error))
        return None


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
        needed='give an angle from the normal in degrees, 0 to 90',
    )
    masks = Masks(
        held=section.flag('held', default=usual.held),
        held_margin=section.number('held_margin', default=usual.held_margin, needed=_IN_METRES),
        boxes=_read_boxes(section, camera),
        silhouette_band=section.number('silhouette_band', default=usual.silhouette_band),
        grazing_angle=math.radians(angle),
        truncation=section.number('truncation', default=usual.truncation, needed=_IN_METRES),
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


def read_rigid_offset(scene: Section) -> RigidOffset:
    """Read `rigid_offset`; what is not given keeps its default."""
    section = scene.child('rigid_offset')
    usual = RigidOffset()
    if section is None:
        return usual
    translation_std = section.number(
        'translation_std',
        default=usual.translation_std,
        needed='give a length in metres, between 1e-9 and 1',
    )
    degrees = section.number(
        'rotation_std_deg',
        default=math.degrees(usual.rotation_std),
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
                needed=f'give a number in {part.unit}, {entry.allowed(part.name)}',
            )
            for part in effect.components
        }
        for name, usual in effect.settings.items():
            # A map has too many numbers to tell whoever misspelt a key of all of them.
            if _is_of_map(effect, name) and name not in entry.names:
                continue
            reach = Interval(*effect.limits_of(name))
            numbers[name] = entry.number(name, default=usual, allowed=reach)
        for part in effect.forms:
            if part.name in entry.names:
                reach = Interval(*part.stated_limits)
                numbers[part.name] = entry.number(part.name, allowed=reach)
        entry.refuse_unknown()
        if effect.has_boundary:
            numbers = bands.without_unused(surface_parts.without_unused(numbers))
        if effect.has_edge:
            numbers = picture_edge.without_unused(numbers)
        found[identifier] = numbers
    section.refuse_unknown()
    return found
