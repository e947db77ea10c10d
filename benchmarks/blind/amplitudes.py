# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How large each effect is: small, medium and large, and what goes into the label."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import GRAVITY, Setup

SIZES = ('small', 'medium', 'large')


@dataclass(frozen=True)
class Effect:
    """One drawn effect.

    Attributes:
        identifier: as in the workflow's library, or of an effect outside it.
        amplitude: components in the library's units.
        unit: of the components.
        changes: fields of `Faults`.
    """

    identifier: str
    amplitude: dict[str, float | str]
    unit: str
    changes: dict[str, Any]

    def label(self) -> dict[str, Any]:
        """Return what the label says."""
        return {'identifier': self.identifier, 'amplitude': self.amplitude, 'unit': self.unit}


Drawer = Callable[[int, Setup, np.random.Generator], Effect]


def direction(
    size: float, count: int, random: np.random.Generator, digits: int = 4
) -> tuple[float, ...]:
    """Draw a vector of a size in any direction, rounded to what a label tells."""
    vector = random.standard_normal(count)
    vector *= size * random.uniform(0.85, 1.15) / np.linalg.norm(vector)
    return tuple(round(float(value), digits) for value in vector)


def number(size: float, random: np.random.Generator) -> float:
    return round(float(size * random.uniform(0.85, 1.15)), 5)


def signed(size: float, random: np.random.Generator) -> float:
    return float(random.choice([-1.0, 1.0])) * number(size, random)


def weight_moment(setup: Setup) -> tuple[float, float]:
    """Return the free body's mass [kg] and the moment of its weight at the clamp [N m]."""
    width, height = setup.shape.section
    free = setup.shape.length - setup.shape.clamp
    mass = setup.density * width * height * free
    return mass, 0.5 * mass * GRAVITY * free


def _xyz(vector: tuple[float, ...], name: str) -> dict[str, float | str]:
    return {f'{name}_{axis}': value for axis, value in zip('xyz', vector, strict=True)}


