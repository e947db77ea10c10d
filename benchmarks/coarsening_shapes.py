# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Numerical coarsening on the spine and the dragon of the public data set.

What the clamp leaves free of the spine is cut off at a plane and meshed anew at four sizes: every
mesh is the same solid, held at the same face. The dragon is taken on the data set's own two
meshes, which differ in volume, and on each of them cut into eight (linear elements only): meshed
anew it touches itself along edges. The target is rendered from quadratic elements on the finest
mesh that is fitted with both elements.
"""

import argparse
from dataclasses import dataclass, replace
from functools import partial
import os
from pathlib import Path
from tempfile import TemporaryDirectory

from coarsening_fit import compare
from diffcal_ros.recording.dataset.import_case import import_case
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.model import HeldPart, Scene
from diffcal_ros.scene.refinement import refined_scene
from diffcal_ros.scene.sections.mesh_files import read_mesh
from diffcal_ros.synthetic.posed_body import PosedBody
from diffcal_ros.synthetic.viewpoint import COLOR_CAMERA, default_view, DEPTH_CAMERA
from diffcal_ros.tet_mesh import mesh_problems, TetMesh
from measuring import data_set, write
import numpy as np
from numpy.typing import NDArray
from pytetwild import tetrahedralize
import pyvista
import yaml

FloatArray = NDArray[np.float64]

LINEAR_START = 0.4


@dataclass(frozen=True)
class Shape:
    """A body of the data set.

    Attributes:
        case: experiment that says how it hangs.
        mesh: folder of its finest mesh.
        axis: of the object frame, along which the clamp ends.
        sign: 1 where the free part lies above the clamp's end, -1 below.
        edges: of the tetrahedra, the finest mesh first [m].
        modulus: true [Pa].
    """

    case: str
    mesh: str
    axis: int
    sign: float
    edges: tuple[float, ...]
    modulus: float


SPINE = Shape('h_e_s', 'spine', 1, -1.0, (0.0036, 0.0050, 0.0075, 0.0120), 400e3)
# The mesher keeps the surface within this share of the diagonal.
_STRAY = 1e-3
DRAGON_MODULUS = 95e3


def free_part(mesh: TetMesh, shape: Shape, end: float) -> pyvista.PolyData:
    """Return the surface of what the clamp leaves free, closed at the clamp's end.

    Args:
        mesh: of the whole body.
        shape: which side of the plane is free.
        end: of the clamp, along the shape's axis [m].
    """
    triangles = np.insert(mesh.surface_triangles, 0, 3, axis=1)
    surface = pyvista.PolyData(mesh.rest_positions, triangles.ravel()).clean()
    normal, origin = np.zeros(3), np.zeros(3)
    normal[shape.axis], origin[shape.axis] = shape.sign, end
    return surface.clip_closed_surface(normal=normal, origin=origin).triangulate().clean()


def scenes(shape: Shape, dataset: Path, folder: Path) -> list[Scene]:
    """Return the shape's scene on every mesh, the finest first."""
    scene = load_scene(import_case(dataset, shape.case, folder / 'case').scene)
    (box,) = [part['box'] for part in scene.document['held'].values()]
    low, high = box['xyz'[shape.axis]]
    end = float(low if shape.sign < 0.0 else high)
    finest = next((dataset / 'CAD_models' / shape.mesh).glob('*.tet'))
    surface = free_part(read_mesh(finest, unit='cm').mesh, shape, end)
    return [_on(surface, edge, scene, shape, end) for edge in shape.edges]


def _meshed(surface: pyvista.PolyData, edge: float) -> TetMesh:
    before = Path.cwd()
    # The mesher leaves a file in the current folder.
    with TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            positions, tets = tetrahedralize(
                np.asarray(surface.points, dtype=np.float64),
                surface.faces.reshape(-1, 4)[:, 1:].astype(np.int32),
                edge_length_abs=edge,
                epsilon=_STRAY,
                num_threads=1,
            )
        finally:
            os.chdir(before)
    # The mesher lists them the other way round.
    mesh = TetMesh(positions, np.ascontiguousarray(tets[:, [0, 1, 3, 2]], dtype=np.int32))
    faults = mesh_problems(mesh)
    if faults:
        raise SystemExit(f'the mesh of {1e3 * edge:g} mm is not sound: {"; ".join(faults)}')
    return mesh


def _on(surface: pyvista.PolyData, edge: float, scene: Scene, shape: Shape, end: float) -> Scene:
    mesh = _meshed(surface, edge)
    from_end = shape.sign * (mesh.rest_positions[:, shape.axis] - end)
    # A face that the mesher may move is as thick as it may stray, to either side.
    held = np.flatnonzero(from_end < 2.0 * _STRAY * surface.length).astype(np.int32)
    region = scene.regions[0]
    modulus = replace(region.youngs_modulus, start=shape.modulus)
    tets = np.arange(mesh.tet_count, dtype=np.int32)
    setup = replace(scene.observations[0], held=(HeldPart('clamp', held),))
    print(f'{mesh.tet_count} tetrahedra, {1e6 * mesh.volumes.sum():.2f} cm^3, {len(held)} held')
    return replace(
        scene,
        mesh=mesh,
        regions=(replace(region, tets=tets, youngs_modulus=modulus),),
        observations=(setup,),
        fit=('youngs_modulus',),
    )


def dragons(dataset: Path, folder: Path) -> list[Scene]:
    """Return the dragon on both meshes of the data set, the finer one first."""
    path = import_case(dataset, 'h_e_d', folder / 'dragon').scene
    document = yaml.safe_load(path.read_text())
    found = []
    for mesh in ('dragon_fine', 'dragon'):
        file = next((dataset / 'CAD_models' / mesh).glob('*.tet')).resolve()
        (region,) = document['regions'].values()
        region['youngs_modulus']['start'] = DRAGON_MODULUS
        own = {**document, 'mesh': {'file': str(file), 'unit': 'cm'}, 'fit': ['youngs_modulus']}
        path.with_name(f'{mesh}.yaml').write_text(yaml.safe_dump(own))
        found.append(load_scene(path.with_name(f'{mesh}.yaml')))
    return found


def look(scene: Scene, body: PosedBody) -> FloatArray:
    """Return a pose from which the camera sees the whole bent body."""
    gravity = scene.observations[0].gravity
    return default_view(body.positions, body.outward, gravity, None, DEPTH_CAMERA, COLOR_CAMERA)


def main() -> None:
    """Compare the meshes of each shape that is asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('shape', choices=('spine', 'dragon'))
    name, finer = parser.parse_args().shape, []
    with TemporaryDirectory() as folder:
        if name == 'spine':
            own = scenes(SPINE, data_set(), Path(folder))
        else:
            own = dragons(data_set(), Path(folder))
            finer = [refined_scene(scene) for scene in reversed(own)]
    figures = compare(
        own,
        DEPTH_CAMERA,
        partial(look, own[0]),
        linear_only=finer,
        linear_start=LINEAR_START,
    )
    write(f'coarsening_{name}', figures)


if __name__ == '__main__':
    main()
