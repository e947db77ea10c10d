# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Simulate with an energy law of one's own.

A law is a module with a few Warp functions and two constants; `plain_neo_hookean.py` beside this
file is one. Any module can be given to `StaticBody`; one that lies in `diffcal_ros/fem/laws` is
also found by its name in a scene.

Printed: the slope of the energy along a random displacement, by differences and from the forces,
and the tip's sag beside that of the law that is usual. Where a body bends without much stretch the
two agree: the constants of both mean the same Young's modulus.
"""

from beam import beam_mesh, GRAVITY, held_end
from diffcal_ros import Element, Material, StaticBody
from diffcal_ros.fem.laws import stable_neo_hookean
import numpy as np
import plain_neo_hookean

STEP = 1e-7  # [m]

mesh = beam_mesh((8, 2, 2))
ones = np.ones(mesh.tet_count)
tip = int(np.argmax(mesh.rest_positions.sum(axis=1)))
sags = {}
for law in (stable_neo_hookean, plain_neo_hookean):
    body = StaticBody(mesh, Element.QUADRATIC, held_end(mesh), law=law)
    material = Material(400e3 * ones, 0.45 * ones, 1080.0 * ones, conversion=law.CONVERSION)
    positions = body.solve_equilibrium(material, GRAVITY).positions
    sags[law.__name__.rpartition('.')[2]] = float(mesh.rest_positions[tip, 1] - positions[tip, 1])

# The nodal forces that hold the last body in its shape are the slope of its energy.
direction = np.random.default_rng(1).normal(size=positions.shape)
above, below = (body.elastic.energy(positions + step * direction) for step in (STEP, -STEP))
slope = (above - below) / (2.0 * STEP)
power = float((body.elastic.forces(positions) * direction).sum())

print(f'slope of the energy   {slope:10.6f} J/m')
print(f'forces along it       {power:10.6f} J/m')
for name, sag in sags.items():
    print(f'{name:20} sags {1e3 * sag:.3f} mm')
