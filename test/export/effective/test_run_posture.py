# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A simulator in the place of the package's own body: positions and derivatives by differences."""

from dataclasses import replace

from diffcal_ros.calibration.forward.posture import PostureInputs, RestingPosture
from diffcal_ros.export.effective.run_posture import RunPosture
from diffcal_ros.export.exported_body import exported_body
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.laws import find_law
from diffcal_ros.fem.statics.equilibrium import EquilibriumError
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.fem.terms.conditions import NO_CONDITIONS
from diffcal_ros.material import Material
import numpy as np
import pytest
from support.scenes import beam_scene, GRAVITY

from .conftest import settle_linear

LAW = 'st_venant_kirchhoff'
# Of a derivative, at the smallest of three steps.
CLOSE = 1e-3


@pytest.fixture
def scene():
    return beam_scene(element=Element.LINEAR, region_count=2)


def inputs(scene, law):
    ones = np.ones(scene.mesh.tet_count)
    material = Material(60e3 * ones, 0.45 * ones, 1080 * ones, conversion=find_law(law).CONVERSION)
    return PostureInputs(material, GRAVITY, NO_CONDITIONS, damping=0.0 * ones, release_time=0.0)


def own_posture(scene):
    return RestingPosture(scene, scene.observations[0], 'auto', 'cpu')


def test_derivatives_by_differences_approach_those_of_the_same_law(scene):
    """The simulator is this package under another law: tangents of that law are exact."""
    body = exported_body(scene, scene.observations[0])
    first = np.where(np.arange(scene.mesh.tet_count) < 60, 60e3, 0.0)
    changes = [Change(youngs_modulus=first), Change(youngs_modulus=60e3 - first)]
    exact = own_posture(replace(scene, law=LAW))
    there = exact.solve(inputs(scene, LAW))
    wanted = exact.tangents(there, changes)
    errors = []
    for difference in (0.08, 0.04, 0.02):
        posture = RunPosture(
            own_posture(scene),
            body,
            lambda body, start: settle_linear(body, LAW),
            difference=difference,
        )
        states = posture.solve(inputs(scene, scene.law))
        np.testing.assert_allclose(states.positions, there.positions, atol=1e-9)
        found = posture.tangents(states, changes)
        assert found.shape == wanted.shape
        errors.append(np.abs(found - wanted).max() / np.abs(wanted).max())
    slopes = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(slopes, 2.0, atol=0.1)
    assert errors[-1] < CLOSE


def test_it_begins_where_the_own_elements_are_or_else_where_it_was(scene):
    starts = []

    def run(body, start):
        starts.append(start.copy())
        return start + 1e-3

    own = own_posture(scene)
    posture = RunPosture(own, exported_body(scene, scene.observations[0]), run)
    posture.solve(inputs(scene, scene.law))
    np.testing.assert_array_equal(starts[0], own.body.state.positions)

    class Lost:
        body = own.body

        def solve(self, inputs, warm=None, prediction=None):
            raise EquilibriumError('no equilibrium')

    lost = RunPosture(Lost(), exported_body(scene, scene.observations[0]), run)
    lost.solve(inputs(scene, scene.law))
    lost.solve(inputs(scene, scene.law))
    rest = exported_body(scene, scene.observations[0]).mesh.rest_positions
    np.testing.assert_array_equal(starts[1], rest)
    np.testing.assert_array_equal(starts[2], rest + 1e-3)


def test_what_a_run_cannot_tell_is_refused(scene):
    posture = RunPosture(
        own_posture(scene),
        exported_body(scene, scene.observations[0]),
        lambda body, start: start,
    )
    states = posture.solve(inputs(scene, scene.law))
    with pytest.raises(NotImplementedError, match='follows the material alone'):
        posture.tangents(states, [Change(gravity=np.ones(3))])
    with pytest.raises(NotImplementedError, match='gives no gradient'):
        posture.gradient(states, np.zeros((1, scene.mesh.vertex_count, 3)))
    assert not posture.mesh_moves(states, 'auto').any()


def test_mujoco_comes_to_the_same_rest_from_two_places(scene):
    pytest.importorskip('mujoco', reason='mujoco is not installed')
    from diffcal_ros.export.effective.mujoco_run import come_to_rest

    body = exported_body(scene, scene.observations[0])
    ours = settle_linear(body, LAW)
    for start in (body.mesh.rest_positions, settle_linear(body, scene.law)):
        np.testing.assert_allclose(come_to_rest(body, start), ours, atol=1e-5)


def test_newton_comes_to_the_same_rest_from_two_places(scene):
    """Its law is the neo-Hookean one: two independent simulators of the same elements."""
    pytest.importorskip('newton', reason='newton is not installed')
    from diffcal_ros.export.effective.newton_run import come_to_rest

    body = exported_body(scene, scene.observations[0])
    ours = settle_linear(body, 'stable_neo_hookean')
    for start in (body.mesh.rest_positions, settle_linear(body, LAW)):
        np.testing.assert_allclose(come_to_rest(body, start), ours, atol=1e-5)


def test_newton_that_never_rests_is_told(scene, monkeypatch):
    pytest.importorskip('newton', reason='newton is not installed')
    from diffcal_ros.export.effective import newton_run

    monkeypatch.setattr(newton_run, '_MOST_STEPS', 50)
    body = exported_body(scene, scene.observations[0])
    with pytest.raises(EquilibriumError, match='Newton did not come to rest within 50 steps'):
        newton_run.come_to_rest(body, body.mesh.rest_positions)


def test_mujoco_that_never_rests_is_told(scene, monkeypatch):
    pytest.importorskip('mujoco', reason='mujoco is not installed')
    from diffcal_ros.export.effective import mujoco_run

    monkeypatch.setattr(mujoco_run, '_LONGEST', 0.05)
    body = exported_body(scene, scene.observations[0])
    with pytest.raises(EquilibriumError, match=r'MuJoCo did not come to rest within 0\.05 s'):
        mujoco_run.come_to_rest(body, body.mesh.rest_positions)
