# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""VTK: an unstructured grid with every number of the body, for ParaView and as a neutral form."""

from pathlib import Path

from diffcal_ros.atomic_file import replacing
from diffcal_ros.export.exported_body import ExportedBody
import numpy as np

SIMULATOR = ''


def write(body: ExportedBody, folder: Path) -> list[Path]:
    """Write `body.vtu`."""
    import meshio

    held = np.zeros(body.mesh.vertex_count, dtype=np.int32)
    held[body.held] = 1
    moved = np.zeros_like(body.mesh.rest_positions)
    moved[body.held] = body.held_positions - body.mesh.rest_positions[body.held]
    columns = {
        'youngs_modulus': body.youngs_modulus,
        'poissons_ratio': body.poissons_ratio,
        'density': body.density,
        'strain_rate_damping': body.damping,
        'region': body.region,
    }
    content = meshio.Mesh(
        body.mesh.rest_positions,
        [('tetra', body.mesh.tets)],
        point_data={'held': held, 'held_displacement': moved},
        cell_data={name: [column] for name, column in columns.items()},
    )
    path = folder / 'body.vtu'
    with replacing(path) as fresh:
        meshio.vtu.write(str(fresh), content)
    return [path]
