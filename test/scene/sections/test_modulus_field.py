# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A modulus that varies over the body, stated by a scene, and what is refused in its file."""

from dataclasses import replace

from diffcal_ros.calibration.forward.body_inputs import BodyInputs
from diffcal_ros.calibration.forward.effect_model import EffectModel
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.errors import SceneError
from diffcal_ros.report.tables.scene_table import scene_rows
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.refinement import refined_scene
from diffcal_ros.scene.save import save_fitted_scene
from diffcal_ros.scene.sections.modulus_field import write_modulus_field
from diffcal_ros.scene.start_material import start_material
from diffcal_ros.tet_mesh import TetMesh
import meshio
import numpy as np
import pytest

FIELD = {'modulus_field': {'file': 'field.vtu'}}
TWO_REGIONS = {
    'regions.body.box': {'x': [-float('inf'), 0.0]},
    'regions.rest_of_it': {
        'rest': True,
        'youngs_modulus': 2e5,
        'poissons_ratio': 0.49,
        'density': 1080,
    },
}


@pytest.fixture
def varied(write_scene, tmp_path, random):
    """A scene of two regions with a field, and the field."""
    mesh = load_scene(write_scene()).mesh
    relative = np.exp(random.normal(scale=0.5, size=mesh.tet_count))
    write_modulus_field(tmp_path / 'field.vtu', mesh, relative)
    return load_scene(write_scene({**FIELD, **TWO_REGIONS})), relative


def test_modulus_of_a_tetrahedron_is_its_share_of_its_regions(varied):
    scene, relative = varied
    np.testing.assert_array_equal(scene.relative_modulus, relative)
    of_region = np.where(scene.mesh.centroids[:, 0] < 0.0, 6e4, 2e5)
    np.testing.assert_array_equal(start_material(scene).youngs_modulus, of_region * relative)


def test_a_regions_modulus_scales_the_field_there(varied):
    scene, relative = varied
    parameters = make_parameters(scene, ('youngs_modulus.body',))
    inputs = BodyInputs(scene, parameters, EffectModel(scene, parameters))
    coordinates = parameters.start() + np.log(1.7)
    modulus = inputs.material(coordinates).youngs_modulus
    of_region = np.where(scene.mesh.centroids[:, 0] < 0.0, 1.7 * 6e4, 2e5)
    np.testing.assert_allclose(modulus, of_region * relative, rtol=1e-12)


def test_a_finer_mesh_has_the_same_field(varied):
    scene, relative = varied
    fine = refined_scene(scene)
    nearest = np.linalg.norm(
        fine.mesh.centroids[:, None] - scene.mesh.centroids[None], axis=2
    ).argmin(axis=1)
    # The middle one of eight has its parent's centroid nearest; so have most others.
    assert (fine.relative_modulus == relative[nearest]).mean() > 0.5
    coarse = float(scene.mesh.volumes @ relative)
    assert float(fine.mesh.volumes @ fine.relative_modulus) == pytest.approx(coarse, rel=1e-12)


def test_a_fitted_scene_has_its_own_copy(varied, tmp_path):
    scene, relative = varied
    fitted = tmp_path / 'out' / 'fitted_scene.yaml'
    save_fitted_scene(scene, fitted, {'youngs_modulus.body': 7e4})
    again = load_scene(fitted)
    assert again.file_of('modulus_field') == tmp_path / 'out' / 'field.vtu'
    np.testing.assert_array_equal(again.relative_modulus, relative)
    assert again.regions[0].youngs_modulus.start == 7e4


def test_a_cut_surface_is_kept_as_it_was_cut(varied, tmp_path):
    scene, relative = varied
    # As it is where the mesh was a surface: another cut would have other tetrahedra.
    document = {**scene.document, 'mesh': {'file': 'b.stl', 'unit': 'mm', 'edge_length': 0.01}}
    save_fitted_scene(replace(scene, document=document), tmp_path / 'fitted.yaml', {})
    again = load_scene(tmp_path / 'fitted.yaml')
    assert again.document['mesh'] == {'file': 'field.vtu', 'unit': 'm'}
    np.testing.assert_array_equal(again.mesh.tets, scene.mesh.tets)
    np.testing.assert_array_equal(again.mesh.rest_positions, scene.mesh.rest_positions)
    np.testing.assert_array_equal(again.relative_modulus, relative)


