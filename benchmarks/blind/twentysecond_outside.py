# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the twenty-second set alone has.

Their second and third size change what is seen of a body by some 4 and 10 mm, where the mechanics
allow it.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number, signed
from benchmarks.blind.outside_forms import tip_stiffness
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import Setup

_MOVES = (0.002, 0.004, 0.010)  # Of the tip, by the formulas of a slender beam, or of places [m].
_PIXEL = 0.00057  # What a pixel sees of a body [m].


def reeled(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw the reel of a balancer beside the rig, whose cord draws the tip with a steady force."""
    around, high = random.uniform(0.0, 2.0 * np.pi), random.uniform(-0.05, 0.25)
    x, z = (0.35 * np.array([np.cos(around), np.sin(around)])).tolist()
    point = (round(x, 5), round(float(high), 5), round(z, 5))
    tip = np.array([[setup.shape.length, 0.0, 0.0]])
    section = np.array(setup.shape.section)
    # A body gives way across its sides by the inverse square of how thick it is that way.
    gives, moves = (section.min() / section) ** 2, []
    for pose in setup.observations:
        away = np.array(point) - applied(pose.world_from_object, setup.shape.place(tip))[0]
        pull = pose.world_from_object[:3, 1:3].T @ away / np.linalg.norm(away)
        moves.append(float(np.linalg.norm(gives * pull)))
    force = number(_MOVES[size] * tip_stiffness(setup) / max(moves), random)
    amplitude: dict[str, float | str] = {'force': force}
    amplitude.update(zip('xyz', point, strict=True))
    return Effect('reeled', amplitude, 'N, m', {'reeled': force, 'pull_point': point})


def droplet(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw a drop on the sensor's window, which bends the rays to a body's outer part."""
    shape, pose, camera = setup.shape, setup.observations[0], setup.camera
    at = shape.clamp + random.uniform(0.55, 0.85) * (shape.length - shape.clamp)
    place = shape.place(np.array([[at, 0.0, 0.0]]))
    seen = camera.project(applied(setup.depth_from_world @ pose.world_from_object, place))[0]
    across, down = (seen - [camera.cx, camera.cy] + random.uniform(-12.0, 12.0, 2)).tolist()
    shift = signed(_MOVES[size] / _PIXEL, random)
    changes = {
        'droplet': shift,
        'droplet_at': (round(across, 3), round(down, 3)),
        'droplet_width': round(float(random.uniform(45.0, 70.0)), 3),
    }
    amplitude = {
        'shift': shift,
        'across': changes['droplet_at'][0],
        'down': changes['droplet_at'][1],
        'width': changes['droplet_width'],
    }
    return Effect('droplet', amplitude, 'px', changes)


TWENTYSECOND_OUTSIDE: dict[str, Drawer] = {drawer.__name__: drawer for drawer in (reeled, droplet)}
