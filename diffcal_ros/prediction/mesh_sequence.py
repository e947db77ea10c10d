# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The deformed mesh of every frame: VTK for ParaView, or the surface as OBJ."""

from pathlib import Path

from diffcal_ros.atomic_file import replacing, write_text_atomically
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.prediction.predicted_body import PredictedBody
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

MESH_FORMATS = ('vtu', 'obj', 'none')
COLLECTION = 'body.pvd'
_CELLS = {Element.LINEAR: 'tetra', Element.QUADRATIC: 'tetra10'}
_COLLECTION = """\
<?xml version="1.0"?>
<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">
  <Collection>
{rows}
  </Collection>
</VTKFile>
"""


def write_meshes(body: PredictedBody, folder: Path, kind: str) -> Path | None:
    """Write one file a frame; positions are in the world frame [m].

    Args:
        body: what is written.
        folder: it goes to.
        kind: one of `MESH_FORMATS`.

    Returns:
        What to open: the collection that gives the frames their times, or the folder.

    Raises:
        InputError: when the folder cannot be written.
    """
    if kind == 'none':
        return None
    names = [f'{number:04d}.{kind}' for number in range(len(body.times))]
    for name, positions in zip(names, body.positions, strict=True):
        if kind == 'obj':
            write_text_atomically(folder / name, _surface(body, positions))
        else:
            _write_volume(body, positions, folder / name)
    if kind == 'obj':
        return folder
    rows = [
        f'    <DataSet timestep="{time:.9g}" part="0" file="{name}"/>'
        for time, name in zip(body.times.tolist(), names, strict=True)
    ]
    write_text_atomically(folder / COLLECTION, _COLLECTION.format(rows='\n'.join(rows)))
    return folder / COLLECTION


def _write_volume(body: PredictedBody, positions: FloatArray, path: Path) -> None:
    import meshio

    shape = body.discretisation
    mesh = meshio.Mesh(
        positions,
        [(_CELLS[shape.element], shape.nodes)],
        point_data={'displacement': positions - shape.rest_nodes},
    )
    with replacing(path) as fresh:
        mesh.write(str(fresh))


def _surface(body: PredictedBody, positions: FloatArray) -> str:
    """Write the surface as Wavefront OBJ, which counts from one."""
    used, triangles = np.unique(body.discretisation.surface_triangles, return_inverse=True)
    lines = [f'v {x:.9g} {y:.9g} {z:.9g}' for x, y, z in positions[used].tolist()]
    faces = triangles.reshape(-1, 3) + 1
    lines += [f'f {a} {b} {c}' for a, b, c in faces.tolist()]
    return '\n'.join(lines) + '\n'