def camera_offset(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    shift = direction((2.0, 5.0, 12.0)[size], 3, random)
    turn = direction((0.5, 1.2, 3.0)[size], 3, random)
    amplitude = {**_xyz(shift, 'shift'), **_xyz(turn, 'turn')}
    return Effect(
        'camera_offset', amplitude, 'mm, deg', {'camera_shift': shift, 'camera_turn': turn}
    )


def depth_affine(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    scale = signed((0.6, 1.5, 3.5)[size], random)
    bias = signed((1.0, 2.5, 6.0)[size], random)
    return Effect(
        'depth_affine',
        {'scale': scale, 'bias': bias},
        '%, mm',
        {'depth_scale': scale, 'depth_bias': bias},
    )


def depth_bias_by_region(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    bias = signed((0.8, 2.0, 5.0)[size], random)
    return Effect('depth_bias_by_region', {'tip': bias}, 'mm', {'region_bias': bias})


def gravity_tilt(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    tilt = direction((4.0, 9.0, 20.0)[size], 2, random)
    return Effect('gravity_tilt', {'x': tilt[0], 'z': tilt[1]}, 'deg', {'gravity_tilt': tilt})


def added_mass(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    mass, _ = weight_moment(setup)
    grams = number(1e3 * mass * (0.05, 0.12, 0.30)[size], random)
    at = round(float(random.uniform(0.45, 0.93)), 3)
    return Effect(
        'added_mass',
        {'mass': grams, 'at': at},
        'g, share of the free length',
        {'added_mass': grams, 'added_mass_at': at},
    )


def contact_plane(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how far the plane lifts the tip; its height follows from where the body sags."""
    lift = number((2.0, 5.0, 11.0)[size], random)
    tilt = np.deg2rad(random.uniform(-6.0, 6.0, size=2))
    normal = np.array([np.sin(tilt[0]), 1.0, np.sin(tilt[1])])
    normal /= np.linalg.norm(normal)
    return Effect(
        'contact_plane',
        {'lift': lift},
        'm; lift in mm',
        {'contact_height': lift, 'contact_normal': tuple(float(value) for value in normal)},
    )


def clamp_offset(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    shift = direction((1.0, 2.5, 6.0)[size], 3, random)
    turn = direction((1.0, 2.5, 6.0)[size], 3, random)
    amplitude = {**_xyz(shift, 'shift'), **_xyz(turn, 'turn')}
    return Effect('clamp_offset', amplitude, 'mm, deg', {'clamp_shift': shift, 'clamp_turn': turn})


def compliant_clamp(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    _, moment = weight_moment(setup)
    degrees = (1.0, 3.0, 7.0)[size]
    compliance = number(float(np.deg2rad(degrees)) / moment, random)
    return Effect(
        'compliant_clamp',
        {'compliance': compliance},
        'rad/(N m)',
        {'clamp_compliance': compliance},
    )


def rest_curvature(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    curvature = direction((0.4, 1.0, 2.5)[size], 2, random)
    return Effect(
        'rest_curvature',
        {'y': curvature[0], 'z': curvature[1]},
        '1/m',
        {'rest_curvature': curvature},
    )


def stiffness_contrast(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    contrast = signed((0.25, 0.6, 1.3)[size], random)
    mode = str(random.choice(['split', 'linear']))
    return Effect(
        'stiffness_contrast',
        {'log_ratio': contrast, 'mode': mode},
        'log E, tip less clamp',
        {'contrast': contrast, 'contrast_mode': mode},
    )


def strain_stiffening(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    ratio = number((8.0, 25.0, 80.0)[size], random)
    return Effect('strain_stiffening', {'ratio': ratio}, 'C2/C1', {'yeoh_ratio': ratio})


def time_offset(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    late = signed((2.0, 5.0, 12.0)[size], random)
    return Effect('time_offset', {'late': late}, 'ms', {'stamps_late': late})


def air_drag(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    area = number((150.0, 450.0, 1200.0)[size], random)
    return Effect('air_drag', {'area': area}, 'cm^2', {'drag_area': area})


def creep(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    share = number((0.08, 0.2, 0.4)[size], random)
    tau = round(float(random.uniform(4.0, 12.0)), 2)
    return Effect(
        'creep', {'share': share, 'tau': tau}, '-, s', {'creep_share': share, 'creep_time': tau}
    )


def side_wind(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    wind = signed((0.2, 0.4, 0.7)[size], random)
    return Effect('side_wind', {'share': wind}, 'of the weight', {'wind': wind})


def swelling(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    growth = number((2.0, 4.0, 7.0)[size], random)
    return Effect('swelling', {'growth': growth}, '%', {'swelling': growth})


def bulge(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    share = signed((0.05, 0.10, 0.18)[size], random)
    return Effect('bulge', {'share': share}, 'of the section', {'bulge': share})


def soft_skin(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    softer = -number((0.7, 1.2, 2.0)[size], random)
    return Effect('soft_skin', {'log_ratio': softer}, 'log E', {'soft_skin': softer})


def lens_distortion(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    radial = signed((0.2, 0.45, 0.9)[size], random)
    return Effect('lens_distortion', {'k1': radial}, '-', {'radial_distortion': radial})


LIBRARY: dict[str, Drawer] = {
    drawer.__name__: drawer
    for drawer in (
        camera_offset,
        depth_affine,
        depth_bias_by_region,
        gravity_tilt,
        added_mass,
        contact_plane,
        clamp_offset,
        compliant_clamp,
        rest_curvature,
        stiffness_contrast,
        strain_stiffening,
    )
}
# Effects that show only over time.
MOTION: dict[str, Drawer] = {drawer.__name__: drawer for drawer in (time_offset, air_drag, creep)}
OUTSIDE: dict[str, Drawer] = {
    drawer.__name__: drawer for drawer in (side_wind, swelling, bulge, soft_skin, lens_distortion)
}
# Which part of the world an effect outside the library belongs to.
OUTSIDE_CLASS = {
    'side_wind': 'load',
    'swelling': 'shape',
    'bulge': 'shape',
    'soft_skin': 'material',
    'lens_distortion': 'sensor',
    'shaken': 'boundary',
    'kicked': 'load',
    'leash': 'load',
    'doppler': 'sensor',
    'gust': 'load',
    'rippled': 'sensor',
    'remanent': 'load',
    'tearing': 'material',
    'rubbed': 'load',
    'lurched': 'boundary',
    'magnet': 'load',
    'tether': 'load',
    'heat': 'shape',
    'cone': 'shape',
    'torn': 'material',
    'wiggle': 'sensor',
    'hollow': 'shape',
    'jet': 'load',
    'stripes': 'sensor',
    'warming': 'material',
    'hose': 'load',
    'parted': 'shape',
    'memory': 'material',
    'tiles': 'sensor',
    'bath': 'load',
    'trimmed': 'shape',
    'fabric': 'material',
    'wobble': 'sensor',
    'screen': 'load',
    'coarse': 'sensor',
    'racked': 'shape',
    'jump': 'sensor',
    'guy': 'load',
    'drawn': 'shape',
    'crazed': 'material',
    'skewed': 'sensor',
    'worn': 'material',
    'clipped': 'sensor',
    'magnetized': 'load',
    'necked': 'shape',
    'whirl': 'load',
    'ghost': 'sensor',
    'dished': 'shape',
    'fattened': 'sensor',
    'shrinking': 'shape',
    'bleeding': 'sensor',
    'unglued': 'material',
    'trailing': 'sensor',
    'updraught': 'load',
    'stuck': 'sensor',
    'flattened': 'shape',
    'combed': 'sensor',
    'reeled': 'load',
    'droplet': 'sensor',
    'unlevel': 'shape',
    'flicker': 'sensor',
    'drafted': 'shape',
    'blocky': 'sensor',
    'ribbed': 'shape',
    'mirrored': 'sensor',
    'rounded': 'shape',
    'rings': 'sensor',
    'joggled': 'shape',
    'moire': 'sensor',
    'mitred': 'shape',
    'lapsed': 'sensor',
    'clubbed': 'shape',
    'jittered': 'sensor',
    'underfilled': 'shape',
    'spoked': 'sensor',
    'domed': 'shape',
    'crosstalk': 'sensor',
    'keeled': 'shape',
    'spiralled': 'sensor',
    'bevelled': 'shape',
    'sawtoothed': 'sensor',
    'chirped': 'sensor',
}


def combined(effects: tuple[Effect, ...]) -> Faults:
    """Put effects together."""
    changes: dict[str, Any] = {}
    for effect in effects:
        changes.update(effect.changes)
    return Faults(**changes)
