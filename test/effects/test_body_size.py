# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Usual sizes and bounds of effects go by the body that they are on."""

from dataclasses import replace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.form_parameters import form_parameters
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.diagnosis.screening.candidates import candidates
from diffcal_ros.effects.body_size import BodySize, USUAL_BODY
from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.rigid_transform import rotation_matrix
from diffcal_ros.scene.size_of_body import size_of_body
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
import pytest
from support.scenes import beam_scene, DENSITY, MODULUS, observation, SIZE, true_depth

SMALLER = 0.3
AMOUNTS = (
    ('added_mass', 'mass'),
    ('added_mass', 'mass_3'),
    ('compliant_clamp', 'compliance'),
    ('compliant_clamp', 'compliance_b'),
    ('compliant_clamp', 'shift_compliance'),
    ('rest_curvature', 'a'),
    ('rest_curvature', 'b_2'),
)


def _scene(times=1.0):
    """Return a beam so many times as large, whose modulus lets it sag to the same shape."""
    scene = beam_scene(modulus=times * MODULUS)
    mesh = scene.mesh
    return replace(scene, mesh=TetMesh(times * mesh.rest_positions, mesh.tets))


def _moved(times, effect, name):
    """Return by how much a fifth of a usual size moves nodes, in lengths of the body, (N, 3)."""
    scene = _scene(times)
    part = EFFECTS[effect].component(name).of(size_of_body(scene))
    own = {'mass': 0.0} if effect == 'added_mass' else {}
    found = []
    for amount in (0.0, 0.2 * part.scale):
        changed = replace(scene, effects={effect: {**own, name: amount, 'at': 0.7}})
        parameters = make_parameters(changed, with_edge_bias=False)
        model = ForwardModel(changed, [observation(true_depth())], parameters)
        found.append(model.worlds(parameters.start())[0])
    return (found[1] - found[0]) / (times * SIZE[0])


@pytest.mark.parametrize(('effect', 'name'), AMOUNTS)
def test_a_usual_size_does_the_same_to_a_body_of_another_size(effect, name):
    large, small = (_moved(times, effect, name) for times in (1.0, SMALLER))
    assert np.abs(large).max() > 1e-3
    np.testing.assert_allclose(small, large, atol=2e-3 * np.abs(large).max())


def test_a_body_is_as_heavy_as_its_regions_and_as_long_as_it_is_in_any_frame():
    scene = beam_scene(region_count=2)
    first, second = scene.regions
    heavier = replace(second, density=replace(second.density, start=3.0 * DENSITY))
    turn = rotation_matrix(np.array([0.3, -1.1, 0.7]))
    mesh = TetMesh(scene.mesh.rest_positions @ turn.T + 2.0, scene.mesh.tets)
    size = size_of_body(replace(scene, mesh=mesh, regions=(first, heavier)))
    assert size.mass == pytest.approx(2.0 * DENSITY * np.prod(SIZE))
    assert size.length == pytest.approx(max(SIZE), rel=0.02)


def test_what_is_fitted_has_the_size_and_bounds_of_its_body():
    scene = _scene(SMALLER)
    body = size_of_body(scene)
    listed = [own for own in candidates(scene) if own.identifier == 'compliant_clamp']
    (turning,) = (own for own in listed if own.components == ('compliance',))
    usual = EFFECTS['compliant_clamp'].component('compliance')
    times = (USUAL_BODY.mass * USUAL_BODY.length) / (body.mass * body.length)
    assert times > 10.0
    assert turning.scales == pytest.approx([times * usual.scale])
    (fitted,) = make_parameters(scene, ('compliant_clamp.compliance',), with_edge_bias=False)
    assert fitted.quantity.prior_std == pytest.approx(times * usual.scale)
    assert fitted.quantity.upper == pytest.approx(times * usual.upper)
    free = form_parameters(EFFECTS['rest_curvature'], 0.5, body)[0]
    assert free.quantity.prior_std == pytest.approx(0.5 * free.part.scale)
    assert free.part.scale > 2.0 * EFFECTS['rest_curvature'].component(free.amplitude).scale


def test_what_a_scene_states_is_within_the_bounds_of_its_fit():
    scene = _scene(SMALLER)
    most = EFFECTS['added_mass'].component('mass').of(size_of_body(scene)).upper
    hung = replace(scene, effects={'added_mass': {'mass': 3.0 * most, 'at': 1.0}})
    (fitted,) = make_parameters(hung, ('added_mass.mass',), with_edge_bias=False)
    assert fitted.quantity.start == 3.0 * most < fitted.quantity.upper


def test_what_does_not_go_by_the_body_stays():
    light = BodySize(1e-3 * USUAL_BODY.mass, 0.1 * USUAL_BODY.length)
    for name in ('gravity_tilt', 'camera_offset', 'depth_affine', 'stiffness_contrast'):
        for part in EFFECTS[name].parts:
            assert part.of(light) == part
            assert part.stated_limits == (part.lower, part.upper)
