# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Newton: arrays for `ModelBuilder.add_soft_mesh`, and a script that builds and steps the body.

Both of its solvers take linear tetrahedra and stable neo-Hookean energies, but their constants
differ: `SolverVBD` is given Lame's parameters as they are, `SolverSemiImplicit` puts what it is
given into Smith et al. 2018 (equation 13), where the constants of section 3.4 measure E and nu.
The file has both.

`SolverSemiImplicit` damps by the rate of the deformation gradient, in which there is the rate of
turning too, and by that of the volume: a slender body that swings turns far more than it strains.
The file's `gradient_damping` takes as much power out of the slowest swing as the material does;
faster ones, which turn less, are damped less than they should be.
"""

import io
from pathlib import Path
from typing import Any

from diffcal_ros.atomic_file import write_bytes_atomically
from diffcal_ros.export.exported_body import ExportedBody
from diffcal_ros.export.first_mode import first_mode
from diffcal_ros.material import Material
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

SIMULATOR = 'newton'


def write(body: ExportedBody, folder: Path) -> list[Path]:
    """Write `body.npz`."""
    content = io.BytesIO()
    np.savez_compressed(content, **arrays(body))
    path = folder / 'body.npz'
    write_bytes_atomically(path, content.getvalue())
    return [path]


def arrays(body: ExportedBody) -> dict[str, Any]:
    """Return what the file holds, by name, in SI units."""
    smith = Material(body.youngs_modulus, body.poissons_ratio, body.density).lame_parameters()
    return {
        'vertices': body.mesh.rest_positions,
        'tets': body.mesh.tets,
        'held': body.held,
        'gravity': body.gravity,
        'density': body.density,
        'vertex_masses': body.vertex_masses,
        'lame_mu': body.lame_mu,
        'lame_lambda': body.lame_lambda,
        'neo_hookean_mu': smith.neo_hookean_mu,
        'neo_hookean_lambda': smith.neo_hookean_lambda,
        'strain_rate_damping': body.damping,
        'stiffness_damping': body.stiffness_damping,
        'gradient_damping': gradient_damping(body),
    }


def gradient_damping(body: ExportedBody) -> FloatArray:
    """Return what damps the slowest swing by the rate of its gradient [Pa s], shape (T,)."""
    factor = body.stiffness_damping
    if not factor.any():
        return np.zeros_like(factor)
    mode, volumes = first_mode(body), body.mesh.volumes
    squares = (mode.strains**2).sum(axis=(1, 2))
    elastic = volumes * (2.0 * body.lame_mu * squares + body.lame_lambda * mode.dilations**2)
    rates = volumes * ((mode.gradients**2).sum(axis=(1, 2)) + mode.dilations**2)
    return factor * float(factor @ elastic) / float(factor @ rates)
