# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A hanging beam, and how its tip follows the modulus.

`StaticBody` finds where all forces on the body balance, by Newton's method. The derivative of that
state costs one more solve with the factor that is there already: no step size, no tape. Beside it
stands the difference of two simulations, which cost a Newton solve each and need a step size.

Printed: the tip's sag, and its derivative by the logarithm of Young's modulus, both ways. The
sag of a stiff beam goes with 1/E, so that the two have the same size; this one sags far enough to
differ.
"""

from beam import beam_mesh, GRAVITY, held_end
from diffcal_ros import Change, Element, Material, StaticBody
import numpy as np

MODULUS = 150e3  # [Pa]
STEP = 1e-3  # Of the logarithm.

mesh = beam_mesh()
body = StaticBody(mesh, Element.QUADRATIC, held_end(mesh))
tip = int(np.argmax(mesh.rest_positions.sum(axis=1)))
ones = np.ones(mesh.tet_count)


def tip_height(youngs_modulus: float) -> float:
    """Return the tip's y after settling [m]."""
    material = Material(youngs_modulus * ones, 0.45 * ones, 1080.0 * ones)
    return float(body.solve_equilibrium(material, GRAVITY).positions[tip, 1])


sag = float(mesh.rest_positions[tip, 1]) - tip_height(MODULUS)
tangent = body.tangents([Change(youngs_modulus=MODULUS * ones)])[0]
derivative = float(tangent[tip, 1])
above, below = (tip_height(MODULUS * np.exp(step)) for step in (STEP, -STEP))
difference = (above - below) / (2.0 * STEP)

print(f'sag of the tip                {1e3 * sag:8.3f} mm')
print(f'its derivative by log E       {1e3 * derivative:8.4f} mm')
print(f'the same by differences       {1e3 * difference:8.4f} mm')
