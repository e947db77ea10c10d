# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The forward model of a motion: derivatives, what motion can show, shared tracers and poses."""

from diffcal_ros.calibration.forward import moving_posture
from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.observations.observation import pose_covariances, pose_owners
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.residuals.time_correlation import part_means, repeated_frames
from diffcal_ros.calibration.whole_image.image_objective import ImageObjective
from diffcal_ros.fem.motion.moving_body import INTEGRATOR_NAMES
from diffcal_ros.scene.sections.motion import INTEGRATORS
import numpy as np
import pytest
from support.moving_beams import (
    instants,
    moving_model,
    moving_scene,
    RELEASE_TIME,
    slope_errors,
    true_depths,
)

FIT = ('youngs_modulus', 'damping', 'density', 'release_time', 'rigid_offset')
# Before the release, at once after it, and through the first swing.
TIMES = (0.02, 0.06, 0.13, 0.2)
# Finite differences of positions that are found to 1e-9 m, at the best of three step sizes.
_SLOPE = 1e-5
# Beyond the second order: above all what the release sets ringing, a quarter just after it.
_FORESEEN = 0.3


@pytest.fixture(scope='module')
def model() -> ForwardModel:
    return moving_model(moving_scene((4, 1, 1), fit=FIT), TIMES)


def test_tangents_are_the_slopes_of_all_frames(model: ForwardModel) -> None:
    start = model.parameters.start()
    start[4:] = [0.002, -0.001, 0.003, 0.02, -0.01, 0.03]
    for place, name in enumerate(model.parameters.names):
        errors = slope_errors(model, start, place)
        # Between two steps positions are polynomials whose ends move with the release time.
        assert min(errors) < (1e-4 if name == 'release_time' else _SLOPE), name


def test_the_body_rests_until_the_release(model: ForwardModel) -> None:
    start = model.parameters.start()
    positions = model.at(start).states[0].positions
    moved = [np.abs(frame - positions[0]).max() for frame in positions]
    assert TIMES[0] < RELEASE_TIME < TIMES[1]
    assert moved[0] == 0.0
    assert 0.0 < moved[1] < moved[2] < moved[3]


def test_motion_under_gravity_shows_only_ratios_to_density(model: ForwardModel) -> None:
    # rho a = E f(x) + beta g(x, v) + rho g: a common factor of the three cancels.
    start = model.parameters.start()
    scaled = start.copy()
    scaled[:3] += np.log(1.7)
    first = np.stack([view.points for view in model.views(start)])
    second = np.stack([view.points for view in model.views(scaled)])
    np.testing.assert_allclose(second, first, atol=1e-8)


def test_frames_of_a_recording_share_a_tracer(model: ForwardModel) -> None:
    views = model.views(model.parameters.start())
    assert len(set(map(id, model.tracers))) == 1
    first, last = views[0].trace, views[3].trace
    assert not np.array_equal(last.full_depth(), first.full_depth(), equal_nan=True)
    assert views[0].trace is first


def test_the_adjoint_of_all_frames_agrees_with_their_tangents() -> None:
    scene = moving_scene((6, 2, 2), fit=FIT)
    depths = true_depths(moving_scene((6, 2, 2), modulus=70e3, damping=35.0), TIMES)
    parameters = make_parameters(scene, with_edge_bias=False)
    model = ForwardModel(scene, instants(TIMES, depths), parameters)
    objective = ImageObjective(model, 'paper')
    start = parameters.start()
    value, gradient = objective.gradient(start)
    linear = objective.linearise(start)
    # L = 1000 sqrt(S): dL = 1e6 / (2 L) dS, and the cost is S / (2 noise).
    forward = -linear.negative_gradient * objective._noise * 1e6 / value
    np.testing.assert_allclose(forward, gradient, rtol=1e-5, atol=1e-6 * np.abs(gradient).max())


def test_frames_of_a_recording_share_its_pose() -> None:
    frames = instants(TIMES, [np.zeros((240, 320))] * len(TIMES))
    assert pose_owners(frames) == (0, 0, 0, 0)
    assert pose_covariances(frames) == [None] * 4


def test_repeated_frames_of_known_series() -> None:
    random = np.random.default_rng(4)
    count, parts = 12, 4000
    white = random.normal(size=(count, parts))
    assert repeated_frames(list(white)) == pytest.approx(1.0, abs=0.1)
    same = [random.normal(size=parts)] * count
    assert repeated_frames(same) == pytest.approx(count)
    # A first-order process whose neighbours correlate by a half: 1 + 2 sum (1 - l/F) 2^-l.
    process = [white[0]]
    for noise in white[1:]:
        process.append(0.5 * process[-1] + np.sqrt(0.75) * noise)
    expected = 1.0 + 2.0 * sum((1.0 - lag / count) * 0.5**lag for lag in range(1, 5))
    assert repeated_frames(process) == pytest.approx(expected, abs=0.3)


