# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the twentieth set alone has, and its pairs.

The second and third size of a form change what is seen of a body by some 4 and 10 mm, where the
mechanics allow it.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed
from benchmarks.blind.form import Form
from benchmarks.blind.moduli import overbent_share
from benchmarks.blind.outside_forms import tip_stiffness
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.slender import even_sag, levers, SHARES, softness
from benchmarks.blind.twelfth_forms import held_moment

_MOVES = (0.002, 0.004, 0.010)  # Of the tip [m], by the formulas of a slender beam.
_MOST_SOFTENED = 4.0  # By which log E fell where a body was bent most.
_SINKS = 0.003  # By how much a body sinks into felt where it lies on that [m].
_MOST_TILTED = 0.4  # Of the weight, by which a table's lean draws aside in the largest size.
_OFF_LEVEL = 0.4  # Of how far a table leans to the rig, by which it is not level anyway.


def _sponge(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Keep a body moist by a sponge around its outer part, in which the water sinks."""
    inner = round(float(random.uniform(0.4, 0.55)), 4)
    outer = round(float(random.uniform(0.9, 0.98)), 4)
    within = (inner < SHARES) & (outer > SHARES)
    lever = float(levers(setup)[within].mean())
    grams = 1e3 * _MOVES[size] * tip_stiffness(setup) / (0.375 * lever * GRAVITY)
    return {
        'mass_form': 'sponge',
        'added_mass': number(grams, random),
        'mass_stops': (inner, outer),
        'mass_suction': round(float(random.uniform(0.008, 0.016)), 5),
    }


def _overbent(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Bend a body far over something once, so that its rubber is soft where it was strained."""
    at = round(float(random.uniform(0.2, 0.4)), 4)
    contrasts = np.linspace(0.0, -_MOST_SOFTENED, 81)
    high = np.asarray((np.arange(20) + 0.5) / 20.0)
    strained = overbent_share(SHARES[:, None], high, at)
    # Parts of a section bear by the square of their height.
    bears = np.exp(contrasts[:, None, None] * strained) @ high**2 / (high**2).sum()
    parts = (1.0 - SHARES) ** 3 * softness(setup) / 50.0
    changes = even_sag(setup) * (1.0 / bears - 1.0) @ parts
    return {
        'contrast_mode': 'overbent',
        'contrast': -number(float(np.interp(_MOVES[size], changes, -contrasts)), random),
        'contrast_at': at,
    }


def _taped(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Stick the holder to the rig by a square of foam tape."""
    edge = round(float(random.uniform(0.03, 0.045)), 4)
    # Less than a level body asks: what shears the tape moves it by more.
    turn = 0.57 * _MOVES[size] / (setup.shape.length - 0.5 * setup.shape.clamp)
    return {
        'clamp_form': 'taped',
        'clamp_compliance': number(turn / held_moment(setup), random),
        'clamp_length': edge,
    }


def _greased(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a greased slide below the clamp unlocked, which creeps by the weight along it."""
    rail = random.standard_normal(3) * np.array([0.5, 1.0, 1.0])
    rail /= np.linalg.norm(rail)
    ways = [-float(pose.world_from_object[1, :3] @ rail) for pose in setup.observations]
    # As long in each pose: it lies where all the weights so far have drawn it.
    lies = np.cumsum(ways)
    lies *= number(1e3 * _MOVES[size], random) / np.abs(lies).max()
    return {
        'clamp_scatter': tuple(
            (*(round(float(value), 4) for value in place * rail), 0.0, 0.0, 0.0) for place in lies
        )
    }


def _felt(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a folded towel below the tip, which hardens as it is pressed."""
    bend = round(float(random.uniform(0.0008, 0.0013)), 5)
    free, width = setup.shape.length - setup.shape.clamp, setup.shape.section[0]
    # Of the outer fifth, which lies on it.
    pressure = tip_stiffness(setup) * _MOVES[size] / (0.2 * free * width)
    return {
        'contact_form': 'felt',
        'contact_height': number(1e3 * (_MOVES[size] + _SINKS), random),
        'contact_pressure': number(pressure / float(np.expm1(_SINKS / bend)), random),
        'contact_bend': bend,
    }


def _sunbeam(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Let the sun in through a slit between curtains, whose beam wanders over what is seen."""
    slant, wander = float(random.uniform(-70.0, 70.0)), signed(30.0, random)
    way = np.array([np.cos(np.deg2rad(slant)), np.sin(np.deg2rad(slant))])
    # Midway through the poses it is somewhere near the image's middle.
    first = random.uniform(-25.0, 25.0, 2) - 0.5 * wander * (len(setup.observations) - 1) * way
    return {
        'depth_form': 'sunbeam',
        'depth_bias': signed((2.2, 4.4, 11.0)[size], random),
        'depth_spot': tuple(round(float(place), 3) for place in first),
        'depth_width': round(float(random.uniform(70.0, 110.0)), 3),
        'depth_slant': round(slant, 3),
        'depth_wander': wander,
    }


def _bleached(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Keep a body at a window, whose sun bleaches the outer part, the more what faces it."""
    around = random.uniform(0.0, 2.0 * np.pi)
    return {
        'region_bias': signed((2.4, 5.0, 12.0)[size], random),
        'region_from': round(float(random.uniform(0.25, 0.4)), 4),
        'region_sun': (round(float(np.cos(around)), 4), round(float(np.sin(around)), 4)),
    }


def _tugged(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Tie a camera's cable to the rig, which tugs at it where the rig turns its end away."""
    most = number((0.35, 0.7, 1.75)[size], random)
    foot = np.array([0.0, random.uniform(0.03, 0.05), 0.0])
    around = random.uniform(0.0, 2.0 * np.pi)
    end = np.array([[-0.02, 0.08 * np.cos(around), 0.08 * np.sin(around)]])
    ways = np.array(
        [
            applied(setup.depth_from_world @ pose.world_from_object, end)[0]
            for pose in setup.observations
        ]
    )
    away = np.linalg.norm(ways, axis=1)
    # It is slack where its end is near, and as tight as it is longer than that beyond.
    slack = away.min() + random.uniform(0.2, 0.5) * np.ptp(away)
    tight = np.maximum(away - slack, 0.0) / max(away.max() - slack, 1e-9)
    turns = np.cross(-foot, ways)
    turns *= most * (tight / np.linalg.norm(turns, axis=1))[:, None]
    return {
        'camera_scatter': tuple(
            (0.0, 0.0, 0.0, *(round(float(value), 4) for value in turn)) for turn in turns
        ),
        'camera_foot': tuple(round(float(value), 4) for value in foot),
    }


def _floating(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Stand all on a table with soft feet, which leans to where the rig is heavy."""
    around, base = random.uniform(0.0, 2.0 * np.pi, 2)
    heavy = np.array([random.uniform(-0.4, 0.4), np.cos(around), np.sin(around)])
    level = _OFF_LEVEL * np.array([np.cos(base), 0.0, np.sin(base)])
    leans = [
        np.diag([1.0, 0.0, 1.0]) @ pose.world_from_object[:3, :3] @ heavy
        for pose in setup.observations
    ]
    section = np.array(setup.shape.section)
    # A body gives way across its sides by the inverse square of how thick it is that way.
    gives = (section.min() / section) ** 2
    moves = [
        np.linalg.norm(gives * (pose.world_from_object[:3, 1:3].T @ (lean + level)))
        for lean, pose in zip(leans, setup.observations, strict=True)
    ]
    share = _MOVES[size] * min(
        1.0 / (even_sag(setup) * float(max(moves))), _MOST_TILTED / _MOVES[2]
    )
    degrees = number(float(np.rad2deg(share)), random)

    def tilt(lean: FloatArray) -> tuple[float, float]:
        # About the world's x gravity turns towards -z, about z towards x.
        return round(float(-degrees * lean[2]), 4), round(float(degrees * lean[0]), 4)

    return {
        'tilt_form': 'floating',
        'gravity_tilt': tilt(level),
        'tilt_scatter': tuple(tilt(lean) for lean in leans),
    }


def _crammed(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Keep a body in a box that is too small for it, around two of its corners."""
    inner, outer, back = (
        round(float(random.uniform(*ends)), 4) for ends in ((0.2, 0.35), (0.55, 0.7), (0.8, 1.3))
    )
    free = setup.shape.length - setup.shape.clamp
    lever = float(np.hypot(1.0 - inner, back * (1.0 - outer)))
    return {
        'curvature_form': 'crammed',
        'rest_curvature': direction(_MOVES[size] / (lever * free**2), 2, random),
        'curvature_at': inner,
        'curvature_again': outer,
        'curvature_back': float(random.choice([-1.0, 1.0])) * back,
    }


TWENTIETH_FORMS = (
    Form('added_mass', 'sponge', _sponge),
    Form('stiffness_contrast', 'overbent', _overbent),
    Form('compliant_clamp', 'taped', _taped),
    Form('clamp_offset', 'greased', _greased),
    Form('contact_plane', 'felt', _felt),
    Form('depth_affine', 'sunbeam', _sunbeam),
    Form('depth_bias_by_region', 'bleached', _bleached),
    Form('camera_offset', 'tugged', _tugged),
    Form('gravity_tilt', 'floating', _floating),
    Form('rest_curvature', 'crammed', _crammed),
)
# Two at a time, of different effects: new ones, and one that a set of before had singly.
TWENTIETH_PAIRS = (
    ('added_mass/sponge', 'depth_affine/sunbeam'),
    ('stiffness_contrast/overbent', 'camera_offset/tugged'),
    ('contact_plane/felt', 'depth_bias_by_region/bleached'),
    ('clamp_offset/greased', 'strain_stiffening/knitted'),
)