def test_the_table_tells_of_it(varied):
    texts = dict(scene_rows(varied[0]))
    assert "times its region's" in texts['field']


@pytest.mark.parametrize(
    ('value', 'words'),
    [(0.0, 'is 0 in tetrahedron 7'), (-2.0, 'is -2 in'), (np.nan, 'is nan'), (np.inf, 'is inf')],
)
def test_values_must_be_positive_and_finite(varied, tmp_path, value, words):
    scene, relative = varied
    wrong = relative.copy()
    wrong[7] = value
    write_modulus_field(tmp_path / 'field.vtu', scene.mesh, wrong)
    with pytest.raises(SceneError, match=f'{words}.*must be positive and finite everywhere'):
        load_scene(scene.path)


def other_count(mesh: TetMesh) -> TetMesh:
    return TetMesh(mesh.rest_positions, mesh.tets[:-2])


def other_corners(mesh: TetMesh) -> TetMesh:
    return TetMesh(mesh.rest_positions, mesh.tets[::-1].copy())


def other_unit(mesh: TetMesh) -> TetMesh:
    return TetMesh(1e3 * mesh.rest_positions, mesh.tets)


@pytest.mark.parametrize(
    ('other', 'words'),
    [
        (other_count, 'has 190 tetrahedra and the mesh 192: it belongs to another mesh'),
        (other_corners, 'tetrahedra have other corners than those of the mesh'),
        (other_unit, 'vertices are up to 9.99e.04 mm from those of the mesh'),
    ],
)
def test_a_field_of_another_mesh_is_refused(varied, tmp_path, other, words):
    scene, relative = varied
    mesh = other(scene.mesh)
    write_modulus_field(tmp_path / 'field.vtu', mesh, relative[: mesh.tet_count])
    with pytest.raises(SceneError, match=f'modulus_field.file is .*{words}'):
        load_scene(scene.path)


@pytest.mark.parametrize(
    ('section', 'words'),
    [
        ({'file': 'none.vtu'}, r'there is no file .*none\.vtu: keep it beside the scene'),
        ({'file': 'beam.tet'}, 'a field is a .vtu file'),
        ({'file': 'broken.vtu'}, 'broken.vtu cannot be read as .vtu'),
        ({'file': 'plain.vtu'}, 'has no cell data `relative_modulus`'),
        ({'file': 'wide.vtu'}, r'has shape \(192, 3\): one number a tetrahedron is needed, 192'),
        ({}, 'name the file of the field, such as field.vtu'),
        ({'file': 'field.vtu', 'unit': 'mm'}, 'modulus_field.unit is no key that is known here'),
        ('field.vtu', 'a mapping is needed here'),
    ],
)
def test_what_is_no_field_is_refused(varied, write_scene, tmp_path, section, words):
    mesh = varied[0].mesh
    (tmp_path / 'broken.vtu').write_text('<VTKFile')
    plain = meshio.Mesh(mesh.rest_positions, [('tetra', mesh.tets)])
    meshio.vtu.write(str(tmp_path / 'plain.vtu'), plain)
    write_modulus_field(tmp_path / 'wide.vtu', mesh, np.ones((mesh.tet_count, 3)))
    with pytest.raises(SceneError, match=words):
        load_scene(write_scene({'modulus_field': section}))


def test_a_broken_mesh_is_told_alone(varied, write_scene):
    with pytest.raises(SceneError) as caught:
        load_scene(write_scene({**FIELD, 'mesh.file': 'none.tet'}))
    assert 'modulus_field' not in str(caught.value)
