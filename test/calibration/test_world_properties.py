# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whatever the world's frame and however the mesh is numbered, the same modulus is fitted."""

from dataclasses import replace
from functools import cache

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.rigid_transform import rotation_matrix, transform
from diffcal_ros.scene.load import load_scene
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
import pytest
from support.far_worlds import moved_scene, moved_views
from support.recorded_beam import write_beam_scene
from support.scenes import beam_scene, observation, true_depth
import yaml

hypothesis = pytest.importorskip('hypothesis', reason='hypothesis is not installed')
given, settings = hypothesis.given, hypothesis.settings
st = pytest.importorskip('hypothesis.strategies')

# Of the modulus, relative: what is asked of a world a kilometre away.
_SAME = 1e-6
_COUNTS = (4, 2, 2)
_CAMERA = PinholeCamera(120, 90, 131.0, 137.0, 56.5, 48.25)
_SETTINGS = CalibrationSettings(with_mesh_error=False, max_iterations=5, search=False)
# The same examples every time: what is hunted for elsewhere is not for every machine to find.
_FEW = settings(max_examples=6, deadline=None, derandomize=True, database=None)
# Even orders of a tetrahedron's corners: it is not turned inside out.
_TURNED_CORNERS = ([0, 1, 2, 3], [1, 2, 0, 3], [3, 0, 2, 1], [2, 3, 0, 1])

shares = st.floats(-1.0, 1.0, allow_subnormal=False)
vectors = st.tuples(shares, shares, shares).map(np.array)


@cache
def _seen():
    depth = true_depth(75e3, counts=_COUNTS, camera=_CAMERA)
    return observation(np.where(np.isnan(depth), 0.9, depth), camera=_CAMERA)


def _scene():
    return beam_scene(_COUNTS, modulus=50e3, region_count=2, fit=('youngs_modulus.part_1',))


def _fitted(scene, seen) -> float:
    (parameter,) = (
        p
        for p in Calibration(scene, seen, _SETTINGS).run().parameters
        if p.name.startswith('youngs_modulus')
    )
    return parameter.value


@cache
def _expected() -> float:
    return _fitted(_scene(), [_seen()])


@_FEW
@given(towards=vectors, distance=st.floats(0.0, 1000.0), turn=vectors)
@pytest.mark.slow
def test_the_worlds_origin_and_axes_do_not_matter(towards, distance, turn) -> None:
    length = max(float(np.linalg.norm(towards)), 1e-3)
    move = transform(rotation_matrix(np.pi * turn), distance / length * towards)
    found = _fitted(moved_scene(_scene(), move), moved_views([_seen()], move))
    assert found == pytest.approx(_expected(), rel=_SAME)


@_FEW
@given(seed=st.integers(0, 2**32 - 1))
def test_the_numbers_of_vertices_and_tetrahedra_do_not_matter(seed) -> None:
    random = np.random.default_rng(seed)
    scene = _scene()
    mesh = scene.mesh
    vertices = random.permutation(mesh.vertex_count)
    new_of_vertex = np.argsort(vertices)
    order = random.permutation(mesh.tet_count)
    corners = np.array(_TURNED_CORNERS)[random.integers(len(_TURNED_CORNERS), size=len(order))]
    tets = np.take_along_axis(new_of_vertex[mesh.tets[order]], corners, axis=1)
    new_of_tet = np.argsort(order)
    (setup,) = scene.observations
    held = tuple(
        replace(part, vertices=new_of_vertex[part.vertices].astype(np.int32))
        for part in setup.held
    )
    regions = tuple(
        replace(region, tets=new_of_tet[region.tets].astype(np.int32)) for region in scene.regions
    )
    numbered = replace(
        scene,
        mesh=TetMesh(mesh.rest_positions[vertices], tets.astype(np.int32)),
        regions=regions,
        observations=(replace(setup, held=held),),
    )
    assert _fitted(numbered, [_seen()]) == pytest.approx(_expected(), rel=_SAME)


@pytest.mark.parametrize(('unit', 'per_metre'), [('m', 1.0), ('cm', 100.0)])
def test_the_unit_of_the_mesh_file_does_not_matter(tmp_path, unit, per_metre) -> None:
    near = write_beam_scene(tmp_path, {'marker': ..., 'mesh.element': 'linear'})
    expected = load_scene(near)
    document = yaml.safe_load(near.read_text())
    lines = (near.parent / 'beam.tet').read_text().splitlines()
    scaled = [_scaled(line, per_metre / 1000.0) for line in lines]
    (near.parent / 'other.tet').write_text('\n'.join(scaled) + '\n')
    document['mesh'].update(file='other.tet', unit=unit)
    other = near.with_name('other.yaml')
    other.write_text(yaml.safe_dump(document))
    found = load_scene(other)
    np.testing.assert_allclose(
        found.mesh.rest_positions, expected.mesh.rest_positions, rtol=1e-12, atol=1e-15
    )
    view = observation(np.full((_CAMERA.height, _CAMERA.width), 0.5), camera=_CAMERA)
    seen = [replace(view, depth_from_world=transform(np.eye(3), np.array([0.0, 0.05, 0.3])))]
    moduli = [_fitted(scene, seen) for scene in (expected, found)]
    assert moduli[1] == pytest.approx(moduli[0], rel=_SAME)


def _scaled(line: str, factor: float) -> str:
    kind, *numbers = line.split()
    if kind != 'v':
        return line
    return ' '.join([kind, *(repr(float(number) * factor) for number in numbers)])
