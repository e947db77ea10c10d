# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""SOFA: the body as JSON; the scene beside it, `play_sofa.py`, is loaded by `runSofa`.

One material becomes a St. Venant-Kirchhoff body of linear tetrahedra, several or a field the
corotational one with a stiffness factor for each tetrahedron, which agrees with it for small
strains.
"""

import json
from pathlib import Path

from diffcal_ros.atomic_file import write_text_atomically
from diffcal_ros.export.exported_body import ExportedBody
from diffcal_ros.export.material_groups import material_groups
import numpy as np

SIMULATOR = 'sofa'


def write(body: ExportedBody, folder: Path) -> list[Path]:
    """Write `body.json`."""
    largest = float(body.youngs_modulus.max())
    weights = body.mesh.volumes / body.volume
    document = {
        'name': body.name,
        'gravity': body.gravity.tolist(),
        'positions': body.mesh.rest_positions.tolist(),
        'tetrahedra': body.mesh.tets.tolist(),
        'held': body.held.tolist(),
        'vertex_masses': body.vertex_masses.tolist(),
        'is_uniform': len(material_groups(body)) == 1,
        'youngs_modulus': largest,
        'stiffness_factors': (body.youngs_modulus / largest).tolist(),
        'poissons_ratio': float(weights @ body.poissons_ratio),
        'lame_mu': float(np.mean(body.lame_mu)),
        'lame_lambda': float(np.mean(body.lame_lambda)),
        'stiffness_damping': float(weights @ body.stiffness_damping),
    }
    path = folder / 'body.json'
    write_text_atomically(path, json.dumps(document) + '\n')
    return [path]
