# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the twelfth set alone has, and its pairs.

The second and third size of a form change what is seen of a body by some 5 and 10 mm.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed
from benchmarks.blind.form import Form
from benchmarks.blind.hexahedra import integrate, mesh_hexahedra
from benchmarks.blind.outside_forms import depth_amid_body, tip_sag, tip_stiffness
from benchmarks.blind.setups import GRAVITY, Setup

_MOVES = (0.002, 0.005, 0.010)  # Of the tip [m], by the formulas of a slender beam.


def _braided(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Fill a rubber with a braid, whose threads resist a pull by its exponential."""
    return {
        'stiffening_form': 'braided',
        'stiffening': number((0.1, 0.3, 1.0)[size], random),
        'stiffening_slant': round(float(random.uniform(20.0, 35.0)), 3),
        'stiffening_steep': round(float(random.uniform(30.0, 60.0)), 3),
    }


def _patched(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Mend one side of a body, near its clamp, with another rubber."""
    sag = tip_sag(setup)
    begin = round(float(random.uniform(0.0, 0.06)), 4)
    end = round(begin + float(random.uniform(0.35, 0.5)), 4)
    contrasts = np.linspace(0.0, float(random.choice([-2.5, 3.0])), 101)
    # By the tip's share of an even load's moments; where it bends towards its mended half.
    part, ratios = (1.0 - begin) ** 4 - (1.0 - end) ** 4, np.exp(contrasts)
    softer = 8.0 * (1.0 + ratios) / (1.0 + 14.0 * ratios + ratios**2)
    changes = sag * part * np.abs(softer - 1.0)
    contrast = np.interp(_MOVES[size], changes, contrasts)
    return {
        'contrast_mode': 'patched',
        'contrast': number(float(contrast), random),
        'contrast_at': begin,
        'contrast_until': end,
        'contrast_side': float(random.choice([-1.0, 1.0])),
    }


def _drying(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Wrap a part of a body in a wet cloth, which dries from pose to pose."""
    inner = round(float(random.uniform(0.35, 0.5)), 4)
    outer = round(inner + float(random.uniform(0.25, 0.4)), 4)
    places = np.linspace(inner, outer, 50)
    lever = float((0.5 * places**2 * (3.0 - places)).mean())
    grams = 1e3 * _MOVES[size] * tip_stiffness(setup) / lever / 9.81
    dry, rate = random.uniform(0.2, 0.35), random.uniform(0.4, 0.8)
    shares = dry + (1.0 - dry) * np.exp(-rate * np.arange(len(setup.observations)))
    return {
        'mass_form': 'drying',
        'added_mass': number(grams, random),
        'mass_stops': (inner, outer),
        'mass_shares': tuple(round(float(share), 4) for share in shares),
    }


def _putty(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Bed a body in putty, which flows on in every pose the way the weight draws, and stays."""
    turn, shift = ((0.4, 0.2), (1.0, 0.4), (2.0, 0.8))[size]
    sunk, found = np.zeros(6), []
    for observation in setup.observations:
        _, y, z = -observation.world_from_object[1, :3]
        # It sinks across itself, and its tip is turned the same way.
        flow = np.array([0.0, shift * y, shift * z, 0.0, -turn * z, turn * y])
        sunk = sunk + number(1.0, random) * flow
        found.append(tuple(round(float(value), 4) for value in sunk))
    return {'clamp_scatter': tuple(found)}


def _preloaded(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Hold a clamp by a spring against a stop, which it leaves at some moment alone."""
    moment = held_moment(setup)
    preload = round(float(random.uniform(0.4, 0.55)) * moment, 6)
    compliance = float(np.deg2rad((0.9, 2.4, 4.8)[size])) / (moment - preload)
    return {
        'clamp_form': 'preloaded',
        'clamp_compliance': number(compliance, random),
        'clamp_preload': preload,
    }


def _entry(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Spoil one entry of the table by which a sensor corrects its depths."""
    between = depth_amid_body(setup, random)
    return {
        'depth_form': 'entry',
        'depth_bias': signed((2.5, 6.0, 12.0)[size], random),
        'depth_entry': round(between + float(random.uniform(-0.01, 0.01)), 5),
        'depth_spacing': round(float(random.uniform(0.05, 0.08)), 4),
    }


def _in_turn(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Look with two cameras in turn, and take them for one."""
    shift, turn = ((2.0, 0.3), (5.0, 0.7), (10.0, 1.4))[size]
    other = direction(shift, 3, random) + direction(turn, 3, random)
    first = int(random.integers(2))
    count = len(setup.observations)
    return {
        'camera_scatter': tuple(
            other if (pose + first) % 2 else (0.0,) * 6 for pose in range(count)
        )
    }


def _pan(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a balance below the tip, whose pan sinks by a third or a half of what it lifts."""
    sinks = random.uniform(0.3, 0.5)
    return {
        'contact_form': 'pan',
        'contact_height': number(1e3 * _MOVES[size] / (1.0 - sinks), random),
        'contact_give': number(sinks / (1.0 - sinks) / tip_stiffness(setup), random),
    }


def held_moment(setup: Setup) -> float:
    """Return the moment of a level body's weight about the middle of what is held [N m]."""
    mesh = mesh_hexahedra(setup.shape, 0.5)
    quadrature = integrate(mesh.nodes, mesh.cells)
    arms = (quadrature.values @ mesh.nodes[mesh.cells])[..., 0] - 0.5 * setup.shape.clamp
    return float(setup.density * GRAVITY * (quadrature.volumes * arms).sum())


TWELFTH_FORMS = (
    Form('strain_stiffening', 'braided', _braided),
    Form('stiffness_contrast', 'patched', _patched),
    Form('added_mass', 'drying', _drying),
    Form('clamp_offset', 'putty', _putty),
    Form('compliant_clamp', 'preloaded', _preloaded),
    Form('depth_affine', 'entry', _entry),
    Form('camera_offset', 'in turn', _in_turn),
    Form('contact_plane', 'pan', _pan),
)
# Two at a time, of different effects: new ones, and some that sets of before had singly.
TWELFTH_PAIRS = (
    ('strain_stiffening/braided', 'depth_bias_by_region/glossy'),
    ('clamp_offset/putty', 'rest_curvature/kink'),
    ('contact_plane/pan', 'camera_offset/in turn'),
    ('stiffness_contrast/patched', 'gravity_tilt/thread'),
)
