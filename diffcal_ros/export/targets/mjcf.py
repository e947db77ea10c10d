# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""MuJoCo: an MJCF model with one flex a material, on bodies that carry the vertices' masses.

Not by `flexcomp`, which gives every vertex the same mass: under gravity a body with small
tetrahedra at one end would hang as if that end were heavy. MuJoCo's elements are linear, its law
is St. Venant-Kirchhoff with E and nu as a small stretch measures them.

The integrator `discrete` takes forces from the end of a step, (M + h (f + h) K) dv = h (F - (f +
h) K v), where h is the step, f the flex's damping, and K the stiffness at the step's begin, kept
positive semi-definite (`engine_metric.c` of MuJoCo 4.0). So a step damps as Rayleigh's factor
does. It is taken off the factor that is written, which is exact for small swings about a body that
is not bent; in a bent one a step damps more than that, so that steps are also short beside f.
"""

from collections.abc import Sequence
from pathlib import Path
from xml.sax.saxutils import quoteattr

from diffcal_ros.atomic_file import write_text_atomically
from diffcal_ros.export.exported_body import ExportedBody
from diffcal_ros.export.material_groups import material_groups, MaterialGroup
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

SIMULATOR = 'mujoco'
# With its usual 100 iterations to 1e-8, MuJoCo stops far from equilibrium near nu = 0.5.
_OPTIONS = 'integrator="discrete" solver="Newton" iterations="400" tolerance="1e-12"'
_TIME_STEP = 0.005  # Of a body without damping of its own: its swings do not matter [s].
# Of a damped one, as a share of Rayleigh's factor on its stiffness, and the least that is stated:
# ten steps a millisecond is what a person still waits for.
_STEP_SHARE = 0.2
_SHORTEST_STEP = 1e-4
# Of the shortest edges: what surrounds the tetrahedra in a contact.
_RADIUS_FRACTION = 0.05
_SLIDES = ''.join(f'<joint type="slide" axis="{axis}"/>' for axis in ('1 0 0', '0 1 0', '0 0 1'))


def write(body: ExportedBody, folder: Path) -> list[Path]:
    """Write `body.xml`."""
    path = folder / 'body.xml'
    write_text_atomically(path, mjcf(body))
    return [path]


def mjcf(body: ExportedBody) -> str:
    """Return the model as text."""
    held = np.zeros(body.mesh.vertex_count, dtype=bool)
    held[body.held] = True
    rows = zip(body.mesh.rest_positions, body.vertex_masses, held, strict=True)
    bodies = [_vertex(number, *row) for number, row in enumerate(rows)]
    groups = material_groups(body)
    step = time_step(groups)
    flexes = [_flex(body, group, step) for group in groups]
    return '\n'.join(
        [
            f'<mujoco model={quoteattr(body.name)}>',
            '  <compiler autolimits="true"/>',
            f'  <!-- {_about_damping(groups, step)} -->',
            f'  <option timestep="{step:.6g}" gravity="{_row(body.gravity)}" {_OPTIONS}/>',
            '  <size memory="500M"/>',
            '  <worldbody>',
            '    <!-- One body a vertex; those without joints are held by the clamp. -->',
            *bodies,
            '  </worldbody>',
            '  <deformable>',
            *flexes,
            '  </deformable>',
            '</mujoco>',
            '',
        ]
    )


def time_step(groups: Sequence[MaterialGroup]) -> float:
    """Return the time step that is stated [s]: short beside what the material damps by."""
    damped = [group.stiffness_damping for group in groups if group.stiffness_damping > 0.0]
    if not damped:
        return _TIME_STEP
    return float(np.clip(_STEP_SHARE * min(damped), _SHORTEST_STEP, _TIME_STEP))


def _about_damping(groups: Sequence[MaterialGroup], step: float) -> str:
    factors = ', '.join(f'{group.name} {group.stiffness_damping:.4g}' for group in groups)
    return (
        f'Each step of {step:.4g} s damps as that many seconds of `damping` do: they are taken '
        f'off what the material has ({factors} s). Another timestep wants another damping.'
    )


def _vertex(number: int, position: FloatArray, mass: float, is_held: bool) -> str:
    # A point mass has no inertia of its own; MuJoCo asks for one, and nothing turns it.
    inertial = f'<inertial pos="0 0 0" mass="{mass:.9g}" diaginertia="1e-9 1e-9 1e-9"/>'
    joints = '' if is_held else _SLIDES
    return f'    <body name="v{number}" pos="{_row(position)}">{inertial}{joints}</body>'


def _flex(body: ExportedBody, group: MaterialGroup, step: float) -> str:
    tets = body.mesh.tets[group.tets]
    vertices, local = np.unique(tets, return_inverse=True)
    sides = body.mesh.rest_positions[body.mesh.edges[0]]
    damping = max(group.stiffness_damping - step, 0.0)
    radius = _RADIUS_FRACTION * float(np.linalg.norm(sides[:, 1] - sides[:, 0], axis=1).min())
    return '\n'.join(
        [
            f'    <flex name={quoteattr(group.name)} dim="3" radius="{radius:.4g}"',
            f'          body="{" ".join(f"v{vertex}" for vertex in vertices)}"',
            f'          element="{" ".join(str(corner) for corner in local.reshape(-1))}">',
            '      <contact selfcollide="none"/>',
            f'      <elasticity young="{group.youngs_modulus:.9g}" '
            f'poisson="{group.poissons_ratio:.9g}" damping="{damping:.6g}"/>',
            '    </flex>',
        ]
    )


def _row(values: FloatArray) -> str:
    return ' '.join(f'{value:.9g}' for value in values)
