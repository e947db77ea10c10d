# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the seventeenth set alone has, and its pairs.

The second and third size of a form change what is seen of a body by some 4 and 10 mm, where the
mechanics allow it.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed, weight_moment
from benchmarks.blind.draught import drawn_in
from benchmarks.blind.faults import Faults
from benchmarks.blind.form import Form
from benchmarks.blind.hexahedra import integrate, mesh_hexahedra
from benchmarks.blind.moduli import on_foil
from benchmarks.blind.outside_forms import tip_stiffness
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.slender import even_sag, levers, SHARES, softness
from benchmarks.blind.twelfth_forms import held_moment

_MOVES = (0.002, 0.004, 0.010)  # Of the tip [m], by the formulas of a slender beam.
_MOST_DRAWN = 0.8  # Of the weight, by which air draws where the camera looks.
_HARDEST = 4.5  # Log of a foil's modulus over a rubber's.
_SINKS = 0.003  # By how much a body sinks into a cushion where it lies on that [m].


def _markers(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave the balls of a motion capture system on a body, each on a stalk."""
    inner = round(float(random.uniform(0.3, 0.45)), 4)
    outer = round(float(random.uniform(0.85, 0.95)), 4)
    count = int(random.integers(3, 6))
    lever = float(np.interp(np.linspace(inner, outer, count), SHARES, levers(setup)).mean())
    grams = 1e3 * _MOVES[size] * tip_stiffness(setup) / (0.375 * lever * GRAVITY)
    stalk = 500.0 * setup.shape.section[1] + random.uniform(12.0, 20.0)
    return {
        'mass_form': 'markers',
        'added_mass': number(grams, random),
        'mass_stops': (inner, outer),
        'mass_count': count,
        'mass_arm': (0.0, round(float(stalk), 3)),
    }


def _foil(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Glue the foil of a bend sensor along the upper side, from near the clamp on."""
    begin = round(float(random.uniform(0.02, 0.08)), 4)
    end = round(begin + float(random.uniform(0.4, 0.55)), 4)
    contrasts = np.linspace(0.0, _HARDEST, 101)
    stiffer = _stiffer(setup, contrasts)
    # By the tip's share of an even load's moments, (1 - share)^3, a part is stiffer by that.
    parts = (1.0 - SHARES) ** 3 * softness(setup) / 50.0
    below = float(parts[(begin < SHARES) & (end > SHARES)].sum())
    changes = even_sag(setup) * below * (1.0 - 1.0 / stiffer)
    return {
        'contrast_mode': 'foil',
        'contrast': number(float(np.interp(_MOVES[size], changes, contrasts)), random),
        'contrast_at': begin,
        'contrast_until': end,
    }


def _stiffer(setup: Setup, contrasts: FloatArray) -> FloatArray:
    """Return by what factor a section with a foil bends less about y, by its contrast, (K,)."""
    mesh = mesh_hexahedra(setup.shape)
    quadrature = integrate(mesh.nodes, mesh.cells)
    points = mesh.lattice[mesh.cells].swapaxes(1, 2) @ quadrature.values.T
    whole = Faults(contrast_at=-1.0, contrast_until=2.0)
    inside = on_foil(setup, whole, np.zeros(points[:, 2].shape), points)
    moments = [
        (quadrature.volumes * points[:, 2] ** power)
        + np.expm1(contrasts)[:, None, None]
        * (quadrature.volumes * points[:, 2] ** power * inside)
        for power in range(3)
    ]
    area, first, second = (moment.sum(axis=(1, 2)) for moment in moments)
    # About where nothing is drawn or pressed, which lies nearer to the foil.
    stiffness = second - first**2 / area
    return np.asarray(stiffness / stiffness[0])


def _wrist(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Hold the clamp by a robot's arm, whose last three joints give way."""
    behind = round(float(random.uniform(0.05, 0.08)), 4)
    mass, _ = weight_moment(setup)
    moment = held_moment(setup) + GRAVITY * mass * behind
    way = behind + setup.shape.length - 0.5 * setup.shape.clamp
    # Less than a level body asks: what is across the joint about z moves by more.
    turn = 0.7 * _MOVES[size] / way
    return {
        'clamp_form': 'wrist',
        'clamp_compliance': number(turn / moment, random),
        'clamp_length': behind,
    }


def _bowed(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Print jaws that came off their bed bowed, so that what they hold is bent."""
    clamp, free = setup.shape.clamp, setup.shape.length - setup.shape.clamp
    return {'clamp_bow': direction(_MOVES[size] / (clamp * (free + 0.5 * clamp)), 2, random)}


def _cushion(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a cushion below the tip, which is soft, and highest beside that."""
    beside = direction(0.007, 2, random)
    free, width = setup.shape.length - setup.shape.clamp, setup.shape.section[0]
    # Of the outer fifth, which lies on it.
    stiffness = tip_stiffness(setup) * _MOVES[size] / (0.2 * free * width * _SINKS)
    return {
        'contact_form': 'cushion',
        'contact_height': number(1e3 * (_MOVES[size] + _SINKS), random),
        'contact_ahead': beside[0],
        'contact_at': beside[1],
        'contact_round': -round(float(random.uniform(0.12, 0.2)), 4),
        'contact_stiffness': number(stiffness, random),
    }


def _saturated(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Let a sensor expose for too long, so that it errs where much light returns."""
    return {
        'depth_form': 'saturated',
        'depth_bias': signed((1.5, 3.0, 7.5)[size], random),
        'depth_full': round(float(random.uniform(0.4, 0.6)), 4),
    }


def _speckled(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Spray dots on the outer part, whose images were to be correlated."""
    return {
        'region_bias': signed((2.0, 4.2, 10.0)[size], random),
        'region_from': round(float(random.uniform(0.25, 0.4)), 4),
        'region_dot': round(float(random.uniform(0.006, 0.009)), 5),
        'region_cover': round(float(random.uniform(0.5, 0.65)), 4),
        'region_seed': int(random.integers(1, 2**31)),
    }


def _leaned_on(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Lean on the camera's table during one recording, which springs back but for a part."""
    shift, turn = ((2.0, 0.3), (4.0, 0.65), (10.0, 1.6))[size]
    whole = np.array(direction(shift, 3, random) + direction(turn, 3, random))
    count, left = len(setup.observations), random.uniform(0.1, 0.25)
    leaned = min(int(random.integers(1, 3)), count - 1)
    shares = [0.0] * leaned + [1.0] + [left] * (count - leaned - 1)
    return {
        'camera_scatter': tuple(
            tuple(round(float(share * value), 4) for value in whole) for share in shares
        )
    }


def _extractor(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave the arm of a fume extractor on behind the bench, whose mouth draws in air."""
    around = random.uniform(-0.9, 0.9)
    level, high = random.uniform(0.17, 0.22), random.uniform(0.04, 0.09)
    ahead = np.array([np.sin(around), 0.0, -np.cos(around)])
    x, _, z = (round(float(value), 4) for value in level * ahead)
    mouth = (x, round(float(high), 4), z)
    shape, felt = setup.shape, []
    line = shape.clamp + SHARES * (shape.length - shape.clamp)
    line = shape.place(line[:, None] * np.array([1.0, 0.0, 0.0]))
    for pose in setup.observations:
        places = applied(pose.world_from_object, line)
        drawn = drawn_in(places, np.array([1.0, 0.0, 0.0]), Faults(tilt_point=mouth))
        # What draws along the body does not bend it.
        across = levers(setup) @ drawn @ pose.world_from_object[:3, 1:3] / len(SHARES)
        felt.append(float(np.linalg.norm(across)))
    # Of the mean over the poses, where none comes much nearer to the mouth than others.
    most = max(float(np.mean(felt)), max(felt) / 1.5)
    share = min(_MOVES[size] / (even_sag(setup) * most), _MOST_DRAWN)
    angle = number(float(np.rad2deg(np.arcsin(share))), random)
    # About the world's x it draws across the body, about z along it.
    tilt = (-angle * ahead[2], angle * ahead[0])
    return {
        'tilt_form': 'extractor',
        'gravity_tilt': tuple(round(float(value), 4) for value in tilt),
        'tilt_point': mouth,
    }


def _weighed_down(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Store a body across a gap, with something heavy on it."""
    free = setup.shape.length - setup.shape.clamp
    return {
        'curvature_form': 'weighed down',
        'rest_curvature': direction(2.0 * _MOVES[size] / free**2, 2, random),
        'curvature_at': round(float(random.uniform(0.25, 0.6)), 4),
    }


SEVENTEENTH_FORMS = (
    Form('added_mass', 'markers', _markers),
    Form('stiffness_contrast', 'foil', _foil),
    Form('compliant_clamp', 'wrist', _wrist),
    Form('clamp_offset', 'bowed', _bowed),
    Form('contact_plane', 'cushion', _cushion),
    Form('depth_affine', 'saturated', _saturated),
    Form('depth_bias_by_region', 'speckled', _speckled),
    Form('camera_offset', 'leaned on', _leaned_on),
    Form('gravity_tilt', 'extractor', _extractor),
    Form('rest_curvature', 'weighed down', _weighed_down),
)
# Two at a time, of different effects: new ones, and one that a set of before had singly.
SEVENTEENTH_PAIRS = (
    ('compliant_clamp/wrist', 'depth_affine/saturated'),
    ('contact_plane/cushion', 'camera_offset/leaned on'),
    ('added_mass/markers', 'depth_bias_by_region/speckled'),
    ('gravity_tilt/extractor', 'depth_affine/toed'),
)