def test_part_means_leave_out_what_was_not_seen() -> None:
    means = part_means(np.array([1.0, 3.0, 5.0]), np.array([0, 0, 2]), 4)
    np.testing.assert_array_equal(means, [2.0, np.nan, 5.0, np.nan])


def test_the_error_of_the_time_step_is_foreseen() -> None:
    coarse, fine = (
        moving_model(moving_scene((4, 1, 1), fit=FIT, time_step=step), TIMES)
        for step in (1 / 480, 1 / 3840)
    )
    start = coarse.parameters.start()
    here, there = (model.at(start).states[0] for model in (coarse, fine))
    true = there.positions - here.positions
    foreseen = coarse.bodies[0].step_moves(here)
    seen = np.linalg.norm(true)
    assert seen > 1e-5
    assert np.linalg.norm(foreseen - true) < _FORESEEN * seen


def test_steps_of_a_tolerance_are_those_of_the_first_motion() -> None:
    model = moving_model(moving_scene((4, 1, 1), fit=FIT, tolerance=5e-6), TIMES)
    start = model.parameters.start()
    chosen = model.at(start).states[0].motion
    assert len(set(chosen.rungs)) > 1
    assert model.warnings(start) == []
    # Half as stiff: it moves more slowly, and on its own would take longer steps.
    softer = start - np.log(2.0) * np.eye(len(start))[0]
    warm = model.at(softer).states[0].motion
    assert warm.rungs == chosen.rungs
    afresh = moving_model(moving_scene((4, 1, 1), fit=FIT, tolerance=5e-6), TIMES)
    assert afresh.at(softer).states[0].motion.step_count < warm.step_count
    # A hundredth of the damping: the same steps are too long, which is told.
    (warning,) = model.warnings(start - np.log(100.0) * np.eye(len(start))[1])
    assert 'the time steps were chosen for the start values' in warning
    assert 'fit again from the fitted scene' in warning


def test_a_small_mesh_is_tried_at_half_its_size(monkeypatch) -> None:
    """On the nodes that both have: the finer mesh is that of the same beam, cut twice as fine."""
    coarse = moving_model(moving_scene((4, 1, 1), fit=FIT), TIMES)
    start = coarse.parameters.start()
    posture, states = coarse.bodies[0], coarse.at(start).states[0]
    foreseen = posture.mesh_moves(states, 'auto') - posture.step_moves(states)
    fine = moving_model(moving_scene((8, 2, 2), fit=FIT), TIMES)
    rest = [model.bodies[0].body.discretisation.rest_nodes for model in (coarse, fine)]
    # Corners alone are in both, and only some: the two cut their cells otherwise.
    distances = np.linalg.norm(rest[0][:, None] - rest[1][None], axis=2)
    places, own = distances.argmin(axis=1), distances.min(axis=1) < 1e-9
    assert own.sum() >= coarse.scene.mesh.vertex_count
    true = fine.at(start).states[0].positions[:, places[own]] - states.positions[:, own]
    seen = np.linalg.norm(true)
    assert np.linalg.norm(foreseen[:, own] - true) < _FORESEEN * seen
    # Stiffness found at rest tells less: the release sets waves off, which the mesh delays.
    monkeypatch.setattr(moving_posture, 'is_affordable', lambda *_: False)
    guessed = posture.mesh_moves(states, 'auto') - posture.step_moves(states)
    assert np.linalg.norm(foreseen[:, own] - true) < np.linalg.norm(guessed[:, own] - true)


def test_the_error_of_chosen_steps_is_foreseen() -> None:
    chosen = moving_model(moving_scene((4, 1, 1), fit=FIT, tolerance=1e-6), TIMES)
    fine = moving_model(moving_scene((4, 1, 1), fit=FIT, time_step=1 / 3840), TIMES)
    start = chosen.parameters.start()
    here, there = (model.at(start).states[0] for model in (chosen, fine))
    true = there.positions - here.positions
    foreseen = chosen.bodies[0].step_moves(here)
    seen = np.linalg.norm(true)
    assert seen > 1e-6
    assert np.linalg.norm(foreseen - true) < _FORESEEN * seen


def test_a_step_that_was_halved_is_told(model: ForwardModel) -> None:
    assert model.warnings(model.parameters.start()) == []
    long = moving_model(moving_scene((6, 2, 2), fit=FIT, time_step=0.04), TIMES)
    (warning,) = long.warnings(long.parameters.start())
    assert 'the time step of 0.04 s did not converge and was halved' in warning
    assert 'a shorter `motion.time_step`' in warning


def test_scenes_know_the_integrators() -> None:
    assert set(INTEGRATOR_NAMES) <= set(INTEGRATORS)
