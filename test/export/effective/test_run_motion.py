# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A simulator in the place of a body that is let go: frames, and derivatives by differences."""

from dataclasses import replace

from diffcal_ros.calibration.forward.moving_posture import MovingPosture
from diffcal_ros.calibration.forward.posture import PostureInputs
from diffcal_ros.damping import Damping
from diffcal_ros.export.effective.run_motion import RunMotion
from diffcal_ros.export.exported_body import exported_body
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.laws import find_law
from diffcal_ros.fem.motion.inputs import MotionChange, Release
from diffcal_ros.fem.motion.moving_body import MovingBody
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.fem.terms.conditions import NO_CONDITIONS
from diffcal_ros.material import Material
import numpy as np
import pytest
from support.moving_beams import moving_scene, RELEASE_TIME
from support.scenes import GRAVITY

LAW = 'st_venant_kirchhoff'
TIMES = (0.0, 0.09, 0.15, 0.22)
LATE = 0.01
CLOSE = 2e-3  # Of a derivative, at the smallest of three steps.


@pytest.fixture(scope='module')
def scene():
    return replace(moving_scene(element=Element.LINEAR), law=LAW)


def inputs(scene, law=LAW):
    ones = np.ones(scene.mesh.tet_count)
    material = Material(80e3 * ones, 0.3 * ones, 1080 * ones, conversion=find_law(law).CONVERSION)
    return PostureInputs(
        material,
        GRAVITY,
        NO_CONDITIONS,
        damping=150.0 * ones,
        release_time=RELEASE_TIME,
        time_offset=LATE,
    )


def this_package(ledge):
    """Return this package's linear elements as a simulator that knows nothing of a support."""

    def swing(body, start, times):
        own = find_law(LAW)
        simulated = StaticBody(body.mesh, Element.LINEAR, body.held, law=own)
        material = Material(
            body.youngs_modulus, body.poissons_ratio, body.density, conversion=own.CONVERSION
        )
        moving = MovingBody(simulated, Release(ledge, 0.0, start[ledge]))
        return moving.simulate(material, Damping(body.damping), body.gravity, times).positions

    return swing


def run(scene, swing, difference=0.02, times=TIMES):
    setup = scene.observations[0]
    own = MovingPosture(scene, setup, times, 'auto', 'cpu')
    body = exported_body(scene, setup)
    return RunMotion(own, scene, setup, times, body, swing, difference=difference)


def test_derivatives_by_differences_approach_those_of_the_same_elements(scene):
    setup = scene.observations[0]
    exact = MovingPosture(scene, setup, TIMES, 'auto', 'cpu')
    there = exact.solve(inputs(scene))
    ones = np.ones(scene.mesh.tet_count)
    changes = [Change(youngs_modulus=80e3 * ones), MotionChange(damping=150.0 * ones)]
    wanted = exact.tangents(there, changes)
    ledge = setup.held[1].vertices
    errors = []
    for difference in (0.08, 0.04, 0.02):
        posture = run(scene, this_package(ledge), difference)
        states = posture.solve(inputs(scene, 'stable_neo_hookean'))
        np.testing.assert_allclose(states.positions, there.positions, atol=1e-8)
        found = posture.tangents(states, changes)
        assert found.shape == wanted.shape
        scale = np.abs(wanted).max(axis=(1, 2, 3))
        errors.append(np.abs(found - wanted).max(axis=(1, 2, 3)) / scale)
    slopes = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(slopes, 2.0, atol=0.2)
    assert max(errors[-1]) < CLOSE


def test_the_simulator_has_the_body_from_its_release_on(scene):
    asked = []

    def swing(body, start, times):
        asked.append(times.copy())
        assert not np.isin(scene.observations[0].held[1].vertices, body.held).any()
        return np.repeat(start[None] + 1e-3, len(times), axis=0)

    states = run(scene, swing).solve(inputs(scene))
    np.testing.assert_allclose(asked, [np.array(TIMES[1:]) - LATE - RELEASE_TIME])
    np.testing.assert_allclose(states.positions[1:] - states.positions[0], 1e-3)
    still = run(scene, swing, times=(0.0, 0.02)).solve(inputs(scene))
    assert len(asked) == 1
    np.testing.assert_array_equal(still.positions[0], still.positions[1])


def test_when_the_body_is_let_go_is_not_the_simulators_to_find(scene):
    posture = run(scene, lambda body, start, times: np.repeat(start[None], len(times), axis=0))
    states = posture.solve(inputs(scene))
    with pytest.raises(NotImplementedError, match='stays as the calibration found it'):
        posture.tangents(states, [MotionChange(release_time=1.0)])
    with pytest.raises(NotImplementedError, match='gives no gradient'):
        posture.gradient(states, np.zeros_like(states.positions))
    assert not posture.mesh_moves(states, 'auto').any()
