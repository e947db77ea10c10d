# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Assets are read back by the packages that they are for: mass, volume, clamp and material."""

from dataclasses import replace
import importlib.util
import json
from pathlib import Path
import runpy
import shutil

from diffcal_ros.cli.commands.export import TARGETS
from diffcal_ros.export import players
from diffcal_ros.export.targets import find_target, target_names
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.laws import find_law
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.material import Material
import meshio
import numpy as np
import pytest

from .conftest import SAME

# A held vertex is where it was [m], in the single precision of USD.
PLACE = 1e-6
# MuJoCo and this package, both at rest under the same law on the same mesh [m].
AT_REST = 1e-6


def volume(points, tets):
    corners = points[tets]
    return np.linalg.det(corners[:, 1:] - corners[:, :1]).sum() / 6.0


def settled(body, law, element):
    """Return where this package's elements come to rest [m], shape (V, 3)."""
    own = find_law(law)
    simulated = StaticBody(body.mesh, element, body.held, law=own)
    material = Material(
        body.youngs_modulus, body.poissons_ratio, body.density, conversion=own.CONVERSION
    )
    simulated.solve_equilibrium(material, body.gravity)
    return simulated.state.positions[: body.mesh.vertex_count]


def player(name):
    """Load a player as a user's Python does: alone."""
    file = Path(players.__file__).with_name(f'play_{name}.py')
    spec = importlib.util.spec_from_file_location(f'play_{name}', file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_command_lists_the_targets_and_each_has_a_player():
    assert target_names() == TARGETS
    for name in TARGETS:
        assert Path(players.__file__).with_name(f'play_{name}.py').is_file()
    with pytest.raises(ValueError, match=r"target is 'unity': use one of abaqus, mjcf"):
        find_target('unity')


def test_vtk_holds_everything(body, tmp_path):
    (path,) = find_target('vtk').write(body, tmp_path)
    content = meshio.read(path)
    tets = content.cells_dict['tetra']
    assert volume(content.points, tets) == pytest.approx(body.volume, rel=SAME)
    cells = {name: columns['tetra'] for name, columns in content.cell_data_dict.items()}
    np.testing.assert_allclose(cells['youngs_modulus'], body.youngs_modulus)
    np.testing.assert_allclose(cells['strain_rate_damping'], body.damping)
    assert np.array_equal(np.flatnonzero(content.point_data['held']), body.held)
    assert player('vtk').read(path) == pytest.approx((body.volume, body.mass, len(body.held)))


@pytest.mark.parametrize('element', list(Element))
def test_abaqus_files_are_read_by_meshio(body, tmp_path, element):
    body = replace(body, element=element)
    (path,) = find_target('abaqus').write(body, tmp_path)
    content = meshio.abaqus.read(path)
    (block,) = content.cells
    assert block.type == ('tetra' if element is Element.LINEAR else 'tetra10')
    assert volume(content.points, block.data[:, :4]) == pytest.approx(body.volume, rel=SAME)
    held = content.point_sets['HELD']
    assert np.array_equal(held[: len(body.held)], body.held)
    # Mid-edge nodes between held ones, and no others, are held as well.
    middle = held[len(body.held) :]
    x_of_clamp = body.mesh.rest_positions[body.held][:, 0].min() - PLACE
    assert (content.points[middle][:, 0] >= x_of_clamp).all()
    assert (len(middle) > 0) == (element is Element.QUADRATIC)
    sets = [content.cell_sets[f'G{number}'][0] for number in range(2)]
    assert [len(own) for own in sets] == [int((body.region == k).sum()) for k in range(2)]
    text = path.read_text()
    assert '*DENSITY\n900\n' in text
    assert '*DENSITY\n1200\n' in text


@pytest.mark.parametrize(
    ('law', 'card', 'twice'),
    [
        ('stable_neo_hookean', '*HYPERELASTIC, NEO HOOKE', 1),
        ('mooney_rivlin', '*HYPERELASTIC, MOONEY-RIVLIN', 2),
    ],
)
def test_hyperelastic_numbers_have_the_moduli_at_rest(body, tmp_path, law, card, twice):
    (path,) = find_target('abaqus').write(replace(body, law=law), tmp_path)
    lines = path.read_text().splitlines()
    *shears, compressibility = map(float, lines[lines.index(card) + 1].split(','))
    assert len(shears) == twice
    mu, bulk = 2.0 * sum(shears), 2.0 / compressibility
    modulus = 9.0 * bulk * mu / (3.0 * bulk + mu)
    assert modulus == pytest.approx(60e3, rel=1e-6)
    assert (3.0 * bulk - 2.0 * mu) / (2.0 * (3.0 * bulk + mu)) == pytest.approx(0.4, rel=1e-6)


@pytest.mark.skipif(shutil.which('ccx') is None, reason='CalculiX (ccx) is not installed')
def test_calculix_sags_as_this_package_does(body, tmp_path):
    """Its C3D10 is our quadratic element; the two neo-Hookean laws differ beyond small strains."""
    body = replace(body, element=Element.QUADRATIC)
    find_target('abaqus').write(body, tmp_path)
    largest = player('abaqus').run(tmp_path)
    moved = settled(body, body.law, Element.QUADRATIC) - body.mesh.rest_positions
    assert largest == pytest.approx(np.linalg.norm(moved, axis=1).max(), rel=0.01)


def test_the_largest_displacement_is_read_from_the_last_step():
    text = (
        ' displacements (vx,vy,vz) for set ALL and time  0.5\n\n'
        '  1  9.0E-03  0.0E+00  0.0E+00\n'
        ' displacements (vx,vy,vz) for set ALL and time  1.0\n\n'
        '  1  1.0E-03 -2.0E-03  2.0E-03\n  2  0.0E+00  1.0E-03  0.0E+00\n'
    )
    assert player('abaqus').largest_displacement(text) == pytest.approx(3e-3)


def test_sofa_s_numbers(body, tmp_path):
    (path,) = find_target('sofa').write(body, tmp_path)
    document = json.loads(path.read_text())
    assert document['held'] == body.held.tolist()
    assert sum(document['vertex_masses']) == pytest.approx(body.mass, rel=SAME)
    assert not document['is_uniform']
    modulus = document['youngs_modulus'] * np.array(document['stiffness_factors'])
    np.testing.assert_allclose(modulus, body.youngs_modulus)


class Recorder:
    """Stands in for SOFA's node: SOFA itself is not on PyPI. It notes what is added."""

    def __init__(self):
        self.added = {}

    def addObject(self, kind, **numbers):
        self.added[kind] = numbers

    def addChild(self, name):
        child = self.added[name] = Recorder()
        return child


@pytest.mark.parametrize('is_uniform', [True, False])
def test_sofa_s_scene_asks_for_the_body(body, tmp_path, is_uniform):
    if is_uniform:
        ones = np.ones(body.mesh.tet_count)
        body = replace(
            body,
            youngs_modulus=8e4 * ones,
            region=np.zeros_like(body.region),
            region_names=('all',),
        )
    find_target('sofa').write(body, tmp_path)
    source = Path(players.__file__).with_name('play_sofa.py')
    shutil.copy(source, tmp_path)
    root = Recorder()
    runpy.run_path(str(tmp_path / 'play_sofa.py'))['createScene'](root)
    node = root.added['body'].added
    assert np.array_equal(node['FixedProjectiveConstraint']['indices'], body.held)
    mu, lam = body.lame_mu.mean(), body.lame_lambda.mean()
    uniform = {'materialName': 'StVenantKirchhoff', 'ParameterSet': pytest.approx([mu, lam])}
    name = 'TetrahedronHyperelasticityFEMForceField'
    assert node.get(name) == (uniform if is_uniform else None)
    assert ('TetrahedronFEMForceField' in node) != is_uniform


def test_newton_s_arrays_hold_both_conventions(body, tmp_path):
    (path,) = find_target('newton').write(body, tmp_path)
    content = np.load(path)
    assert content['vertex_masses'].sum() == pytest.approx(body.mass, rel=SAME)
    np.testing.assert_allclose(content['neo_hookean_mu'], 4.0 / 3.0 * content['lame_mu'])
    np.testing.assert_allclose(
        content['neo_hookean_lambda'],
        content['lame_lambda'] + 5.0 / 6.0 * content['lame_mu'],
    )


def test_newton_builds_the_body(body, tmp_path):
    pytest.importorskip('newton', reason='newton is not installed')
    (path,) = find_target('newton').write(body, tmp_path)
    content = player('newton').load(path)
    # Lame's parameters are what `SolverVBD` takes.
    model = player('newton').build(content, 'vbd').finalize()
    assert (model.particle_count, model.tet_count) == (body.mesh.vertex_count, body.mesh.tet_count)
    masses = model.particle_mass.numpy()
    held = np.zeros(len(masses), dtype=bool)
    held[body.held] = True
    np.testing.assert_allclose(masses[~held], body.vertex_masses[~held], rtol=SAME)
    assert np.array_equal(masses == 0.0, held)
    np.testing.assert_allclose(model.tet_materials.numpy()[:, 0], body.lame_mu, rtol=SAME)
    np.testing.assert_allclose(model.gravity.numpy().reshape(-1), body.gravity, rtol=SAME)
    # In so short a time it falls, but for what is held.
    moved = player('newton').play_vbd(path, 0.02, 5)
    assert not moved[body.held].any()
    fallen = moved @ body.gravity / np.linalg.norm(body.gravity)
    assert 1e-3 < fallen.max() < 4e-3


def test_usd_is_read_by_pxr(body, tmp_path):
    pytest.importorskip('pxr', reason='usd-core is not installed')
    from pxr import Usd, UsdGeom, UsdShade

    (path,) = find_target('usd').write(body, tmp_path)
    points, tets, held, numbers = player('usd').read(path)
    assert volume(points, tets) == pytest.approx(body.volume, rel=SAME)
    assert volume(points, tets) * numbers['density'] == pytest.approx(body.mass, rel=SAME)
    assert np.array_equal(held, body.held)
    assert np.abs(points[held] - body.mesh.rest_positions[body.held]).max() < PLACE
    stage = Usd.Stage.Open(str(path))
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    mesh = stage.GetPrimAtPath('/World/deformable/mesh')
    assert not UsdGeom.TetMesh.FindInvertedElements(UsdGeom.TetMesh(mesh))
    mass = 0.0
    for name, modulus in (('tip', 60e3), ('root', 150e3)):
        subset = mesh.GetChild(name)
        bound, _ = UsdShade.MaterialBindingAPI(subset).ComputeBoundMaterial('physics')
        own = bound.GetPrim()
        assert own.GetAttribute('physics:youngsModulus').Get() == pytest.approx(modulus)
        indices = UsdGeom.Subset(subset).GetIndicesAttr().Get()
        mass += volume(points, tets[indices]) * own.GetAttribute('physics:density').Get()
    assert mass == pytest.approx(body.mass, rel=SAME)


def test_mujoco_has_mass_clamp_and_material(body, tmp_path):
    mujoco = pytest.importorskip('mujoco', reason='mujoco is not installed')
    (path,) = find_target('mjcf').write(body, tmp_path)
    model = mujoco.MjModel.from_xml_path(str(path))
    assert model.body_mass.sum() == pytest.approx(body.mass, rel=SAME)
    assert model.nflex == 2
    # A vertex that is held has no joint.
    free = [model.body(f'v{number}').dofnum[0] == 3 for number in range(body.mesh.vertex_count)]
    assert np.array_equal(np.flatnonzero(np.logical_not(free)), body.held)
    np.testing.assert_allclose(model.opt.gravity, body.gravity)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    total = sum(
        volume(data.flexvert_xpos[model.flex_vertadr[f] :], _flex_tets(model, f)) for f in range(2)
    )
    # MuJoCo turns every tetrahedron round as it reads it.
    assert -total == pytest.approx(body.volume, rel=SAME)


def _flex_tets(model, flex):
    start = model.flex_elemdataadr[flex]
    return model.flex_elem[start : start + 4 * model.flex_elemnum[flex]].reshape(-1, 4)


def test_mujoco_comes_to_rest_where_our_linear_elements_do(body, tmp_path):
    """Two independent simulators of the same law, in two flexes that share vertices."""
    pytest.importorskip('mujoco', reason='mujoco is not installed')
    # Damped enough to be at rest soon, which changes nothing about where that is.
    slow = replace(body, damping=0.02 * body.youngs_modulus)
    (path,) = find_target('mjcf').write(slow, tmp_path)
    moved = player('mjcf').play(path, 3.0)
    ours = settled(body, 'st_venant_kirchhoff', Element.LINEAR) - body.mesh.rest_positions
    assert np.linalg.norm(ours, axis=1).max() > 5e-3
    assert np.abs(moved - ours).max() < AT_REST
